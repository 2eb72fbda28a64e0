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
    start : ndarray, shape (3 + 2 k,)
        Guess of scaled x, x', z, z' and wheel torque at the first angle, z the k stretches of shafts and supports.
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
    Unknowns x(0), x'(0), z(0), z'(0), T2; conditions: these, and the pinion's speed, return. Forces do not depend on the common
    rotation, so its angle and speed are no unknowns: the start of q1 is 0 and its mean speed is 0. First with a loose
    integration, then with the stated one.
    """
    guess = start
    for stage in (max(LOOSE, tolerance), tolerance):
        guess, cycle, matrix, size = _newton(system, guess, stage, progress)
    return Orbit((cycle,), np.linalg.eigvals(matrix[:-2, :-2]), size)


def _newton(system: RelativeMotion, guess: Array, tolerance: float, progress: Progress) -> tuple[Array, Cycle, Array, float]:
    cycle, miss = _miss(system, guess, tolerance)
    for step in range(NEWTON_STEPS):
        progress("orbit", step, NEWTON_STEPS)
        matrix = propagator(system, cycle)
        if np.abs(miss).max() <= CLOSED * tolerance:
            progress("orbit", NEWTON_STEPS, NEWTON_STEPS)
            return guess, cycle, matrix, float(np.abs(miss).max())
        try:
            columns = np.delete(matrix[:-1], -2, axis=1)
            move = np.linalg.solve(columns - np.diag(np.append(np.ones(miss.size - 1), 0.0)), -miss)
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
    """Integrate one cycle from a guess (x, x', z, z', torque); return it and the mismatch of x, x', z, z' and r_b1 q1'."""
    cycle = integrate_cycle(system, np.concatenate([guess[:2], [0.0, 0.0], guess[2:-1]]), float(guess[-1]), tolerance)
    return cycle, np.append(_relative(cycle.end) - guess[:-1], cycle.end[3])


def _relative(state: Array) -> Array:
    return np.delete(state, [2, 3])


def settle(system: RelativeMotion, start: Array, count: int, tail: int, tolerance: float, progress: Progress) -> tuple[Orbit, Array]:
    """Integrate a transient and return its last cycles, and where they end.

    Parameters
    ----------
    system : RelativeMotion
        Equations.
    start : ndarray, shape (3 + 2 k,)
        Scaled x, x', z, z' and wheel torque at the first angle.
    count, tail : int
        Cycles that settle, and cycles that are kept after them.
    tolerance : float
        Of the integration.
    progress : Progress
        Listener.

    Returns
    -------
    Orbit, ndarray of shape (3 + 2 k,)
        Kept cycles (no multipliers), and the last x, x', z, z' and wheel torque.

    Notes
    -----
    The pinion's speed would drift where the wheel torque does not balance. While settling the torque is moved by
    half of what would stop the drift, ever less from cycle to cycle; its mean over the second half then stays, since
    single cycles of a subharmonic motion need not balance. Each cycle starts its own count of q1, which no force feels.
    """
    r1, r2 = system.mesh.base_radius1, system.mesh.base_radius2
    weight1, weight2 = r2**2 * system.drive.pinion_side_inertia, r1**2 * system.drive.wheel_side_inertia
    # A wheel torque off balance by one unit changes the common speed r_b1 psi1' by this in a unit of scaled time.
    drift = system.balanced_torque * r1**2 * r2 / (weight1 + weight2) / (system.unit * system.natural**2)
    guess, kept, torques = start, [], [float(start[-1])]
    for step in range(count + tail):
        progress("transient", step, count + tail)
        cycle, miss = _miss(system, guess, tolerance)
        gain = 0.5 / (1.0 + 0.1 * step) if step < count else 0.0
        guess = np.append(_relative(cycle.end), guess[-1] + gain * miss[-1] / (system.length * drift))
        torques.append(float(guess[-1]))
        if step == count - 1:
            guess[-1] = np.mean(torques[-(count // 2 + 1) :])
        if step >= count:
            kept.append(cycle)
    progress("transient", count + tail, count + tail)
    return Orbit(tuple(kept), np.empty(0, dtype=complex), float(np.abs(miss).max())), guess
