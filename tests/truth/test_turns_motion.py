"""Motion over many turns against closed forms, the slow engagement and the elastic model."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from gearfem.dynamics import DriveTrain, elastic_motion, unloaded_transport
from gearfem.dynamics.record import Ripple
from gearfem.dynamics.turns import march_turns
from gearfem.dynamics.turns_plan import mean_stiffness
from gearfem.dynamics.waves import slow_torque
from gearfem.engagement import Mesh, MeshForce, mesh_force
from gearfem.engagement.turns import Turns, static
from gearfem.foundation import InputError
from gearfem.placement import runout_gap

TORQUE = 50.0


@pytest.fixture(scope="module")
def drive(small_pair) -> DriveTrain:
    operation = small_pair.operation
    return DriveTrain(
        pinion_inertia=50.0 * operation.pinion_inertia,
        wheel_inertia=50.0 * operation.wheel_inertia,
        pinion_torque=TORQUE,
        wheel_torque=75.0,
        efficiency=1.0,
        pinion_speed=100.0,
        friction_coefficient=0.0,
        damping_ratio=0.06,
    )


def placed(mesh: Mesh, **changes: object) -> Turns:
    return Turns(mesh=dataclasses.replace(mesh, placement=dataclasses.replace(mesh.placement, **changes)))


@pytest.fixture(scope="module")
def forces(mesh) -> MeshForce:
    return mesh_force(mesh, TORQUE)


def natural(mesh: Mesh, drive: DriveTrain, torque: float) -> float:
    """Return sqrt(C/M) [rad/s]."""
    pair = mesh.placement.pair
    inverse = pair.pinion.base_radius**2 / drive.pinion_inertia + pair.wheel.base_radius**2 / drive.wheel_inertia
    return math.sqrt(mean_stiffness(Turns(mesh=mesh), torque) * inverse)


def test_low_speed_is_the_slow_engagement(mesh, drive) -> None:
    """With late teeth, runout and supports: what is left falls with the speed, as the damper's share of the load does.

    No friction: its step at the pitch point rings for some natural periods at any speed.
    """
    late = np.random.default_rng(1).normal(0.0, 1e-6, 30)
    turns = placed(mesh, wheel_late=late, pinion_runout=(6e-6, -4e-6), wheel_runout=(5e-6, 7e-6), series=1e-9)
    angle = 0.2 + np.linspace(0.0, 2.0, 61) * mesh.placement.pair.pinion.pitch_angle
    slow = static(turns, angle, TORQUE).transmission_error
    misses = [np.abs(march_turns(turns, drive, angle, speed=speed).transmission_error - slow).max() / 1e-5 for speed in (40.0, 10.0, 2.5)]
    assert misses[1] < 0.4 * misses[0]
    assert misses[2] < 0.4 * misses[1]
    assert misses[2] < 6e-3


def test_runout_shakes_the_mass_but_not_the_damper(mesh, turns, drive) -> None:
    """Under a common gap A cos(phi) the deflection moves by A r^2/(1 - r^2 + 2 i zeta r), r the speed over the natural frequency.

    A damper on the lag itself would add 2 i zeta r A, five times as much.
    """
    size, part = 5e-6, 0.03
    eccentric = placed(mesh, pinion_runout=(size, 0.0))
    speed = part * natural(mesh, drive, TORQUE)
    angle = np.arange(20 * 16) / (20 * 16) * math.tau
    gap = runout_gap(eccentric.mesh.placement, angle)[0]
    moved = march_turns(eccentric, drive, angle, speed=speed).transmission_error - gap
    moved = moved - march_turns(turns, drive, angle, speed=speed).transmission_error
    answer = np.mean(moved * np.exp(-1j * angle)) / np.mean(gap * np.exp(-1j * angle))
    expected = part**2 / (1.0 - part**2 + 2j * drive.damping_ratio * part)
    assert abs(answer / expected - 1.0) < 0.1


@pytest.mark.parametrize("part", [0.3, 0.9, 1.0, 1.6])
def test_linear_limit_is_the_damped_oscillator(mesh, turns, forces, drive, part) -> None:
    """A small torque wave to each turn, so fast that tooth meshing, 20 times faster, leaves its mean stiffness alone: amplitude and phase.

    The lag then stands still over a pitch, so that the stiffness is the slope of the mean load over it.
    """
    pair = mesh.placement.pair
    moment = CubicSpline(forces.deflection, forces.pinion_moment.mean(axis=0))
    stiffness = float(moment.derivative()(moment.solve(TORQUE, extrapolate=False)[0])) / pair.pinion.base_radius
    inverse = pair.pinion.base_radius**2 / drive.pinion_inertia + pair.wheel.base_radius**2 / drive.wheel_inertia
    damping = drive.damping_ratio * math.sqrt(mean_stiffness(turns, TORQUE) / stiffness)
    speed = part * math.sqrt(stiffness * inverse)
    angle = np.arange(20 * 16) / (20 * 16) * math.tau
    ripple = Ripple(member="pinion", order=1.0, amplitude=0.005 * TORQUE, phase=0.0)
    still = march_turns(turns, drive, angle, speed=speed).transmission_error
    moved = march_turns(turns, dataclasses.replace(drive, ripples=(ripple,)), angle, speed=speed).transmission_error - still
    wave = 2.0 * np.mean(moved * np.exp(-1j * angle))
    push = ripple.amplitude * pair.pinion.base_radius / drive.pinion_inertia
    answer = 1.0 / (1.0 - part**2 + 2j * damping * part)
    # The stiffness of the tables is known to 0.2 %, which resonance magnifies as it does the answer.
    assert abs(wave / (push / inverse / stiffness * answer) - 1.0) < 2e-3 * max(abs(answer), 1.0)


def test_equal_teeth_move_as_the_elastic_model(turns, forces, drive) -> None:
    """With friction; the elastic model's tables (240 angles, 48 levels) err by some tenths of a percent beside the ends of the path."""
    rubbed = dataclasses.replace(drive, friction_coefficient=0.08)
    elastic = elastic_motion(forces, rubbed, unloaded_transport(forces, rubbed))
    motion = march_turns(turns, rubbed, elastic.pinion_angle)
    miss = (motion.transmission_error - elastic.transmission_error) / elastic.transmission_error.mean()
    factor = motion.dynamic_factor - elastic.dynamic_factor
    assert np.abs(miss).max() < 8e-3
    assert np.abs(factor).max() < 1.5e-2
    assert np.sqrt((factor**2).mean()) < 4e-3
    assert motion.wheel_torque == pytest.approx(elastic.wheel_torque, rel=1e-4, abs=0.0)


def test_mean_moments_balance(turns, drive) -> None:
    """The pinion keeps its mean speed, and friction takes from the wheel."""
    angle = np.arange(20 * 64) / (20 * 64) * math.tau
    rubbed = march_turns(turns, dataclasses.replace(drive, friction_coefficient=0.08), angle)
    assert rubbed.dynamic_factor.mean() == pytest.approx(1.0, abs=2e-3)
    assert 0.97 < rubbed.wheel_torque / 75.0 < 0.999


def test_late_tooth_strikes_once_a_turn(mesh, turns, drive) -> None:
    late = np.zeros(20)
    late[5] = 4e-6
    pitch = mesh.placement.pair.pinion.pitch_angle
    angle = np.arange(40 * 32) / 32 * pitch
    even = march_turns(turns, drive, angle).transmission_error
    odd = march_turns(placed(mesh, pinion_late=late), drive, angle).transmission_error
    change = np.abs(odd - even).reshape(40, 32).max(axis=1)
    assert set(np.argsort(change)[-2:]) == {5, 25} or set(np.argsort(change)[-2:]) <= {4, 5, 6, 24, 25, 26}
    assert change[5] == pytest.approx(change[25], rel=1e-3, abs=0.0)
    assert change[15] < 0.02 * change[5]


def test_contact_never_pulls_and_backlash_bounds_the_lead(mesh, drive) -> None:
    """Light load at resonance: contact is lost and made again; the force on the back flank is negative, never on the working one."""
    free = placed(mesh, normal_backlash=5e-6)
    speed = natural(mesh, drive, 2.0) / 20.0
    angle = np.linspace(0.0, 4.0 * math.tau, 4000)
    light = dataclasses.replace(drive, damping_ratio=0.02)
    motion = march_turns(free, light, angle, speed=speed, torque=2.0)
    assert motion.contact_loss > 0.01
    back = motion.mesh_force < 0.0
    assert (motion.transmission_error[back] < -5e-6).all()
    lost = motion.mesh_force == 0.0
    assert (motion.transmission_error[lost] < 10e-6).all()


def test_slow_ripples_of_both_shafts_add_on_the_pinion(drive) -> None:
    ripples = (
        Ripple(member="pinion", order=2.0, amplitude=3.0, phase=0.4),
        Ripple(member="wheel", order=1.0, amplitude=6.0, phase=-0.2),
    )
    angle = np.linspace(0.0, 9.0, 5)
    expected = 50.0 + 3.0 * np.cos(2.0 * angle + 0.4) + 6.0 / 1.5 * np.cos(angle / 1.5 - 0.2)
    found = slow_torque(dataclasses.replace(drive, ripples=ripples), 50.0, angle, 1.5)
    assert found == pytest.approx(expected, rel=1e-14, abs=0.0)


@pytest.mark.parametrize("speed", [40.0, 80.0, 120.0, 160.0])
@pytest.mark.parametrize(("stride", "friction", "most"), [(0.2, 0.0, 1e-3), (0.7, 0.0, 4e-3), (0.2, 0.05, 1e-2)])
def test_least_acceleration_is_that_of_dense_angles(turns, drive, speed, stride, friction, most) -> None:
    """Steps and parabolas through them miss a peak by a small part of its height, at a reversal of friction by a part of that jump."""
    angle = np.linspace(0.0, math.tau, 20 * 400)
    motion = march_turns(turns, dataclasses.replace(drive, friction_coefficient=friction), angle, speed=speed, stride=stride)
    height = float(np.ptp(motion.pinion_acceleration))
    assert motion.least_acceleration == pytest.approx(motion.pinion_acceleration.min(), rel=0.0, abs=most * height)


def test_motion_without_its_loads_is_the_same(turns, drive) -> None:
    angle = np.random.default_rng(3).uniform(0.0, 2.0 * math.tau, 200)
    whole, bare = (march_turns(turns, drive, angle, speed=120.0, loads=loads) for loads in (True, False))
    assert bare.transmission_error == pytest.approx(whole.transmission_error, rel=1e-9, abs=1e-15)
    assert bare.end == pytest.approx(whole.end, rel=1e-9, abs=1e-15)
    assert bare.mesh_force.size == bare.pinion_acceleration.size == bare.dynamic_factor.size == 0


def test_what_cannot_be_stepped_is_refused(turns, drive) -> None:
    with pytest.raises(InputError, match="positive speed"):
        march_turns(turns, drive, 0.0, speed=0.0)
    with pytest.raises(InputError, match="damping that settles"):
        march_turns(turns, dataclasses.replace(drive, damping_ratio=0.0), 0.0)
