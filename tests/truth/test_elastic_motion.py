"""The elastic model against closed forms, energy, and an independent integration in absolute angles."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from gearfem.dynamics import elastic_motion, uniform_transport, unloaded_transport
from gearfem.dynamics.cycle import integrate_cycle, propagator
from gearfem.dynamics.relative import RelativeMotion

RADII = (60.14e-3, 191.7e-3)
TEETH = 16
PERIOD = 2.0 * math.pi / TEETH
STIFFNESS = 1.4e9
REVERSALS = np.array([0.0, 0.5 * PERIOD])
TANGENT = math.tan(math.radians(26.57))


def constant(angle):
    return np.full_like(angle, STIFFNESS)


def varying(angle):
    return STIFFNESS * (1.0 + 0.15 * np.cos(TEETH * angle) + 0.05 * np.sin(2 * TEETH * angle))


def sliding_arms(angle):
    """Return sign(v_sl) h1 and sign(v_sl) h2 of one involute pair, one pitch around the pitch point, where the next takes over."""
    path = ((angle / PERIOD + 0.5) % 1.0 - 0.5) * PERIOD * RADII[0]
    return np.sign(path) * (RADII[0] * TANGENT + path), np.sign(path) * (RADII[1] * TANGENT - path)


def reduced_mass(drive):
    mass1, mass2 = drive.pinion_inertia / RADII[0] ** 2, drive.wheel_inertia / RADII[1] ** 2
    return mass1 * mass2 / (mass1 + mass2)


@pytest.mark.parametrize("tuning", [0.3, 0.9, 1.0, 1.1, 2.5])
def test_linear_limit_is_the_damped_oscillator(mesh_factory, coal_drive, tuning):
    """Amplitude and phase of the deflection under e_u = A cos(z phi): M A W^2/(C - M W^2 + i D W)."""
    amplitude, mass = 0.2e-6, reduced_mass(coal_drive)
    natural = math.sqrt(STIFFNESS / mass)
    drive = dataclasses.replace(coal_drive, pinion_speed=tuning * natural / TEETH)
    mesh = mesh_factory(TEETH, RADII, constant, angles=1024, unloaded=lambda phi: amplitude * (1.0 + np.cos(TEETH * phi)))
    motion = elastic_motion(mesh, drive, uniform_transport(mesh, drive), cycles=1, samples=128, tolerance=1e-10)
    turn = 2.0 * math.pi * np.arange(128) / 128
    deflection = motion.transmission_error - amplitude * (1.0 + np.cos(turn))
    found = 2.0 * np.mean(deflection * np.exp(-1j * turn))
    expected = amplitude * tuning**2 / (1.0 - tuning**2 + 2j * drive.damping_ratio * tuning)
    # Splines over 1024 angles err by 1e-8; the integration by some thousand times 1e-10 of the mean deflection, 100 times A.
    assert abs(found - expected) < 2e-6 * abs(expected) + 1e-7 * amplitude
    assert deflection.mean() == pytest.approx(1605.0 / RADII[0] / STIFFNESS, rel=1e-7, abs=0.0)
    # The orbit closes to 100 times the tolerance of 1e-10.
    assert motion.wheel_torque == pytest.approx(1605.0 * RADII[1] / RADII[0], rel=1e-7, abs=0.0)
    assert motion.periodic


def test_static_limit_follows_the_quasi_static_error(mesh_factory, coal_drive):
    """At 0.2 rad/s the transmission error is e_u + d, d = F/C(phi) less the lag D d'/C of the damping."""
    drive = dataclasses.replace(coal_drive, pinion_speed=0.2)
    mesh = mesh_factory(TEETH, RADII, varying, unloaded=lambda phi: 1e-6 * (1.0 + np.sin(TEETH * phi)))
    motion = elastic_motion(mesh, drive, uniform_transport(mesh, drive), cycles=1, samples=256)
    angle = 0.2 * motion.time
    force, stiffness = 1605.0 / RADII[0], varying(angle)
    slope = np.fft.irfft(1j * TEETH * np.arange(129) * np.fft.rfft(force / stiffness))
    damping = 2.0 * drive.damping_ratio * math.sqrt(STIFFNESS * reduced_mass(drive))
    static = 1e-6 * (1.0 + np.sin(TEETH * angle)) + force / stiffness
    lagging = static - damping * 0.2 * slope / stiffness
    # Next: inertia, (W/omega_n)^2 = 1.3e-6 of ripples of 4 um at W and four times that of 1 um at 2 W, 1e-11; as much again
    # for the square of the lag and for the closing of the orbit, 1e-7 of 20 um.
    assert np.abs(motion.transmission_error - static).max() > 1e-9
    assert np.abs(motion.transmission_error - lagging).max() < 2e-11


def test_energy_is_conserved_without_damping_and_friction(mesh_factory, coal_drive):
    """Kinetic plus elastic energy minus work, in absolute coordinates, from a start far off any orbit."""
    drive = dataclasses.replace(coal_drive, damping_ratio=0.0)
    mesh = mesh_factory(TEETH, RADII, constant)
    system = RelativeMotion(mesh, drive, uniform_transport(mesh, drive))
    torque = 1.1
    cycle = integrate_cycle(system, np.array([1.6, 0.9, 0.0, 0.0]), torque, 1e-11)
    times = np.linspace(0.0, system.length, 200)
    x, rate, turn, turning = cycle.pieces[0].solution(times)
    seconds, speed = times / system.natural, system.unit * system.natural
    one = 53.0 + speed * turning / RADII[0]
    two = 53.0 * RADII[0] / RADII[1] + speed * (turning - rate) / RADII[1]
    angle1 = 53.0 * seconds + system.unit * turn / RADII[0]
    angle2 = (RADII[0] * angle1 - system.unit * x) / RADII[1]
    work = 1605.0 * angle1 - torque * system.balanced_torque * angle2
    energy = 0.5 * 10.16 * one**2 + 0.5 * 6.72 * two**2 + 0.5 * STIFFNESS * (system.unit * x) ** 2 - work
    assert len(cycle.pieces) == 1
    # In units of the elastic energy that moves to and fro; some thousand steps of 1e-11, and rounding of 15 kJ.
    assert np.ptp(energy) < 1e-7 * 0.5 * STIFFNESS * system.unit**2


def test_friction_moves_the_wheel_torque_by_its_mean_loss(mesh_factory, coal_drive):
    """At slow speed P follows from x'' = 0 at each angle; the means of both moments then give T2."""
    drive = dataclasses.replace(coal_drive, pinion_speed=0.5, friction_coefficient=0.1)
    mesh = mesh_factory(TEETH, RADII, constant, friction=sliding_arms, sliding_reversals=REVERSALS, angles=128)
    motion = elastic_motion(mesh, drive, uniform_transport(mesh, drive), cycles=1, samples=64)
    share1, share2 = RADII[0] / 10.16, RADII[1] / 6.72

    def arms(angle):
        one, two = sliding_arms(np.asarray(angle))
        return RADII[0] + 0.1 * float(one), RADII[1] + 0.1 * float(two)

    def mean(function):
        edges = [(1e-12, 0.5 * PERIOD), (0.5 * PERIOD, PERIOD - 1e-12)]
        return sum(quad(lambda phi: function(*arms(phi)), *edge)[0] for edge in edges) / PERIOD

    # P = (share1 T1 + share2 T2)/(share1 l1 + share2 l2), and mean(P l1) = T1, mean(P l2) = T2.
    gain1 = mean(lambda l1, l2: l1 / (share1 * l1 + share2 * l2))
    gain2 = mean(lambda l1, l2: l2 / (share1 * l1 + share2 * l2))
    push = 1605.0 / gain1
    # The sum of the forces decays after each reversal in some 1e-3 of the cycle; it jumps by 1 % of the loss.
    loss = 1.0 - gain2 * push / (1605.0 * RADII[1] / RADII[0])
    found = 1.0 - motion.wheel_torque / (1605.0 * RADII[1] / RADII[0])
    print(f"loss of the teeth by quadrature {loss:.6f}, by the orbit {found:.6f}")
    assert loss > 0.005
    assert found == pytest.approx(loss, rel=2e-4, abs=0.0)


def absolute(mesh, drive, stiffness, unloaded, slope, wheel_torque, seconds, start):
    """Integrate (22) in absolute angles with analytic forces by Radau: psi1, psi2 and their rates at the end."""
    damping = 2.0 * drive.damping_ratio * math.sqrt(mesh.mean_stiffness * reduced_mass(drive))

    def change(time, y):
        angle = drive.pinion_speed * time
        rate = RADII[0] * y[2] - RADII[1] * y[3] - slope(angle) * drive.pinion_speed
        depth = RADII[0] * y[0] - RADII[1] * y[1] - unloaded(angle)
        force = max(stiffness(np.asarray(angle)) * depth + damping * rate, 0.0) if depth > 0.0 else 0.0
        one, two = sliding_arms(np.asarray(angle))
        f = drive.friction_coefficient
        pinion = (drive.pinion_torque - force * (RADII[0] + f * one)) / drive.pinion_inertia
        wheel = (force * (RADII[1] + f * two) - wheel_torque) / drive.wheel_inertia
        return [y[2], y[3], pinion, wheel]

    for span in itertools.pairwise(seconds):
        inner = (span[0] + 1e-15, span[1] - 1e-15)
        start = solve_ivp(change, inner, start, method="Radau", rtol=1e-10, atol=1e-13).y[:, -1]
    return start


@pytest.mark.parametrize("lag", [-0.6, 1.0])
def test_a_cycle_agrees_with_an_independent_integration(mesh_factory, coal_drive, lag):
    """The whole law (stiffness, unloaded error, friction, contact) written again in absolute angles, by another solver.

    The start of -0.6 mean deflections is free flight, so that the first cycle holds an impact.
    """
    drive = dataclasses.replace(coal_drive, friction_coefficient=0.1)

    def unloaded(phi):
        return 2e-6 * (1.0 - np.cos(TEETH * phi))

    def slope(phi):
        return 2e-6 * TEETH * np.sin(TEETH * phi)

    mesh = mesh_factory(TEETH, RADII, varying, angles=512, unloaded=unloaded, friction=sliding_arms, sliding_reversals=REVERSALS)
    system = RelativeMotion(mesh, drive, uniform_transport(mesh, drive))
    cycle = integrate_cycle(system, np.array([lag, 0.3, 0.0, 0.0]), 0.98, 1e-10)
    assert [piece.side for piece in cycle.pieces] == ([0, 1, 1] if lag < 0.0 else [1, 1])

    speed = system.unit * system.natural
    start = [0.0, -lag * system.unit / RADII[1], 53.0, (RADII[0] * 53.0 - 0.3 * speed) / RADII[1]]
    seconds = np.array([0.0, 0.5, 1.0]) * PERIOD / 53.0
    end = absolute(mesh, drive, varying, unloaded, slope, 0.98 * system.balanced_torque, seconds, start)
    x, rate, _, turning = cycle.end
    # Tables over 512 angles, the transport's tables and splines of the friction jump: some 1e-5; the impact's place adds to it.
    assert (RADII[0] * end[0] - RADII[1] * end[1]) / system.unit == pytest.approx(x, abs=3e-5)
    assert (RADII[0] * end[2] - RADII[1] * end[3]) / speed == pytest.approx(rate, abs=3e-5)
    assert RADII[0] * (end[2] - 53.0) / speed == pytest.approx(turning, abs=3e-5)


def test_propagator_is_the_derivative_of_the_cycle(mesh_factory, coal_drive):
    """Differences of whole cycles, free flight and impact included, against the linear equations."""
    mesh = mesh_factory(TEETH, RADII, varying, unloaded=lambda phi: 2e-6 * (1.0 - np.cos(TEETH * phi)))
    system = RelativeMotion(mesh, coal_drive, uniform_transport(mesh, coal_drive))
    base = np.array([-0.6, 0.3, 0.98])

    def end(values):
        return integrate_cycle(system, np.array([values[0], values[1], 0.0, 0.0]), values[2], 1e-11).end[[0, 1, 3]]

    small = 1e-4
    differences = np.array([(end(base + small * row) - end(base - small * row)) / (2.0 * small) for row in np.eye(3)]).T
    matrix = propagator(system, integrate_cycle(system, np.array([-0.6, 0.3, 0.0, 0.0]), 0.98, 1e-9))
    # Central differences: 1e-8 of curvature and 1e-11/1e-4 of integration; fourth order steps of 0.05 to 0.1: 1e-6.
    assert np.abs(matrix[:3][:, [0, 1, 3]] - differences).max() < 1e-5


def test_kw_is_the_moment_of_the_teeth(mesh_factory, coal_drive):
    """1 - J1 psi1''/T1 = sum P l1/T1 without friction, and psi1'' is the slope of psi1' over the absolute motion."""
    mesh = mesh_factory(TEETH, RADII, varying, unloaded=lambda phi: 2e-6 * (1.0 - np.cos(TEETH * phi)))
    motion = elastic_motion(mesh, coal_drive, unloaded_transport(mesh, coal_drive), cycles=2, samples=2000, tolerance=1e-10)
    assert np.allclose(motion.dynamic_factor, motion.mesh_force * RADII[0] / 1605.0, rtol=1e-12)
    assert motion.dynamic_factor.mean() == pytest.approx(1.0, abs=1e-6)
    slope = np.gradient(motion.pinion_speed, motion.time)
    # Central differences at 600 samples per natural period: (2 pi/600)^2/6 = 2e-5 of the largest.
    assert np.abs(slope - motion.pinion_acceleration)[1:-1].max() < 1e-4 * np.abs(motion.pinion_acceleration).max()
    travelled = np.cumsum(0.5 * (motion.pinion_speed[1:] + motion.pinion_speed[:-1]) * np.diff(motion.time))
    assert np.abs(motion.pinion_angle[1:] - motion.pinion_angle[0] - travelled).max() < 1e-9
    assert motion.pinion_angle[2000] - motion.pinion_angle[0] == pytest.approx(PERIOD, rel=1e-12, abs=0.0)


def test_multipliers_obey_liouville(mesh_factory, coal_drive):
    """Their product is exp(-2 zeta omega_n T): the friction-free damping acts all the time in contact."""
    mesh = mesh_factory(TEETH, RADII, varying)
    motion = elastic_motion(mesh, coal_drive, unloaded_transport(mesh, coal_drive))
    natural = math.sqrt(mesh.mean_stiffness / reduced_mass(coal_drive))
    expected = math.exp(-2.0 * coal_drive.damping_ratio * natural * PERIOD / coal_drive.pinion_speed)
    assert np.prod(motion.multipliers).real == pytest.approx(expected, rel=1e-6, abs=0.0)


def test_the_choice_of_transport_does_not_matter(mesh_factory, coal_drive):
    """Counted from the rigid motion with the unloaded ratio or from uniform rotation, the absolute motion is one."""
    mesh = mesh_factory(TEETH, RADII, varying, unloaded=lambda phi: 5e-6 * (1.0 - np.cos(TEETH * phi)))
    one = elastic_motion(mesh, coal_drive, unloaded_transport(mesh, coal_drive))
    two = elastic_motion(mesh, coal_drive, uniform_transport(mesh, coal_drive))
    # The tables are read at the transport's angle, which differs by some 5 um/r_b1 = 8e-5 rad of a period of 0.39.
    assert np.abs(one.transmission_error - two.transmission_error).max() < 1e-3 * np.ptp(one.transmission_error)
    assert np.abs(one.dynamic_factor - two.dynamic_factor).max() < 1e-3 * np.ptp(one.dynamic_factor)


@pytest.mark.parametrize("side", [1, -1])
def test_friction_takes_power_on_both_flanks(mesh_factory, coal_drive, side):
    """f P |v_sl| = what friction takes from the pinion less what it gives to the wheel, whichever flank is pressed."""
    drive = dataclasses.replace(coal_drive, friction_coefficient=0.1)
    mesh = mesh_factory(TEETH, RADII, constant, friction=sliding_arms, sliding_reversals=REVERSALS, normal_backlash=10e-6)
    system = RelativeMotion(mesh, drive, uniform_transport(mesh, drive))
    x = (20e-6 if side > 0 else -30e-6) / system.unit
    for part in (0.1, 0.4, 0.6, 0.9):
        carried = system.transport(part * system.length)
        touch = system.contact(carried, np.asarray(x), np.asarray(0.0), side, float(carried.angle))
        taken = touch.force * (touch.arms - side * np.array(RADII))
        path = ((part + 0.5) % 1.0 - 0.5) * PERIOD * RADII[0]
        ratio = RADII[0] / RADII[1]
        sliding = 53.0 * (RADII[0] * TANGENT + path - ratio * (RADII[1] * TANGENT - path))
        # Spline of the arms beside their jumps; the force is 20 um times the stiffness.
        assert taken[0] * 53.0 - taken[1] * 53.0 * ratio == pytest.approx(0.1 * 20e-6 * STIFFNESS * abs(sliding), rel=1e-6, abs=0.0)
