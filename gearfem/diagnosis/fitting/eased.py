"""Strengths of a fit for which nothing speaks: halved while that costs little."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING

from gearfem.definition.setup import Setup
from gearfem.diagnosis.fitting import parameters
from gearfem.diagnosis.fitting.point import Point
from gearfem.diagnosis.modelling.model_form import SHAPE
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE

if TYPE_CHECKING:
    from gearfem.diagnosis.fitting.fit import Fit
    from gearfem.diagnosis.fitting.problem import Problem

# Halvings at most of a strength that ended at its bound, and what they may cost of what its effect explains, whose shape is no
# better, and at least.
HALVED, LITTLE, LEAST = 5, SHAPE**2, 1.0
# Standard deviation of what is known to a factor of two, in parts of it.
FACTOR = 0.33


def eased(problem: Problem, point: Point, attained: float) -> tuple[Point, float]:
    """Return a point that attains so much with strengths halved while that costs little of what their effect explains, and what it attains.

    Those at a bound, and those of single teeth: half of what acts in proportion costs a quarter. A pit that takes all load off its part of
    a flank does nothing more if it is deeper: nothing speaks for the deepest one.
    """
    setup = problem.campaign.setup
    for number, field in dict.fromkeys((*parameters.at_bounds(point.effects, setup), *_of_single_teeth(point.effects))):
        before, after = point.effects[:number], point.effects[number + 1 :]
        if field not in point.effects[number].strengths() or point.effects[number].parameters()[field].reciprocal:
            continue
        # What cannot be computed with less of it stays as it is.
        with contextlib.suppress(*UNCOMPUTABLE):
            without = problem.attained(problem.at((*before, *after), point.stood, point.weights))
            most = attained + max(LEAST, LITTLE * (without - attained))
            for _ in range(HALVED):
                effect = point.effects[number]
                rest = effect.parameters()[field].at_rest(setup, effect.member)
                less = dataclasses.replace(effect, **{field: 0.5 * (getattr(effect, field) + rest)})
                ahead = problem.at((*before, less, *after), point.stood, point.weights)
                left = problem.attained(ahead)
                if left > most:
                    break
                point, attained = ahead, left
    return point, attained


def to_a_factor(fit: Fit, before: tuple[Effect, ...], setup: Setup) -> tuple[dict[str, float], ...]:
    """Return the deviations of a fit, with those of strengths that were halved since: known to a factor of two."""
    found = []
    for effect, one, known in zip(fit.effects, before, fit.deviations, strict=True):
        halved = {field: far for field, far in parameters.strengths(effect, setup).items() if getattr(effect, field) != getattr(one, field)}
        found.append(known | {field: max(known[field], FACTOR * far) for field, far in halved.items()})
    return tuple(found)


def _of_single_teeth(effects: tuple[Effect, ...]) -> Iterator[tuple[int, str]]:
    """Yield the strengths of single teeth: number of the effect and field."""
    for number, effect in enumerate(effects):
        if effect.repeats == "one tooth":
            yield from ((number, field) for field in effect.strengths())
