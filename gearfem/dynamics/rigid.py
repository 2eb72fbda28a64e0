"""The rigid model: one degree of freedom, two inertias joined by a gear ratio that varies with the angle."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from gearfem.dynamics.periodic import Curve, Through, smooth
from gearfem.dynamics.record import DriveTrain, RigidMotion
from gearfem.engagement.record import MeshForce
from gearfem.foundation import Array, InputError, SolveError

FEWEST_SAMPLES = 8
# Slower than this part of the mean (or where one sample takes half the period), the time is not resolved.
SLOWEST = 0.05


def rigid_motion(pinion_angle: Array, gear_ratio: Array, period: float, drive: DriveTrain, through: Through = smooth) -> RigidMotion:
    """Return the periodic motion of two inertias joined by a variable gear ratio.

    The kinetic energy follows from the work of the torques; the wheel's torque is scaled so that the work over
    one period balances, and the level of the energy is that at which the mean speed is the nominal one.

    Parameters
    ----------
    pinion_angle : ndarray, shape (n,)
        Equally spaced angles over one period, the end excluded [rad].
    gear_ratio : ndarray, shape (n,)
        i = dphi1/dphi2 at these angles, positive.
    period : float
        Angle after which the ratio repeats [rad].
    drive : DriveTrain
        Inertias, torques, efficiency and mean speed.
    through : Through
        Curve through the samples of 1/i: `smooth`, or `kinked` for a ratio whose slope jumps.

    Returns
    -------
    RigidMotion
        The motion at the same angles.

    Raises
    ------
    InputError
        If the angles are not equally spaced over the period, or a ratio is not positive.
    SolveError
        If the work within the period exceeds the kinetic energy, so that the pinion would nearly stop.

    Notes
    -----
    With s = 1/i: J_m = J1 + J2 s^2, d(J_m omega^2/2)/dphi = T1 - T2 s/eta, and from it
    phi1'' = (T1 - T2 s/eta - omega^2 J2 s s')/J_m, phi2'' = s phi1'' + omega^2 s', Kw = 1 - J1 phi1''/T1.
    s is a periodic piecewise polynomial, whose integral and slope are exact. For a smooth ratio and spline Kw errs by h^4
    of the step h. Where a tooth pair takes up load the slope of s jumps, and Kw with it: a smooth spline overshoots there
    at every step, `kinked` converges with h. `step_error` is the largest change of Kw when every second sample is
    dropped: beside a kink it stays of the size of the jump, and where the ratio itself jumps, of the result.

    References
    ----------
    Wojnarowski & Onishchenko 2003, eqs. (14)-(20), derived again.

    Examples
    --------
    >>> drive = DriveTrain(pinion_inertia=1.0, wheel_inertia=4.0, pinion_torque=10.0, wheel_torque=20.0,
    ...     efficiency=1.0, pinion_speed=50.0, friction_coefficient=0.0, damping_ratio=0.1)
    >>> angle = np.linspace(0.0, 0.4, 64, endpoint=False)
    >>> motion = rigid_motion(angle, 2.0 + 0.02 * np.cos(2 * np.pi * angle / 0.4), 0.4, drive)
    >>> bool(motion.dynamic_factor.max() > 1.0), round(motion.wheel_torque, 3)
    (True, 19.999)
    """
    _refuse(pinion_angle, gear_ratio, period)
    fine = _Balance(through(pinion_angle, 1.0 / gear_ratio, period), pinion_angle, period, drive)
    coarse = _Balance(through(pinion_angle[::2], 1.0 / gear_ratio[::2], period), pinion_angle, period, drive)
    slowness = through(pinion_angle, 1.0 / fine.speed, period).antiderivative()
    return RigidMotion(
        period=period,
        pinion_angle=pinion_angle,
        wheel_angle=fine.wheel_angle,
        time=slowness(pinion_angle) - slowness(pinion_angle[0]),
        pinion_speed=fine.speed,
        pinion_acceleration=fine.acceleration,
        wheel_acceleration=fine.slope * fine.speed**2 + fine.inverse_ratio * fine.acceleration,
        dynamic_factor=fine.dynamic_factor,
        wheel_torque=fine.wheel_torque,
        step_error=float(np.abs(fine.dynamic_factor - coarse.dynamic_factor).max()),
    )


def unloaded_transport(mesh: MeshForce, drive: DriveTrain) -> RigidMotion:
    """Return the motion of the rigid gears under the unloaded gear ratio, the transport of the elastic model.

    Parameters
    ----------
    mesh : MeshForce
        Its unloaded transmission error e_u gives the ratio; e_u = 0 gives uniform rotation.
    drive : DriveTrain
        Inertias, torques, efficiency and mean speed.

    Returns
    -------
    RigidMotion

    Notes
    -----
    r_b1 phi1 - r_b2 phi2 = e_u(phi1), so that 1/i = (r_b1 - e_u')/r_b2, e_u' the slope of a periodic cubic spline.
    """
    slope = smooth(mesh.pinion_angle, mesh.unloaded_error, mesh.period)(mesh.pinion_angle, 1)
    return rigid_motion(mesh.pinion_angle, mesh.base_radius2 / (mesh.base_radius1 - slope), mesh.period, drive)


def uniform_transport(mesh: MeshForce, drive: DriveTrain) -> RigidMotion:
    """Return the uniform rotation of gears with the constant ratio r_b2/r_b1, on the angles of `mesh`.

    Parameters
    ----------
    mesh : MeshForce
        Angles, period and base radii.
    drive : DriveTrain
        Mean speed, inertias and torques.

    Returns
    -------
    RigidMotion
    """
    ratio = np.full_like(mesh.pinion_angle, mesh.base_radius2 / mesh.base_radius1)
    return rigid_motion(mesh.pinion_angle, ratio, mesh.period, drive)


class _Balance:
    """The balanced state for one curve of 1/i, evaluated at `angle`."""

    def __init__(self, spline: Curve, angle: Array, period: float, drive: DriveTrain) -> None:
        turned = spline.antiderivative()
        turn = float(turned(angle[0] + period) - turned(angle[0]))
        self.inverse_ratio: Array = spline(angle)
        self.slope: Array = spline(angle, 1)
        self.wheel_angle: Array = turned(angle) - turned(angle[0])
        self.wheel_torque = drive.efficiency * drive.pinion_torque * period / turn
        reduced = self.wheel_torque / drive.efficiency
        work = drive.pinion_torque * (angle - angle[0]) - reduced * self.wheel_angle
        one, two = drive.pinion_side_inertia, drive.wheel_side_inertia
        inertia = one + two * self.inverse_ratio**2
        self.speed = _speed(work, inertia, drive.pinion_speed)
        torque = drive.pinion_torque - reduced * self.inverse_ratio
        gyration = two * self.inverse_ratio * self.slope * self.speed**2
        self.acceleration: Array = (torque - gyration) / inertia
        self.dynamic_factor: Array = 1.0 - one * self.acceleration / drive.pinion_torque


def _speed(work: Array, inertia: Array, mean: float) -> Array:
    """Return the speed at the energy level where the harmonic mean over equal angles is `mean`: period over time."""

    def excess(level: float) -> float:
        return float(np.mean(np.sqrt(inertia / (2.0 * (level + work))))) - 1.0 / mean

    highest = 0.5 * float(inertia.max()) * mean**2 * (1.0 + 1e-9) - float(work.min())
    lowest = -float(work.min()) + 1e-12 * abs(highest)
    if excess(lowest) > 0.0:
        level = brentq(excess, lowest, highest, xtol=1e-15 * abs(highest), rtol=1e-15)
        speed: Array = np.sqrt(2.0 * (level + work) / inertia)
        if speed.min() > mean * max(SLOWEST, 2.0 / work.size):
            return speed
    raise SolveError(f"rigid model: the work within one period nearly stops the pinion at a mean speed of {mean:g} rad/s; raise the speed")


def _refuse(angle: Array, ratio: Array, period: float) -> None:
    count = angle.size
    if count < FEWEST_SAMPLES or ratio.shape != angle.shape:
        found = f"{angle.shape} angles, {ratio.shape} ratios"
        raise InputError("rigid_motion, gear_ratio", found, f"one ratio per angle, at least {FEWEST_SAMPLES}")
    if not np.allclose(angle, angle[0] + period * np.arange(count) / count, rtol=0.0, atol=1e-9 * period):
        raise InputError("rigid_motion, pinion_angle", "unequal steps", f"{count} equal steps over the period {period:g} rad, end excluded")
    if not (np.isfinite(ratio).all() and (ratio > 0.0).all()):
        raise InputError("rigid_motion, gear_ratio", f"{ratio.min()}", "positive, finite ratios")
