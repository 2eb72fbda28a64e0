"""Fit effects to a campaign, together with everything that is never exactly known."""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import lsq_linear

from gearfem.diagnosis.fitting import parameters
from gearfem.diagnosis.fitting.eased import eased, to_a_factor
from gearfem.diagnosis.fitting.inexact import inexact
from gearfem.diagnosis.fitting.marginal import WEIGHED
from gearfem.diagnosis.fitting.point import Point
from gearfem.diagnosis.fitting.straying import halves
from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.modelling.differences import one_sided
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, Array, Record

if TYPE_CHECKING:
    from gearfem.diagnosis.fitting.problem import Problem

# Rounds after which derivatives are taken again; between them Broyden's corrections do.
ROUNDS, SETTLED, EXACT = 9, 1.0, 3
# What a fit may still gain, in parts of what its last round has.
AHEAD = 3.0
# What is added to the squares of all columns, in parts of them, until a step helps.
DAMPING = (1e-9, 1e-3, 0.05, 3.0)
# Steps of differences in parts of a parameter's size; and of those of an instrument, which leave the motion as it is: beside impacts in an
# acceleration 5 ns of delay are little, 1 us is not. Ten times as long ones put derivatives over where pits lie off by half of them.
DIFFERENCE, READ = 0.003, 0.0001
# Times that a fit is prepared anew at most, rounds of each, and times in a row that it may gain little.
AGAIN, NEARBY, WORSE = 8, 2, 2


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Fit(Record):
    """Effects fitted to records.

    Parameters
    ----------
    effects : tuple of Effect
        As fitted; none for the nuisances alone.
    deviations : tuple of dict
        Standard deviation of each parameter [SI], or of its reciprocal where that is smooth, by field, one dict for each effect: noise,
        nuisances, model form, and see `inexact`; less than is stated of it, see `stated`.
    bound : tuple of (int, str)
        Parameters that ended at a bound: number of the effect and field.
    objective : float
        Squares of the whitened residual and of all nuisances in prior deviations, summed, and what scales cost that stray, see `beyond`,
        and effects that are unlikely: as attained where the fit stands; of one joined from two, as if all that is linear nearby were.
    point : Point
        Where the fit ended.
    settings : Settings
        Nuisances in the model's own terms.
    squares : ndarray, shape (r,)
        Mean square of the whitened rows of each record; 1 in noise alone.
    left : tuple of ndarray
        What is left of each record [SI], everything taken off.
    white : ndarray, shape (m,)
        The same whitened, one record below the other.
    told : ndarray, shape (z1 + z2,)
        Deviation of each index error as found over that of the true ones: 1 where the records tell it, 0 where none meets the tooth, and
        between where they tell it together with those of other teeth alone. Empty where index errors stand still.
    """

    effects: tuple[Effect, ...]
    deviations: tuple[dict[str, float], ...]
    bound: tuple[tuple[int, str], ...]
    objective: float
    point: Point
    settings: Settings
    squares: Array
    left: tuple[Array, ...]
    white: Array
    told: Array


def fit(problem: Problem, effects: tuple[Effect, ...], unknown: Array, rounds: int = ROUNDS, hopeless: float = np.inf) -> Fit:
    """Fit the parameters of effects and all nuisances.

    Parameters
    ----------
    problem : Problem
        Prepared at a point nearby.
    effects : tuple of Effect
        Where to start; gears and teeth stay.
    unknown : ndarray, shape (k,)
        Nuisances to start from, as `Problem.prepare` returns them.
    rounds : int
        Rounds at most.
    hopeless : float
        Objective that a fit must promise to reach; one that will not is given up where it stands.

    Returns
    -------
    Fit

    Raises
    ------
    SolveError, InputError
        If the start cannot be computed.

    Notes
    -----
    Gauss and Newton's method. Bounded least squares, from which everything linear nearby (offsets, teeth, model form) has been
    eliminated, give the step of the parameters and of the scales; what is linear goes along to where it then leaves least, and a step
    helps if less is attained there, nothing moved any further (`Problem.attained`). Steps that do not help are damped (Levenberg and
    Marquardt's), since scales do nearly the work of effects and valleys are narrow. Derivatives are corrected by what each step shows, and
    taken again every third round and before the fit ends. Columns of what is linear are those of the last `prepare`.
    """
    return _standing(problem, *_descend(problem, problem.at(effects, unknown), rounds, hopeless))


def _descend(problem: Problem, point: Point, rounds: int, hopeless: float = np.inf) -> tuple[Point, float, Array]:
    """Return where a fit from a point on ends, see `fit`, what it attains there, and derivatives about there."""
    derivatives, exact, attained = jacobian(problem, point), True, problem.attained(point)
    for number in range(rounds):
        before, left = point, attained
        point, attained = _ahead(problem, before, left, derivatives)
        gained, small = left - attained, _little(left)
        if (gained < small and exact) or (number > 0 and left - AHEAD * gained > hopeless):
            break
        exact = gained < small or number % EXACT == EXACT - 1
        derivatives = jacobian(problem, point) if exact else _corrected(problem, derivatives, before, point)
    return point, attained, derivatives


def _standing(problem: Problem, point: Point, attained: float, derivatives: Array) -> Fit:
    """Return the fit that stands at a point."""
    rest = problem.left(point)
    white = problem.whiten(rest)
    return Fit(
        effects=point.effects,
        deviations=_deviations(problem, point, derivatives),
        bound=parameters.at_bounds(point.effects, problem.campaign.setup),
        objective=attained,
        point=point,
        settings=problem.settings(point.unknown),
        squares=problem.squares(white) / problem.counts,
        left=rest,
        white=white,
        told=_told(problem, point),
    )


def _told(problem: Problem, point: Point) -> Array:
    """Return how much of each index error the records tell, see `Fit`: what is expected of one and found about it adds up in squares."""
    late = np.arange(problem.unknowns.first_form)[problem.unknowns.late]
    if not late.size:
        return np.empty(0)
    doubt = problem.linear.weighed(point.weights).deviations_of(late - problem.outer)
    return np.asarray(np.sqrt(np.maximum(1.0 - doubt**2, 0.0)))


def again(
    problem: Problem,
    effects: tuple[Effect, ...],
    unknown: Array,
    times: int = AGAIN,
    hopeless: float = np.inf,
    weights: Array | None = None,
) -> Fit:
    """Return the fit of effects from nuisances on, the problem prepared anew where it ends until that gains little, so many times at most.

    The columns of what is linear change along the way: near a resonance, and where load passes from tooth to tooth. The problem stays
    prepared near where the fit stands that is returned. One that does not promise to come down to `hopeless` is given up as in `fit`. What
    each record counts at first is found from 1, or goes on from weights (r,) of a fit nearby.
    """
    here = copy.copy(problem)
    best = point = here.at(effects, here.prepare(effects, unknown), weights, WEIGHED)
    there, lowest, worse = here, math.inf, 0
    least = start = here.attained(best)
    # Where a round ends that cannot be computed, those before it count.
    with contextlib.suppress(*UNCOMPUTABLE):
        for _ in range(times):
            point, attained, _ = _descend(here, point, NEARBY)
            little, gained = _little(attained), start - attained
            if gained < little or attained - AHEAD * gained > hopeless:
                if attained < least:
                    least, best, there = attained, point, here
                break
            worse = 0 if lowest - attained > little else worse + 1
            lowest, here = min(lowest, attained), copy.copy(problem)
            point = here.at(point.effects, here.prepare(point.effects, point.stood), point.weights, WEIGHED)
            start = here.attained(point)
            if start < least:
                least, best, there = start, point, here
            if worse == WORSE:
                break
    problem.__dict__.update(there.__dict__)
    moved, least = eased(problem, best, least)
    found = _ended(problem, moved, least)
    if moved is best:
        return found
    return dataclasses.replace(found, deviations=to_a_factor(found, best.effects, problem.campaign.setup))


def attempt(
    problem: Problem,
    effects: tuple[Effect, ...],
    unknown: Array,
    times: int = AGAIN,
    hopeless: float = np.inf,
    weights: Array | None = None,
) -> Fit | None:
    """Return what `again` finds, the problem itself left as it is; None where the model cannot be computed."""
    with contextlib.suppress(*UNCOMPUTABLE):
        return again(copy.copy(problem), effects, unknown, times, hopeless, weights)
    return None


def _ended(problem: Problem, point: Point, attained: float) -> Fit:
    """Return the fit that ends at a point, where there is a model."""
    if not math.isfinite(problem.left_at(point.effects, point.unknown)):
        # As if all were linear it would end where there is none.
        point = problem.still(point)
    return _standing(problem, point, attained, jacobian(problem, point))


def _little(objective: float) -> float:
    """Return what is too little to go on for."""
    return SETTLED + 1e-4 * objective


def jacobian(problem: Problem, point: Point) -> Array:
    """Return the whitened derivatives of all records over parameters and scales, the former by one-sided differences."""
    values, sizes = parameters.values(point.effects), parameters.sizes(point.effects, problem.campaign.setup)
    low, high = parameters.bounds(point.effects, problem.campaign.setup)
    parts = [READ if effect.stage == "sensing" else DIFFERENCE for effect in point.effects for _ in effect.fitted()]
    columns = []
    for place, value in enumerate(values):

        def quotient(step: float, place: int = place, value: float = value) -> Array:
            ahead = values.copy()
            ahead[place] = min(max(value + step, low[place]), high[place])
            return np.asarray(problem.change(point, parameters.moved(point.effects, ahead), point.stood) / (ahead[place] - value))

        step = parts[place] * sizes[place]
        columns.append(one_sided(quotient, step if value + step <= high[place] else -step))
    return np.column_stack([*columns, problem.scales])


def _corrected(problem: Problem, derivatives: Array, point: Point, ahead: Point) -> Array:
    """Return derivatives that foretell the step just made and are what they were across it (Broyden's)."""
    sizes = np.concatenate([parameters.sizes(point.effects, problem.campaign.setup), np.ones(problem.outer)])
    moved = parameters.values(ahead.effects) - parameters.values(point.effects)
    step = np.concatenate([moved, ahead.unknown[: problem.outer] - point.unknown[: problem.outer]]) / sizes
    if not step.any():
        # Only what is linear has moved, and they do not change with that.
        return derivatives
    # Residuals, unlike predictions, hold no index errors, which move too.
    change = point.residual - ahead.residual
    scaled = derivatives * sizes
    return np.asarray((scaled + np.outer(change - scaled @ step, step / (step @ step))) / sizes)


def _ahead(problem: Problem, point: Point, left: float, derivatives: Array) -> tuple[Point, float]:
    """Return the next point and what it attains, or the same one, where so much is left, if no step helps."""
    values, outer = parameters.values(point.effects), problem.outer
    for step in _steps(problem, point, derivatives):
        with contextlib.suppress(*UNCOMPUTABLE):
            unknown = problem.foretold(point, derivatives @ step)
            unknown[:outer] += step[len(values) :]
            ahead = problem.at(parameters.moved(point.effects, values + step[: len(values)]), unknown, point.weights)
            attained = problem.attained(ahead)
            if attained < left:
                return ahead, attained
    return point, left


def _steps(problem: Problem, point: Point, derivatives: Array) -> Iterator[Array]:
    """Yield steps of parameters and outer nuisances, within their bounds, that would leave least if all were linear, damped ever more."""
    values, outer = parameters.values(point.effects), point.unknown[: problem.outer]
    if not values.size + outer.size:
        yield np.empty(0)
        return
    low, high = parameters.bounds(point.effects, problem.campaign.setup)
    least, most = np.reshape([nuisance.room for nuisance in problem.nuisances], (outer.size, 2)).T
    low, high = np.concatenate([low - values, least - outer]), np.concatenate([high - values, most - outer])
    gram, pull = _measure(problem, point, derivatives)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
    room = (np.minimum(low / scale, -1e-12), np.maximum(high / scale, 1e-12))
    for damping in DAMPING:
        try:
            factor = np.linalg.cholesky(scale[:, None] * gram * scale + damping * np.eye(len(scale)))
        except np.linalg.LinAlgError:
            # Alike but for rounding: more damping tells them apart.
            continue
        target = np.linalg.solve(factor, scale * pull)
        yield scale * lsq_linear(factor.T, target, bounds=room).x


def _deviations(problem: Problem, point: Point, derivatives: Array) -> tuple[dict[str, float], ...]:
    if not point.effects:
        return ()
    gram, _ = _measure(problem, point, derivatives)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
    inverse = np.linalg.pinv(scale[:, None] * gram * scale, rcond=1e-12, hermitian=True)
    deviation = iter(scale * np.sqrt(np.maximum(np.diag(inverse), 0.0)))
    doubts = (inexact(effect, problem) for effect in point.effects)
    return tuple({field: math.hypot(float(next(deviation)), part) for field, part in parts.items()} for parts in doubts)


def _measure(problem: Problem, point: Point, derivatives: Array) -> tuple[Array, Array]:
    """Return the products of derivatives and their pull on what a point leaves, what is known of nuisances and effects in both."""
    gram, pull = problem.linear.weighed(point.weights).measure(derivatives, point.residual)
    outer = point.unknown[: problem.outer]
    own = np.arange(len(pull) - problem.outer, len(pull))
    gram[own, own] += 1.0
    pull[own] -= outer
    scales = problem.unknowns.scales
    slopes, bends = halves(outer[scales])
    gram[own[scales], own[scales]] += problem.detected * bends
    pull[own[scales]] -= problem.detected * slopes
    far = parameters.unlikely(point.effects)
    if far.size:
        slopes = parameters.unlikely_slopes(point.effects, problem.campaign.setup)
        among = slice(slopes.shape[1])
        gram[among, among] += slopes.T @ slopes
        pull[among] -= slopes.T @ far
    return gram, pull
