"""The fitted parameters of sets of effects as one vector: values, bounds and sizes, in coordinates in which effects are smooth."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect
from gearfem.foundation import Array

# Part of its range within which a strength counts as none.
NOTHING = 1e-3
# Step of derivatives over parameters that need no prediction, in typical sizes.
NUDGE = 1e-6
# Standard deviations from which on a strength surely is one.
SURE = 3.0


def values(effects: tuple[Effect, ...]) -> Array:
    """Return the parameters of effects, shape (p,)."""
    pairs = ((effect, field, known) for effect in effects for field, known in effect.fitted().items())
    return np.array([known.coordinate(getattr(effect, field)) for effect, field, known in pairs], float)


def bounds(effects: tuple[Effect, ...], setup: Setup) -> tuple[Array, Array]:
    """Return their bounds, shapes (p,)."""
    both = [
        sorted(known.coordinate(edge) for edge in known.bounds(setup, effect.member))
        for effect in effects
        for known in effect.fitted().values()
    ]
    array = np.array(both).reshape(-1, 2)
    return array[:, 0], array[:, 1]


def sizes(effects: tuple[Effect, ...], setup: Setup) -> Array:
    """Return their typical sizes, by which differences are taken, shape (p,)."""
    out = []
    for effect in effects:
        for known in effect.fitted().values():
            typical = known.coordinate(known.typically(setup, effect.member))
            rest = known.coordinate(known.at_rest(setup, effect.member)) if known.neutral is not None else 0.0
            out.append(abs(typical - rest) or abs(typical) or 1.0)
    return np.array(out)


def moved(effects: tuple[Effect, ...], to: Array) -> tuple[Effect, ...]:
    """Return effects with other parameters, shape (p,)."""
    left = iter(to)
    return tuple(
        dataclasses.replace(effect, **{field: known.value(float(next(left))) for field, known in effect.fitted().items()})
        for effect in effects
    )


def unlikely(effects: tuple[Effect, ...]) -> Array:
    """Return how far parameters are from what the causes of effects make of them, in standard deviations, shape (q,)."""
    return np.array([one for effect in effects for one in effect.unlikely()])


def unlikely_slopes(effects: tuple[Effect, ...], setup: Setup) -> Array:
    """Return the derivatives of `unlikely` over the parameters, shape (q, p)."""
    here, stands = unlikely(effects), values(effects)
    steps = NUDGE * sizes(effects, setup)
    return np.column_stack([(unlikely(moved(effects, stands + step)) - here) / step.sum() for step in np.diag(steps)])


def at_bounds(effects: tuple[Effect, ...], setup: Setup) -> tuple[tuple[int, str], ...]:
    """Return the parameters that stand at a bound: number of the effect and field."""
    return tuple((number, field) for number, effect in enumerate(effects) for field in _ended(effect, setup))


def strengths(effect: Effect, setup: Setup) -> dict[str, float]:
    """Return how far each strength of an effect is from its neutral value, by field."""
    known = effect.parameters()
    both = {field: (getattr(effect, field), known[field].at_rest(setup, effect.member)) for field in effect.strengths()}
    return {field: abs(known[field].coordinate(value) - known[field].coordinate(rest)) for field, (value, rest) in both.items()}


def faint(effect: Effect, deviations: Mapping[str, float], setup: Setup, multiplies: bool = False) -> bool:
    """Return whether no strength of an effect is surely one, by the standard deviations of its parameters.

    Of an effect that multiplies, by its logarithm: three times as much, known to a fifth, is far from once as much.
    """
    known, far = effect.parameters(), strengths(effect, setup)
    if multiplies:
        here = {field: known[field].coordinate(getattr(effect, field)) for field in far}
        rest = {field: known[field].coordinate(known[field].at_rest(setup, effect.member)) for field in far}
        far = {field: value * abs(math.log(value / rest[field])) for field, value in here.items()}
    return all(strength < SURE * deviations[field] for field, strength in far.items())


def overdone(effects: tuple[Effect, ...], setup: Setup) -> tuple[Effect, ...]:
    """Return the effects that are as strong as can be: of which a strength stands at a bound that is not its neutral value."""
    return tuple(e for e in effects if any(_away(e, field, setup) > NOTHING for field in _ended(e, setup) if field in e.strengths()))


def _ended(effect: Effect, setup: Setup) -> tuple[str, ...]:
    """Return the fields of an effect that stand at a bound."""
    found = []
    for field, known in effect.fitted().items():
        value, *edges = (known.coordinate(at) for at in (getattr(effect, field), *known.bounds(setup, effect.member)))
        if any(abs(value - edge) <= 1e-6 * abs(edges[1] - edges[0]) for edge in edges):
            found.append(field)
    return tuple(found)


def _away(effect: Effect, field: str, setup: Setup) -> float:
    """Return how far a strength is from its neutral value, in parts of its range."""
    known = effect.parameters()[field]
    low, high = map(known.coordinate, known.bounds(setup, effect.member))
    return strengths(effect, setup)[field] / abs(high - low)
