"""Compiled inner loops of the motion over many turns; imported when the first one is stepped, never with gearfem.

Built on the loops of `gearfem.engagement.turn_kernels`; machine code kept on disk does not notice a change of that file alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gearfem.engagement.turn_kernels import (
    ARM1,
    ARM2,
    CELL,
    COLUMNS,
    FORCE,
    FRICTION1,
    FRICTION2,
    GAP_RATE,
    SLIDING,
    compiled,
    couple,
    inlined,
    lay,
    respond,
    shift,
)

ROUNDS, TOLERANCE = 60, 1e-9
# Pitches by which a point stands inside its step, on the right side of a reversal of the sliding.
INSIDE = 1e-9
# Weight of a pitch's moments in the next one's balance, least load that says anything about it, and what no machine swings by [m].
MEMORY, LEAST_LOAD, UNBOUNDED = 0.7, 0.1, 0.1


@inlined
def wave(waves: Any, angle: float) -> tuple[float, float]:
    """Return the sum of waves (amplitude, order, phase) at a pinion angle, and its slope over the angle."""
    value, rate = 0.0, 0.0
    for row in range(waves.shape[0]):
        turned = waves[row, 1] * angle + waves[row, 2]
        value += waves[row, 0] * np.cos(turned)
        rate -= waves[row, 0] * waves[row, 1] * np.sin(turned)
    return value, rate


@inlined
def push(
    e: float,
    v: float,
    common: float,
    common_rate: float,
    speed: float,
    damp: float,
    friction: float,
    width: float,
    stiffness: float,
    play: float,
    base1: float,
    base2: float,
    law: Any,
    lowest: float,
    step: float,
    desk: Any,
    matrix: Any,
    work: Any,
    right: Any,
) -> tuple[float, float, float]:
    """Return the moments of the teeth on pinion and wheel and the force along the line of action; NaN without convergence.

    `speed` is in pitches per second.
    """
    count = desk.shape[0]
    miss = np.inf
    for _ in range(ROUNDS):
        miss = respond(e, law, lowest, step, count, desk, matrix)
        if miss < TOLERANCE:
            break
        shift(0.0, count, desk, matrix, work, right)
        # Newton's method squares its error: after a step as small as this the loads are met.
        if miss < 1e-5:
            break
    else:
        return np.nan, np.nan, np.nan
    force, moment1, moment2, gap_rate = 0.0, 0.0, 0.0, 0.0
    for j in range(count):
        load = desk[j, FORCE] * width
        if load <= 0.0:
            continue
        held = friction * np.sign(desk[j, SLIDING])
        force += load
        moment1 += load * (desk[j, ARM1] + held * desk[j, FRICTION1])
        moment2 += load * (desk[j, ARM2] + held * desk[j, FRICTION2])
        gap_rate += load * (desk[j, GAP_RATE] + common_rate)
    if force > 0.0:
        whole = force + damp * (v - gap_rate / force * speed)
        if whole <= 0.0:
            return 0.0, 0.0, 0.0
        return moment1 * whole / force, moment2 * whole / force, whole
    depth = common - e - play
    if depth > 0.0:
        back = stiffness * depth - damp * (v - common_rate * speed)
        if back > 0.0:
            return -back * base1, -back * base2, -back
    return 0.0, 0.0, 0.0


@inlined
def look(
    q: float,
    e: float,
    v: float,
    fresh: bool,
    first: int,
    pitch: float,
    speed: float,
    damp: float,
    friction: float,
    stiffness: float,
    play: float,
    gaps: Any,
    yielding: float,
    width: float,
    base1: float,
    base2: float,
    turn: float,
    early: float,
    tables: Any,
    late1: Any,
    late2: Any,
    knots: Any,
    bins: Any,
    shape: Any,
    law: Any,
    lowest: float,
    step: float,
    partners: Any,
    cknots: Any,
    cbins: Any,
    coupling: Any,
    desk: Any,
    matrix: Any,
    work: Any,
    right: Any,
) -> tuple[int, float, float, float]:
    """Return the first pair, the teeth's moments on pinion and wheel, and their force; NaN where the loads do not converge.

    `fresh` lays the pairs out anew, at another angle than before; their loads are kept to start from.
    """
    count = desk.shape[0]
    common, rate = wave(gaps, q * pitch)
    if fresh:
        found = lay(q, common, tables, late1, late2, knots, bins, shape, base1, base2, turn, early, count, desk)
        if found != first:
            for slot in range(count):
                right[slot] = desk[slot, FORCE]
            for slot in range(count):
                before = slot + found - first
                desk[slot, FORCE] = right[before] if 0 <= before < count else 0.0
        for slot in range(count):
            if desk[slot, CELL] < 0.0:
                desk[slot, FORCE] = 0.0
        first = found
        couple(q, first, count, partners, cknots, cbins, coupling, yielding * width, desk, matrix)
    m1, m2, force = push(
        e,
        v,
        common,
        rate * pitch,
        speed,
        damp,
        friction,
        width,
        stiffness,
        play,
        base1,
        base2,
        law,
        lowest,
        step,
        desk,
        matrix,
        work,
        right,
    )
    return first, m1, m2, force


@inlined
def between(s: float, h: float, e: float, v: float, a: float, rise: float, end: float, last: float) -> tuple[float, float]:
    """Return position and rate at a share s of a step: the quintic with position, rate and acceleration of both ends."""
    d0, d1, b0, b1 = h * v, h * end, 0.5 * h * h * a, 0.5 * h * h * last
    c3 = 10.0 * rise - 6.0 * d0 - 4.0 * d1 - 3.0 * b0 + b1
    c4 = -15.0 * rise + 8.0 * d0 + 7.0 * d1 + 3.0 * b0 - 2.0 * b1
    c5 = 6.0 * rise - 3.0 * d0 - 3.0 * d1 - b0 + b1
    position = e + s * (d0 + s * (b0 + s * (c3 + s * (c4 + s * c5))))
    return position, (d0 + s * (2.0 * b0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))) / h


@compiled
def march(
    begin: int,
    settling: int,
    steps: int,
    samples: Any,
    state: Any,
    torque1: float,
    torque2: float,
    waves1: Any,
    waves2: Any,
    inertia1: float,
    inertia2: float,
    count: int,
    pitch: float,
    speed: float,
    damp: float,
    friction: float,
    stiffness: float,
    play: float,
    gaps: Any,
    yielding: float,
    width: float,
    base1: float,
    base2: float,
    turn: float,
    early: float,
    tables: Any,
    late1: Any,
    late2: Any,
    knots: Any,
    bins: Any,
    shape: Any,
    law: Any,
    lowest: float,
    step: float,
    partners: Any,
    cknots: Any,
    cbins: Any,
    coupling: Any,
    error: Any,
    acceleration: Any,
    force: Any,
    means: Any,
) -> float:
    """Step from pitch `begin` past the last sample; the wheel torque follows its balance over `settling` pitches, then stays.

    `samples` (n,) are pinion angles in pitches, increasing; `state` (2,) transmission error and its rate at the start; `speed` is in
    pitches per second. Outputs (n,): transmission error [m], psi1'' [rad/s2], normal force [N]; `means` (3,): mean moments on pinion
    and wheel, and share of the steps without contact on the working flank. Returns the wheel torque, NaN where it failed.
    """
    desk, matrix = np.zeros((count, COLUMNS)), np.zeros((count, count))
    work, right = np.zeros((count, count)), np.zeros(count)
    e, v, first, sample, number = state[0], state[1], -(1 << 60), 0, begin
    h = 1.0 / steps / speed
    push1, push2 = base1 / inertia1, base2 / inertia2
    recent1, recent2, moved = 0.0, 0.0, True
    means[:] = 0.0
    while sample < samples.size:
        own1, own2 = 0.0, 0.0
        for part in range(steps):
            q0, q1 = number + part / steps, number + (part + 1) / steps
            es, vs, a, rate, rise, start, touching = e, v, 0.0, 0.0, 0.0, 0.0, True
            # The end of a step is the start of the next, but for the side of a reversal at the pitch point.
            moved = moved or part == 0
            for stage in range(4):
                share = 0.0 if stage == 0 else 0.5 if stage < 3 else 1.0
                weight = 1.0 / 3.0 if 0 < stage < 3 else 1.0 / 6.0
                es, vs = e + share * h * vs, v + share * h * a
                q = min(max(q0 + share * (q1 - q0), q0 + INSIDE), q1 - INSIDE)
                moved = moved or stage % 2 == 1
                # fmt: off
                first, m1, m2, f = look(
                    q, es, vs, moved, first, pitch, speed, damp, friction, stiffness, play, gaps, yielding, width, base1, base2,
                    turn, early, tables, late1, late2, knots, bins, shape, law, lowest, step, partners, cknots, cbins, coupling,
                    desk, matrix, work, right,
                )
                # fmt: on
                t1, t2 = torque1 + wave(waves1, q * pitch)[0], torque2 + wave(waves2, q * pitch)[0]
                a = push1 * (t1 - m1) + push2 * (t2 - m2)
                rise, rate = rise + weight * vs, rate + weight * a
                own1, own2 = own1 + weight * m1, own2 + weight * m2
                moved = False
                if stage == 0:
                    start, touching = a, f > 0.0
            rise, rate = h * rise, h * rate
            if not abs(e + rise) < UNBOUNDED:
                return np.nan
            while sample < samples.size and samples[sample] < q1:
                s = (samples[sample] - q0) / (q1 - q0)
                es, vs = between(s, h, e, v, start, rise, v + rate, a)
                q = min(max(samples[sample], q0 + INSIDE), q1 - INSIDE)
                # fmt: off
                first, m1, m2, f = look(
                    q, es, vs, True, first, pitch, speed, damp, friction, stiffness, play, gaps, yielding, width, base1, base2,
                    turn, early, tables, late1, late2, knots, bins, shape, law, lowest, step, partners, cknots, cbins, coupling,
                    desk, matrix, work, right,
                )
                # fmt: on
                if not abs(f) < np.inf:
                    return np.nan
                error[sample], force[sample] = es, f
                acceleration[sample] = (torque1 + wave(waves1, q * pitch)[0] - m1) / inertia1
                sample, moved = sample + 1, True
            if number >= begin + settling and not touching:
                means[2] += 1.0 / steps
            e, v = e + rise, v + rate
        own1, own2 = own1 / steps, own2 / steps
        if number < begin + settling:
            recent1, recent2 = MEMORY * recent1 + own1, MEMORY * recent2 + own2
            if recent1 > LEAST_LOAD * torque1:
                torque2 = recent2 / recent1 * torque1
        else:
            means[0], means[1] = means[0] + own1, means[1] + own2
        number += 1
    means /= max(number - begin - settling, 1)
    return float(torque2)
