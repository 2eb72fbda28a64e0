"""Periodic orbits of the elastic model by shooting, and the transient where there is none."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.dynamics.cycle import Cycle, integrate_cycle, propagator
from gearfem.dynamics.relative import RelativeMotion
from gearfem.foundation import Array, SolveError
from gearfem.foundation.progress import Progress

NEWTON_STEPS = 20
CLOSED = 100.0
LOOSE = 1e-5
MARGIN = 1e-6


@dataclasses.dataclass(frozen=True)
class Orbit:
    """Cycles in order of time, Floquet multipliers of the relative motion, and the mismatch over the last cycle."""

    cycles: tuple[Cycle, ...]
    multipliers: NDArray[Any]
    closure: float

    @property
    def stable(self) -> bool:
        """Whether no multiplier lies outside the unit circle by more than their error."""
        return bool(np.abs(self.multipliers).max(initial=0.0) <= 1.0 + MARGIN)


def shoot(system: RelativeMotion, start: Array, tolerance: float, progress: Progress) -> Orbit:
    """Return the periodic orbit near a start, with the wheel torque that its mean power balances.

    Parameters
    ----------
    system : RelativeMotion
        Equations.
    start : ndarray, shape (3,)
        Guess of scaled x, x' and wheel torque at the first angle.
    tolerance : float
        Of the integration; the orbit closes to 100 times that.
    progress : Progress
        Listener.

    Returns
    -------
    Orbit
        One cycle.

    Raises
    ------
    SolveError
        If Newton's method does not close the orbit.

    Notes
    -----
    Unknowns x(0), x'(0), T2; conditions: x, x' and the pinion's speed return. Forces do not depend on the common
    rotation, so its angle and speed are no unknowns: the start of q1 is 0 and its mean speed is 0. First with a loose
    integration, then with the stated one.
    """
    guess = start
    for stage in (max(LOOSE, tolerance), tolerance):
        guess, cycle, matrix, size = _newton(system, guess, stage, progress)
    return Orbit((cycle,), np.linalg.eigvals(matrix[:2, :2]), size)


def _newton(system: RelativeMotion, guess: Array, tolerance: float, progress: Progress) -> tuple[Array, Cycle, Array, float]:
    cycle, miss = _miss(system, guess, tolerance)
    for step in range(NEWTON_STEPS):
        progress("orbit", step, NEWTON_STEPS)
        matrix = propagator(system, cycle)
        if np.abs(miss).max() <= CLOSED * tolerance:
            progress("orbit", NEWTON_STEPS, NEWTON_STEPS)
            return guess, cycle, matrix, float(np.abs(miss).max())
        try:
            move = np.linalg.solve(matrix[:3][:, [0, 1, 3]] - np.diag([1.0, 1.0, 0.0]), -miss)
        except np.linalg.LinAlgError:
            break
        for fraction in (1.0, 0.5, 0.25, 0.125):
            trial, attempt = _miss(system, guess + fraction * move, tolerance)
            if np.abs(attempt).max() < np.abs(miss).max():
                break
        else:
            break
        guess, cycle, miss = guess + fraction * move, trial, attempt
    raise SolveError(f"elastic model: the orbit does not close; mismatch {np.abs(miss).max():.2e} mean deflections")


def _miss(system: RelativeMotion, guess: Array, tolerance: float) -> tuple[Cycle, Array]:
    cycle = integrate_cycle(system, np.array([guess[0], guess[1], 0.0, 0.0]), guess[2], tolerance)
    return cycle, np.array([cycle.end[0] - guess[0], cycle.end[1] - guess[1], cycle.end[3]])


def settle(system: RelativeMotion, start: Array, count: int, tail: int, tolerance: float, progress: Progress) -> tuple[Orbit, Array]:
    """Integrate a transient and return its last cycles, and where they end.

    Parameters
    ----------
    system : RelativeMotion
        Equations.
    start : ndarray, shape (3,)
        Scaled x, x' and wheel torque at the first angle.
    count, tail : int
        Cycles that settle, and cycles that are kept after them.
    tolerance : float
        Of the integration.
    progress : Progress
        Listener.

    Returns
    -------
    Orbit, ndarray of shape (3,)
        Kept cycles (no multipliers), and the last x, x' and wheel torque.

    Notes
    -----
    The pinion's speed would drift where the wheel torque does not balance. While settling the torque is moved by
    half of what would stop the drift, ever less from cycle to cycle; its mean over the second half then stays, since
    single cycles of a subharmonic motion need not balance. Each cycle starts its own count of q1, which no force feels.
    """
    share = system.gain2 * system.balanced_torque / (system.gain1 * system.mesh.base_radius1 + system.gain2 * system.mesh.base_radius2)
    guess, kept, torques = start, [], [float(start[2])]
    for step in range(count + tail):
        progress("transient", step, count + tail)
        cycle, miss = _miss(system, guess, tolerance)
        gain = 0.5 / (1.0 + 0.1 * step) if step < count else 0.0
        shift = gain * miss[2] / (system.gain1 * system.length * system.mesh.base_radius1 * share)
        guess = np.array([cycle.end[0], cycle.end[1], guess[2] + shift])
        torques.append(guess[2])
        if step == count - 1:
            guess[2] = np.mean(torques[-(count // 2 + 1) :])
        if step >= count:
            kept.append(cycle)
    progress("transient", count + tail, count + tail)
    return Orbit(tuple(kept), np.empty(0, dtype=complex), float(np.abs(miss).max())), guess
