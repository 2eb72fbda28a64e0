"""The teeth on which an effect of one tooth would explain most."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from gearfem.definition.setup import GearPair, Member, Setup
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.bench import neutral
from gearfem.diagnosis.ranking.one_flank import likeliest_flanks
from gearfem.diagnosis.ranking.shapes import bounded, placed
from gearfem.diagnosis.ranking.standing_out import standing_out
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, Array

# Angles to the pitch at which the response of a tooth is taken before it is moved.
PER_PITCH = 48
# Places between root and tip at which something narrow is tried, and those about each to which what is felt of it is moved along.
PLACES, ASIDE = 8, 6
# Teeth on either side that an effect of one tooth reaches.
ASIDE_TEETH = 1


def starts_of(problem: Problem, base: Fit, kind: type[Effect], member: Member) -> list[Effect]:
    """Return the typical effect, on the likeliest teeth where it acts on one, and where it is likeliest on the flank of each.

    What takes metal from one flank is sought twice: shallow, as teeth stand, and as deep as it is typically, as if teeth were even. Under a
    deep hollow a tooth bears nothing, which no slope foretells.
    """
    first = kind.example(problem.campaign.setup, member)
    if not hasattr(first, "tooth"):
        return [first]
    found = likeliest_flanks(problem, base, first) if first.stage == "flank" else []
    shallow = [found[tooth][1] for tooth in standing_out(np.array([gain for gain, _ in found]), ASIDE_TEETH)] if found else []
    try:
        bare = _over_a_turn(problem, base, base.effects, member)
    except UNCOMPUTABLE:
        return shallow
    likeliest: dict[int, tuple[float, Effect]] = {}
    for here, moved, later in _places(first, problem.campaign.setup):
        on_first = dataclasses.replace(here, tooth=0)  # type: ignore[call-arg]
        try:
            turn = _over_a_turn(problem, base, (*base.effects, on_first), member)
        except UNCOMPUTABLE:
            # As in a search: what cannot be computed at a place explains nothing there.
            continue
        for effect, gains in zip(moved, _tooth_gains(problem, base, member, turn, bare, later), strict=True):
            for tooth, gain in enumerate(gains.tolist()):
                if gain >= likeliest.get(tooth, (0.0, first))[0]:
                    likeliest[tooth] = gain, dataclasses.replace(effect, tooth=tooth)  # type: ignore[call-arg]
    gains = np.array([likeliest[tooth][0] for tooth in range(len(likeliest))])
    return [*shallow, *(likeliest[tooth][1] for tooth in standing_out(gains, ASIDE_TEETH))]


def _places(effect: Effect, setup: Setup) -> Iterator[tuple[Effect, list[Effect], Array]]:
    """Yield an effect at places from root to tip, others up and down the flank from each, and by how much later these are felt [rad].

    The effect itself, not later, where it has no place.
    """
    fields = [field for field, known in effect.parameters().items() if known.place]
    if not fields:
        yield effect, [effect], np.zeros(1)
        return
    (field,) = fields
    low, high = effect.parameters()[field].bounds(setup, effect.member)
    forward = (1.0 if effect.member == "pinion" else -1.0) / setup.pair.pinion.base_radius
    aside = ((np.arange(ASIDE) + 0.5) / ASIDE - 0.5) * (high - low) / PLACES
    for here in placed(effect, setup, PLACES):
        yield here, [dataclasses.replace(here, **{field: getattr(here, field) + by}) for by in aside.tolist()], forward * aside


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
    tooth, *_ = (*standing_out((late - usual) ** 2, ASIDE_TEETH), -1)
    if tooth < 0:
        return []
    first = dataclasses.replace(kind.example(setup, member), tooth=tooth)  # type: ignore[call-arg]
    share = (float(late[tooth]) - usual) / getattr(first, first.strengths()[0])
    without = late.copy()
    without[tooth] = usual
    both = dataclasses.replace(base.settings, **{f"{member}_late": without})  # type: ignore[arg-type]
    unknown = base.point.unknown.copy()
    unknown[problem.unknowns.late] = problem.unknowns.of(both)[problem.unknowns.late]
    return [(bounded(first.scaled(share, setup), setup), unknown)]


def _over_a_turn(problem: Problem, base: Fit, effects: tuple[Effect, ...], member: Member) -> list[Array | None]:
    """Return what records would read over one turn of a gear under effects, its teeth even; None for those that are not used.

    Slow records are used where there are any.
    """
    pair = problem.campaign.setup.pair
    over = [record.quantity.axis == "angle" for record in problem.records]
    slow = [angle and not record.quantity.moving for angle, record in zip(over, problem.records, strict=True)]
    used = slow if any(slow) else over
    settings = dataclasses.replace(base.settings, angle_offset=0.0).with_teeth_of(neutral(pair))
    bench, grid = problem.bench(effects), _grid(pair, member)
    return [bench.predict(record.over(grid), settings) if wanted else None for record, wanted in zip(problem.records, used, strict=True)]


def _grid(pair: GearPair, member: Member) -> Array:
    """Return pinion angles over one turn of a gear, both ends included [rad]."""
    return np.arange(pair.gear(member).teeth * PER_PITCH + 1) / PER_PITCH * pair.pinion.pitch_angle


def _tooth_gains(problem: Problem, base: Fit, member: Member, turn: list[Array | None], bare: list[Array | None], later: Array) -> Array:
    """Return by how much an effect would lower the objective on each tooth of its gear, if the response were linear.

    Parameters
    ----------
    problem, base : Problem, Fit
        As for `rank`.
    member : {"pinion", "wheel"}
        Its gear.
    turn, bare : list of ndarray, shape (g,), or None
        From `_over_a_turn`, with the effect on tooth 0 and without it.
    later : ndarray, shape (s,)
        Turns of the pinion [rad] by which it may come later than it does.

    Returns
    -------
    ndarray, shape (s, z)

    Notes
    -----
    Teeth are alike but for their scatter: the response of tooth k is that of tooth 0 k pitches later.
    """
    grid = _grid(problem.campaign.setup.pair, member)
    late = (later[:, None] + grid[:-1:PER_PITCH]).ravel()
    series = []
    for record, with_it, without in zip(problem.records, turn, bare, strict=True):
        if with_it is None or without is None:
            series.append(np.zeros((len(record.axis), late.size)))
            continue
        place = (record.axis + base.settings.angle_offset)[:, None] - late
        series.append(np.interp(place % grid[-1], grid, with_it - without))
    gram, pull = problem.freed(base.point)(problem.whiten(tuple(series)))
    freed = np.diag(gram)
    gains = np.where(freed > 0.0, pull**2 / np.maximum(freed, 1e-300), 0.0)
    return np.asarray(gains.reshape(later.size, -1))
