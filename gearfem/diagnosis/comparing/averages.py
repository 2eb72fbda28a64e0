"""What all pitches of a record share, and what is left for single teeth: one campaign as two problems.

An effect that all teeth have shows in the mean over the pitches, in which index errors and waviness of single teeth, ten times as large
as what is looked for, have averaged out; an effect of one tooth, or of a turn, shows in what differs from pitch to pitch.
"""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from scipy.linalg import block_diag, orth

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.fitting.approach import part_of
from gearfem.diagnosis.fitting.fit import AGAIN, Fit, again
from gearfem.diagnosis.fitting.problem import BenchOf, Problem
from gearfem.diagnosis.modelling.bench import Settings, neutral
from gearfem.diagnosis.modelling.pitch_point import COEFFICIENT, sooner_or_later, turns_round
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.modelling.teeth import Scatter, tooth_columns
from gearfem.diagnosis.modelling.unknowns import unknowns_of
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.noise import Noise
from gearfem.diagnosis.reading.quantities import Quantity
from gearfem.diagnosis.reading.whitening import Whitening
from gearfem.effects.effect import Effect
from gearfem.effects.friction import Friction
from gearfem.foundation import Array, Record

# Places of the pitch between which a mean over pitches runs in straight lines.
PLACES = 48
# Part of a mean that a model may miss though nothing is missing from it: of slow records, of those of a quantity, of which waviness
# raises the largest Kw of a turn, and of motions whose flanks hammer, which take another way for next to nothing. Sixteen healthy pairs
# of two other simulators leave slow means within noise, up to 1.8 % of transmission errors at speed, and 1.0 to 5 % of accelerations.
SLOW, HAMMERING = 0.003, 0.2
MISSED = {"dynamic_transmission_error": 0.015, "pinion_angular_acceleration": 0.03, "mesh_stiffness": 0.10, "dynamic_factor": 0.25}
# Part of the time that flanks are apart from which on they hammer ever more, and where they do: near resonances it is a quarter at most,
# under light loads half or more. Row by row nothing of it is foretold then: one micrometre of index errors changes all of what follows.
APART, HAMMERS, ANY = 0.25, 0.35, 1.0
# Times that index errors and waviness are fitted anew: they are all but linear.
TIMES = 3
# What index errors may be off where they stand still [m], and the least that single teeth do to a mean, in deviations of its noise.
INDEX, LEAST = 0.1e-6, 0.1
# By how much scores of the same explanation may differ by where its fit began (2 from six starts, with contact over tip edges unknown too),
# and what a name must gain: of eight healthy pairs the best explanation gained 8 at most.
WANDER = 10.0
# The same of slow records row by row, fitted from where means stand, and the share of their rows that a name must gain: of eight healthy
# pairs the best explanation gained nothing, of one whose sensor alone is wrong 0.25 %.
BY_ROWS, BY_ROWS_SHARE = 24.0, 0.003
# What an effect of one tooth must gain: waviness that is not linear has gained up to 54 as a pit of one of sixty teeth.
SINGLE = 80.0


# Chooses among quantities.
Which: TypeAlias = Callable[[Quantity], bool]


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Average(Record):
    """Takes the mean over the pitches of a record, as a whitener does: rows of variance 1, if what goes in is noise.

    Parameters
    ----------
    inner : Whitening
        Of the single rows.
    basis : ndarray, shape (m, p)
        Orthonormal basis of whitened series that repeat with the pitch.
    """

    inner: Whitening
    basis: Array

    def apply(self, values: Array) -> Array:
        """Return the mean of series in the rows of the record, shapes (n,) or (n, k): shapes (p,) or (p, k)."""
        return np.asarray(self.basis.T @ self.inner.apply(values))


def every(quantity: Quantity) -> bool:
    """Return that a quantity is wanted."""
    return True


def all_but_largest(quantity: Quantity) -> bool:
    """Return whether a quantity says much of single teeth for its cost: the largest Kw of turns says little and costs most."""
    return quantity.axis != "speed"


def of_teeth(problem: Problem) -> Which:
    """Return which quantities of a campaign say much of single teeth: not the largest Kw, nor a mesh stiffness beside slow ones.

    That jumps where pairs hand over, so that a few rows carry all that is missed of it, and what turns with a shaft moves some of these.
    """
    told = any(turns_round(record) for record in problem.records)
    return lambda quantity: all_but_largest(quantity) and not (told and quantity.name == "mesh_stiffness")


def slow(quantity: Quantity) -> bool:
    """Return whether single teeth act linearly on a quantity: motions whose flanks part take one branch or another for next to nothing."""
    return not quantity.moving


def has_means(problem: Problem) -> bool:
    """Return whether any record is over the pinion angle, so that it has a mean over the pitches."""
    return any(record.quantity.axis == "angle" for record in problem.records)


def shows_in_means(effect: Effect | type[Effect]) -> bool:
    """Return whether an effect shows in means over the pitches; all others differ from pitch to pitch."""
    return effect.repeats in ("every tooth", "not periodic")


def averaged(problem: Problem, settings: Settings, effects: tuple[Effect, ...] = ()) -> Problem:
    """Return the means over the pitches of all records as a problem, index errors as settings have them; not prepared.

    Parameters
    ----------
    problem : Problem
        Of the records row by row.
    settings : Settings
        Whose index errors stand, and where the gears stand otherwise.
    effects : tuple of Effect
        Effects that are known.

    Returns
    -------
    Problem
        Records over the teeth of a gear, which hold nothing that all teeth share, are left out, those of which means tell nothing
        (`Problem.untold`), and erratic motions; so is the largest Kw of turns beside other motions, which costs most and is missed by so
        much that it adds nothing.

    Notes
    -----
    A projection: of all whitened rows, those combinations that repeat with the pitch, as lines between 48 places of it. What single teeth
    still do to them, load being shared otherwise at every pitch, is held by the strongest combinations of their waviness, as they act where
    the settings stand, and of what index errors may be off. What a mean misses of the model is none of the errors that differ from tooth
    to tooth, and so far smaller: see `SLOW` and its neighbours.
    """
    campaign = problem.campaign
    moving = any(record.quantity.moving and all_but_largest(record.quantity) and not record.erratic for record in problem.records)
    over = (i for i, record in enumerate(problem.records) if record.quantity.axis != "tooth")
    told = (i for i in over if problem.records[i].file not in problem.untold and not problem.records[i].erratic)
    kept = [i for i in told if not moving or all_but_largest(problem.records[i].quantity)]
    records = tuple(problem.records[i] for i in kept)
    noises = tuple(mean_of(record, problem.noises[i], campaign.setup.pair) for record, i in zip(records, kept, strict=True))

    known, scatter = (*problem.known, *effects), problem.unknowns.scatter

    def bench(further: tuple[Effect, ...]) -> SystemBench:
        return problem.make((*known, *further))

    scatter = dataclasses.replace(scatter, rest=_rest(records, noises, bench, settings, scatter))
    level = neutral(campaign.setup.pair).with_teeth_of(settings)
    unknowns = unknowns_of(campaign, records, scatter, problem.unknowns.errors, level=level)
    found = Problem(campaign, records, noises, bench=problem.make, unknowns=unknowns, known=known)
    found.wander = found.least = WANDER
    found.counts = np.array([float(len(noise.whitener.apply(record.value))) for record, noise in zip(records, noises, strict=True)])
    usual = bench(())
    found.floor = np.array(
        [floor_of(record, noise, usual.pair, hammering(record, usual, settings)) for record, noise in zip(records, noises, strict=True)]
    )
    return found


def of_single_teeth(problem: Problem, settings: Settings, effects: tuple[Effect, ...], which: Which = every) -> Problem:
    """Return the records row by row as a problem of single teeth alone, under effects and nuisances that stand; not prepared.

    Parameters
    ----------
    problem : Problem
        Of the records row by row.
    settings : Settings
        Scales, zero of the angle and errors of the model that stand; index errors are fitted anew.
    effects : tuple of Effect
        Effects of all teeth that stand.
    which : callable
        Which quantities are among the records: `every`, `slow`, or those of `of_teeth`.
    """
    level = settings.with_teeth_of(neutral(problem.campaign.setup.pair))
    kept = [i for i, record in enumerate(problem.records) if which(record.quantity)]
    records, noises = tuple(problem.records[i] for i in kept), tuple(problem.noises[i] for i in kept)

    unknowns = unknowns_of(problem.campaign, records, problem.unknowns.scatter, (), (), level)
    found = Problem(problem.campaign, records, noises, bench=problem.make, unknowns=unknowns, known=(*problem.known, *effects))
    found.least = SINGLE
    usual = found.bench(())
    apart = np.array([1.0 if record.erratic else hammering(record, usual, settings) for record in records])
    course = np.array([np.std(record.value[record.keep]) / noise.std for record, noise in zip(records, noises, strict=True)])
    found.floor += apart * np.maximum(1.0 + (ANY * course) ** 2 - found.floor, 0.0)
    return found


def row_by_row(problem: Problem, effects: tuple[Effect, ...] = ()) -> Problem:
    """Return the slow records row by row, single teeth and nuisances both unknown, under known effects of single teeth; not prepared.

    How much of an index error shows, and where each tooth takes over, goes by what all teeth have: rows say several times as much of it as
    their mean does. They are fitted from where means stand: from further off waviness, which is linear nearby only, leads anywhere.
    """
    rows = part_of(problem, [i for i, record in enumerate(problem.records) if slow(record.quantity)], effects)
    rows.wander, rows.least, rows.share = BY_ROWS, BY_ROWS, BY_ROWS_SHARE
    return rows


def stand(problem: Problem, fit: Fit, teeth: Problem, single: Fit) -> Fit:
    """Return one fit of the records row by row from the fit of the means over the pitches and that of single teeth.

    Parameters
    ----------
    problem : Problem
        Of the records row by row; it is prepared where the fit stands.
    fit : Fit
        Of the means: nuisances, errors of the model and effects of all teeth.
    teeth, single : Problem, Fit
        From `of_single_teeth` under it: constants, index errors, waviness and effects of single teeth.
    """
    both, own, split = beside(fit, single), single.point.unknown, teeth.unknowns.first_form
    settings = fit.settings.with_teeth_of(single.settings)
    known = problem.unknowns.of(settings)
    unknown = np.concatenate([known[: problem.outer], own[:split], known[problem.unknowns.wrong], own[split:]])
    problem.prepare(both.effects, unknown)
    point = dataclasses.replace(problem.at(both.effects, unknown, single.point.weights), unknown=unknown)
    return dataclasses.replace(both, objective=point.objective, point=point, settings=problem.settings(unknown))


def beside(known: Fit, further: Fit) -> Fit:
    """Return a fit that was made under the effects of another one, these counted among its own."""
    return dataclasses.replace(
        further,
        effects=(*known.effects, *further.effects),
        deviations=(*known.deviations, *further.deviations),
        bound=(*known.bound, *((number + len(known.effects), field) for number, field in further.bound)),
    )


def whole(problem: Problem, means: Fit, single: Fit) -> Fit:
    """Return the fit of all records row by row, the largest Kw of turns included, from one of the means and of single teeth under it."""
    teeth = of_single_teeth(problem, means.settings, means.effects)
    found = teeth.fit(single.effects, teeth.prepare(single.effects, single.point.stood), rounds=0)
    # What has been halved is known to a factor still.
    known = zip(found.deviations, single.deviations, strict=True)
    deviations = tuple({field: max(here, before[field]) for field, here in one.items()} for one, before in known)
    return stand(problem, means, teeth, dataclasses.replace(found, deviations=deviations))


def without_single(problem: Problem, fit: Fit) -> Fit:
    """Return a fit of all records row by row without its effects of single teeth and turns: index errors anew, all else as it stands."""
    count = sum(shows_in_means(effect) for effect in fit.effects)
    bound = tuple((number, field) for number, field in fit.bound if number < count)
    means = dataclasses.replace(fit, effects=fit.effects[:count], deviations=fit.deviations[:count], bound=bound)
    teeth, single = teeth_under(problem, fit.settings, means.effects)
    return stand(copy.copy(problem), means, teeth, single)


def teeth_under(problem: Problem, settings: Settings, effects: tuple[Effect, ...], which: Which = every) -> tuple[Problem, Fit]:
    """Return the problem of single teeth under settings and effects that stand, see `of_single_teeth`, and its fit without further ones."""
    teeth = of_single_teeth(problem, settings, effects, which)
    return teeth, bare(teeth, np.zeros(teeth.unknowns.wrong.stop), TIMES)


def bare(rows: Problem, unknown: Array, times: int = AGAIN) -> Fit:
    """Return the fit of records row by row without effects, from unknowns on.

    Errors of the model that stay alike over many rows cost less: what effects gain is counted from what this fit costs then.
    """
    fit = again(rows, (), unknown, times)
    rows.remember(fit)
    return rows.fit((), fit.point.stood, rounds=1)


def mean_of(record: Measurement, noise: Noise, pair: GearPair) -> Noise:
    """Return the noise of the mean of a record; that of the record itself where it is not over the angle."""
    if record.quantity.axis != "angle":
        return noise
    return dataclasses.replace(noise, whitener=Average(inner=noise.whitener, basis=orth(noise.whitener.apply(_lines(record, pair)))))


def _lines(record: Measurement, pair: GearPair) -> Array:
    """Return what each row of a record takes of the places of the pitch between which a mean runs in straight lines, shape (n, places)."""
    place = record.axis / pair.pinion.pitch_angle * PLACES
    first = np.floor(place).astype(int)
    share, rows = place - first, np.arange(len(place))
    lines = np.zeros((len(place), PLACES))
    lines[rows, first % PLACES] += 1.0 - share
    lines[rows, (first + 1) % PLACES] += share
    return lines


def _rest(
    records: tuple[Measurement, ...], noises: tuple[Noise, ...], bench: BenchOf, settings: Settings, scatter: Scatter
) -> dict[str, Array]:
    """Return what means may miss of a model that is right, by file [SI], shapes (n, r), at one deviation.

    The strongest combinations of what single teeth still do to all, and of each slow one where friction turns round.
    """
    usual = bench(())
    sizes = dataclasses.replace(scatter, index=INDEX).deviations(usual.pair)
    columns = [tooth_columns(record, usual, settings, scatter) * sizes for record in records]
    white = np.concatenate([noise.whitener.apply(part) for noise, part in zip(noises, columns, strict=True)])
    _, strength, ways = np.linalg.svd(white, full_matrices=False)
    ways = ways[strength > LEAST].T
    own = [_sooner_or_later(record, bench, settings) if turns_round(record) else np.empty((len(record.axis), 0)) for record in records]
    missed = np.column_stack([np.concatenate(columns) @ ways, block_diag(*own)])
    parts = np.split(missed, np.cumsum([len(record.axis) for record in records])[:-1])
    return {record.file: part for record, part in zip(records, parts, strict=True)}


def _sooner_or_later(record: Measurement, bench: BenchOf, settings: Settings) -> Array:
    rubbing, smooth = (bench((Friction(coefficient=much),)).predict(record, settings) for much in (COEFFICIENT, 0.0))
    return sooner_or_later((rubbing - smooth) / COEFFICIENT)


def hammering(record: Measurement, bench: SystemBench, settings: Settings) -> float:
    """Return how far the motion of a record as settings have it is one whose flanks hammer, from 0 to 1: apart for much of the time."""
    if not record.quantity.is_motion:
        return 0.0
    swing = bench.swing(bench.turned(record.axis, settings), record.pinion_torque, record.pinion_speed, settings, record.kick)
    return float(np.interp(np.mean(swing.stiffness == 0.0), (APART, HAMMERS), (0.0, 1.0)))


def floor_of(record: Measurement, noise: Noise, pair: GearPair, hammering: float) -> float:
    """Return the least mean square of the rows of a mean that a model of finite accuracy can be expected to leave.

    What it misses is like the course of the mean or rougher: what has been made white where noise is smooth shows as much of either.
    """
    if record.quantity.axis == "roll":
        return 1.0
    usual = MISSED.get(record.quantity.name, SLOW)
    share = usual + hammering * (HAMMERING - usual)
    # The mean itself of a mesh stiffness or an acceleration says nothing of how far their course may be missed.
    course = record.value - record.value[record.keep].mean()
    size = float(np.mean(noise.whitener.apply(course) ** 2))
    if record.quantity.axis == "angle" and noise.covariance.size > 1:
        # Of white noise rough is less: lines between places, squared and summed, are 1 at most in any row.
        lines = _lines(record, pair)
        white, mean = noise.whitener.apply(lines), orth(lines[record.keep]).T @ course[record.keep]
        size = max(size, float(mean @ mean) / record.keep.sum() * float(np.sum(white**2)) / len(white))
    return 1.0 + share**2 * size
