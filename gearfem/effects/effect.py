"""What every physical effect is: a frozen record of parameters, the stage it acts on, and one pure method."""

from __future__ import annotations

import abc
import contextlib
import dataclasses
import functools
import math
import numbers
from collections.abc import Callable, Iterator
from typing import Any, ClassVar, Literal, Self, TypeAlias, TypeVar, cast, get_args

from gearfem.definition.setup import Member, Setup
from gearfem.foundation import UNCOMPUTABLE, EffectError, InputError, Record
from gearfem.foundation.units import factor

Stage = Literal["flank", "compliance", "placement", "contact", "drive", "sensing"]
STAGES: tuple[Stage, ...] = get_args(Stage)
Repeat = Literal["every tooth", "one tooth", "once a turn", "not periodic"]
# A gear is cut, then mounted, then wears and cracks, and runs at last: effects of one stage act in this order.
History = Literal["made", "mounted", "worn", "running"]
HISTORY: tuple[History, ...] = get_args(History)
MEMBERS: tuple[Member, ...] = get_args(Member)

# What a class may say in code of its own: where that fails, it is said of the effect.
SAID = ("act", "check", "contradicts", "unlikely", "table", "describe", "brief")

Stated = TypeVar("Stated")
Size: TypeAlias = float | Callable[[Setup, Member], float]


def modules(count: float) -> Size:
    """Return a length of so many modules of the pair, for bounds and typical values."""
    return lambda setup, member: count * setup.pair.pinion.module


def of_width(share: float) -> Size:
    """Return a share of the face width, for bounds and typical values."""
    return lambda setup, member: share * setup.pair.face_width


@contextlib.contextmanager
def _of_ones_own(what: str) -> Iterator[None]:
    """Raise EffectError where code of an effect fails, with what fails in words; a place without a model stays what it is."""
    try:
        yield
    except (*UNCOMPUTABLE, MemoryError, EffectError):
        raise
    except Exception as error:
        raise EffectError(f"{what} fails with {type(error).__name__} ({error})") from error


@dataclasses.dataclass(frozen=True, kw_only=True)
class Parameter:
    """What is known of one parameter of an effect; sizes are in SI, or functions of the setup and the gear that give them.

    Parameters
    ----------
    words : str
        What it is.
    unit : str
        As it ends the key in files ("um"); empty for a number without dimension.
    low, high : Size
        Physical bounds, both allowed.
    typical : Size
        A value that a worn or badly made pair may well have: where a fit starts, and what is shown.
    neutral : Size, optional
        Value at which the effect does nothing. A parameter without one says where or how the effect acts.
    reciprocal : bool
        Whether the effect grows with the reciprocal of the value (a frequency that is infinite at no effect).
    place : bool
        Whether it says where on the flank the effect lies, which may be anywhere between the bounds.
    whole : bool
        Whether it is a whole number by its cause, as the order of a motor: a diagnosis chooses it and does not fit it.
    """

    words: str
    unit: str = ""
    low: Size
    high: Size
    typical: Size
    neutral: Size | None = None
    reciprocal: bool = False
    place: bool = False
    whole: bool = False

    def bounds(self, setup: Setup, member: Member) -> tuple[float, float]:
        """Return both bounds for a gear of a pair."""
        return self._size(self.low, setup, member), self._size(self.high, setup, member)

    def typically(self, setup: Setup, member: Member) -> float:
        """Return the typical value for a gear of a pair, within the bounds."""
        low, high = self.bounds(setup, member)
        return min(max(self._size(self.typical, setup, member), low), high)

    def at_rest(self, setup: Setup, member: Member) -> float:
        """Return the neutral value; only for parameters that have one."""
        assert self.neutral is not None
        return self._size(self.neutral, setup, member)

    def coordinate(self, value: float) -> float:
        """Return what the effect is smooth in: the value, or its reciprocal; `value` is its own inverse."""
        return 1.0 / value if self.reciprocal and value != 0.0 else (math.inf if self.reciprocal else value)

    value = coordinate

    def _size(self, size: Size, setup: Setup, member: Member) -> float:
        """Return a size of this parameter for a gear of a pair; raises EffectError if the function that gives it fails."""
        if not callable(size):
            return size
        with _of_ones_own(f'effect parameter "{self.words}": its size'):
            found = size(setup, member)
        if not isinstance(found, numbers.Real) or math.isnan(found):
            raise EffectError(f'effect parameter "{self.words}": its size is {found!r:.40}, no number')
        return float(found)


def parameter(
    words: str,
    unit: str = "",
    *,
    low: Size,
    high: Size,
    typical: Size,
    neutral: Size | None = None,
    reciprocal: bool = False,
    place: bool = False,
    whole: bool = False,
) -> Any:
    """Declare a parameter: the default of a dataclass field of an effect. Arguments as those of `Parameter`."""
    declared = Parameter(
        words=words, unit=unit, low=low, high=high, typical=typical, neutral=neutral, reciprocal=reciprocal, place=place, whole=whole
    )
    return dataclasses.field(metadata={"parameter": declared})


def _named(method: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method of an effect that raises EffectError, which names both, where its code fails."""

    @functools.wraps(method)
    def said(self: Effect, *args: Any, **kwargs: Any) -> Any:
        with _of_ones_own(f'effect "{self.name}": {method.__name__}'):
            return method(self, *args, **kwargs)

    return said


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Effect(Record, abc.ABC):
    """A physical effect. Subclasses are dataclasses whose fields are `gear`, `tooth` (both only where needed) and parameters.

    Attributes
    ----------
    name : str
        Name in model files and diagnoses.
    stage : Stage
        Whose record it changes: Flanks, Compliance, Placement, law of contact, DriveTrain or Instrument.
    repeats : Repeat
        How it comes back as the gears turn.
    history : History
        When in the life of the pair it happens; decides the order only within a stage.
    either_gear : bool
        Whether nothing differs if the other gear has it: the flanks leave the same gap, of which no record tells whose it is.
    replaces : bool
        Whether it overrules the value of the model (the last one wins) rather than adding to it.
    disputed : float
        Share of its strengths, 0 without it, by which models in use of the same thing differ: a diagnosis states it with what it names,
        since no record tells which is right.
    form : float
        Part of what it does that a real one may do in another form than this: so much wider a diagnosis states its parameters.
    sentence : str
        For reports; keys of model files in braces are filled in.
    reverse : str
        The same where a strength is below 0, filled in without signs; empty where none can be.
    source : str
        Where the shape comes from.
    """

    name: ClassVar[str]
    stage: ClassVar[Stage]
    repeats: ClassVar[Repeat]
    history: ClassVar[History] = "made"
    either_gear: ClassVar[bool] = False
    replaces: ClassVar[bool] = False
    disputed: ClassVar[float] = 0.0
    form: ClassVar[float] = 0.1
    sentence: ClassVar[str]
    reverse: ClassVar[str] = ""
    source: ClassVar[str]

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        for method in SAID:
            if callable(own := vars(cls).get(method)):
                setattr(cls, method, _named(own))

    @abc.abstractmethod
    def act(self, record: Any, setup: Setup) -> Any:
        """Return the record of its stage with this effect in it, of the same type."""

    def acted(self, record: Stated, setup: Setup) -> Stated:
        """Return what `act` makes of the record of its stage.

        Raises
        ------
        InputError, SolveError
            If it cannot act on this pair, as it says itself.
        FloatingPointError
            If it leaves a field that is no number.
        EffectError
            If its code fails, or returns no record of that type, or of a contact none at all.
        """
        try:
            changed = self.act(record, setup)
        except FloatingPointError as error:
            raise FloatingPointError(f'effect "{self.name}": {error}') from None
        # A law of contact may become one that scales it.
        alike = self.stage == "contact" or isinstance(changed, type(record))
        if not (alike and isinstance(changed, Record)):
            raise EffectError(f'effect "{self.name}": act returns {changed!r:.40}, no {type(record).__name__} as it is given')
        for field in dataclasses.fields(changed):
            # Arrays are looked at where a record is made.
            if _has_nan(getattr(changed, field.name)):
                raise FloatingPointError(f'effect "{self.name}": {field.name} of the {type(record).__name__} is no number')
        return cast(Stated, changed)

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """Return what is known of the numbers among the fields, by field; `gear` and `tooth` are not among them."""
        return {field.name: field.metadata["parameter"] for field in dataclasses.fields(cls) if "parameter" in field.metadata}

    @classmethod
    def fitted(cls) -> dict[str, Parameter]:
        """Return the parameters that a diagnosis fits, by field: all but whole numbers."""
        return {field: known for field, known in cls.parameters().items() if not known.whole}

    @classmethod
    def strengths(cls) -> tuple[str, ...]:
        """Return the fields that have a neutral value."""
        return tuple(name for name, known in cls.parameters().items() if known.neutral is not None)

    @classmethod
    def key(cls, field: str) -> str:
        """Return the key of a field in files, which ends in its unit."""
        known = cls.parameters().get(field)
        return f"{field}_{known.unit}" if known and known.unit else field

    @classmethod
    def keys(cls) -> dict[str, str]:
        """Return the fields by their keys in files."""
        return {cls.key(field.name): field.name for field in dataclasses.fields(cls)}

    @classmethod
    def of_one_gear(cls) -> bool:
        """Return whether it acts on one of the two gears."""
        return any(field.name == "gear" for field in dataclasses.fields(cls))

    @property
    def member(self) -> Member:
        """The gear it acts on; "pinion" where it acts on no single one."""
        member: Member = getattr(self, "gear", "pinion")
        return member

    @classmethod
    def example(cls, setup: Setup, member: Member = "pinion", tooth: int = 0) -> Self:
        """Return the effect with typical values on a pair.

        Parameters
        ----------
        setup : Setup
            The pair.
        member : {"pinion", "wheel"}
            The gear, if it acts on one.
        tooth : int
            The tooth, if it acts on one.

        Returns
        -------
        Effect
        """
        values: dict[str, Any] = {name: known.typically(setup, member) for name, known in cls.parameters().items()}
        fields = {field.name for field in dataclasses.fields(cls)}
        values |= {name: value for name, value in (("gear", member), ("tooth", tooth)) if name in fields}
        return cls(**values)

    def scaled(self, strength: float, setup: Setup) -> Self:
        """Return the effect at a fraction of its strength: 0 is neutral, 1 the effect itself.

        Parameters
        ----------
        strength : float
            Fraction; parameters without a neutral value stay as they are.
        setup : Setup
            The pair, since some neutral values are the model's.

        Returns
        -------
        Effect
        """
        changes = {}
        for field in self.strengths():
            known = self.parameters()[field]
            rest, full = known.coordinate(known.at_rest(setup, self.member)), known.coordinate(getattr(self, field))
            changes[field] = known.value(rest + strength * (full - rest))
        return dataclasses.replace(self, **changes)

    def contradicts(self) -> str:
        """Return in words what in its parameters contradicts its own cause; empty where nothing does. A diagnosis names none that does."""
        return ""

    def unlikely(self) -> tuple[float, ...]:
        """Return how far its parameters are from what its cause makes of them, in standard deviations. A diagnosis counts their squares."""
        return ()

    def check(self, setup: Setup) -> None:
        """Refuse what is not on these gears or beyond the bounds; raises InputError that names the key.

        Parameters
        ----------
        setup : Setup
            The pair.
        """
        gear = setup.pair.gear(self.member)
        if self.member not in MEMBERS:
            raise InputError("gear", f'"{self.member}"', '"pinion" or "wheel"')
        tooth = getattr(self, "tooth", 0)
        if isinstance(tooth, bool) or not isinstance(tooth, int) or not 0 <= tooth < gear.teeth:
            raise InputError("tooth", tooth, f"an integer from 0 to {gear.teeth - 1}, the teeth of the {self.member}")
        for field, known in self.parameters().items():
            value, (low, high) = getattr(self, field), known.bounds(setup, self.member)
            if not low <= value <= high:
                key, unit = self.key(field), factor(self.key(field))
                words = known.unit.replace("_per_", "/")
                allowed = f"a number from {low / unit:.6g} to {high / unit:.6g} {words}".rstrip()
                raise InputError(key, f"{value / unit:.6g}", f"{allowed} ({known.words})")

    def table(self) -> dict[str, str | int | float]:
        """Return the effect as a table of a model file, its name first."""
        values: dict[str, str | int | float] = {"name": self.name}
        for key, field in self.keys().items():
            value = getattr(self, field)
            # Twelve digits: what a person wrote comes back as it was written.
            values[key] = float(f"{value / factor(key):.12g}") if field in self.parameters() else value
        return values

    @_named
    def describe(self) -> str:
        """Return the sentence for reports with the values filled in."""
        below = bool(self.reverse) and any(getattr(self, field) < 0.0 for field in self.strengths())
        values = {key: abs(value) if below and isinstance(value, float) else value for key, value in self.table().items()}
        shown = {key: f"{value:.4g}" if isinstance(value, float) else value for key, value in values.items()}
        return (self.reverse if below else self.sentence).format(**shown)

    brief = describe


def _has_nan(value: object) -> bool:
    """Return whether a plain value, or one of a tuple, is no number."""
    return any(map(_has_nan, value)) if isinstance(value, tuple) else isinstance(value, float) and math.isnan(value)
