"""Equations of the elastic motion relative to its transport, in scaled coordinates, one contact state at a time."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
from scipy.interpolate import CubicSpline, PPoly
from scipy.optimize import brentq

from gearfem.dynamics.flank_force import flank_force
from gearfem.dynamics.record import DriveTrain, RigidMotion
from gearfem.engagement.record import MeshForce
from gearfem.foundation import Array, InputError


@dataclasses.dataclass(frozen=True)
class Carried:
    """The transport at given times, arrays of one shape: `offset` is r_b1 phi1 - r_b2 phi2 - e_u [m], `drift` its rate."""

    angle: Array
    speed: Array
    pinion_acceleration: Array
    wheel_acceleration: Array
    offset: Array
    drift: Array


@dataclasses.dataclass(frozen=True)
class Touch:
    """One flank at given times: depth [m], force [N] (no contact where either is negative), slope [N/m], and (..., 2) arms [m].

    The arms are those of M1 and M2 with friction; `turns` are their slopes over the depth.
    """

    depth: Array
    force: Array
    stiffness: Array
    arms: Array
    turns: Array


class RelativeMotion:
    """Two inertias on their transport, joined by flanks with backlash, friction and damping.

    State y = (x, x', r_b1 q1, r_b1 q1') with x = r_b1 q1 - r_b2 q2, lengths in units of X = T1/(r_b1 C), times in
    units of 1/omega_n = sqrt(M/C). Forces depend on x, x' and time alone, so that the common rotation is a
    quadrature beside the relative motion.

    Parameters
    ----------
    mesh : MeshForce
        Forces of the working flanks.
    drive : DriveTrain
        Inertias, torques, damping and friction.
    transport : RigidMotion
        Motion that the elastic one is counted from, over the period of `mesh`.

    Notes
    -----
    psi_i = phi_i + q_i; depth d = r_b1 psi1 - r_b2 psi2 - e_u(phi1). Working flank (side +1): P = P(phi1, d) + D d' where
    both d > 0 and P > 0, else 0. Back flank (side -1): the same law for -d - j_n, as if its pairs met at the same
    angles, which they do not quite. J1 psi1'' = T1 - M1, J2 psi2'' = M2 - T2 with M_i = P (side a_i + f b_i): the arms
    share P as in the table, and friction keeps its direction on the back flank, since sliding does.
    D = 2 zeta sqrt(C M), M = m1 m2/(m1 + m2), m_i = J_i/r_bi^2. The tables are taken at the transport's angle phi1,
    which misses the true angle by q1: about X/r_b1, and more where the drive turns so slowly that the torques swing it.

    References
    ----------
    Wojnarowski & Onishchenko 2003, eqs. (21)-(28); signs of friction on both flanks derived from v_sl F_t >= 0.
    """

    def __init__(self, mesh: MeshForce, drive: DriveTrain, transport: RigidMotion) -> None:
        if not math.isclose(transport.period, mesh.period, rel_tol=1e-9):
            raise InputError("transport.period", transport.period, f"the period of the mesh, {mesh.period:g} rad")
        self.mesh, self.drive = mesh, drive
        self.force = flank_force(mesh)
        r1, r2 = mesh.base_radius1, mesh.base_radius2
        mass1, mass2 = drive.pinion_inertia / r1**2, drive.wheel_inertia / r2**2
        mass = mass1 * mass2 / (mass1 + mass2)
        self.natural = math.sqrt(mesh.mean_stiffness / mass)
        self.damping = 2.0 * drive.damping_ratio * math.sqrt(mesh.mean_stiffness * mass)
        self.unit = drive.pinion_torque / (r1 * mesh.mean_stiffness)
        self.length = self.natural * mesh.period / drive.pinion_speed
        self.friction = drive.friction_coefficient > 0.0
        self.gain1 = r1 / (drive.pinion_inertia * self.unit * self.natural**2)
        self.gain2 = r2 / (drive.wheel_inertia * self.unit * self.natural**2)
        self.balanced_torque = drive.pinion_torque * r2 / r1
        self._carry(transport, r1, r2)

    def _carry(self, transport: RigidMotion, r1: float, r2: float) -> None:
        """Put the transport into one spline of time, so that its accelerations belong exactly to its angles."""
        angle, speed = transport.pinion_angle, self.drive.pinion_speed
        self.unloaded = _closed(self.mesh.pinion_angle, self.mesh.unloaded_error, self.mesh.period)
        uniform = speed * transport.time
        one, two = angle - angle[0] - uniform, transport.wheel_angle - uniform * r1 / r2
        offset = r1 * one - r2 * two - self.unloaded(angle)
        spline = _closed(transport.time, np.stack([one, two, offset], axis=1), self.mesh.period / speed)
        pieces = np.zeros((4, spline.x.size - 1, 6))
        for column, (order, source) in enumerate([(0, 0), (1, 0), (2, 0), (2, 1), (0, 2), (1, 2)]):
            pieces[order:, :, column] = spline.derivative(order).c[:, :, source] if order else spline.c[:, :, source]
        self._carrier = PPoly(pieces, spline.x, extrapolate="periodic")
        self._start = float(angle[0])

    def transport(self, time: Array | float) -> Carried:
        """Return the transport at scaled times."""
        seconds = np.asarray(time) / self.natural
        columns = self._carrier(seconds)
        speed = self.drive.pinion_speed
        angle = self._start + speed * seconds + columns[..., 0]
        return Carried(angle, speed + columns[..., 1], columns[..., 2], columns[..., 3], columns[..., 4], columns[..., 5])

    def contact(self, carried: Carried, x: Array, rate: Array, side: int, middle: Array | float) -> Touch:
        """Return one flank (side +1 working, -1 back) for scaled x and x'; `middle` is an angle on this side of the reversals."""
        depth = self.unit * x + carried.offset
        speed = self.unit * self.natural * rate + carried.drift
        if side < 0:
            depth, speed = -depth - self.mesh.normal_backlash, -speed
        values, slopes = self.force(carried.angle, depth, middle, self.friction)
        f = self.drive.friction_coefficient
        arms = side * values[..., 1:3] + f * values[..., 3:5]
        turns = side * slopes[..., 1:3] + f * slopes[..., 3:5]
        return Touch(depth, values[..., 0] + self.damping * speed, slopes[..., 0], arms, turns)

    def change(self, time: float, state: Array, torque: float, side: int, middle: float) -> Array:
        """Return the derivative of the scaled state, shape (4,); `torque` is the wheel's in units of the balanced one.

        The flank of `side` acts whatever the sign of its force; 0 is free flight.
        """
        carried = self.transport(time)
        one = two = 0.0
        if side:
            touch = self.contact(carried, state[0], state[1], side, middle)
            one, two = touch.force * touch.arms
        pinion = self.gain1 * (self.drive.pinion_torque - one - self.drive.pinion_inertia * carried.pinion_acceleration)
        wheel = self.gain2 * (two - torque * self.balanced_torque - self.drive.wheel_inertia * carried.wheel_acceleration)
        return np.array([state[1], pinion - wheel, state[3], pinion])

    def gradients(self, time: Array | float, x: Array, rate: Array, side: int, middle: float) -> Array:
        """Return d(x'', r_b1 q1'')/d(x, x') in scaled units, shape (..., 2, 2)."""
        if side == 0:
            return np.zeros((*np.shape(x), 2, 2))
        touch = self.contact(self.transport(time), x, rate, side, middle)
        over_x = side * self.unit * (touch.stiffness[..., None] * touch.arms + touch.force[..., None] * touch.turns)
        over_rate = side * self.unit * self.natural * self.damping * touch.arms
        both = np.stack([over_x, over_rate], axis=-1)
        pinion, wheel = -self.gain1 * both[..., 0, :], self.gain2 * both[..., 1, :]
        return np.stack([pinion - wheel, pinion], axis=-2)

    def closeness(self, time: float, state: Array, side: int, middle: float) -> float:
        """Return a scaled number that is positive where the flank of that side is in contact, continuous in the state."""
        touch = self.contact(self.transport(time), state[0], state[1], side, middle)
        pull = touch.force if touch.depth > 0.0 else touch.force - touch.stiffness * touch.depth
        return float(min(touch.depth, pull / self.mesh.mean_stiffness)) / self.unit

    def intervals(self) -> list[tuple[float, float, float]]:
        """Return start, end (scaled times) and middle angle of the parts of one cycle between reversals of the sliding."""
        times = [self._time_of(reversal) for reversal in self.force.reversals] if self.friction else []
        edge = 1e-9 * self.length
        edges = [0.0, *sorted(t for t in times if edge < t < self.length - edge), self.length]
        spans = itertools.pairwise(edges)
        return [(a, b, float(self.transport(0.5 * (a + b)).angle)) for a, b in spans]

    def _time_of(self, angle: float) -> float:
        goal = self._start + (angle - self._start) % self.mesh.period
        root: float = brentq(lambda time: float(self.transport(time).angle) - goal, -0.5 * self.length, 1.5 * self.length)
        return root


def _closed(x: Array, values: Array, period: float) -> CubicSpline:
    return CubicSpline(np.append(x, x[0] + period), np.concatenate([values, values[:1]]), bc_type="periodic")
