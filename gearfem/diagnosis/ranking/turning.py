"""Effects that come with the turns of a shaft: the orders, phases and strengths at which they would explain most."""

from __future__ import annotations

import contextlib
import dataclasses
import math

import numpy as np

from gearfem.diagnosis.ranking.candidate import View
from gearfem.diagnosis.ranking.shapes import bounded
from gearfem.diagnosis.ranking.standing_out import standing_out
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE

# Orders that are tried where an effect has one, and the strength at which responses count as linear, in typical ones.
ORDERS, PROBE = tuple(float(order) for order in range(1, 11)), 0.1
# Multiples of their strengths at which orders are looked at as they stand: where flanks part, the linear ones fall short.
MULTIPLES = (1.0, 2.0)


def turns(effect: Effect) -> bool:
    """Return whether an effect is a wave over the turns of a shaft, with a strength and a phase."""
    return effect.repeats == "once a turn" and len(effect.strengths()) == 1 and len(_phases(effect)) == 1


def turned(view: View, start: Effect) -> list[Effect]:
    """Return an effect that `turns` at the orders, phases and strengths that would explain most; the best order first.

    Parameters
    ----------
    view : View
        Records beside a fit. All of them are used: slow ones are nearly blind to a torque that swings.
    start : Effect
        At its typical strength.

    Returns
    -------
    list of Effect
        At most two orders, each at two strengths; none where no record feels it, or all orders explain about as much.

    Notes
    -----
    A wave of phase p is cos p times that of phase 0 plus sin p times that of a quarter turn later: two predictions at a strength that is
    small enough to be linear give the phase and the strength that lower the objective most.
    """
    found = []
    for order in _orders(start):
        with contextlib.suppress(*UNCOMPUTABLE):
            found.append(_wave(view, order))
    setup = view.problem.campaign.setup
    # Motions whose flanks part take another branch for a wave of any order.
    likeliest = [found[place][1] for place in standing_out(np.array([gain for gain, _ in found]))]
    return [bounded(effect.scaled(multiple, setup), setup) for effect in likeliest for multiple in MULTIPLES]


def _orders(start: Effect) -> list[Effect]:
    """Return the effect at every order that is tried; itself where it has none."""
    fields = [field for field, known in start.parameters().items() if known.whole]
    return [dataclasses.replace(start, **{fields[0]: order}) for order in ORDERS] if fields else [start]


def _wave(view: View, effect: Effect) -> tuple[float, Effect]:
    """Return by how much a wave would lower the objective, and it at the phase and the strength that do."""
    problem, point = view.problem, view.base.point
    (phase,) = _phases(effect)
    small = effect.scaled(PROBE, problem.campaign.setup)
    responses = []
    for quarter in (0.0, 0.5 * math.pi):
        effects = (*point.effects, dataclasses.replace(small, **{phase: quarter}))
        responses.append(problem.change(point, effects, point.stood))
    gram, pull = view.freed(np.column_stack(responses))
    along, across = np.linalg.lstsq(gram, pull, rcond=1e-9)[0]
    strength, angle = PROBE * math.hypot(along, across), math.atan2(across, along)
    best = dataclasses.replace(effect, **{phase: angle}).scaled(strength, problem.campaign.setup)
    return float(pull @ (along, across)), best


def _phases(effect: Effect) -> list[str]:
    return [field for field, known in effect.parameters().items() if known.neutral is None and known.unit == "rad"]
