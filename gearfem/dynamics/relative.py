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
from gearfem.dynamics.shafting import Shafting
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
    """A drive train on its transport, joined by flanks with backlash, friction and damping.

    State y = (x, x', r_b1 q1, r_b1 q1', z, z') with x = r_b1 q1 - r_b2 q2 and z the k stretches of shafts (times r_b1 or
    r_b2) and supports, none for two inertias; lengths in units of X = T1/(r_b1 C), times in units of 1/omega_n =
    sqrt(M/C). Forces depend on x, z, their rates and time alone, so that the common rotation is a quadrature.

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
        self._join(r1, r2)
        self._carry(transport, r1, r2)

    def _join(self, r1: float, r2: float) -> None:
        """Scale the shafting: accelerations of r_b1 psi1, r_b2 psi2 and the stretches, per load, stretch and its rate."""
        train = self.shafting = Shafting(self.drive)
        count = self.count = train.springs.size
        arms = np.where(train.supports, 1.0, np.where(np.arange(count) < train.wheel - 1, r1, r2))
        rows = np.zeros((2 + count, 2 + count))
        rows[0, 0], rows[1, train.wheel], rows[2:] = r1, r2, arms[:, None] * train.stretches
        per_force = rows / train.masses / (self.unit * self.natural**2)
        self.per_load = per_force @ train.loads
        self.per_stretch = -per_force @ (train.stretches.T * (train.springs * self.unit / arms))
        self.per_rate = -per_force @ (train.stretches.T * (train.dampers * self.unit * self.natural / arms))
        self.stretch_unit = self.unit / arms
        self.yielding = train.supports.astype(float)
        self.rotation = np.array([r1, r2]) / (self.unit * self.natural**2)

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

    def approach(self, state: Array) -> tuple[Array, Array]:
        """Return scaled approach of the flanks and its rate, x less what the supports yield, for states (4 + 2 k, ...)."""
        if not self.count:
            return state[0], state[1]
        z, rates = self.stretches(state)
        return state[0] - np.tensordot(self.yielding, z, axes=1), state[1] - np.tensordot(self.yielding, rates, axes=1)

    def stretches(self, state: Array) -> tuple[Array, Array]:
        """Return the scaled stretches and their rates, each (k, ...)."""
        return state[4 : 4 + self.count], state[4 + self.count :]

    def stretch_loads(self, state: Array) -> Array:
        """Return torque of each shaft [N m] and force of each support [N], shape (k, n), for states (4 + 2 k, n)."""
        z, rates = self.stretches(state)
        train, unit = self.shafting, self.stretch_unit[:, None]
        loads: Array = unit * (train.springs[:, None] * z + self.natural * train.dampers[:, None] * rates)
        return loads

    def change(self, time: float, state: Array, torque: float, side: int, middle: float) -> Array:
        """Return the derivative of the scaled state; `torque` is the wheel's in units of the balanced one.

        The flank of `side` acts whatever the sign of its force; 0 is free flight.
        """
        carried = self.transport(time)
        one = two = push = 0.0
        if side:
            touch = self.contact(carried, *self.approach(state), side, middle)
            one, two = touch.force * touch.arms
            push = side * float(touch.force)
        z, rates = self.stretches(state)
        loads = np.array([self.drive.pinion_torque, one, torque * self.balanced_torque, two, push])
        gain = self.per_load @ loads + self.per_stretch @ z + self.per_rate @ rates
        pinion = gain[0] - self.rotation[0] * carried.pinion_acceleration
        wheel = gain[1] - self.rotation[1] * carried.wheel_acceleration
        return np.concatenate([[state[1], pinion - wheel, state[3], pinion], rates, gain[2:]])

    def slopes(self, time: Array | float, state: Array, side: int, middle: float) -> Array:
        """Return the derivative of `change` over the state, shape (..., 4 + 2 k, 4 + 2 k), for states (4 + 2 k, ...)."""
        size, count = 4 + 2 * self.count, self.count
        stretch, rate = slice(4, 4 + count), slice(4 + count, size)
        gains = np.zeros((*np.shape(state)[1:], 2 + count, size))
        gains[..., stretch], gains[..., rate] = self.per_stretch, self.per_rate
        if side:
            x, speed = self.approach(state)
            touch = self.contact(self.transport(time), x, speed, side, middle)
            over_x = side * self.unit * (touch.stiffness[..., None] * touch.arms + touch.force[..., None] * touch.turns)
            over_rate = side * self.unit * self.natural * self.damping * touch.arms
            push = np.broadcast_to(self.unit * self.natural * self.damping, np.shape(x))
            by_x = np.stack([over_x[..., 0], over_x[..., 1], self.unit * touch.stiffness], axis=-1) @ self.per_load[:, [1, 3, 4]].T
            by_rate = np.stack([over_rate[..., 0], over_rate[..., 1], push], axis=-1) @ self.per_load[:, [1, 3, 4]].T
            gains[..., 0], gains[..., 1] = by_x, by_rate
            gains[..., stretch] -= by_x[..., None] * self.yielding
            gains[..., rate] -= by_rate[..., None] * self.yielding
        matrix = np.zeros((*np.shape(state)[1:], size, size))
        matrix[..., 0, 1] = matrix[..., 2, 3] = 1.0
        matrix[..., 1, :], matrix[..., 3, :] = gains[..., 0, :] - gains[..., 1, :], gains[..., 0, :]
        matrix[..., stretch, rate] = np.eye(count)
        matrix[..., rate, :] = gains[..., 2:, :]
        return matrix

    def closeness(self, time: float, state: Array, side: int, middle: float) -> float:
        """Return a scaled number that is positive where the flank of that side is in contact, continuous in the state."""
        touch = self.contact(self.transport(time), *self.approach(state), side, middle)
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
