"""One mesh cycle of the elastic model: integrated by Gear's method from contact event to contact event."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from gearfem.dynamics.relative import RelativeMotion
from gearfem.foundation import Array, SolveError

MOST_PIECES = 400
FEWEST_STEPS = 50


@dataclasses.dataclass(frozen=True)
class Piece:
    """A smooth stretch: dense solution over `steps` (scaled times), flank in contact, angle between the reversals.

    `jump` carries neighbouring orbits across the event at its end.
    """

    solution: Callable[[Any], Any]
    steps: Array
    side: int
    middle: float
    jump: Array

    @property
    def duration(self) -> float:
        """Scaled time it takes."""
        return float(self.steps[-1] - self.steps[0])


@dataclasses.dataclass(frozen=True)
class Cycle:
    """The pieces of one cycle, its wheel torque (in units of the balanced one) and the scaled state at its end."""

    pieces: tuple[Piece, ...]
    torque: float
    end: Array


def integrate_cycle(system: RelativeMotion, state: Array, torque: float, tolerance: float) -> Cycle:
    """Integrate one cycle from its first angle.

    Parameters
    ----------
    system : RelativeMotion
        Equations.
    state : ndarray, shape (4 + 2 k,)
        Scaled state at the start.
    torque : float
        Wheel torque in units of T1 r_b2/r_b1.
    tolerance : float
        Relative and absolute tolerance of the scaled state per step.

    Returns
    -------
    Cycle

    Raises
    ------
    SolveError
        If the integration fails, or contact is made and lost without end.

    Notes
    -----
    Backward differentiation of variable order up to 5 (Gear) with exact Jacobian. It stops where the sliding of a pair
    reverses, and where contact is made or lost: located on the dense solution and started anew, never stepped over.
    """
    pieces: list[Piece] = []
    first = system.intervals()[0]
    sides = [side for side in (1, -1) if system.closeness(first[0], state, side, first[2]) > 0.0]
    side = sides[0] if sides else 0
    for start, end, middle in system.intervals():
        time = start
        while end - time > 1e-12 * system.length:
            piece, state, side = _advance(system, (time, end), state, torque, side, middle, tolerance)
            pieces.append(piece)
            time = float(piece.steps[-1])
            if len(pieces) > MOST_PIECES:
                raise SolveError(f"elastic model: more than {MOST_PIECES} contact events in one cycle; raise the damping ratio")
    return Cycle(tuple(pieces), torque, state)


def _advance(
    system: RelativeMotion, span: tuple[float, float], state: Array, torque: float, side: int, middle: float, tolerance: float
) -> tuple[Piece, Array, int]:
    """Integrate to the end of the span or the next contact event; return the piece, the state and the new side."""
    flanks = (side,) if side else (1, -1)
    result: Any = solve_ivp(
        lambda time, y: system.change(time, y, torque, side, middle),
        span,
        state,
        method="BDF",
        jac=lambda time, y: system.slopes(time, y, side, middle),
        events=[_event(system, flank, side, middle) for flank in flanks],
        dense_output=True,
        rtol=tolerance,
        atol=tolerance,
        max_step=system.length / FEWEST_STEPS,
    )
    if result.status < 0 or not np.isfinite(result.y).all():
        raise SolveError(f"elastic model: the integration stopped at angle {middle:.4g} rad: {result.message}")
    after, state = side, result.y[:, -1]
    for flank, times in zip(flanks, result.t_events, strict=True):
        if times.size:
            after = 0 if side else flank
    jump = _jump(system, float(result.t[-1]), state, (side, after), middle)
    return Piece(result.sol, result.t, side, middle, jump), state, after


def _event(system: RelativeMotion, flank: int, side: int, middle: float) -> Callable[[float, Array], float]:
    """Return the function of time and state whose root ends the present contact, or makes one."""

    def leaves(time: float, y: Array) -> float:
        touch = system.contact(system.transport(time), *system.approach(y), flank, middle)
        return float(touch.force) / (system.unit * system.mesh.mean_stiffness)

    def meets(time: float, y: Array) -> float:
        return system.closeness(time, y, flank, middle)

    event: Any = leaves if side else meets
    event.terminal, event.direction = True, -1.0 if side else 1.0
    return event  # type: ignore[no-any-return]


def _jump(system: RelativeMotion, time: float, state: Array, sides: tuple[int, int], middle: float) -> Array:
    """Return how neighbouring orbits cross an event, for the variables of `propagator`.

    The force jumps only where a flank lands with speed: 1 + (f_after - f_before) grad(d)/d', d the depth.
    """
    count = system.count
    matrix = np.eye(4 + 2 * count)
    if sides[0] == 0 and sides[1] != 0:
        step = system.change(time, state, 1.0, sides[1], middle) - system.change(time, state, 1.0, 0, middle)
        speed = float(system.approach(state)[1]) + float(system.transport(time).drift) / (system.unit * system.natural)
        if abs(speed) > math.sqrt(np.finfo(float).eps):
            slope = np.concatenate([[1.0, 0.0], -system.yielding, np.zeros(count + 2)])
            matrix[:-1] += np.outer(step[_order(count)], slope) / speed
    return matrix


def _order(count: int) -> list[int]:
    """Return where x, x', the stretches, their rates and r_b1 q1' stand in the state."""
    return [0, 1, *range(4, 4 + 2 * count), 3]


def propagator(system: RelativeMotion, cycle: Cycle) -> Array:
    """Return the derivative of the state at the end of a cycle over that at its start.

    Parameters
    ----------
    system : RelativeMotion
        Equations.
    cycle : Cycle
        Solution.

    Returns
    -------
    ndarray, shape (4 + 2 k, 4 + 2 k)
        For (x, x', z, z', r_b1 q1', wheel torque), scaled, k the yielding shafts and supports.

    Notes
    -----
    The linear equations along the solution, by the Magnus series of fourth order at the two Gauss points of each step
    of the integration, and the jumps between the pieces. Stable for steps longer than a natural period.
    """
    whole = np.eye(4 + 2 * system.count)
    for piece in cycle.pieces:
        width = np.diff(piece.steps)
        centre, reach = piece.steps[:-1] + 0.5 * width, width * math.sqrt(3.0) / 6.0
        one, two = (_matrix(system, piece, centre + sign * reach) for sign in (-1.0, 1.0))
        h = width[:, None, None]
        steps = expm(0.5 * h * (one + two) + math.sqrt(3.0) / 12.0 * h**2 * (two @ one - one @ two))
        whole = piece.jump @ functools.reduce(lambda done, step: step @ done, steps, whole)
    return whole


def _matrix(system: RelativeMotion, piece: Piece, times: Array) -> Array:
    order = _order(system.count)
    slopes = system.slopes(times, piece.solution(times), piece.side, piece.middle)
    matrix = np.zeros_like(slopes)
    matrix[:, :-1, :-1] = slopes[:, order][:, :, order]
    gain = system.per_load[:, 2] * system.balanced_torque
    matrix[:, 1, -1], matrix[:, -2, -1] = gain[0] - gain[1], gain[0]
    matrix[:, 2 + system.count : -2, -1] = gain[2:]
    return matrix
