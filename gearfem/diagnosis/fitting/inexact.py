"""How far parameters may be off by what no record tells: no real effect has quite the form of its name."""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING

import numpy as np

from gearfem.diagnosis.fitting import parameters
from gearfem.diagnosis.modelling.model_form import SHAPE
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, Array

if TYPE_CHECKING:
    from gearfem.diagnosis.fitting.fit import Fit
    from gearfem.diagnosis.fitting.point import Point
    from gearfem.diagnosis.fitting.problem import Problem

# Units of places and lengths along a flank or a face, and of where a wave begins.
ALONG, TURNED = "mm", "rad"


def inexact(effect: Effect, problem: Problem) -> dict[str, float]:
    """Return how far parameters may be off by what no record tells, in coordinates in which effects are smooth.

    No real effect has quite the form of its name: a tenth of what it amounts to, of depths at several places the largest one, and of how
    far it reaches along the tooth; that much its place is off too. Nothing for how else it acts. And what the model has of it before was as
    unknown as the nuisance, or error of the model, that does the same.
    """
    setup = problem.campaign.setup
    known, largest, strengths = effect.fitted(), dict[str, float](), parameters.strengths(effect, setup)
    lengths = {field: getattr(effect, field) for field, one in known.items() if one.unit == ALONG and not one.place}
    for field, size in (lengths | strengths).items():
        unit = known[field].unit
        largest[unit] = max(largest.get(unit, 0.0), size)
    served = [one for one in problem.stand_ins if one.serves(effect)]
    shapes = {field: SHAPE * largest.get(one.unit, 0.0) if field in strengths or one.unit == ALONG else 0.0 for field, one in known.items()}
    return {
        field: math.hypot(shape, *(way.doubt(effect, field) for way in served if field in strengths)) for field, shape in shapes.items()
    }


def stated(problem: Problem, fit: Fit) -> tuple[dict[str, float], ...]:
    """Return the standard deviations of the parameters of a fit as they are stated, by field, one dict for each effect.

    Parameters
    ----------
    problem : Problem
        Prepared where the fit stands.
    fit : Fit
        Of effects.

    Returns
    -------
    tuple of dict
        In coordinates in which effects are smooth; without what models dispute. None is less than `Fit.deviations`.

    Notes
    -----
    If a tenth of what an effect does has another form than its name says, parameters are off by more than a tenth where what it does hardly
    goes by them, or where two of them do nearly the same: how deep a pit is that bears no load, how a pit is wide or deep, which of two
    supports yields. So that much counts as if it were of the form that misleads a parameter most, all nuisances free. Amounts are judged
    over half of themselves, since effects saturate; where a wave begins is off by as much of a radian.
    """
    point, found = fit.point, list[dict[str, float]]()
    for number, (effect, least) in enumerate(zip(fit.effects, fit.deviations, strict=True)):
        loose = {field: SHAPE for field, known in effect.fitted().items() if known.unit == TURNED}
        with contextlib.suppress(*UNCOMPUTABLE, np.linalg.LinAlgError):
            loose |= {field: far for field, far in _misled(problem, point, number).items() if field not in loose}
        found.append({field: max(deviation, loose.get(field, 0.0)) for field, deviation in least.items()})
    return tuple(found)


def _misled(problem: Problem, point: Point, number: int) -> dict[str, float]:
    """Return how far each parameter of an effect of a point is off, by field, if a tenth of what it does misleads that most."""
    effect = point.effects[number]
    before, after = point.effects[:number], point.effects[number + 1 :]
    here = parameters.values((effect,))
    columns = []
    for place, to in enumerate(_elsewhere(effect, problem)):
        there = here.copy()
        there[place] = to
        moved = problem.change(point, (*before, *parameters.moved((effect,), there), *after), point.stood)
        columns.append(moved / (to - here[place]))
    gram, _ = problem.freed(point)(np.column_stack([*columns, problem.response(point, (*before, *after))]))
    scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
    inverse = np.linalg.pinv(scale[:-1, None] * gram[:-1, :-1] * scale[:-1], rcond=1e-12, hermitian=True)
    off = SHAPE / scale[-1] * scale[:-1] * np.sqrt(np.maximum(np.diag(inverse), 0.0))
    return dict(zip(effect.fitted(), off.tolist(), strict=True))


def _elsewhere(effect: Effect, problem: Problem) -> Array:
    """Return to where each parameter of an effect is moved to see what it does: amounts to half, others by a tenth of what is typical."""
    setup, here, to = problem.campaign.setup, parameters.values((effect,)), []
    steps, most, strengths = SHAPE * parameters.sizes((effect,), setup), parameters.bounds((effect,), setup)[1], effect.strengths()
    for (field, known), value, step, high in zip(effect.fitted().items(), here, steps, most, strict=True):
        rest = known.coordinate(known.at_rest(setup, effect.member)) if field in strengths else value
        if abs(value - rest) > step:
            to.append(0.5 * (value + rest))
        else:
            to.append(value + step if value + step <= high else value - step)
    return np.array(to)
