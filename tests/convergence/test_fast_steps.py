"""Fixed compiled steps against Gear's method: the same motion, fourth order, through impacts and reversals of friction."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest

from gearfem.dynamics import DriveTrain, elastic_motion, uniform_transport, unloaded_transport
from gearfem.dynamics.cycle import integrate_cycle
from gearfem.dynamics.fast import march
from gearfem.dynamics.orbit import shoot
from gearfem.dynamics.relative import RelativeMotion
from gearfem.dynamics.sweep import sweep
from gearfem.dynamics.track import default_steps, make_track, scales
from gearfem.foundation.progress import quiet

RADII, TEETH, STIFFNESS = (60.14e-3, 191.7e-3), 16, 1.4e9
PERIOD = 2.0 * math.pi / TEETH
TANGENT = math.tan(math.radians(26.57))


def varying(angle):
    return STIFFNESS * (1.0 + 0.15 * np.cos(TEETH * angle) + 0.05 * np.sin(2 * TEETH * angle))


def sliding_arms(angle):
    """Friction arms of one involute pair, which the next one replaces half a pitch from the pitch point."""
    path = ((angle / PERIOD + 0.5) % 1.0 - 0.5) * PERIOD * RADII[0]
    return np.sign(path) * (RADII[0] * TANGENT + path), np.sign(path) * (RADII[1] * TANGENT - path)


@pytest.fixture(scope="module")
def rubbing(mesh_factory, coal_drive):
    """Mesh with friction that reverses within the cycle, and its drive; play of 80 um."""
    mesh = mesh_factory(
        TEETH,
        RADII,
        varying,
        angles=128,
        offset=0.3,
        friction=sliding_arms,
        sliding_reversals=np.array([0.0, 0.5 * PERIOD]),
        normal_backlash=80e-6,
    )
    return mesh, dataclasses.replace(coal_drive, friction_coefficient=0.1)


@pytest.mark.parametrize(("start", "events"), [((1.3, 0.5), 0), ((-0.6, 0.3), 1), ((-3.0, -4.0), 5)])
def test_fourth_order_through_impacts_and_reversals(rubbing, start, events):
    """One cycle from three starts: contact throughout, one landing, both flanks in turn."""
    mesh, drive = rubbing
    system = RelativeMotion(mesh, drive, uniform_transport(mesh, drive))
    cycle = integrate_cycle(system, np.array([*start, 0.0, 0.0]), 0.98, 1e-11)
    sides = [piece.side for piece in cycle.pieces]
    assert sum(a != b for a, b in itertools.pairwise(sides)) >= events
    counts, errors = (64, 128, 256, 512), []
    for count in counts:
        end, _, _ = march(make_track(mesh, drive, count), np.array([*start, 0.98]), 1)
        errors.append(float(np.abs(end - cycle.end[[0, 1, 3]]).max()))
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    print(f"start {start}: errors {', '.join(f'{error:.1e}' for error in errors)}, order {order:.2f}")
    # The splines over the angle have kinks of the third derivative, which a step meets at any place: 3.5 to 4.5 in the mean.
    assert order > 3.4
    # Mean deflections, at the least steps of the default.
    assert errors[2] < 2e-5


def test_both_layouts_of_a_cycle_are_the_same(rubbing):
    """Uniform rotation written as a transport, with splines over time, against the layout by angles alone."""
    mesh, drive = rubbing
    even, carried = make_track(mesh, drive, 200), make_track(mesh, drive, 200, uniform_transport(mesh, drive))
    assert np.array_equal(even.first, carried.first)
    for name, size in (("steps", 0.1), ("motion", 1.0), ("table", 1.0)):
        # Rounding: cubics over small cells, of terms up to a thousand times the scale.
        assert np.abs(getattr(even, name) - getattr(carried, name)).max() < 1e-9 * size


def reference_factors(system, cycle):
    """Return largest and least Kw of a cycle by Gear's method, the limits on both sides of every event included."""
    factors = []
    for piece in cycle.pieces:
        times = np.linspace(piece.steps[0], piece.steps[-1], 4001)
        x, rate, _, _ = piece.solution(times)
        touch = system.contact(system.transport(times), x, rate, piece.side, piece.middle)
        factors.append(touch.force * touch.arms[:, 0] / system.drive.pinion_torque)
    return max(values.max() for values in factors), min(values.min() for values in factors)


@pytest.mark.parametrize("speed", [pytest.param(20.0, marks=pytest.mark.slow), 53.0, 160.0, 400.0])
def test_default_steps_keep_kw_within_a_ten_thousandth(rubbing, speed):
    """Largest and least Kw, which may lie at a reversal of friction, wheel torque and multipliers, against BDF at 1e-9."""
    mesh, drive = rubbing
    drive = dataclasses.replace(drive, pinion_speed=speed)
    system = RelativeMotion(mesh, drive, uniform_transport(mesh, drive))
    orbit = shoot(system, np.array([1.0, 0.0, 1.0]), 1e-9, quiet)
    largest, least = reference_factors(system, orbit.cycles[0])
    point = sweep(mesh, drive, [speed]).points[0]
    differences = abs(point.dynamic_factor_max - largest), abs(point.dynamic_factor_min - least)
    print(f"{speed} rad/s, {point.steps} steps: Kw {least:.5f} to {largest:.5f}, off by {differences[1]:.1e} and {differences[0]:.1e}")
    assert max(differences) < 1e-4
    assert point.wheel_torque == pytest.approx(orbit.cycles[0].torque * system.balanced_torque, rel=1e-7, abs=0.0)
    assert point.multiplier_magnitude == pytest.approx(np.sort(np.abs(orbit.multipliers))[::-1], abs=1e-5)
    assert point.period_cycles == 1
    assert point.contact_loss == 0.0


@pytest.fixture
def light(mesh_factory):
    """A light equal pair, 2 % damping, strongly excited: function of tuning and backlash."""
    radius, teeth, stiffness, inertia = 0.0705, 50, 4e8, 0.0076
    natural = math.sqrt(stiffness * 2.0 * radius**2 / inertia)

    def make(tuning, backlash):
        mesh = mesh_factory(
            teeth,
            (radius, radius),
            lambda angle: stiffness * (1.0 + 0.3 * np.cos(teeth * angle)),
            columns=np.linspace(0.0, 30e-6, 13),
            normal_backlash=backlash,
        )
        drive = DriveTrain(
            pinion_inertia=inertia,
            wheel_inertia=inertia,
            pinion_torque=150.0,
            wheel_torque=150.0,
            efficiency=1.0,
            pinion_speed=tuning * natural / teeth,
            friction_coefficient=0.0,
            damping_ratio=0.02,
        )
        return mesh, drive

    return make


@pytest.mark.parametrize(("tuning", "backlash"), [(0.9, 1.0), (0.75, 1.0), (0.7, 20e-6)])
def test_kw_with_contact_loss_agrees_sample_by_sample(light, tuning, backlash):
    """The upper branch of the jump, started alike in both: same Kw at every node, same parts of the time in contact."""
    mesh, drive = light(tuning, backlash)
    # The upper branch is reached from above.
    point = sweep(mesh, drive, np.arange(tuning, 1.21, 0.05) / tuning * drive.pinion_speed, both_ways=True).branch("down")[0]
    motion = elastic_motion(
        mesh, drive, uniform_transport(mesh, drive), cycles=1, samples=2048, tolerance=1e-9, start=tuple(point.state[:2])
    )
    track = make_track(mesh, drive, point.steps)
    _, _, nodes = march(track, point.state / scales(mesh, drive).state, 1, nodes=True)
    factor = nodes[0, :, 3] / track.drive
    times = np.linspace(0.0, 1.0, 2049)[:-1]
    reference = np.interp(track.times[:-1] / track.times[-1], times, motion.dynamic_factor)
    largest = abs(point.dynamic_factor_max - motion.largest_dynamic_factor)
    loss = abs(point.contact_loss - motion.contact_loss)
    apart = np.median(np.abs(factor - reference))
    print(f"tuning {tuning}: Kw {point.dynamic_factor_max:.5f}, BDF differs by {largest:.1e}, loss by {loss:.1e}, samples by {apart:.1e}")
    assert point.contact_loss > 0.3
    assert motion.periodic
    assert largest < 1e-4 * point.dynamic_factor_max
    assert loss < 1e-5
    # Straight lines between 2048 samples of a wave of 3: (2 pi/2048)^2/8 times its height. Samples beside an impact are off by more.
    assert apart < 1e-5


@pytest.mark.slow
def test_worn_teeth_move_as_by_gears_method(mesh_factory, coal_drive):
    """An unloaded error of 20 um: the transport is not uniform, and deflection counts from it."""
    mesh = mesh_factory(
        TEETH, RADII, varying, unloaded=lambda angle: 5e-6 * (1.0 - np.cos(TEETH * angle)) + 2e-6 * (1.0 - np.sin(2 * TEETH * angle))
    )
    for speed in (60.0, 120.0):
        drive = dataclasses.replace(coal_drive, pinion_speed=speed)
        motion = elastic_motion(mesh, drive, unloaded_transport(mesh, drive), cycles=1, samples=2048)
        point = sweep(mesh, drive, [speed]).points[0]
        spectrum = 2.0 * np.fft.rfft(motion.transmission_error)[1:7] / 2048
        assert point.dynamic_factor_max == pytest.approx(motion.largest_dynamic_factor, abs=1e-4)
        assert point.error_rms == pytest.approx(motion.transmission_error.std(), rel=1e-4, abs=0.0)
        # Trapezoidal sums over whole cycles of equal steps add no error; the motions agree to 1e-5 of the deflection, 20 um.
        found = point.harmonic_amplitude * np.exp(1j * point.harmonic_phase)
        assert np.abs(found - spectrum).max() < 2e-10


def test_steps_grow_with_the_cycle():
    assert default_steps(1.0) == 256
    assert all(default_steps(length) >= length / 0.1 for length in (10.0, 30.0, 100.0, 1000.0))
