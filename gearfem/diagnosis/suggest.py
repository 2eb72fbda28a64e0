"""Suggest the measurement that would tell explanations apart."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable

import numpy as np

from gearfem.definition.setup import Member
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.marginal import marginal
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.columns import as_columns, error_columns
from gearfem.diagnosis.modelling.model_form import error_slope
from gearfem.diagnosis.modelling.nuisances import BUILD, MOVING, SCALES, slope
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.reading.measurement import Measurement, make_record
from gearfem.diagnosis.reading.periods import hunting_period
from gearfem.effects.effect import MEMBERS, Effect
from gearfem.effects.roll import active_flank
from gearfem.foundation import UNCOMPUTABLE, Array, Record
from gearfem.foundation.progress import Progress, quiet
from gearfem.foundation.units import RPM, UM

# A constant that is not known at all [m], against deviations of micrometres.
FREE = 1e-2
# What instruments resolve where the campaign holds none of their kind: indicators and flank traces; stiffness in parts of itself.
INDICATOR, STIFFNESS = 0.5 * UM, 0.02
SAMPLES, TURNS = 12, 2.0
# Part by which the amount of each explanation may still move: what fits the records taken does so within a range.
AMOUNT = 0.05
# Torques tried, in parts of the rated one, and speeds in parts of the one at which the mesh meets its resonance.
TORQUES, SPEEDS = (0.05, 0.3, 0.6, 1.0), ((0.6, 1.4), (0.85, 1.2))
TAKEN = 1.3
# What is read as an angle by the same instrument.
ERRORS = ("static_transmission_error", "dynamic_transmission_error")
# Standard deviations by which two explanations are told apart, and beyond which any measurement decides: the cheaper one wins then.
TOLD, ENOUGH = 3.0, 20.0


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Plan(Record):
    """A measurement that might be taken.

    Parameters
    ----------
    words : str
        What is measured.
    records : tuple of Measurement
        Its records, values left at 0.
    cost : float
        Against one slow record of a few turns.
    """

    words: str
    records: tuple[Measurement, ...]
    cost: float


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Suggestion(Record):
    """A measurement and what it would tell.

    Parameters
    ----------
    words : str
        What is measured.
    separation : float
        Least distance of two explanations in it, in standard deviations, with all freed that may imitate it.
    told : str
        What it would tell, in words.
    cost : float
        Against one slow record of a few turns.
    """

    words: str
    separation: float
    told: str
    cost: float

    @property
    def sentence(self) -> str:
        """The same in words."""
        return f"Measure {self.words}: {self.told}."


def suggest(problem: Problem, fit: Fit, rivals: Iterable[tuple[Effect, ...]], progress: Progress = quiet) -> tuple[Suggestion, ...]:
    """Rank measurements not yet taken by how far they drive explanations apart for their cost.

    Parameters
    ----------
    problem : Problem
        Of the records that could not decide.
    fit : Fit
        The explanation that was chosen, and the nuisances.
    rivals : iterable of tuple of Effect
        The other ones, as fitted.
    progress : Progress
        Told after each measurement.

    Returns
    -------
    tuple of Suggestion
        The best first.

    Notes
    -----
    Of several pairs of explanations the mean of their distances counts, each up to 20: where two of them can be told apart by nothing, a
    measurement that decides between the others is worth as much as before. The distance of two predictions d is
    sqrt(d' (S + A A')^-1 d): S holds the noise, A the derivatives over the constant, the nuisances, the errors of single teeth and of
    our own model, each times its prior deviation, and a twentieth of each explanation itself, so that only what these cannot imitate
    counts.
    """
    explanations = [fit.effects, *list(rivals)[:4]]
    plans = _plans(problem, fit, explanations)
    found = []
    for number, plan in enumerate(plans):
        progress("what to measure next", number, len(plans))
        try:
            apart = _apart(problem, fit, plan, explanations)
        except UNCOMPUTABLE:
            continue
        worth = float(np.minimum(apart, ENOUGH).mean()) / plan.cost
        found.append((worth, Suggestion(words=plan.words, separation=float(apart.min()), told=_told(apart), cost=plan.cost)))
    progress("what to measure next", len(plans), len(plans))
    return tuple(one for _, one in sorted(found, key=lambda both: -both[0]))


def _told(apart: Array) -> str:
    """Return what a measurement would tell in words, from the distances of all pairs of explanations in it, shape (q,)."""
    if apart.min() >= TOLD or len(apart) == 1:
        return f"the explanations then differ by at least {apart.min():.1f} standard deviations"
    return f"{np.count_nonzero(apart >= TOLD)} of {len(apart)} pairs of explanations then differ by {TOLD:g} standard deviations or more"


def _apart(problem: Problem, fit: Fit, plan: Plan, explanations: list[tuple[Effect, ...]]) -> Array:
    """Return the distances of all pairs of explanations in a measurement, in standard deviations, shape (q,)."""
    benches = [problem.bench(effects) for effects in explanations]
    plain = problem.bench(())
    pairs = list(itertools.combinations(range(len(benches)), 2))
    squares = np.zeros(len(pairs))
    for record in plan.records:
        predictions = [bench.predict(record, fit.settings) for bench in benches]
        noise = record.noise_std or STIFFNESS * float(np.mean(predictions[0]))
        without = plain.predict(record, fit.settings)
        strengths = np.column_stack([AMOUNT * (prediction - without) for prediction in predictions])
        freed = np.concatenate([_nuisances(problem, fit, record, benches[0], predictions[0]), strengths], axis=1)
        imitated = marginal((freed / noise,))
        for place, (i, j) in enumerate(pairs):
            difference = (predictions[i] - predictions[j]) / noise
            squares[place] += float(imitated.measure(difference[:, None], difference)[1][0])
    return np.sqrt(np.maximum(squares, 0.0))


def _nuisances(problem: Problem, fit: Fit, record: Measurement, bench: SystemBench, predicted: Array) -> Array:
    """Return what a constant, nuisances, errors of single teeth and of our own model do to a record, at one deviation each."""
    own = problem.unknowns.places
    known = (*problem.nuisances, *(nuisance for nuisance in (*SCALES, *BUILD, *MOVING) if nuisance.name not in own))
    moved = [float(fit.point.unknown[own[nuisance.name]]) if nuisance.name in own else 0.0 for nuisance in known]
    constant = np.full((len(record.axis), 1), FREE if record.quantity.free_constant else 0.0)
    variants, settings = problem.unknowns.errors, fit.settings
    wrong = as_columns([error_slope(record, bench, settings, predicted, variants, place) for place in range(len(variants))], predicted)
    errors = error_columns(record, bench, settings, problem.unknowns.scatter, predicted, variants, wrong)
    scales = [slope(record, bench, settings, nuisance, stands, predicted) for nuisance, stands in zip(known, moved, strict=True)]
    return np.concatenate([constant, as_columns(scales, predicted), errors], axis=1)


# ---- what can be measured -------------------------------------------------------------------------------


def _plans(problem: Problem, fit: Fit, explanations: list[tuple[Effect, ...]]) -> list[Plan]:
    """Return the measurements that the campaign has not taken."""
    setup, records = problem.campaign.setup, problem.campaign.records
    pair, rated = setup.pair, setup.operation.pinion_torque
    own = zip(problem.records, problem.noises, strict=True)
    noise = [one.std for record, one in own if record.quantity.name in ERRORS]
    std = float(np.median(noise)) if noise else 0.3 * UM
    angle = np.arange(round(TURNS * pair.pinion.teeth * SAMPLES)) / SAMPLES * pair.pinion.pitch_angle
    plans = []
    taken = [record.pinion_torque for record in records if record.quantity.name == "static_transmission_error"]
    for share in TORQUES:
        torque = share * rated
        if not any(1.0 / TAKEN < torque / other < TAKEN for other in taken):
            words = f"the slow transmission error at {torque:.3g} N m ({100.0 * share:.0f} % of the rated torque)"
            plans.append(Plan(words=words, records=(_record("static_transmission_error", angle, std, torque=torque),), cost=1.0))
    hunting = round(hunting_period(pair) / (2.0 * math.pi))
    longest = max((float(np.ptp(record.axis)) for record in records if record.quantity.axis == "angle"), default=0.0)
    if longest < 0.9 * hunting * 2.0 * math.pi:
        whole = np.arange(hunting * pair.pinion.teeth * SAMPLES // 2) / (SAMPLES // 2) * pair.pinion.pitch_angle
        words = f"the slow transmission error at {rated:.3g} N m over a whole hunting cycle ({hunting} turns of the pinion)"
        plans.append(Plan(words=words, records=(_record("static_transmission_error", whole, std, torque=rated),), cost=2.0))
    plans.append(
        Plan(words=f"the mesh stiffness at {rated:.3g} N m", records=(_record("mesh_stiffness", angle, None, torque=rated),), cost=2.0)
    )
    return plans + _at_speed(problem, fit, angle, std) + _of_gears(problem, explanations)


def _at_speed(problem: Problem, fit: Fit, angle: Array, std: float) -> list[Plan]:
    setup = problem.campaign.setup
    torque = setup.operation.pinion_torque
    resonance = problem.bench(()).oscillator(torque, fit.settings).frequency / setup.pair.pinion.teeth
    plans = []
    for shares in SPEEDS:
        records = tuple(_record("dynamic_transmission_error", angle, std, torque=torque, speed=share * resonance) for share in shares)
        speeds = " and ".join(f"{share * resonance / RPM:.3g}" for share in shares)
        words = f"the transmission error at {speeds} rpm and {torque:.3g} N m, on both sides of the resonance"
        plans.append(Plan(words=words, records=records, cost=3.0))
    return plans


def _of_gears(problem: Problem, explanations: list[tuple[Effect, ...]]) -> list[Plan]:
    """Return measurements of single gears off the rig: flank traces of the suspected teeth, pitch and runout."""
    setup = problem.campaign.setup
    plans = []
    for member in MEMBERS:
        teeth = setup.pair.gear(member).teeth
        active = active_flank(setup, member)
        roll = np.linspace(active.lowest, active.tip, 61)
        suspects = {getattr(e, "tooth", 0) for effects in explanations for e in effects if e.stage == "flank" and e.member == member}
        for tooth in sorted(suspects or {0}):
            if not _has(problem, "flank_profile", member, tooth):
                words = f"the flank of tooth {tooth} of the {member} (a profile trace)"
                record = _record("flank_profile", roll, INDICATOR, gear=member, tooth=tooth)
                plans.append(Plan(words=words, records=(record,), cost=1.0))
        turned = np.arange(2.0 * teeth)
        for name, words in (("pitch_deviation", "the pitch deviations"), ("radial_runout", "the radial runout")):
            if not _has(problem, name, member, None):
                record = _record(name, turned, INDICATOR, gear=member)
                plans.append(Plan(words=f"{words} of the {member}", records=(record,), cost=1.0))
    return plans


def _has(problem: Problem, name: str, member: Member, tooth: int | None) -> bool:
    return any(r.quantity.name == name and r.gear == member and r.tooth in (tooth, None) for r in problem.campaign.records)


def _record(
    name: str, axis: Array, std: float | None, torque: float = 0.0, speed: float = 0.0, gear: Member | None = None, tooth: int | None = None
) -> Measurement:
    return make_record(name, axis, pinion_torque=torque, pinion_speed=speed, gear=gear, tooth=tooth, noise_std=std)
