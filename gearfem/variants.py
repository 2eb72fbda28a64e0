"""How a model may be wrong though nothing is missing from it, and the variants of a system that are."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, Protocol

from gearfem.compliance.record import Compliance
from gearfem.definition.setup import Setup
from gearfem.effects.body_compliance import BodyCompliance
from gearfem.effects.centre_distance import CentreDistance
from gearfem.effects.contact_compliance import ContactCompliance
from gearfem.effects.effect import Stage
from gearfem.effects.friction import Friction
from gearfem.effects.lead_misalignment import LeadMisalignment
from gearfem.foundation.units import UM
from gearfem.sensing import System

# Part of a System that effects of a stage act on.
PARTS: dict[Stage, str] = {
    "flank": "flanks",
    "compliance": "compliance",
    "placement": "placement",
    "contact": "law",
    "drive": "drive",
    "sensing": "instrument",
}


class Cause(Protocol):
    """What acts on the part of one stage, as effects do."""

    @property
    def stage(self) -> Stage:
        """Stage whose part it changes."""
        ...

    def act(self, part: Any, setup: Setup) -> Any:
        """Return the part with itself in it."""
        ...


@dataclasses.dataclass(frozen=True, kw_only=True)
class Variant:
    """A way in which a model may be wrong.

    Parameters
    ----------
    name : str
        Field of `Calibration`.
    words : str
        For reports, with its standard deviation.
    cause : callable
        Takes a System and the value of the field, and returns what would do the same: an effect, where the catalogue has one.
    size : float
        One standard deviation: a factor, or what is added [SI].
    unit : str
        Unit of the value in reports; empty for a number.
    is_scale : bool
        Whether it multiplies.
    least, most : float
        How far the model can follow, in standard deviations; beyond, responses go on in straight lines.
    """

    name: str
    words: str
    cause: Callable[[System, float], Cause]
    size: float
    is_scale: bool
    unit: str = ""
    least: float = -4.0
    most: float = 4.0

    def value(self, moved: float) -> float:
        """Return the value of the field so many standard deviations from a model that is right."""
        return self.size**moved if self.is_scale else self.size * moved

    def deviations(self, value: float) -> float:
        """Return how many standard deviations a value of the field is from a model that is right."""
        return math.log(value) / math.log(self.size) if self.is_scale else value / self.size

    def both(self, one: float, other: float) -> float:
        """Return the value of two errors together."""
        return one * other if self.is_scale else one + other

    def act(self, system: System, value: float) -> System:
        """Return the system that is wrong by so much."""
        cause = self.cause(system, value)
        part = PARTS[cause.stage]
        return dataclasses.replace(system, **{part: cause.act(getattr(system, part), system.setup)})


def varied(system: System, errors: Iterable[tuple[Variant, float]]) -> System:
    """Return a system that is wrong in some ways, by the value of each."""
    for variant, value in errors:
        system = variant.act(system, value) if value != variant.value(0.0) else system
    return system


@dataclasses.dataclass(frozen=True, kw_only=True)
class ContactDepth:
    """Depth of the contact, of all teeth, as a multiple of the computed one."""

    scale: float
    stage: Stage = "compliance"

    def act(self, compliance: Compliance, setup: Setup) -> Compliance:
        """Scale the depths."""
        return compliance.each(lambda tooth: tooth.deeper(self.scale))


def just(kind: Callable[..., Any], field: str, system: System, value: float) -> Any:
    """Return a cause that has one strength, whatever the system."""
    return kind(**{field: value})


def _rubbing(system: System, more: float) -> Friction:
    return Friction(coefficient=system.drive.friction_coefficient + more)


# Sizes: what independent ways of computing each part differ by, and what nobody measured. Contact of healthy pairs yields 0.7 to 1.8 times
# as much in independent simulators as by Weber and Banaschek, what happens at tip edges set apart. Depth of the contact: twice the way from
# the depth that yields as the tooth does to Weber and Banaschek's. Housings and bearings hold shafts to some hundredths of a millimetre.
# Friction and misalignment act alike to either side.
VARIANTS = (
    Variant(
        name="contact_scale",
        words="contact law, 30 %",
        cause=partial(just, ContactCompliance, "scale"),
        size=1.3,
        is_scale=True,
    ),
    Variant(
        name="body_scale",
        words="gear bodies, 20 %",
        cause=partial(just, BodyCompliance, "scale"),
        size=1.2,
        is_scale=True,
    ),
    Variant(
        name="depth_scale",
        words="depth of the contact, 40 %",
        cause=partial(just, ContactDepth, "scale"),
        size=0.6,
        is_scale=True,
        least=-2.0,
        most=2.0,
    ),
    Variant(name="friction", words="tooth friction, 0.02", cause=_rubbing, size=0.02, is_scale=False, least=0.0, most=12.0),
    Variant(
        name="misalignment",
        words="misalignment, 1 um over the face width",
        cause=partial(just, LeadMisalignment, "slope"),
        size=1.0 * UM,
        is_scale=False,
        unit="um",
        least=0.0,
    ),
    Variant(
        name="centre_distance",
        words="centre distance, 20 um",
        cause=partial(just, CentreDistance, "amount"),
        size=20.0 * UM,
        is_scale=False,
        unit="um",
        least=-2.0,
    ),
)
