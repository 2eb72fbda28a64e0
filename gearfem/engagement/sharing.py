"""How pairs share a load: contact with gaps for any number of pairs, and the closed form for two."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gearfem.contact import Line
from gearfem.engagement.lead_approach import LeadApproach
from gearfem.foundation import Array, Record, SolveError

ITERATIONS = 80
TOLERANCE = 1e-12
# A step of Newton's method after which the next one would be its square: loads are then inverted. That those of all pairs agree is judged
# by `TOLERANCE`, to which the last such step is as small.
CLOSE = 1e-8


class LineLaw(Protocol):
    """Approach of one line contact under a line load, without the teeth."""

    def respond(self, force: Array, line: Line, /) -> tuple[Array, Array]:
        """Return the approach [m] under line loads [N/m] and its slope [m per N/m]."""

    def beside(self, force: Array, distance: Array, line: Line, /) -> Array:
        """Return the approach at a distance [m] beside a contact as wide as under a line load [N/m], per load on it [m per N/m]."""


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class PairSystem(Record):
    """All pairs at n angles, ready to be loaded.

    Parameters
    ----------
    linear : ndarray, shape (n, p, p)
        Compliance without contact [m per N/m].
    lever : ndarray, shape (n, p)
        Approach of each pair per transmission error, l2/r_b2.
    arm : ndarray, shape (n, p)
        Torque on the pinion per line load on each pair: l1 times the face width [m2].
    gap : ndarray, shape (n, p)
        Transmission error at which each pair touches [m].
    line : Line of ndarrays, shape (n, p)
        Geometry of the line contacts.
    lead : LeadApproach of shape (n, p), optional
        What a gap that opens along the face width adds to the approach.
    """

    linear: Array
    lever: Array
    arm: Array
    gap: Array
    line: Line
    lead: LeadApproach | None = None

    def approach(self, law: LineLaw, force: Array) -> Array:
        """Return the approach of each pair [m] under line loads [N/m], shape (n, p)."""
        linear: Array = np.einsum("ajk,ak->aj", self.linear, force)
        return linear + self.local(law).approach(force)

    def local(self, law: LineLaw) -> LocalApproach:
        """Return what each pair yields besides its teeth and bodies."""
        return LocalApproach(law, self.line, self.lead)


class LocalApproach(NamedTuple):
    """Contact and lead of many pairs."""

    law: LineLaw
    line: Line
    lead: LeadApproach | None

    def at(self, chosen: NDArray[np.bool_]) -> LocalApproach:
        """Return those of some of the pairs."""
        lead = None if self.lead is None else self.lead.at(chosen)
        return LocalApproach(self.law, Line(*(values[chosen] for values in self.line)), lead)

    def approach(self, force: Array) -> Array:
        """Return the approach [m] under line loads [N/m]."""
        return self.respond(force)[0]

    def respond(self, force: Array) -> tuple[Array, Array]:
        """Return the approach [m] under line loads [N/m] and its slope [m per N/m]."""
        approach, slope = self.law.respond(force, self.line)
        if self.lead is None:
            return approach, slope
        further, rate = self.lead.respond(force)
        return approach + further, slope + rate


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Sharing(Record):
    """Loads of all pairs.

    Parameters
    ----------
    force : ndarray, shape (n, p)
        Line loads [N/m], not negative.
    transmission_error : ndarray, shape (n,)
        Common lag of the wheel [m].
    slope : ndarray, shape (n,)
        Change of the transmission error with the torque [m per N m]; 0 where the transmission error was given.
    """

    force: Array
    transmission_error: Array
    slope: Array


def share_torque(system: PairSystem, law: LineLaw, torque: float) -> Sharing:
    """Return the loads under a torque: contact with gaps, complementary, summing to the torque.

    Parameters
    ----------
    system : PairSystem
        Compliance, gaps and arms of all pairs.
    law : LineLaw
        Contact law.
    torque : float
        Torque on the pinion [N m], positive.

    Returns
    -------
    Sharing

    Raises
    ------
    SolveError
        If any angle does not converge to 1e-12 of the load.

    Notes
    -----
    Pair j touches where its available approach a_j = (e - gap_j) l2/r_b2 - sum_(k != j) C_jk f_k is positive,
    and then carries f_j = g_j(a_j), the inverse of C_jj f + h(f). g_j is continuous, increasing and zero for
    a_j <= 0, so the complementarity becomes the equation f = g(a(f, e)), solved by Newton's method for all
    angles at once. It starts above the solution (one pair alone), from where the convex g leads down.
    """
    # Counted from the first touch, so that a small deflection keeps its digits beside a large gap.
    touch = system.gap.min(axis=1)
    system = dataclasses.replace(system, gap=system.gap - touch[:, None])
    alone = _invert_alone(system, law, torque)
    force: Array = np.zeros_like(system.gap)
    rows = np.arange(len(force))
    best = np.argmin(alone, axis=1)
    error = alone[rows, best]
    force[rows, best] = torque / system.arm[rows, best]
    for _ in range(ITERATIONS):
        carried, slope = _respond(system, law, force, error)
        residual = carried - force
        missing = torque - (system.arm * force).sum(axis=1)
        off = np.maximum(np.abs(residual).max(axis=1) / force.max(axis=1), np.abs(missing) / torque)
        if off.max() < TOLERANCE:
            return Sharing(force=force, transmission_error=touch + error, slope=_error_slope(system, slope))
        matrix = _bordered(system, slope)
        step = np.linalg.solve(matrix, np.concatenate([residual, missing[:, None]], axis=1)[..., None])[..., 0]
        force = _not_pulling(force + step[:, :-1])
        error = error + step[:, -1]
    worst = int(np.argmax(off))
    raise SolveError(f"load sharing did not converge at {torque:g} N m (angle number {worst} of {len(force)})")


def share_error(system: PairSystem, law: LineLaw, error: Array, start: Array | None = None) -> Sharing:
    """Return the loads at a given transmission error.

    Parameters
    ----------
    system, law
        As for `share_torque`.
    error : ndarray, shape (n,)
        Transmission error [m].
    start : ndarray, shape (n, p), optional
        Line loads to start from [N/m].

    Returns
    -------
    Sharing

    Raises
    ------
    SolveError
        If any angle does not converge.
    """
    force: Array = np.array(np.zeros_like(system.gap) if start is None else start)
    eye = np.eye(force.shape[1])
    for _ in range(ITERATIONS):
        carried, slope = _respond(system, law, force, error)
        residual = carried - force
        if np.abs(residual).max() <= TOLERANCE * max(force.max(), 1.0):
            return Sharing(force=force, transmission_error=error, slope=np.zeros_like(error))
        matrix = eye + slope[..., None] * _coupling(system)
        force = _not_pulling(force + np.linalg.solve(matrix, residual[..., None])[..., 0])
    raise SolveError("load sharing at a given transmission error did not converge")


def _not_pulling(force: Array) -> Array:
    """Return the loads of a Newton step with those that would pull set to 0, from where they may return."""
    return np.where(force > 0.0, force, 0.0)


def _coupling(system: PairSystem) -> Array:
    eye = np.eye(system.gap.shape[1])
    return system.linear * (1.0 - eye)


def _bordered(system: PairSystem, slope: Array) -> Array:
    count = system.gap.shape[1]
    matrix = np.zeros((len(slope), count + 1, count + 1))
    matrix[:, :count, :count] = np.eye(count) + slope[..., None] * _coupling(system)
    matrix[:, :count, count] = -slope * system.lever
    matrix[:, count, :count] = system.arm
    return matrix


def _error_slope(system: PairSystem, slope: Array) -> Array:
    matrix = _bordered(system, slope)
    unit = np.zeros((len(slope), matrix.shape[1], 1))
    unit[:, -1] = 1.0
    return np.asarray(np.linalg.solve(matrix, unit)[:, -1, 0], dtype=np.float64)


def _respond(system: PairSystem, law: LineLaw, force: Array, error: Array) -> tuple[Array, Array]:
    """Return the line load g_j of each pair in its available approach, and its slope g'."""
    available = (error[:, None] - system.gap) * system.lever - np.einsum("ajk,ak->aj", _coupling(system), force)
    touching = available > 0.0
    own = np.einsum("ajj->aj", system.linear)
    carried, slope = np.zeros_like(available), np.zeros_like(available)
    carried[touching], slope[touching] = _invert(system.local(law).at(touching), available[touching], own[touching], force[touching])
    return carried, slope


def _invert(local: LocalApproach, available: Array, own: Array, near: Array) -> tuple[Array, Array]:
    """Return f with own f + h(f) = available, and df/d(available), from loads nearby on, or the chord's where one is 0.

    As h is concave, the chord bounds f from above, and a step from either side ends below f, from where steps lead up.
    """
    force = near
    if not (near > 0.0).all():
        bound = available / own
        force = np.where(near > 0.0, near, available / (own + local.approach(bound) / bound))
    for _ in range(ITERATIONS):
        approach, compliance = local.respond(force)
        step = (available - own * force - approach) / (own + compliance)
        force = np.maximum(force + step, 0.1 * force)
        if np.all(np.abs(step) <= CLOSE * force):
            return force, 1.0 / (own + compliance)
    raise SolveError("the contact law could not be inverted")


def _invert_alone(system: PairSystem, law: LineLaw, torque: float) -> Array:
    """Return the transmission error at which each pair carries the whole torque alone, shape (n, p)."""
    force = torque / system.arm
    own = np.einsum("ajj->aj", system.linear)
    approach = own * force + system.local(law).approach(force)
    alone: Array = system.gap + approach / system.lever
    return alone


def share_two_pairs(load: float, stiffness: tuple[float, float], backlash: float, tolerance: float = 0.0) -> tuple[float, float]:
    """Return the loads of two uncoupled linear pairs K and S by the paper's three cases.

    Parameters
    ----------
    load : float
        Whole normal force P_n [N].
    stiffness : (float, float)
        Single stiffnesses C_K and C_S [N/m]; pair K touches first.
    backlash : float
        Backlash L_S of the neighbour pair along the line of action [m].
    tolerance : float
        Backlash up to which both pairs count as touching [m].

    Returns
    -------
    (float, float)
        P_K and P_S [N].

    Notes
    -----
    Wojnarowski & Onishchenko (2003), end of section 2; the closed form of `share_torque` for two pairs.

    Examples
    --------
    >>> share_two_pairs(100.0, (2.0, 2.0), 10.0)
    (60.0, 40.0)
    """
    first, second = stiffness
    if abs(backlash) <= tolerance:
        closing = 0.0
    elif backlash <= load / first:
        closing = backlash * first
    else:
        return load, 0.0
    shared = (load - closing) * first / (first + second) + closing
    return shared, load - shared
