"""Compiled inner loops of the fast elastic model; imported when the first motion is stepped, never with gearfem.

Arrays of a `Track` come one by one and its constants as numbers: tuples of arrays are copied at every call.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
import numpy as np

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

# Events of one cycle beyond which contact is taken to be made and lost without end; rounds of locating one.
MOST_EVENTS = 400
MOST_ROUNDS = 60
SHARP = 1e-13
# Weight of a cycle's moments in the next one's balance, and mean load below which they say nothing about it.
MEMORY, LEAST_LOAD = 0.8, 0.1


def compiled(function: Kernel) -> Kernel:
    """Return the function compiled at its first call, the machine code kept on disk beside this file."""
    return cast(Kernel, numba.njit(cache=True, error_model="numpy")(function))


def inlined(function: Kernel) -> Kernel:
    """Return the function compiled into its callers."""
    return cast(Kernel, numba.njit(cache=True, error_model="numpy", forceinline=True)(function))


@inlined
def law(table: Any, knots: Any, point: int, depth: float, side: int, cell: int) -> tuple[float, float, float, int]:
    """Return elastic force, its arm on the relative motion, that on the pinion, and the cell of the depth.

    The force goes on linearly beyond the knots, the arms stay.
    """
    last = knots.size - 2
    inside = min(max(depth, 0.0), knots[last + 1])
    while cell > 0 and inside < knots[cell]:
        cell -= 1
    while cell < last and inside >= knots[cell + 1]:
        cell += 1
    s = inside - knots[cell]
    c = table[point, cell]
    force = ((c[3] * s + c[2]) * s + c[1]) * s + c[0]
    if depth != inside:
        force += ((3.0 * c[3] * s + 2.0 * c[2]) * s + c[1]) * (depth - inside)
    n = 4 if side > 0 else 12
    both = ((c[n + 3] * s + c[n + 2]) * s + c[n + 1]) * s + c[n]
    one = ((c[n + 7] * s + c[n + 6]) * s + c[n + 5]) * s + c[n + 4]
    return force, both, one, cell


@inlined
def push(
    motion: Any, table: Any, knots: Any, damp: float, brake: float, play: float, point: int, x: float, v: float, side: int, cell: int
) -> tuple[float, float, float, float, int]:
    """Return x'', r_b1 q1'', force on the flank in contact and its moment on the pinion at a point of the track, and the cell.

    `brake` is the push of the present wheel torque on x.
    """
    if side == 0:
        return motion[point, 2] + brake, motion[point, 3], 0.0, 0.0, cell
    depth, speed = x + motion[point, 0], v + motion[point, 1]
    if side < 0:
        depth, speed = -depth - play, -speed
    force, both, one, cell = law(table, knots, point, depth, side, cell)
    force += damp * speed
    return motion[point, 2] + brake - force * both, motion[point, 3] - force * one, force, force * one, cell


@compiled
def between(
    motion: Any, table: Any, knots: Any, damp: float, play: float, point: int, share: float, x: float, v: float, side: int
) -> tuple[float, float, float, float]:
    """Return x'' without the wheel torque, r_b1 q1'', closeness and force at a share of a step, for one flank.

    Whatever depends on time is a parabola through the step's three points: h^3, on steps that hold an event alone.
    Closeness is positive where the flank is in contact, as `RelativeMotion.closeness`.
    """
    weights = ((1.0 - share) * (1.0 - 2.0 * share), 4.0 * share * (1.0 - share), share * (2.0 * share - 1.0))
    depth, speed, base, own, elastic, both, one, cell = x, v, 0.0, 0.0, 0.0, 0.0, 0.0, 0
    for number in range(3):
        depth += weights[number] * motion[point + number, 0]
        speed += weights[number] * motion[point + number, 1]
        base += weights[number] * motion[point + number, 2]
        own += weights[number] * motion[point + number, 3]
    if side == 0:
        return base, own, 0.0, 0.0
    if side < 0:
        depth, speed = -depth - play, -speed
    for number in range(3):
        f, b, o, cell = law(table, knots, point + number, depth, side, cell)
        elastic, both, one = elastic + weights[number] * f, both + weights[number] * b, one + weights[number] * o
    force = elastic + damp * speed
    close = min(depth, force) if depth > 0.0 else min(depth, damp * speed)
    return base - force * both, own - force * one, close, force


@compiled
def ends(
    motion: Any, table: Any, knots: Any, damp: float, play: float, point: int, share: float, x: float, v: float, side: int
) -> tuple[float, int]:
    """Return a number above zero where the present contact state has ended, and the state after it."""
    if side != 0:
        return -between(motion, table, knots, damp, play, point, share, x, v, side)[3], 0
    front = between(motion, table, knots, damp, play, point, share, x, v, 1)[2]
    back = between(motion, table, knots, damp, play, point, share, x, v, -1)[2]
    return (front, 1) if front >= back else (back, -1)


@compiled
def part(
    motion: Any,
    table: Any,
    knots: Any,
    damp: float,
    brake: float,
    play: float,
    point: int,
    whole: float,
    start: float,
    end: float,
    x: float,
    v: float,
    w: float,
    side: int,
) -> tuple[float, float, float]:
    """Return x, x' and r_b1 q1' at another share of a step of length `whole`: one Runge-Kutta step from share to share."""
    h, middle = whole * (end - start), 0.5 * (start + end)
    a1, o1, _, _ = between(motion, table, knots, damp, play, point, start, x, v, side)
    v2 = v + 0.5 * h * (a1 + brake)
    a2, o2, _, _ = between(motion, table, knots, damp, play, point, middle, x + 0.5 * h * v, v2, side)
    v3 = v + 0.5 * h * (a2 + brake)
    a3, o3, _, _ = between(motion, table, knots, damp, play, point, middle, x + 0.5 * h * v2, v3, side)
    v4 = v + h * (a3 + brake)
    a4, o4, _, _ = between(motion, table, knots, damp, play, point, end, x + h * v3, v4, side)
    gain = (a1 + 2.0 * (a2 + a3) + a4) / 6.0 + brake
    return x + h / 6.0 * (v + 2.0 * (v2 + v3) + v4), v + h * gain, w + h / 6.0 * (o1 + 2.0 * (o2 + o3) + o4)


@compiled
def locate(
    motion: Any,
    table: Any,
    knots: Any,
    damp: float,
    brake: float,
    play: float,
    point: int,
    whole: float,
    start: float,
    x: float,
    v: float,
    w: float,
    side: int,
) -> tuple[float, float, float, float, int]:
    """Return share, state and contact state just after the end of the present contact state; share 2 if it does not end here.

    Regula falsi (Illinois), bisection every fourth time, on parts of the step from `start`; the far side of the root.
    """
    low, high, kept = start, 1.0, 0
    below = min(ends(motion, table, knots, damp, play, point, start, x, v, side)[0], 0.0)
    hx, hv, hw = part(motion, table, knots, damp, brake, play, point, whole, start, 1.0, x, v, w, side)
    above, after = ends(motion, table, knots, damp, play, point, 1.0, hx, hv, side)
    if above <= 0.0:
        return 2.0, hx, hv, hw, side
    for number in range(MOST_ROUNDS):
        share = 0.5 * (low + high)
        if number % 4 != 3:
            share = low - below * (high - low) / (above - below)
        if high - low <= SHARP or above < SHARP or not low < share < high:
            break
        tx, tv, tw = part(motion, table, knots, damp, brake, play, point, whole, start, share, x, v, w, side)
        value, new = ends(motion, table, knots, damp, play, point, share, tx, tv, side)
        if value > 0.0:
            high, above, after, hx, hv, hw = share, value, new, tx, tv, tw
            below = 0.5 * below if kept == 1 else below
            kept = 1
        else:
            low, below = share, value
            above = 0.5 * above if kept == -1 else above
            kept = -1
    return high, hx, hv, hw, after


@compiled
def march(
    steps: Any,
    first: Any,
    motion: Any,
    table: Any,
    knots: Any,
    damp: float,
    brake: float,
    play: float,
    state: Any,
    cycles: int,
    nodes: Any,
    held: Any,
) -> int:
    """Step whole cycles; state (x, x', r_b1 q1') is moved on in place.

    `nodes` (cycles * steps, 5) takes x, x', signed force, moment on the pinion and contact state at the start of each step, or is
    empty; `held` (3,) adds up the times in contact on the back flank, without contact, on the working flank.
    Returns the number of contact events, or -1 where they did not end.
    """
    x, v, w = state[0], state[1], state[2]
    found, side = ends(motion, table, knots, damp, play, first[0], 0.0, x, v, 0)
    if found <= 0.0:
        side = 0
    cell, events, row, wanted = 0, 0, 0, nodes.shape[0] > 0
    for _ in range(cycles):
        cap = events + MOST_EVENTS
        for step in range(steps.size):
            point, h = first[step], steps[step]
            a1, o1, force, moment, cell = push(motion, table, knots, damp, brake, play, point, x, v, side, cell)
            if wanted:
                nodes[row, 0], nodes[row, 1], nodes[row, 2], nodes[row, 3], nodes[row, 4] = x, v, side * force, moment, side
                row += 1
            v2 = v + 0.5 * h * a1
            a2, o2, _, _, cell = push(motion, table, knots, damp, brake, play, point + 1, x + 0.5 * h * v, v2, side, cell)
            v3 = v + 0.5 * h * a2
            a3, o3, _, _, cell = push(motion, table, knots, damp, brake, play, point + 1, x + 0.5 * h * v2, v3, side, cell)
            v4 = v + h * a3
            a4, o4, _, _, cell = push(motion, table, knots, damp, brake, play, point + 2, x + h * v3, v4, side, cell)
            nx, nv = x + h / 6.0 * (v + 2.0 * (v2 + v3) + v4), v + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
            nw = w + h / 6.0 * (o1 + 2.0 * (o2 + o3) + o4)
            if side != 0:
                _, _, force, _, cell = push(motion, table, knots, damp, brake, play, point + 2, nx, nv, side, cell)
                over = force < 0.0
            else:
                depth = nx + motion[point + 2, 0]
                over = depth > 0.0 or depth < -play
            share = 0.0
            while over:
                at, tx, tv, tw, after = locate(motion, table, knots, damp, brake, play, point, h, share, x, v, w, side)
                if at > 1.0:
                    nx, nv, nw = tx, tv, tw
                    break
                held[side + 1] += h * (at - share)
                share, x, v, w, side, events = at, tx, tv, tw, after, events + 1
                if events > cap:
                    return -1
                nx, nv, nw = x, v, w
                over = at < 1.0
            held[side + 1] += h * (1.0 - share)
            x, v, w = nx, nv, nw
    state[0], state[1], state[2] = x, v, w
    return events


@compiled
def settle(
    steps: Any,
    first: Any,
    motion: Any,
    table: Any,
    knots: Any,
    damp: float,
    load: float,
    play: float,
    state: Any,
    torque: float,
    count: int,
    drive: float,
    visits: Any,
) -> tuple[float, int]:
    """Step `count` cycles, the wheel torque following the ratio of the teeth's moments; return it for the second half.

    `visits` (count, 2) takes x and x' at the end of each cycle; `drive` and `load` are what pinion torque and balanced wheel torque
    add to the speeds r_b1 q1' and x' over a cycle.
    """
    nodes, held, events = np.empty((0, 5)), np.zeros(3), 0
    recent1, recent2, late1, late2 = 0.0, 0.0, 0.0, 0.0
    length = steps.sum()
    for number in range(count):
        before, state[2] = state[1], 0.0
        found = march(steps, first, motion, table, knots, damp, torque * load / length, play, state, 1, nodes, held)
        if found < 0:
            return torque, -1
        events += found
        visits[number, 0], visits[number, 1] = state[0], state[1]
        # Mean moments of the teeth over the torques: what is left of the torques sped the gears up.
        one, two = 1.0 - state[2] / drive, torque - (state[1] - before - state[2]) / load
        recent1, recent2 = MEMORY * recent1 + one, MEMORY * recent2 + two
        if number >= count // 2:
            late1, late2 = late1 + one, late2 + two
        if recent1 > LEAST_LOAD:
            torque = recent2 / recent1
    return (late2 / late1 if late1 > LEAST_LOAD else torque), events
