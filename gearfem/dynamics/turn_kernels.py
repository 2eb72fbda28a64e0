"""Compiled inner loops of the motion over many turns; imported when the first one is stepped, never with gearfem.

Built on the loops of `gearfem.engagement.turn_kernels`. Coordinates y (n,): the lag e = r_b1 psi1 - r_b2 psi2 [m], then the stretches
of shafts [rad] and supports [m], none for two inertias. A `place` on the way of the gears is a pinion angle in pitches.
"""

from __future__ import annotations

from typing import Any, NamedTuple

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
    SLIDING_RATE,
    TABLE,
    compiled,
    couple,
    cubic,
    find,
    inlined,
    keep,
    lay,
    respond,
    shift,
)

ROUNDS, TOLERANCE = 60, 1e-9
# Shortest part of a step that a reversal of the sliding cuts off, Newton steps to its place, and how far beyond a step it is looked for.
SHORTEST, NEWTON, NEAR = 1e-6, 3, 1.5
# Weight of a pitch's moments in the next one's balance, least load that says anything about it, and what no machine swings by [m].
MEMORY, LEAST_LOAD, UNBOUNDED = 0.7, 0.1, 0.1


class Rows(NamedTuple):
    """The pairs, as of `Stack.arrays`."""

    early: float
    tables: Any
    late1: Any
    late2: Any
    knots: Any
    bins: Any
    shape: Any
    law: Any
    lowest: float
    step: float
    partners: Any
    cknots: Any
    cbins: Any
    coupling: Any


class Teeth(NamedTuple):
    """What all pairs share: pitch [rad], pitches per second, damper, friction, mean stiffness, play, waves of the common gap, yield of
    massless supports, face width, base radii and 1/(r_b1 pitch)."""

    pitch: float
    speed: float
    damp: float
    friction: float
    stiffness: float
    play: float
    gaps: Any
    yielding: float
    width: float
    base1: float
    base2: float
    turn: float


class Train(NamedTuple):
    """The linear part: waves of both torques, and accelerations of the coordinates and (last row) of psi1.

    `by_load` (n + 1, 5) is per T1, M1, T2, M2 and normal force, `by_place` and `by_rate` (n + 1, n) per coordinate and its rate; `touch`
    (n,) makes the approach of the flanks of the coordinates.
    """

    waves1: Any
    waves2: Any
    by_load: Any
    by_place: Any
    by_rate: Any
    touch: Any


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
def dot(row: Any, values: Any) -> float:
    """Return the inner product."""
    total = 0.0
    for i in range(values.size):
        total += row[i] * values[i]
    return total


@inlined
def arrange(q: float, first: int, teeth: Teeth, rows: Rows, desk: Any, matrix: Any, right: Any) -> int:
    """Lay out the pairs at a place and return the first one; loads are kept to start from."""
    count = desk.shape[0]
    common = wave(teeth.gaps, q * teeth.pitch)[0]
    # fmt: off
    found = lay(
        q, common, rows.tables, rows.late1, rows.late2, rows.knots, rows.bins, rows.shape, teeth.base1, teeth.base2, teeth.turn,
        rows.early, count, desk,
    )
    # fmt: on
    keep(found - first, count, desk, right)
    couple(q, found, count, rows.partners, rows.cknots, rows.cbins, rows.coupling, teeth.yielding * teeth.width, desk, matrix)
    return int(found)


@inlined
def push(
    e: float, v: float, q: float, middle: float, teeth: Teeth, rows: Rows, desk: Any, matrix: Any, work: Any, right: Any
) -> tuple[float, float, float, float]:
    """Return the moments of the teeth on pinion and wheel, the force along the line of action, and that on the working flanks without
    the damper; NaN without convergence.

    Sliding has the direction that it has at `middle`, that of the step.
    """
    count, miss = desk.shape[0], np.inf
    for _ in range(ROUNDS):
        miss = respond(e, rows.law, rows.lowest, rows.step, count, desk, matrix)
        if miss < TOLERANCE:
            break
        shift(0.0, count, desk, matrix, work, right)
        # Newton's method squares its error: after a step as small as this the loads are met.
        if miss < 1e-5:
            break
    else:
        return np.nan, np.nan, np.nan, np.nan
    common, common_rate = wave(teeth.gaps, q * teeth.pitch)
    common_rate *= teeth.pitch
    force, moment1, moment2, gap_rate = 0.0, 0.0, 0.0, 0.0
    for j in range(count):
        load = desk[j, FORCE] * teeth.width
        if load <= 0.0:
            continue
        held = teeth.friction * np.sign(desk[j, SLIDING] + (middle - q) * desk[j, SLIDING_RATE])
        force += load
        moment1 += load * (desk[j, ARM1] + held * desk[j, FRICTION1])
        moment2 += load * (desk[j, ARM2] + held * desk[j, FRICTION2])
        gap_rate += load * (desk[j, GAP_RATE] + common_rate)
    if force > 0.0:
        whole = force + teeth.damp * (v - gap_rate / force * teeth.speed)
        if whole <= 0.0:
            return 0.0, 0.0, 0.0, force
        return moment1 * whole / force, moment2 * whole / force, whole, force
    depth = common - e - teeth.play
    if depth > 0.0:
        back = teeth.stiffness * depth - teeth.damp * (v - common_rate * teeth.speed)
        if back > 0.0:
            return -back * teeth.base1, -back * teeth.base2, -back, 0.0
    return 0.0, 0.0, 0.0, 0.0


@inlined
def reversal(q: float, end: float, first: int, teeth: Teeth, rows: Rows, desk: Any) -> float:
    """Return where between the place that the desk is laid at and `end` the sliding of a pair first reverses, `end` if nowhere."""
    least = SHORTEST * (end - q)
    for j in range(desk.shape[0]):
        if desk[j, CELL] < 0.0:
            continue
        value, rate = desk[j, SLIDING], desk[j, SLIDING_RATE]
        if value * rate > 0.0 or abs(value) > NEAR * (end - q) * abs(rate) or rate == 0.0:
            continue
        table, pair = int(desk[j, TABLE]), first + j
        x = q - pair - rows.late1[pair % rows.late1.size] * teeth.turn
        root = x
        for _ in range(NEWTON):
            root -= value / rate
            cell = find(rows.knots, rows.bins, table, root)
            if cell < 0:
                break
            own, d = rows.shape[table, cell, SLIDING], root - rows.knots[table, cell]
            value, rate = cubic(own, d), (3.0 * own[0] * d + 2.0 * own[1]) * d + own[2]
        else:
            at = q + root - x
            if q + least < at < end - least:
                end = at
    return end


@inlined
def accelerate(
    q: float, torque1: float, torque2: float, m1: float, m2: float, force: float, y: Any, v: Any, teeth: Teeth, train: Train, out: Any
) -> None:
    """Set the accelerations of the coordinates, and of psi1 behind them."""
    t1, t2 = torque1 + wave(train.waves1, q * teeth.pitch)[0], torque2 + wave(train.waves2, q * teeth.pitch)[0]
    for i in range(out.size):
        load = train.by_load[i]
        out[i] = load[0] * t1 + load[1] * m1 + load[2] * t2 + load[3] * m2 + load[4] * force
        if y.size > 1:
            out[i] += dot(train.by_place[i], y) + dot(train.by_rate[i], v)


@inlined
def between(s: float, h: float, e: float, v: float, a: float, rise: float, end: float, last: float) -> tuple[float, float]:
    """Return position and rate at a share s of a step: the quintic with position, rate and acceleration of both ends."""
    d0, d1, b0, b1 = h * v, h * end, 0.5 * h * h * a, 0.5 * h * h * last
    c3 = 10.0 * rise - 6.0 * d0 - 4.0 * d1 - 3.0 * b0 + b1
    c4 = -15.0 * rise + 8.0 * d0 + 7.0 * d1 + 3.0 * b0 - 2.0 * b1
    c5 = 6.0 * rise - 3.0 * d0 - 3.0 * d1 - b0 + b1
    position = e + s * (d0 + s * (b0 + s * (c3 + s * (c4 + s * c5))))
    return position, (d0 + s * (2.0 * b0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))) / h


@inlined
def lowest(older: float, middle: float, newer: float) -> float:
    """Return the least of the parabola through values at equal distances, where the middle one is least; else the last one."""
    if middle < older and middle < newer:
        return middle - (newer - older) ** 2 / (8.0 * (older - 2.0 * middle + newer))
    return newer


@compiled
def march(
    begin: int,
    settling: int,
    steps: int,
    samples: Any,
    state: Any,
    torque1: float,
    torque2: float,
    count: int,
    teeth: Teeth,
    rows: Rows,
    train: Train,
    error: Any,
    acceleration: Any,
    force: Any,
    moment: Any,
    pressed: Any,
    means: Any,
) -> float:
    """Step from pitch `begin` past the last sample; the wheel torque follows its balance over `settling` pitches, then stays.

    `samples` (m,) are places, increasing; `state` (2, n) coordinates and rates at the start, and then at the end. Outputs (m,):
    transmission error [m] and, unless these are empty, psi1'' [rad/s2], normal force [N], moment of the teeth on the pinion [N m] and
    normal force without the damper [N]; `means` (4,): mean moments on pinion and wheel, share of the time without contact on the working
    flank, and the least psi1'' of the steps between the samples, by parabolas through the least of them and its neighbours. Returns the
    wheel torque, NaN where it failed.
    """
    size = state.shape[1]
    desk, matrix, work, right = np.zeros((count, COLUMNS)), np.zeros((count, count)), np.zeros((count, count)), np.zeros(count)
    y, v, ys, vs, rise, rate = state[0].copy(), state[1].copy(), np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(size)
    start, last, now = np.zeros(size + 1), np.zeros(size + 1), np.zeros(size + 1)
    first, sample, number, recent1, recent2, moved = -(1 << 60), 0, begin, 0.0, 0.0, True
    means[:], least, older, newer, cut = 0.0, np.inf, np.nan, np.nan, False
    while sample < samples.size:
        own1, own2, part, q = 0.0, 0.0, 0, float(number)
        while part < steps:
            end = number + (part + 1) / steps
            if moved:
                first = arrange(q, first, teeth, rows, desk, matrix, right)
            # Sliding reverses at the ends of steps, whose parts it cuts: no step sees two directions of friction.
            stop = reversal(q, end, first, teeth, rows, desk) if teeth.friction > 0.0 else end
            h, middle, touching = (stop - q) / teeth.speed, 0.5 * (q + stop), True
            for i in range(size):
                ys[i], vs[i], rise[i], rate[i], last[i] = y[i], v[i], 0.0, 0.0, 0.0
            for stage in range(4):
                share = 0.0 if stage == 0 else 0.5 if stage < 3 else 1.0
                weight = 1.0 / 3.0 if 0 < stage < 3 else 1.0 / 6.0
                for i in range(size):
                    ys[i], vs[i] = y[i] + share * h * vs[i], v[i] + share * h * last[i]
                at = q + share * (stop - q)
                if stage % 2 == 1:
                    first = arrange(at, first, teeth, rows, desk, matrix, right)
                m1, m2, f, _ = push(dot(train.touch, ys), dot(train.touch, vs), at, middle, teeth, rows, desk, matrix, work, right)
                accelerate(at, torque1, torque2, m1, m2, f, ys, vs, teeth, train, last)
                for i in range(size):
                    rise[i], rate[i] = rise[i] + h * weight * vs[i], rate[i] + h * weight * last[i]
                own1, own2 = own1 + (stop - q) * weight * m1, own2 + (stop - q) * weight * m2
                if stage == 0:
                    start[:], touching = last, f > 0.0
            moved = False
            if not abs(y[0] + rise[0]) < UNBOUNDED:
                return np.nan
            if samples[0] <= q <= samples[-1]:
                least = min(least, lowest(older, newer, start[size]))
                older, newer = newer, start[size]
                if stop < end or cut:
                    # Parts of a step are no equal distances.
                    older, newer = np.nan, np.nan
                cut = stop < end
            while sample < samples.size and samples[sample] < stop:
                at = samples[sample]
                for i in range(size):
                    ys[i], vs[i] = between((at - q) / (stop - q), h, y[i], v[i], start[i], rise[i], v[i] + rate[i], last[i])
                error[sample], sample = ys[0], sample + 1
                if force.size == 0:
                    continue
                first = arrange(at, first, teeth, rows, desk, matrix, right)
                m1, m2, f, elastic = push(dot(train.touch, ys), dot(train.touch, vs), at, middle, teeth, rows, desk, matrix, work, right)
                if not abs(f) < np.inf:
                    return np.nan
                accelerate(at, torque1, torque2, m1, m2, f, ys, vs, teeth, train, now)
                force[sample - 1], moment[sample - 1], acceleration[sample - 1], moved = f, m1, now[size], True
                pressed[sample - 1] = elastic
            if number >= begin + settling and not touching:
                means[2] += stop - q
            for i in range(size):
                y[i], v[i] = y[i] + rise[i], v[i] + rate[i]
            q = stop
            if stop == end:
                part += 1
        if number < begin + settling:
            recent1, recent2 = MEMORY * recent1 + own1, MEMORY * recent2 + own2
            if recent1 > LEAST_LOAD * torque1:
                torque2 = recent2 / recent1 * torque1
        else:
            means[0], means[1] = means[0] + own1, means[1] + own2
        number += 1
    means /= max(number - begin - settling, 1)
    means[3] = least
    state[0], state[1] = y, v
    return float(torque2)
