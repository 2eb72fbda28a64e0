"""Compare a campaign with its model: nuisances fitted, everything else left as the gap."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from functools import partial

import numpy as np

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.comparing.averages import averaged, has_means, of_teeth, teeth_under, whole
from gearfem.diagnosis.comparing.branches import FAR, nearest
from gearfem.diagnosis.comparing.comparison import Compared, Comparison, Shift
from gearfem.diagnosis.comparing.erratic import marked
from gearfem.diagnosis.comparing.magnitudes import refuse_magnitudes
from gearfem.diagnosis.comparing.mirrored import refuse_mirrored
from gearfem.diagnosis.fitting.approach import ROUGH, at_rest, fit_from, from_zeros, lost, part_of, tuned
from gearfem.diagnosis.fitting.fit import Fit, again, attempt
from gearfem.diagnosis.fitting.problem import BenchOf, Problem
from gearfem.diagnosis.fitting.score import PARAMETER, stays
from gearfem.diagnosis.modelling.bench import Settings, neutral
from gearfem.diagnosis.modelling.system_bench import bench_of
from gearfem.diagnosis.modelling.teeth import Scatter
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.noise import measure_noise
from gearfem.effects.effect import MEMBERS
from gearfem.effects.profile_wear import ProfileWear
from gearfem.foundation import UNCOMPUTABLE, Array, InputError
from gearfem.foundation.progress import Progress, quiet
from gearfem.foundation.side_by_side import side_by_side

# Terms of the waviness of a flank. To find the zero and the noise, the few of `Scatter` are enough, and they leave the noise alone.
TERMS = 14
# Rounds in which guesses of the zero are told apart.
GUESSED = 1
# Pitches beyond which no descent leads from one zero to another.
VALLEY = 0.2
# Times that nuisances and single teeth are fitted by turns.
TURNS = 2


def compare(campaign: Campaign, scatter: Scatter | None = None, bench: BenchOf | None = None, progress: Progress = quiet) -> Comparison:
    """Fit the nuisances of a campaign, and nothing else.

    Parameters
    ----------
    campaign : Campaign
        Only its `fitted` records are looked at.
    scatter : Scatter, optional
        What single teeth are expected to do.
    bench : callable, optional
        Makes the model with effects; by default the campaign's.
    progress : Progress
        Told how far the fit is.

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        If a record is in another unit than it says or of the other sign, or taken at another speed; if there is none, or no campaign.
    SolveError
        If the model cannot be computed where a record was taken.

    Notes
    -----
    The zero of the angle comes first, from the slow records where there are any; then a rough fit, whose remainder shows the noise. Then
    nuisances and errors of the model come from the means over the pitches (`averaged`), and index errors and waviness from the records row
    by row (`of_single_teeth`), by turns: in the means the slow records come first, then the compliance in series and the damping that suit
    motions, then all, from several places where nuisances stray. Those that do the work of a missing effect still do then, see `screened`.
    Where another steady motion than that from rest meets a record (`nearest`), all of this is done again. Erratic motions, marked after the
    rough fit, are left out of the means.
    """
    if not isinstance(campaign, Campaign):
        raise InputError("campaign", f"{campaign!r:.60}", "a Campaign, from read_campaign(...)")
    if not campaign.fitted:
        raise InputError("record", "no record of role fit", "at least one record that is not held out", campaign.path)
    pair, records = campaign.setup.pair, campaign.fitted
    noises = tuple(measure_noise(record, pair) for record in records)
    make: BenchOf = bench or partial(bench_of, campaign)
    rough = Problem(campaign, records, noises, scatter or Scatter(), lambda effects: dataclasses.replace(make(effects), errors=()))
    refuse_magnitudes(campaign, rough.bench(()))
    level = dataclasses.replace(neutral(pair), angle_offset=_zero(rough, progress))
    progress("nuisances", 0, 4)
    found = fit_from(rough, level, ROUGH)
    refuse_mirrored(rough, found)
    explained = (record.value - left for record, left in zip(records, found.left, strict=True))
    noises = tuple(measure_noise(record, pair, part) for record, part in zip(records, explained, strict=True))
    records = marked(records, noises, rough.bench(()), found.settings)
    problem = Problem(campaign, records, noises, scatter or Scatter(terms=TERMS), make)
    # Solid elements for leads, before the work is shared out: what children compute is lost with them.
    with contextlib.suppress(*UNCOMPUTABLE):
        problem.predict((), problem.unknowns.of(dataclasses.replace(level, errors=(1.0,) * len(problem.bench(()).errors))))
    progress("nuisances", 1, 4)
    level = dataclasses.replace(level, angle_offset=found.settings.angle_offset)
    if has_means(problem):
        alone, shifts = _by_turns(problem, level, found.settings, progress)
        begun = _begun(problem, alone)
        if any(one is not other for one, other in zip(begun, problem.records, strict=True)):
            problem = _of_parts(problem, begun)
            alone, shifts = _by_turns(problem, level, found.settings, progress)
    else:
        met = tuned(problem, problem.prepare((), problem.unknowns.of(level)))
        alone = again(problem, (), problem.fit((), met).point.unknown)
        shifts = _shifts(problem, alone)
        problem.remember(alone)
    progress("nuisances", 4, 4)
    return Comparison(problem=problem, alone=alone, shifts=shifts, records=_compared(problem, alone))


def _begun(problem: Problem, alone: Fit) -> tuple[Measurement, ...]:
    """Return the records, motions that nuisances alone really leave far off begun where the model comes nearest to them.

    As if linear, index errors may do near a resonance what a wrong beginning does: what a fit says it leaves is no measure of that.
    """
    bench = problem.bench(())

    def left(one: Measurement) -> Array:
        gap = one.value - bench.predict(one, alone.settings)
        return np.asarray(gap - gap[one.keep].mean() if one.quantity.free_constant else gap)

    pitch = problem.campaign.setup.pair.pinion.pitch_angle
    expected = [noise.std * math.sqrt(floor) for noise, floor in zip(problem.noises, problem.floor, strict=True)]
    sized = zip(problem.records, expected, strict=True)
    return tuple(
        nearest(one, FAR * size, left(one), left, pitch) if one.quantity.is_motion and not one.erratic else one for one, size in sized
    )


def _of_parts(problem: Problem, records: tuple[Measurement, ...]) -> Problem:
    """Return the problem of records begun otherwise, or of parts of them, whose noise is that of the whole."""
    noises = tuple(
        noise if len(one.axis) == len(other.axis) else noise.over(one)
        for noise, one, other in zip(problem.noises, records, problem.records, strict=True)
    )
    return Problem(problem.campaign, records, noises, problem.unknowns.scatter, problem.make)


def _by_turns(problem: Problem, level: Settings, late: Settings, progress: Progress) -> tuple[Fit, tuple[Shift, ...]]:
    """Return the fit of the nuisances, from a level on and the index errors of a rough fit, and where they went."""
    fit = None
    late = level.with_teeth_of(late)
    for number in range(TURNS):
        progress("nuisances", 2 + number, 2 + TURNS)
        mean = averaged(problem, late)
        fit = _of_means(mean, level) if fit is None else again(mean, (), mean.unknowns.of(fit.settings))
        _, single = teeth_under(problem, fit.settings, (), of_teeth(problem))
        late = fit.settings.with_teeth_of(single.settings)
    assert fit is not None
    alone = whole(problem, fit, single)
    problem.remember(alone)
    return alone, _shifts(mean, fit)


def _of_means(mean: Problem, level: Settings) -> Fit:
    """Return the fit of the nuisances to means over the pitches, prepared nowhere yet."""
    start = at_rest(mean, level)
    met = tuned(mean, mean.prepare((), mean.unknowns.of(start)))
    alone = again(mean, (), met)
    if not lost(mean, alone) and stays(mean, alone):
        return alone
    other = attempt(mean, (), mean.unknowns.neutral(alone.point.unknown))
    return alone if other is None else min(alone, other, key=lambda fit: fit.objective)


def _zero(problem: Problem, progress: Progress) -> float:
    """Return the angle offset from which slow records, or all over the angle where none is slow, leave least.

    What is missing from all flanks moves the mesh lines by up to half a pitch. Where wear of either gear leaves less from there, though it
    pays for its parameters, the zero is the one under wear: index errors, free in these fits, would be wrong under another one.
    """
    if "angle_offset" not in problem.unknowns.places:
        return 0.0
    setup, over = problem.campaign.setup, [i for i, record in enumerate(problem.records) if record.quantity.axis == "angle"]
    few = part_of(problem, [i for i in over if not problem.records[i].quantity.moving] or over)
    worn = [(ProfileWear.example(setup, member),) for member in MEMBERS]

    best = min(from_zeros(few, GUESSED), key=_paid, default=None)
    if best is None:
        # What is fitted next says why.
        return 0.0
    zero, begun = best.settings.angle_offset, [best]
    for number, effects in enumerate(worn):
        progress("angle zero", number, len(worn))
        # Worn flanks that cannot be computed tell nothing of the zero.
        with contextlib.suppress(*UNCOMPUTABLE):
            from_elsewhere = from_zeros(few, ROUGH, effects, lambda other: _apart(other, zero, setup.pair) > VALLEY)
            begun += [fit for fit in from_elsewhere if _paid(fit) < _paid(best)]
    if len(begun) > 1:
        # A fit of fewer rounds, without wear, may have further to go.
        led = side_by_side(lambda fit: attempt(few, fit.effects, fit.point.stood), begun)
        best = min([best, *filter(None, led)], key=_paid)
    progress("angle zero", len(worn), len(worn))
    return best.settings.angle_offset


def _paid(fit: Fit) -> float:
    """Return the objective of a fit, and what the parameters of its effects cost."""
    return fit.objective + PARAMETER * sum(len(effect.parameters()) for effect in fit.effects)


def _apart(one: float, other: float, pair: GearPair) -> float:
    """Return how far two zeros of the pinion angle are apart, in pitches: half of one at most."""
    pitches = (one - other) / pair.pinion.pitch_angle
    return abs(pitches - round(pitches))


# ---- what is handed on ----------------------------------------------------------------------------------


def _shifts(problem: Problem, alone: Fit) -> tuple[Shift, ...]:
    """Return where the outer nuisances went."""
    deviations = problem.whole.weighed(alone.point.weights).deviations
    deviations = deviations[len(deviations) - problem.outer :]
    out = []
    for nuisance, moved, deviation in zip(problem.nuisances, alone.point.unknown, deviations, strict=False):
        value = nuisance.value(float(moved))
        stderr = float(deviation) * nuisance.prior * (value if nuisance.is_scale else 1.0)
        out.append(
            Shift(name=nuisance.name, words=nuisance.words, value=value, stderr=stderr, prior=nuisance.prior, deviations=float(moved))
        )
    return tuple(out)


def _compared(problem: Problem, alone: Fit) -> tuple[Compared, ...]:
    """Return the records beside the model as its owner believes it, and beside the fit."""
    believed = dataclasses.replace(neutral(problem.campaign.setup.pair), angle_offset=alone.settings.angle_offset)
    nominal = problem.predict((), problem.unknowns.of(believed))
    out = []
    for i, record in enumerate(problem.records):
        before = record.value - nominal[i]
        offset = problem.unknowns.constant(i, alone.point.unknown)
        out.append(
            Compared(
                measurement=record,
                noise=problem.noises[i],
                before=before - before[record.keep].mean() if record.quantity.free_constant else before,
                after=alone.left[i],
                scatter=record.value - alone.point.predicted[i] - alone.left[i] - offset,
                offset=offset,
            )
        )
    return tuple(out)
