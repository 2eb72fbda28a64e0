"""Compiled loop of the response of a motion to the errors of single teeth; imported when the first one is followed."""

from __future__ import annotations

from typing import Any

import numpy as np

from gearfem.engagement.turn_kernels import compiled


@compiled
def follow(
    errors: Any,
    rates: Any,
    stiffness: Any,
    damp: float,
    springs: Any,
    dampers: Any,
    solved: Any,
    by_force: Any,
    touch: Any,
    by_place: Any,
    by_rate: Any,
    step: float,
    acceleration: bool,
    out: Any,
) -> None:
    """Write the response out (n, k) to errors and rates (n, k), by Newmark's mean acceleration: see `gearfem.diagnosis.teeth.respond`.

    Matrices are of the train's c coordinates: springs and solved (n, c, c), dampers (c, c); by_force, touch, by_place and by_rate (c,).
    """
    length, width = errors.shape
    count = touch.shape[0]
    place, rate, pull = np.zeros((count, width)), np.zeros((count, width)), np.zeros((count, width))
    ahead, faster, push = np.zeros((count, width)), np.zeros((count, width)), np.zeros((count, width))
    load, force = np.empty(width), np.empty(width)
    half, quarter = 0.5 * step, 0.25 * step * step
    place[0] = errors[0]
    for number in range(length):
        load[:] = -(stiffness[number] * errors[number] + damp * rates[number])
        if number:
            for a in range(count):
                ahead[a] = place[a] + step * rate[a] + quarter * pull[a]
                faster[a] = rate[a] + half * pull[a]
            for a in range(count):
                push[a] = by_force[a] * load
                for b in range(count):
                    push[a] += springs[number, a, b] * ahead[b] + dampers[a, b] * faster[b]
            for a in range(count):
                pull[a] = 0.0
                for b in range(count):
                    pull[a] += solved[number, a, b] * push[b]
                place[a] = ahead[a] + quarter * pull[a]
                rate[a] = faster[a] + half * pull[a]
        if not acceleration:
            out[number] = place[0]
            continue
        force[:] = load
        for a in range(count):
            force += touch[a] * (stiffness[number] * place[a] + damp * rate[a])
        out[number] = by_force[count] * force
        for a in range(count):
            out[number] += by_place[a] * place[a] + by_rate[a] * rate[a]
