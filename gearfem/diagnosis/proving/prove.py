"""Prove a fit: frozen, it has to foretell records that nobody has looked at."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from gearfem.definition.setup import Setup
from gearfem.diagnosis.comparing.branches import FAR, nearest
from gearfem.diagnosis.comparing.erratic import erratic
from gearfem.diagnosis.fitting import parameters
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.bench import Settings, neutral
from gearfem.diagnosis.modelling.calibrate import Left, calibrated, left_of
from gearfem.diagnosis.modelling.largest import at_peaks, expected
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.modelling.teeth import tooth_columns
from gearfem.diagnosis.proving.proof import Gap, Proof, judged
from gearfem.diagnosis.proving.smooth import Smooth, fit_smooth
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.noise import Noise, measure_noise
from gearfem.foundation import UNCOMPUTABLE, Array
from gearfem.foundation.progress import Progress, quiet
from gearfem.sensing import System


def prove(problem: Problem, fit: Fit, alone: Fit, progress: Progress = quiet) -> Proof:
    """Open the hold-out records and compare them with a fit that stays as it is.

    Parameters
    ----------
    problem : Problem
        Of the records that were fitted.
    fit : Fit
        Named effects and nuisances.
    alone : Fit
        Nuisances alone; or a part of the effects, to ask what the others do beside these.
    progress : Progress
        Told after each record.

    Returns
    -------
    Proof

    Raises
    ------
    InputError, SolveError
        If a record that was fitted cannot be computed with what was fitted; of others this is said.

    Notes
    -----
    On each record, of either role, only what it leaves unknown is fitted: its constant, its first tooth where that is unknown, and, held
    out, which of several steady motions it shows, see `nearest`; one that was fitted begins as it was fitted. Erratic motions say nothing
    for or against a name. The floor is noise and
    waviness of single teeth as the fit has it, its own uncertainty included. A record held out counts by that floor and by how well the
    parameters of the named effects foretell it: near a resonance a small doubt about one changes all.
    """
    campaign = problem.campaign
    believed = dataclasses.replace(neutral(campaign.setup.pair), angle_offset=fit.settings.angle_offset)
    setup, bench = campaign.setup, problem.bench(fit.effects)
    systems = (calibrated(setup, believed), calibrated(setup, alone.settings, alone.effects), calibrated(setup, fit.settings, fit.effects))
    floor_of = partial(_floor, problem, fit, bench, waviness=_waviness(problem, fit))
    fitted = {record.file: (record, noise) for record, noise in zip(problem.records, problem.noises, strict=True)}
    drafts, missed = [], []
    for number, record in enumerate(campaign.records):
        progress("proof", number, len(campaign.records))
        try:
            own, noise = fitted.get(record.file, (record, None))
            drafts.append(_draft(own, noise, systems, bench, fit.settings, floor_of))
        except UNCOMPUTABLE as error:
            if record.file in fitted:
                raise
            missed.append(f"{record.file} is left out of the proof: the model has no such record where it was taken ({error}).")
    progress("proof", len(campaign.records), len(campaign.records))
    corrections = _corrections(problem, alone, {record.file: parts[1][0] for record, _, _, parts in drafts})
    gaps = []
    for record, noise_rms, floor, (before, nuisances_only, after) in drafts:
        gaps.append(
            Gap(
                measurement=record,
                before=before[0],
                nuisances_only=nuisances_only[0],
                smooth=_smooth(record, nuisances_only[0], corrections),
                after=after[0],
                offset=after[1],
                first_tooth=after[2],
                noise_rms=noise_rms,
                floor_rms=floor,
                doubt_rms=_parametric(record, fit, setup, after[0]) if record.proves else 0.0,
            )
        )
    proof = judged(tuple(gaps), bool(fit.effects))
    return dataclasses.replace(proof, reasons=(*proof.reasons, *missed))


def _draft(
    record: Measurement,
    noise: Noise | None,
    systems: tuple[System, ...],
    bench: SystemBench,
    settings: Settings,
    floor_of: Callable[..., float],
) -> tuple[Measurement, float, float, list[Left]]:
    """Return a record of the campaign, its noise, which is measured where it is not known, its floor, and what each system leaves of it."""
    parts = [left_of(record, system) for system in systems]
    if noise is None:
        noise = measure_noise(record, bench.pair, record.value - parts[-1][0])
        record = dataclasses.replace(record, erratic=erratic(record, noise, bench, settings))
    record, floor, parts = _met(record, partial(floor_of, noise=noise), parts, systems)
    return record, noise.std, floor, parts


def _met(
    record: Measurement, floor_of: Callable[[Measurement], float], parts: list[Left], systems: tuple[System, ...]
) -> tuple[Measurement, float, list[Left]]:
    """Return a record, its floor and what systems leave of it: one held out as each comes nearest, and as the last does."""
    floor = floor_of(record)
    if not record.proves:
        return record, floor, parts
    begun = [_begun(record, floor, part, system) for part, system in zip(parts, systems, strict=True)]
    last = begun[-1][0]
    return last, floor if last is record else floor_of(last), [part for _, part in begun]


def _begun(record: Measurement, floor: float, part: Left, system: System) -> tuple[Measurement, Left]:
    """Return a record begun where a frozen model comes nearest to it, and what this leaves of it then."""
    one = nearest(record, FAR * floor, part[0], lambda other: left_of(other, system)[0])
    return one, part if one is record else left_of(one, system)


def _parametric(record: Measurement, fit: Fit, setup: Setup, left: Array) -> float:
    """Return the root mean square of what one deviation of each parameter of a fit does to what it leaves of a record, (n,), together."""
    values, (low, high) = parameters.values(fit.effects), parameters.bounds(fit.effects, setup)
    deviations = np.array([one for several in fit.deviations for one in several.values()])
    total = 0.0
    for place in np.flatnonzero(np.isfinite(deviations)):
        squares = []
        for step in (deviations[place], -deviations[place]):
            ahead = values.copy()
            ahead[place] = min(max(values[place] + step, low[place]), high[place])
            # What cannot be computed so far off says nothing of the doubt.
            with contextlib.suppress(*UNCOMPUTABLE):
                moved = left_of(record, calibrated(setup, fit.settings, parameters.moved(fit.effects, ahead)))[0]
                squares.append(float(np.mean((moved - left)[record.keep] ** 2)))
        total += sum(squares) / max(len(squares), 1)
    return math.sqrt(total)


def _corrections(problem: Problem, alone: Fit, left: Mapping[str, Array]) -> Mapping[str, Smooth]:
    own = tuple(left[record.file] for record in problem.records)
    return fit_smooth(problem.records, problem.noises, own, problem.campaign.setup.pair, alone.settings.angle_offset)


def _smooth(record: Measurement, left: Array, corrections: Mapping[str, Smooth]) -> Array:
    if record.quantity.name not in corrections:
        return np.empty(0)
    gap = left - corrections[record.quantity.name].at(record)
    return np.asarray(gap - (gap[record.keep].mean() if record.quantity.free_constant else 0.0))


def _waviness(problem: Problem, fit: Fit) -> tuple[Array, Array]:
    """Return the waviness of all teeth as the fit has it, in prior deviations, and a factor F of its covariance F F'."""
    unknowns, linear = problem.unknowns, problem.beside(fit.effects).linear.weighed(fit.point.weights)
    return fit.point.unknown[unknowns.wavy], linear.root[unknowns.wavy - unknowns.outer]


def _floor(problem: Problem, fit: Fit, bench: SystemBench, record: Measurement, noise: Noise, waviness: tuple[Array, Array]) -> float:
    """Return what remains of a record under a model that is right: noise, and the waviness that the fit finds, its doubt included."""
    unknowns = problem.unknowns
    if record.quantity.name == "dynamic_factor":
        rise = at_peaks(record, bench, fit.settings, unknowns.scatter)[1] * expected(fit.point.unknown[-1])
        return math.hypot(noise.std, record.rms(rise))
    columns = tooth_columns(record, bench, fit.settings, unknowns.scatter) * unknowns.teeth
    columns = columns[:, unknowns.wavy - unknowns.first_tooth][record.keep]
    if record.quantity.free_constant:
        columns = columns - columns.mean(axis=0)
    waves, doubt = columns @ waviness[0], columns @ waviness[1]
    return math.sqrt(noise.std**2 + float(np.mean(waves**2) + np.mean((doubt**2).sum(axis=1))))
