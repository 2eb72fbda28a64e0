"""Compiled loops of the errors of single teeth: what they weigh, and how a motion responds; imported when the first one is needed."""

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
    """Write the response out (n, k) to errors and rates (n, k), by Newmark's mean acceleration: see `teeth.respond`.

    Matrices are of the train's c coordinates: springs and solved (n, c, c), dampers (c, c); by_force, touch, by_place and by_rate (c,).
    """
    length, width = errors.shape
    count = touch.shape[0]
    place, rate, pull = np.zeros((count, width)), np.zeros((count, width)), np.zeros((count, width))
    ahead, faster, push = np.zeros((count, width)), np.zeros((count, width)), np.zeros((count, width))
    load = np.empty(width)
    half, quarter = 0.5 * step, 0.25 * step * step
    place[0] = errors[0]
    for number in range(length):
        stiff = stiffness[number]
        for k in range(width):
            load[k] = -(stiff * errors[number, k] + damp * rates[number, k])
        if number:
            for a in range(count):
                for k in range(width):
                    ahead[a, k] = place[a, k] + step * rate[a, k] + quarter * pull[a, k]
                    faster[a, k] = rate[a, k] + half * pull[a, k]
            for a in range(count):
                own = by_force[a]
                for k in range(width):
                    push[a, k] = own * load[k]
                for b in range(count):
                    spring, damper = springs[number, a, b], dampers[a, b]
                    for k in range(width):
                        push[a, k] += spring * ahead[b, k] + damper * faster[b, k]
            for a in range(count):
                pull[a] = 0.0
                for b in range(count):
                    share = solved[number, a, b]
                    for k in range(width):
                        pull[a, k] += share * push[b, k]
                for k in range(width):
                    place[a, k] = ahead[a, k] + quarter * pull[a, k]
                    rate[a, k] = faster[a, k] + half * pull[a, k]
        if not acceleration:
            out[number] = place[0]
            continue
        for a in range(count):
            own = touch[a]
            for k in range(width):
                load[k] += own * (stiff * place[a, k] + damp * rate[a, k])
        own = by_force[count]
        for k in range(width):
            out[number, k] = own * load[k]
        for a in range(count):
            spring, damper = by_place[a], by_rate[a]
            for k in range(width):
                out[number, k] += spring * place[a, k] + damper * rate[a, k]


@compiled
def spread(pairs: Any, pinion: Any, wheel: Any, shapes: Any, teeth: int, others: int, first: int, out: Any) -> None:
    """Add shapes (n, p, s) of pairs (n, p) by the weights of both teeth to those of some teeth from the first on, out (n, t, s)."""
    count = out.shape[1]
    for row in range(pairs.shape[0]):
        for slot in range(pairs.shape[1]):
            one, two = pairs[row, slot] % teeth - first, teeth + pairs[row, slot] % others - first
            if 0 <= one < count:
                for k in range(shapes.shape[2]):
                    out[row, one, k] += pinion[row, slot] * shapes[row, slot, k]
            if 0 <= two < count:
                for k in range(shapes.shape[2]):
                    out[row, two, k] += wheel[row, slot] * shapes[row, slot, k]
