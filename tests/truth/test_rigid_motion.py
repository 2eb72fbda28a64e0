"""The rigid model against its energy integral, a direct integration of its equation, and its order in the step."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gearfem.dynamics import RigidMotion, rigid_motion
from gearfem.dynamics.periodic import kinked

PERIOD = 2.0 * math.pi / 16.0
MEAN = 51.0 / 16.0


def ratio(angle: np.ndarray) -> np.ndarray:
    """Return a ratio with 3 % of ripple and a sharper second half."""
    turn = 2.0 * math.pi * angle / PERIOD
    return MEAN * (1.0 + 0.03 * np.sin(turn + 0.4 * np.cos(turn)))


def ratio_slope(angle: float) -> float:
    """Return di/dphi of `ratio`."""
    turn = 2.0 * math.pi * angle / PERIOD
    return MEAN * 0.03 * np.cos(turn + 0.4 * np.cos(turn)) * (1.0 - 0.4 * np.sin(turn)) * 2.0 * math.pi / PERIOD


def solve(drive, count: int) -> RigidMotion:
    angle = PERIOD * np.arange(count) / count
    return rigid_motion(angle, ratio(angle), PERIOD, drive)


def test_a_constant_ratio_rotates_uniformly_at_the_balanced_torque(coal_drive):
    angle = PERIOD * np.arange(32) / 32
    motion = rigid_motion(angle, np.full(32, MEAN), PERIOD, coal_drive)
    # Rounding of sums of 32 terms.
    assert np.allclose(motion.pinion_speed, 53.0, rtol=1e-13)
    assert np.abs(motion.dynamic_factor - 1.0).max() < 1e-11
    assert motion.wheel_torque == pytest.approx(0.96 * 1605.0 * MEAN, rel=1e-13, abs=0.0)
    assert motion.step_error < 1e-11


def test_equation_of_motion_holds_and_time_and_angle_agree(coal_drive):
    """Integrate (15)-(16) with the exact ratio and slope over one period, by another method and in time."""
    motion = solve(coal_drive, 1024)
    t1, t2, j1, j2 = 1605.0, motion.wheel_torque / 0.96, 10.16, 6.72

    def change(_: float, y: np.ndarray) -> list[float]:
        i, slope = ratio(y[0]), ratio_slope(y[0])
        inertia, inertia_slope = j1 + j2 / i**2, -2.0 * j2 * slope / i**3
        return [y[1], (t1 - t2 / i - 0.5 * y[1] ** 2 * inertia_slope) / inertia]

    period = PERIOD / coal_drive.pinion_speed
    start = [0.0, motion.pinion_speed[0]]
    times = np.append(motion.time, period)
    result = solve_ivp(change, (0.0, period), start, method="DOP853", t_eval=times, rtol=1e-12, atol=1e-12)
    # The spline of 1/i errs by h^4 = (2 pi / 1024)^4 times the fourth derivative: below 1e-9.
    assert np.abs(result.y[0][:-1] - motion.pinion_angle).max() < 1e-9
    assert np.abs(result.y[1][:-1] / motion.pinion_speed - 1.0).max() < 1e-9
    assert result.y[0][-1] == pytest.approx(PERIOD, abs=1e-9)
    assert result.y[1][-1] == pytest.approx(start[1], rel=1e-9, abs=0.0)


def test_energy_is_conserved_without_losses(coal_drive):
    """Kinetic energy minus work, with the exact ratio: constant to 1e-8 of the energy."""
    drive = dataclasses.replace(coal_drive, efficiency=1.0)
    motion = solve(drive, 1024)
    inertia = 10.16 + 6.72 / ratio(motion.pinion_angle) ** 2
    work = drive.pinion_torque * motion.pinion_angle - motion.wheel_torque * motion.wheel_angle
    energy = 0.5 * inertia * motion.pinion_speed**2 - work
    assert np.ptp(energy) < 1e-8 * energy.mean()


def test_the_wheel_follows_the_ratio(coal_drive):
    """phi2'' against the derivative of omega/i by differences over time on a fine grid."""
    motion = solve(coal_drive, 4096)
    wheel_speed = motion.pinion_speed / ratio(motion.pinion_angle)
    differences = np.gradient(wheel_speed, motion.time)
    # Central differences err by h^2 = (2 pi / 4096)^2, a few times 1e-6 of the largest value.
    assert np.abs(differences - motion.wheel_acceleration)[2:-2].max() < 2e-5 * np.abs(motion.wheel_acceleration).max()


def test_kw_above_one_means_teeth_loaded_above_the_torque(coal_drive):
    """Torque of the teeth on the pinion from the wheel's side: J2 phi2'' + T2/eta, moved by 1/i."""
    motion = solve(coal_drive, 512)
    i = ratio(motion.pinion_angle)
    # phi1'' from eq. (16) shares kinetic energy; per shaft, T1 - J1 phi1'' must equal (T2/eta + J2 phi2'')/i.
    teeth = (motion.wheel_torque / 0.96 + 6.72 * motion.wheel_acceleration) / i
    assert np.allclose(motion.dynamic_factor * 1605.0, teeth, rtol=1e-6)


def test_the_result_does_not_depend_on_the_step(coal_drive):
    """At its knots a periodic cubic spline's slope errs by h^4, and so does Kw; the reported step error bounds the true one."""
    exact = solve(coal_drive, 4096)
    counts = (32, 64, 128, 256)
    errors = []
    for count in counts:
        motion = solve(coal_drive, count)
        errors.append(np.abs(motion.dynamic_factor - exact.dynamic_factor[:: 4096 // count]).max())
        assert errors[-1] < motion.step_error
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    print("orders of Kw in the angle step:", orders)
    assert orders.min() > 3.8


def test_a_kink_of_the_ratio_leaves_a_limit(coal_drive):
    """Where the slope of the ratio jumps, so does Kw: Akima's curve tends to the limit from one side, halving with the step."""
    largest = []
    for count in (400, 800, 1600, 3200):
        angle = PERIOD * (np.arange(count) + 0.3) / count
        part = angle / PERIOD
        bump = np.clip(part - 0.4, 0.0, None) * np.exp(-40.0 * np.clip(part - 0.4, 0.0, None))
        largest.append(rigid_motion(angle, 3.1875 + 2.0 * bump, PERIOD, coal_drive, kinked).dynamic_factor.max())
    changes = np.abs(np.diff(largest))
    assert changes[-1] < 0.02 * (largest[-1] - 1.0)
    assert changes[-1] < 0.7 * changes[0]


def test_a_jump_of_the_ratio_is_told_by_the_step_error(coal_drive):
    """A ratio that jumps has no step-free answer: the step error stays of the size of the result."""
    for count in (128, 512):
        angle = PERIOD * np.arange(count) / count
        motion = rigid_motion(angle, np.where(angle < 0.5 * PERIOD, 3.15, 3.22), PERIOD, coal_drive)
        assert motion.step_error > 0.2 * np.abs(motion.dynamic_factor - 1.0).max()
