"""Shapes and sizes of an effect that are tried before it is fitted."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np

from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, Parameter

# Further strengths at which an effect of all teeth is tried, as multiples of the typical one: on flanks, and elsewhere.
DEEP, WIDE = (0.25, 4.0, 16.0), (0.4, 2.5, 6.0)
# Multiples of its typical value at which either of two strengths is tried, for the resonances that they make together; and multiples of
# the model's at which a value in its place is, since a play decides which of two motions a pair takes.
EITHER, INSTEAD = (0.0, *np.geomspace(0.3, 3.3, 8).tolist()), np.geomspace(0.25, 4.0, 24)
# Natural frequencies between which a resonance is tried [Hz].
FREQUENCIES = 200.0, 10000.0


def bounded(effect: Effect, setup: Setup) -> Effect:
    """Return an effect whose strengths are moved into their bounds."""
    changes = {}
    for field in effect.strengths():
        low, high = effect.parameters()[field].bounds(setup, effect.member)
        changes[field] = min(max(getattr(effect, field), low), high)
    return dataclasses.replace(effect, **changes)


def shapes_of(effect: Effect, setup: Setup) -> list[Effect]:
    """Return the effect with all combinations of the parameters that say how it acts, where it lies on a flank."""
    # A frequency is infinite at no effect, and says where it acts all the same.
    acts = {field: one for field, one in effect.parameters().items() if not one.place and not one.whole}
    known = {field: one for field, one in acts.items() if one.neutral is None or one.reciprocal}
    if stands(effect):
        known = {field: one for field, one in known.items() if one.reciprocal}
    options = [tries(one, setup, effect) for one in known.values()]
    shapes = [dataclasses.replace(effect, **dict(zip(known, values, strict=True))) for values in itertools.product(*options)]
    strengths = effect.strengths()
    if len(strengths) == 2:
        # Two places share what they yield in sum: motions may tell them apart, but not from half way between.
        shapes += [
            dataclasses.replace(effect, **{one: 0.0, other: 2.0 * getattr(effect, other)}) for one, other in (strengths, strengths[::-1])
        ]
    if effect.repeats == "one tooth" or not effect.strengths() or stands(effect):
        return shapes
    # Far from typical sizes the response is not that of the typical one, scaled.
    sizes = DEEP if effect.stage == "flank" else WIDE
    return shapes + [bounded(effect.scaled(size, setup), setup) for size in sizes]


def placed(effect: Effect, setup: Setup, count: int) -> list[Effect]:
    """Return an effect at so many places from root to tip; the effect itself where it has no place."""
    effects = [effect]
    for field, known in effect.parameters().items():
        if known.place:
            low, high = known.bounds(setup, effect.member)
            places = low + (np.arange(count) + 0.5) / count * (high - low)
            effects = [dataclasses.replace(one, **{field: place}) for one in effects for place in places.tolist()]
    return effects


def spread_of(effect: Effect, setup: Setup) -> list[Effect]:
    """Return the shapes of an effect that motions alone feel; where it has two strengths, with each at sizes of its own.

    Resonances that they make together are met only from nearby, like those of nuisances (`approach.tuned`), and so is
    what stands in the place of a value of the model.
    """
    strengths = effect.strengths()
    if scanned(effect, setup):
        rest = effect.parameters()[strengths[0]].at_rest(setup, effect.member)
        return [bounded(dataclasses.replace(effect, **{strengths[0]: rest * factor}), setup) for factor in INSTEAD.tolist()]
    if len(strengths) != 2 or effect.stage == "flank":
        return shapes_of(effect, setup)
    sizes = itertools.product(EITHER, repeat=2)
    both = (tuple(size * getattr(effect, field) for size, field in zip(pair, strengths, strict=True)) for pair in sizes if any(pair))
    return [bounded(dataclasses.replace(effect, **dict(zip(strengths, values, strict=True))), setup) for values in both]


def scanned(effect: Effect, setup: Setup) -> bool:
    """Return whether an effect is tried at many strengths in a row: one that stands in the place of a value of the model."""
    strengths = effect.strengths()
    return effect.replaces and len(strengths) == 1 and effect.parameters()[strengths[0]].at_rest(setup, effect.member) > 0.0


def stands(effect: Effect) -> bool:
    """Return whether an effect is tried as it stands: strengths that say where it acts, as a frequency does, cannot be scaled."""
    return any(known.reciprocal for known in effect.parameters().values())


def tries(known: Parameter, setup: Setup, effect: Effect) -> tuple[float, ...]:
    """Return values at which a parameter that says where or how is tried."""
    low, high = known.bounds(setup, effect.member)
    typical = known.typically(setup, effect.member)
    if known.unit == "Hz":
        return tuple(float(f) for f in np.geomspace(*FREQUENCIES, 5))
    return tuple(sorted({min(max(share * typical, low), high) for share in (0.5, 1.0, 1.8)}))
