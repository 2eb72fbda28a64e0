"""Responses per unit parameter: what each effect would add to records, computed once, for scans over many of them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from gearfem.assembly import assemble
from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.progress import Progress, quiet
from gearfem.sensing import Request, observe


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Templates(Record):
    """Responses of r records to p parameters of effects.

    Parameters
    ----------
    requests : tuple of Request, length r
        The records.
    baseline : tuple of ndarray, shapes (n_i,)
        Their values without the effects [SI].
    parameters : tuple of (Effect, str), length p
        Effect, as given, and the field of its parameter.
    change : ndarray, shape (p,)
        Change of each parameter's coordinate from its neutral value over which the response was taken [SI]; the coordinate is the
        value, or its reciprocal where the effect grows with that.
    response : tuple of ndarray, shapes (n_i, p)
        Change of the values per unit of each coordinate [SI].
    """

    requests: tuple[Request, ...]
    baseline: tuple[Array, ...]
    parameters: tuple[tuple[Effect, str], ...]
    change: Array
    response: tuple[Array, ...]

    def predict(self, change: ArrayLike) -> tuple[Array, ...]:
        """Return the values of all records for changes of the coordinates from neutral, shape (p,), to the first order."""
        by = np.asarray(change, float)
        return tuple(values + response @ by for values, response in zip(self.baseline, self.response, strict=True))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters: effect, gear and tooth where it has them, key in model files."""
        return tuple(
            "_".join(str(part) for part in (effect.name, getattr(effect, "gear", None), getattr(effect, "tooth", None)) if part is not None)
            + f"_{'one_over_' if effect.parameters()[field].reciprocal else ''}{effect.key(field)}"
            for effect, field in self.parameters
        )


def templates(
    setup: Setup, effects: Iterable[Effect], requests: Sequence[Request], strength: float = 1.0, progress: Progress = quiet
) -> Templates:
    """Return the responses of records per unit of every parameter that has a neutral value.

    Parameters
    ----------
    setup : Setup
        The pair; effects that it names belong to the baseline.
    effects : iterable of Effect
        Effects of the sizes that are looked for, as from `Effect.example`; parameters that say where or how stay as they are.
    requests : sequence of Request
        The records.
    strength : float
        Part of each size over which the response is taken, each parameter alone: 1 for the mean slope up to it, a small one for the
        slope at neutral strength, which is 0 for a root crack.
    progress : Progress
        Told after each parameter.

    Returns
    -------
    Templates

    Raises
    ------
    InputError
        If the strength is not positive, an effect is beyond its bounds there, or neutral as given.
    SolveError
        As the prediction does.

    Notes
    -----
    (y(p0 + s (p - p0)) - y(p0)) / (s (p - p0)): all stages before the effect's are those of the baseline, remembered. Responses add up as
    far as the gears are linear in the effects: worn depths, gaps and friction bend them where contacts come and go.

    Examples
    --------
    >>> from gearfem.effects.catalogue import catalogue
    >>> from gearfem.model import load_model
    >>> from gearfem.sensing import requests
    >>> setup = load_model("studies/coal_combine/model.toml")
    >>> late = catalogue()["pitch_error"].example(setup, "pinion", 0)
    >>> record = requests()["static_transmission_error"](axis=np.array([0.05]), pinion_torque=1605.0)
    >>> table = templates(setup, [late], [record], strength=0.01)
    >>> table.names, round(float(table.response[0][0, 0]), 3)
    (('pitch_error_pinion_0_amount_um',), 1.0)
    """
    if not 0.0 < strength < math.inf:
        raise InputError("templates.strength", strength, "a positive number")
    chosen = [(effect, field) for effect in effects for field in effect.strengths()]
    system = assemble(setup)
    baseline = tuple(observe(system, request) for request in requests)
    changes, columns = [], []
    for number, (effect, field) in enumerate(chosen):
        progress("responses", number, len(chosen))
        moved, change = _alone(effect, field, strength, setup)
        system = assemble(setup, [moved])
        columns.append([(observe(system, request) - before) / change for request, before in zip(requests, baseline, strict=True)])
        changes.append(change)
    progress("responses", len(chosen), len(chosen))
    response = tuple(
        np.stack([column[number] for column in columns], axis=1) if columns else np.empty((len(before), 0))
        for number, before in enumerate(baseline)
    )
    return Templates(
        requests=tuple(requests), baseline=baseline, parameters=tuple(chosen), change=np.array(changes, float), response=response
    )


def _alone(effect: Effect, field: str, strength: float, setup: Setup) -> tuple[Effect, float]:
    """Return an effect with one of its parameters at a part of its size, all others neutral, and the change of its coordinate."""
    known = effect.parameters()
    rest = {name: known[name].at_rest(setup, effect.member) for name in effect.strengths()}
    neutral, full = (known[field].coordinate(value) for value in (rest[field], getattr(effect, field)))
    if full == neutral:
        raise InputError(f"{effect.name}.{effect.key(field)}", "its neutral value", "the size that is looked for, as from Effect.example")
    change = strength * (full - neutral)
    return dataclasses.replace(effect, **{**rest, field: known[field].value(neutral + change)}), change
