"""The elastic model in fixed compiled steps: marching over cycles, and steady motion by Newton's method."""

from __future__ import annotations

import dataclasses
import functools
import math
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.dynamics.track import Track
from gearfem.foundation import Array, SolveError

# Cycles after which a motion may repeat: all parts of 24, so that one set of orders holds the lines of each.
PERIODS = (1, 2, 3, 4, 6, 8, 12, 24)
# Cycles that stand for a motion that does not repeat, four times the longest period.
TAIL = 96
DECAY, FEWEST_CYCLES, MOST_CYCLES, ATTEMPTS = 7.0, 2 * PERIODS[-1] + 2, 300, 10
NEWTON_STEPS = 12
CLOSED, SAME = 1e-9, 1e-6
DIFFERENCE = 1e-5
# How far Newton's method may lead from where the transient stood, in mean deflections; farther is another motion.
NEAR = 0.1
KICK = np.array([NEAR, 0.0, 0.0])
MARGIN = 1e-6
# Mean deflections: no machine swings by that much, and backlash no longer bounds anything.
UNBOUNDED = 1e6


@dataclasses.dataclass(frozen=True)
class Steady:
    """A steady motion at the first angle of the cycle: scaled x, x' and wheel torque.

    `period` is the number of cycles after which it repeats, 0 if it was not found to; `multipliers` are those over that
    period, `growth` the largest of their magnitudes per cycle, or that of neighbouring motions on average.
    """

    state: Array
    period: int
    multipliers: NDArray[Any]
    growth: float
    closure: float


@functools.cache
def kernels() -> ModuleType:
    """Return the compiled loops; the first call of a process loads the compiler (or its cached code)."""
    from gearfem.dynamics import kernels as module

    return module


def march(track: Track, start: Array, cycles: int, nodes: bool = False) -> tuple[Array, Array, Array]:
    """Step whole cycles.

    Parameters
    ----------
    track : Track
        One cycle.
    start : ndarray, shape (3,)
        Scaled x, x' and wheel torque, in units of the balanced one, at the first angle.
    cycles : int
        How many.
    nodes : bool
        Whether the motion at the start of each step is wanted.

    Returns
    -------
    end : ndarray, shape (3,)
        Scaled x and x' at the end, and the change of r_b1 q1' over the cycles.
    held : ndarray, shape (3,)
        Parts of the time in contact on the back flank, without contact, on the working flank.
    nodes : ndarray, shape (cycles, s, 5)
        x, x', force on the working flank less that on the back, moment on the pinion (all scaled) and contact state +1, 0, -1; or empty.

    Raises
    ------
    SolveError
        If contact is made and lost without end, or the motion grows without bound.

    Notes
    -----
    The classical Runge-Kutta formula, fourth order. A step in which contact is made or lost is divided there, and steps end where
    sliding reverses, so that the order holds through impacts; an event that begins and ends within one step is not seen.
    Against `integrate_cycle` at 1e-11, both with the same splines, 400 steps of the coal combine pair err by 4e-7 of the mean
    deflection in contact and by 3e-6 through three impacts. Stable up to steps of 2.8/omega_n. An exponential step with the
    stiffness frozen costs as much and is stable at any length, but of second order: at equal steps it errs ten to a hundred
    times more, but for steps above 2/omega_n (both in tests/benchmarks/bench_dynamics.py).
    """
    steps = track.steps.size
    rows = np.empty((cycles * steps if nodes else 0, 5))
    state, held = np.array([start[0], start[1], 0.0]), np.zeros(3)
    brake = float(start[2]) * track.load
    law = (track.motion, track.table, track.knots, track.damping, brake, track.backlash)
    events = kernels().march(track.steps, track.first, *law, state, cycles, rows, held)
    _whole(events, state)
    return state, held / (cycles * track.times[-1]), rows.reshape(-1, steps, 5)


def settle(track: Track, start: Array, count: int) -> tuple[Array, Array]:
    """Step a transient, the wheel torque following its balance.

    Parameters
    ----------
    track : Track
        One cycle.
    start : ndarray, shape (3,)
        Scaled x, x' and wheel torque.
    count : int
        Cycles.

    Returns
    -------
    ndarray, shape (3,), ndarray, shape (count, 2)
        Where it ends, with the torque that balances the second half; x and x' after each cycle.

    Raises
    ------
    SolveError
        As `march`.

    Notes
    -----
    The torque is that of the pinion times the ratio of the teeth's mean moments on both gears over the last cycles. Where the
    relative motion repeats, mean(M2)/mean(M1) = T2/T1 is the balance mean(M1) = T1, mean(M2) = T2; away from it the ratio
    hardly moves, whatever the loads do, so that impacts do not upset it. Without friction it is constant.
    """
    state, visits = np.array([start[0], start[1], 0.0]), np.empty((count, 2))
    length = float(track.times[-1])
    law = (track.motion, track.table, track.knots, track.damping, track.load * length, track.backlash)
    torque, events = kernels().settle(track.steps, track.first, *law, state, float(start[2]), count, track.drive * length, visits)
    _whole(events, state)
    return np.array([state[0], state[1], torque]), visits


def _whole(events: int, state: Array) -> None:
    if events < 0:
        raise SolveError("elastic model, fixed steps: contact is made and lost without end in one cycle; raise the damping ratio")
    if not np.abs(state[:2]).max() < UNBOUNDED:
        raise SolveError("elastic model, fixed steps: the motion grows without bound; parametric resonance outgrows the damping")


def steady(track: Track, start: Array, decay: float, nearby: bool) -> Steady:
    """Return the stable motion that a start leads to.

    Parameters
    ----------
    track : Track
        One cycle.
    start : ndarray, shape (3,)
        Scaled x, x' and wheel torque.
    decay : float
        Damping times scaled length of a cycle: logarithm of the decay of a transient over one.
    nearby : bool
        Whether the start lies near a steady motion, as in a sweep: then Newton's method is tried at once.

    Returns
    -------
    Steady

    Raises
    ------
    SolveError
        As `march`.

    Notes
    -----
    A transient decides which of coexisting motions it is, Newton's method (central differences of whole periods) makes it exact
    and gives the multipliers. What it leads to counts only if it is stable and near where the transient stood, so that neither
    an unstable orbit nor another branch can pass for the motion; a start on an unstable orbit is moved off it by a tenth of the
    mean deflection. Where no part of 24 cycles is a period, the motion is taken as not periodic. A growth below 1 then
    gives away a period of another number of cycles, or a transient longer than all attempts, 500 to 3000 cycles.
    """
    if nearby and (found := _orbit(track, start, 1)) is not None:
        if _stable(found):
            return found
        start = start + KICK
    count = min(max(FEWEST_CYCLES, math.ceil(DECAY / max(decay, 1e-9))), MOST_CYCLES)
    for _ in range(ATTEMPTS):
        start, visits = settle(track, start, count)
        for period in PERIODS:
            back = np.abs(visits[-1 - period :: -period][: PERIODS[-1] // period] - visits[-1])
            if back.max() < NEAR and (found := _orbit(track, start, period)) is not None:
                if _stable(found):
                    return _shortest(track, found)
                start = start + KICK
                break
    return _wander(track, start)


def _orbit(track: Track, start: Array, period: int) -> Steady | None:
    """Return the orbit near a start, stable or not, or None."""
    guess = start
    for _ in range(NEWTON_STEPS):
        end = march(track, guess, period)[0]
        miss = np.array([end[0] - guess[0], end[1] - guess[1], end[2]])
        matrix = _differences(track, guess, period)
        if np.abs(miss).max() <= CLOSED:
            multipliers = np.linalg.eigvals(matrix[:2, :2])
            growth = float(np.abs(multipliers).max()) ** (1.0 / period)
            return Steady(guess, period, multipliers, growth, float(np.abs(miss).max()))
        try:
            guess = guess - np.linalg.solve(matrix - np.diag([1.0, 1.0, 0.0]), miss)
        except np.linalg.LinAlgError:
            return None
        if np.abs(guess - start).max() > NEAR:
            return None
    return None


def _stable(orbit: Steady) -> bool:
    return orbit.growth <= 1.0 + MARGIN


def _shortest(track: Track, found: Steady) -> Steady:
    """Return the same orbit over its least period."""
    for period in PERIODS[: PERIODS.index(found.period)]:
        if found.period % period == 0 and np.abs(march(track, found.state, period)[0][:2] - found.state[:2]).max() < SAME:
            return _orbit(track, found.state, period) or found
    return found


def _differences(track: Track, guess: Array, period: int) -> Array:
    """Return d(x, x', change of r_b1 q1')/d(x, x', torque) over a period, shape (3, 3), by central differences."""
    columns = []
    for row in DIFFERENCE * np.eye(3):
        ahead, behind = march(track, guess + row, period)[0], march(track, guess - row, period)[0]
        columns.append((ahead - behind) / (2.0 * DIFFERENCE))
    return np.stack(columns, axis=1)


def _wander(track: Track, start: Array) -> Steady:
    """Return a motion without a period, with the mean growth of neighbouring motions per cycle over its tail."""
    state, direction, growth = start, np.array([1.0, 0.0]), 0.0
    for _ in range(TAIL):
        direction = _differences(track, state, 1)[:2, :2] @ direction
        size = float(np.hypot(*direction))
        growth += math.log(max(size, 1e-300))
        direction = direction / size if size > 0.0 else np.array([1.0, 0.0])
        state = np.array([*march(track, state, 1)[0][:2], start[2]])
    return Steady(start, 0, np.empty(0, complex), math.exp(growth / TAIL), float(np.abs(state[:2] - start[:2]).max()))
