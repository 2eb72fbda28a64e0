"""The teeth, and the places on their flanks, where metal missing from one flank would explain most."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from gearfem.definition.setup import Member, Setup
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.teeth import Forms, felt, way_of
from gearfem.diagnosis.ranking.candidate import signed
from gearfem.diagnosis.ranking.shapes import bounded, placed, shapes_of
from gearfem.effects.effect import Effect
from gearfem.flank import Deviation, Flanks, Outline
from gearfem.foundation import Array, InputError

# Places between the lowest contact point and the tip at which something narrow is tried.
PLACES = 12
# Share of what is felt of it that nuisances must leave, or nothing is told.
LEAST = 1e-6


def likeliest_flanks(problem: Problem, base: Fit, first: Effect) -> list[tuple[float, Effect]]:
    """Return for each tooth of a gear by how much an effect of one flank would lower the objective, and where it would do most.

    Parameters
    ----------
    problem, base : Problem, Fit
        As for `rank`.
    first : Effect
        What it is typically.

    Returns
    -------
    list of (float, Effect)
        Tooth by tooth; at the strength that lowers most, were what is felt of it linear about the fit.

    Notes
    -----
    Under light loads errors of single teeth decide which pair bears, so that each tooth is asked with the weights that it has in the fit,
    as for its waviness, in motions as in slow records. A trace of its flank is left out.
    """
    setup, member = problem.campaign.setup, first.member
    bench = problem.bench(base.effects)
    ways = [way_of(record, bench, base.settings) for record in problem.records]
    freed = problem.freed(base.point)
    counts = setup.pair.pinion.teeth, setup.pair.wheel.teeth
    teeth = range(counts[0]) if member == "pinion" else range(counts[0], sum(counts))
    found: list[tuple[float, Effect]] = [(0.0, first)] * len(teeth)
    for shape in shapes_of(first, setup):
        shallow = [(effect, depth) for effect in placed(shape, setup, PLACES) if (depth := missing_from(effect, setup)) is not None]
        if not shallow:
            continue
        forms = on_path([depth for _, depth in shallow], setup, member)
        series = (
            np.zeros((len(record.axis), len(teeth) * len(shallow))) if way is None else felt(record, bench, way, forms, counts, teeth)
            for record, way in zip(problem.records, ways, strict=True)
        )
        felt_so = problem.whiten(tuple(series))
        gram, pull = freed(felt_so)
        square = np.diag(gram)
        helps = (square > LEAST**2 * np.einsum("ij,ij->j", felt_so, felt_so)) & ((pull > 0.0) | signed(first, setup))
        strength = np.divide(pull, square, out=np.zeros_like(pull), where=helps)
        gains, strengths = (part.reshape(len(teeth), -1) for part in (pull * strength, strength))
        for tooth, place in enumerate(np.argmax(gains, axis=1).tolist()):
            if gains[tooth, place] > found[tooth][0]:
                effect = bounded(shallow[place][0].scaled(float(strengths[tooth, place]), setup), setup)
                found[tooth] = float(gains[tooth, place]), dataclasses.replace(effect, tooth=tooth)  # type: ignore[call-arg]
    return found


def missing_from(effect: Effect, setup: Setup) -> Deviation | None:
    """Return what an effect takes from one flank; None if it takes nothing, or cannot be computed and so explains nothing."""
    pair = setup.pair
    designed = Flanks(pinion=Outline(gear=pair.pinion), wheel=Outline(gear=pair.wheel))
    try:
        odd = effect.acted(designed, setup).odd(effect.member)
    except InputError:
        return None
    return next((outline.deviation for outline in odd.values()), None)


def on_path(depths: Sequence[Deviation], setup: Setup, member: Member) -> Forms:
    """Return what is missing from flanks of a gear over the path of contact."""
    pair, upward = setup.pair, 1.0 if member == "pinion" else -1.0
    pitch_point = pair.gear(member).base_radius * math.tan(pair.working_pressure_angle)

    def forms(path: Array, *, derivative: int = 0) -> Array:
        roll = pitch_point + upward * path
        if derivative:
            return np.stack([upward * pair.pinion.base_radius * depth.slope(roll) for depth in depths], axis=-1)
        return np.stack([depth.at(roll) for depth in depths], axis=-1)

    return forms
