"""How far parameters may be off by what no record tells: no real effect has quite the form of its name."""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING

import numpy as np

from gearfem.definition.setup import Setup
from gearfem.diagnosis.fitting import parameters
from gearfem.diagnosis.modelling.model_form import SHAPE
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, Array

if TYPE_CHECKING:
    from gearfem.diagnosis.fitting.fit import Fit
    from gearfem.diagnosis.fitting.point import Point
    from gearfem.diagnosis.fitting.problem import Problem

# Units of places and lengths along a flank or a face, and of where a wave begins.
ALONG, TURNED = "mm", ("rad", "deg")


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
    If a part of what an effect does, `Effect.form`, has another form than its name says, a parameter is off by more than that where what
    the effect does hardly goes by it, or where another one does nearly the same: how deep a pit is that bears no load, how a pit is wide
    or deep, which of two supports yields. So that much counts as if it were of the form that misleads the parameter most, within its
    bounds, all nuisances and the parameters of all effects free. Amounts are judged over half of themselves, since effects saturate; where
    a wave begins is off by a tenth of a radian.
    """
    if not fit.effects:
        return ()
    misled = [dict.fromkeys(effect.fitted(), 0.0) for effect in fit.effects]
    with contextlib.suppress(*UNCOMPUTABLE, np.linalg.LinAlgError):
        misled = _misled(problem, fit.point)
    found = []
    for effect, fitted, off in zip(fit.effects, fit.deviations, misled, strict=True):
        waves = (field for field, known in effect.fitted().items() if known.unit in TURNED and field not in effect.strengths())
        form, counted = off | dict.fromkeys(waves, SHAPE), inexact(effect, problem)
        found.append({field: math.sqrt(known**2 + max(form[field] ** 2 - counted[field] ** 2, 0.0)) for field, known in fitted.items()})
    return tuple(found)


def _misled(problem: Problem, point: Point) -> list[dict[str, float]]:
    """Return how far each parameter is off, by field, one dict for each effect, if what this does in another form misleads that most."""
    effects, setup = point.effects, problem.campaign.setup
    here, columns = parameters.values(effects), []
    for place, to in enumerate(_elsewhere(effects, setup)):
        there = here.copy()
        there[place] = to
        columns.append(problem.change(point, parameters.moved(effects, there), point.stood) / (to - here[place]))
    columns += [problem.response(point, (*effects[:number], *effects[number + 1 :])) for number in range(len(effects))]
    gram, _ = problem.freed(point)(np.column_stack(columns))
    # In parts of their range, which bounds how far they may be off.
    low, high = parameters.bounds(effects, setup)
    own, span = gram[: here.size, : here.size], high - low
    causes = parameters.unlikely_slopes(effects, setup) if parameters.unlikely(effects).size else np.zeros((1, here.size))
    found, first = [], 0
    for effect, square in zip(effects, np.diag(gram)[here.size :], strict=True):
        precision = own / max(effect.form**2 * square, 1e-300) + causes.T @ causes
        inverse = np.linalg.inv(span[:, None] * precision * span + np.eye(here.size))
        off = span * np.sqrt(np.maximum(np.diag(inverse), 0.0))
        last = first + len(effect.fitted())
        found.append(dict(zip(effect.fitted(), off[first:last].tolist(), strict=True)))
        first = last
    return found


def _elsewhere(effects: tuple[Effect, ...], setup: Setup) -> Array:
    """Return to where each parameter is moved to see what it does, shape (p,): amounts to half, others by a tenth of what is typical."""
    steps, most = SHAPE * parameters.sizes(effects, setup), parameters.bounds(effects, setup)[1]
    rest = [
        known.coordinate(known.at_rest(setup, effect.member)) if field in effect.strengths() else math.nan
        for effect in effects
        for field, known in effect.fitted().items()
    ]
    here = parameters.values(effects)
    beside = np.where(here + steps <= most, here + steps, here - steps)
    return np.where(np.abs(here - rest) > steps, 0.5 * (here + rest), beside)
