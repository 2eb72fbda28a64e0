"""The teeth on which an effect of one tooth would explain most."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.definition.setup import Member
from gearfem.diagnosis.fit import Fit
from gearfem.diagnosis.problem import Problem
from gearfem.diagnosis.shapes import bounded
from gearfem.effects.effect import Effect
from gearfem.foundation import Array

# Angles to the pitch at which the response of a tooth is taken before it is moved.
PER_PITCH = 48
# Teeth that are looked at in full, of each effect of one tooth.
TEETH = 2


def starts_of(problem: Problem, base: Fit, kind: type[Effect], member: Member) -> list[Effect]:
    """Return the typical effect, on the likeliest teeth where it acts on one."""
    first = kind.example(problem.campaign.setup, member)
    if not hasattr(first, "tooth"):
        return [first]
    gains = tooth_gains(problem, base, first)
    return [dataclasses.replace(first, tooth=int(tooth)) for tooth in np.argsort(-gains)[:TEETH]]  # type: ignore[call-arg]


def late_tooth(problem: Problem, base: Fit, kind: type[Effect], member: Member) -> list[tuple[Effect, Array]]:
    """Return an effect that displaces one tooth where the index errors of a fit stand out most, and the unknowns without that error.

    Parameters
    ----------
    problem, base : Problem, Fit
        As for `rank`.
    kind, member : type, {"pinion", "wheel"}
        Effect and gear; others than those that place one tooth have none.

    Returns
    -------
    list of (Effect, ndarray of shape (k,))
        One or none.
    """
    if not (kind.stage == "placement" and kind.repeats == "one tooth"):
        return []
    setup, late = problem.campaign.setup, base.settings.pinion_late if member == "pinion" else base.settings.wheel_late
    usual = float(np.median(late))
    tooth = int(np.argmax(np.abs(late - usual)))
    first = dataclasses.replace(kind.example(setup, member), tooth=tooth)  # type: ignore[call-arg]
    share = (float(late[tooth]) - usual) / getattr(first, first.strengths()[0])
    without = late.copy()
    without[tooth] = usual
    both = dataclasses.replace(base.settings, **{f"{member}_late": without})  # type: ignore[arg-type]
    unknown = base.point.unknown.copy()
    unknown[problem.unknowns.late] = problem.unknowns.of(both)[problem.unknowns.late]
    return [(bounded(first.scaled(share, setup), setup), unknown)]


def tooth_gains(problem: Problem, base: Fit, effect: Effect) -> Array:
    """Return by how much an effect would lower the objective on each tooth of its gear, if the response were linear.

    Parameters
    ----------
    problem, base : Problem, Fit
        As for `rank`.
    effect : Effect
        On any tooth.

    Returns
    -------
    ndarray, shape (z,)

    Notes
    -----
    Teeth are alike but for their scatter: the response of tooth k is that of tooth 0 k pitches later. It is computed once, over one
    turn of the gear, and moved. Slow records are used where there are any.
    """
    pair = problem.campaign.setup.pair
    pitch = pair.pinion.pitch_angle
    teeth = pair.pinion.teeth if effect.member == "pinion" else pair.wheel.teeth
    over = [record.quantity.axis == "angle" for record in problem.records]
    slow = [angle and not record.quantity.moving for angle, record in zip(over, problem.records, strict=True)]
    used = slow if any(slow) else over
    settings = dataclasses.replace(
        base.settings, angle_offset=0.0, pinion_late=np.zeros(pair.pinion.teeth), wheel_late=np.zeros(pair.wheel.teeth)
    )
    grid = np.arange(teeth * PER_PITCH + 1) / PER_PITCH * pitch
    benches = [problem.bench(effects) for effects in ((*base.effects, dataclasses.replace(effect, tooth=0)), base.effects)]  # type: ignore[call-arg]
    responses: list[Array | None] = []
    for record, wanted in zip(problem.records, used, strict=True):
        if not wanted:
            responses.append(None)
            continue
        turn = dataclasses.replace(record, axis=grid, value=grid, line=np.arange(len(grid)), keep=np.ones(len(grid), bool))
        responses.append(benches[0].predict(turn, settings) - benches[1].predict(turn, settings))
    series = []
    for record, response in zip(problem.records, responses, strict=True):
        if response is None:
            series.append(np.zeros((len(record.axis), teeth)))
            continue
        later = (record.axis + base.settings.angle_offset)[:, None] - np.arange(teeth) * pitch
        series.append(np.interp(later % (teeth * pitch), grid, response))
    signatures = problem.whiten(tuple(series))
    gram, pull = problem.freed(base.point)(signatures)
    freed = np.diag(gram)
    return np.asarray(np.where(freed > 0.0, pull**2 / np.maximum(freed, 1e-300), 0.0))
