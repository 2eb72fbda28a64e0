"""The teeth on which an effect of one tooth would explain most."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.definition.setup import Member
from gearfem.diagnosis.fit import Fit
from gearfem.diagnosis.problem import Problem
from gearfem.diagnosis.shapes import PLACES, bounded, places_of
from gearfem.effects.effect import Effect
from gearfem.foundation import Array

# Angles to the pitch at which the response of a tooth is taken before it is moved.
PER_PITCH = 48
# Places about each one tried to which what is felt of an effect is moved along.
ASIDE = 6
# Teeth that are looked at in full, of each effect of one tooth.
TEETH = 2


def starts_of(problem: Problem, base: Fit, kind: type[Effect], member: Member) -> list[Effect]:
    """Return the typical effect, on the likeliest teeth where it acts on one, and where it is likeliest on the flank of each."""
    setup = problem.campaign.setup
    first = kind.example(setup, member)
    if not hasattr(first, "tooth"):
        return [first]
    likeliest: dict[int, tuple[float, Effect]] = {}
    for here in places_of(first, setup):
        moved, turns = _aside(here, problem)
        for effect, gains in zip(moved, tooth_gains(problem, base, here, turns), strict=True):
            for tooth, gain in enumerate(gains.tolist()):
                if gain >= likeliest.get(tooth, (0.0, first))[0]:
                    likeliest[tooth] = gain, dataclasses.replace(effect, tooth=tooth)  # type: ignore[call-arg]
    return [effect for _, effect in sorted(likeliest.values(), key=lambda item: -item[0])[:TEETH]]


def _aside(effect: Effect, problem: Problem) -> tuple[list[Effect], Array]:
    """Return an effect at places up and down the flank, half way to the next ones tried, and by how much later each is felt [rad].

    The effect itself, not later, where it has no place.
    """
    setup = problem.campaign.setup
    places = [field for field, known in effect.parameters().items() if known.place]
    if not places:
        return [effect], np.zeros(1)
    (place,) = places
    low, high = effect.parameters()[place].bounds(setup, effect.member)
    moved = ((np.arange(ASIDE) + 0.5) / ASIDE - 0.5) * (high - low) / PLACES
    forward = 1.0 if effect.member == "pinion" else -1.0
    others = [dataclasses.replace(effect, **{place: float(getattr(effect, place) + by)}) for by in moved]
    return others, forward * moved / setup.pair.pinion.base_radius


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


def tooth_gains(problem: Problem, base: Fit, effect: Effect, later: Array) -> Array:
    """Return by how much an effect would lower the objective on each tooth of its gear, if the response were linear.

    Parameters
    ----------
    problem, base : Problem, Fit
        As for `rank`.
    effect : Effect
        On any tooth.
    later : ndarray, shape (s,)
        Turns of the pinion [rad] by which it may come later than it does.

    Returns
    -------
    ndarray, shape (s, z)

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
    late, series = (later[:, None] + np.arange(teeth) * pitch).ravel(), []
    for record, response in zip(problem.records, responses, strict=True):
        if response is None:
            series.append(np.zeros((len(record.axis), late.size)))
            continue
        place = (record.axis + base.settings.angle_offset)[:, None] - late
        series.append(np.interp(place % (teeth * pitch), grid, response))
    signatures = problem.whiten(tuple(series))
    gram, pull = problem.freed(base.point)(signatures)
    freed = np.diag(gram)
    gains = np.where(freed > 0.0, pull**2 / np.maximum(freed, 1e-300), 0.0)
    return np.asarray(gains.reshape(later.size, teeth))
