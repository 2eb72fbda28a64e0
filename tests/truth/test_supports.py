"""Gears that move with their masses on their supports: modes, steady limits, and what is left of a mass on a stiff support."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem.assembly import assemble
from gearfem.definition.drive_parts import Support
from gearfem.definition.setup import Setup
from gearfem.diagnosis.modelling.bench import Settings, neutral
from gearfem.diagnosis.modelling.largest import at_peaks
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.modelling.teeth import Scatter, tooth_columns
from gearfem.diagnosis.reading.measurement import make_record
from gearfem.dynamics import DriveTrain, elastic_motion, modes, unloaded_transport
from gearfem.dynamics.record import Ripple
from gearfem.dynamics.supports import RATIO, STIFF, on_supports
from gearfem.dynamics.turns import march_turns
from gearfem.dynamics.turns_plan import make_plan, mesh_mode, moving
from gearfem.effects.support_compliance import SupportCompliance
from gearfem.engagement.engage import mesh_force
from gearfem.engagement.record import MeshForce
from gearfem.engagement.turns import Turns
from gearfem.foundation import Array
from gearfem.placement import Placement, make_placement
from gearfem.sensing import System

TORQUE, SPEED = 50.0, 300.0
SOFT = SupportCompliance(pinion=3e-9, wheel=2e-9)


@pytest.fixture(scope="module")
def setup(small_pair: Setup) -> Setup:
    """Inertias five times those of the gears, so that these are light on the line of action."""
    operation = small_pair.operation
    five = {name: 5.0 * getattr(operation, name) for name in ("pinion_inertia", "wheel_inertia")}
    return dataclasses.replace(small_pair, operation=dataclasses.replace(operation, pinion_speed=SPEED, **five))


@pytest.fixture(scope="module")
def soft(setup: Setup) -> System:
    return assemble(setup, [SOFT])


@pytest.fixture(scope="module")
def forces(soft: System) -> MeshForce:
    """Forces of the teeth of gears whose supports have gone over to the drive."""
    return mesh_force(moving(soft.mesh, soft.drive)[0], TORQUE)


def natural_frequency(system: System) -> float:
    """Return the frequency of the two gears on their teeth, rigidly held [rad/s]."""
    plan = make_plan(Turns(mesh=assemble(system.setup).mesh), system.drive, SPEED, TORQUE)
    pair = system.setup.pair
    return mesh_mode(system.drive, plan.stiffness, pair.pinion.base_radius, pair.wheel.base_radius)[0]


def compliances_of(system: System, share: float) -> tuple[float, float]:
    """Return compliances on which both gears swing by a multiple of the mesh's frequency."""
    limit = (share * natural_frequency(system)) ** 2
    return 1.0 / (limit * system.drive.pinion_mass), 1.0 / (limit * system.drive.wheel_mass)


def test_masses_are_those_of_discs(soft: System) -> None:
    steel = 7850.0 * math.pi * 20e-3
    assert soft.drive.pinion_mass == pytest.approx(steel * (20e-3**2 - soft.setup.pair.pinion.bore_radius**2), rel=1e-12, abs=0.0)
    assert soft.drive.wheel_mass == pytest.approx(steel * (30e-3**2 - soft.setup.pair.wheel.bore_radius**2), rel=1e-12, abs=0.0)


ANGLES = np.arange(2000) / 2000 * 8.0 * 2.0 * math.pi


def lags(system: System, *ripples: Ripple) -> Array:
    """Return the transmission error over eight turns."""
    drive = dataclasses.replace(system.drive, ripples=ripples)
    return march_turns(Turns(mesh=system.mesh), drive, ANGLES, speed=SPEED, torque=TORQUE).transmission_error


def response(system: System, order: float, steady: Array) -> complex:
    """Return the wave of the transmission error per wave of the pinion's torque [m/(N m)], around the steady motion."""
    window, amplitude = np.hanning(ANGLES.size), 0.2
    moved = lags(system, Ripple(member="pinion", order=order, amplitude=amplitude, phase=0.0)) - steady
    return complex(2.0 * np.sum(window * moved * np.exp(-1j * order * ANGLES)) / window.sum() / amplitude)


def linear_response(drive: DriveTrain, stiffness: float, damper: float, bases: tuple[float, float], omega: float) -> complex:
    """Return the same of matrices written out: psi1, psi2, and the displacements of both gears away from each other."""
    approach = np.array([bases[0], -bases[1], -1.0, -1.0])
    mass = [drive.pinion_inertia, drive.wheel_inertia, drive.pinion_mass, drive.wheel_mass]
    springs = np.diag([0.0, 0.0, 1.0 / SOFT.pinion, 1.0 / SOFT.wheel])
    dampers = np.diag([0.0, 0.0, *(2.0 * RATIO * math.sqrt(m / c) for m, c in zip(mass[2:], (SOFT.pinion, SOFT.wheel), strict=True))])
    dynamic = springs + 1j * omega * dampers + (stiffness + 1j * omega * damper) * np.outer(approach, approach) - omega**2 * np.diag(mass)
    moved = np.linalg.solve(dynamic, np.array([1.0, 0.0, 0.0, 0.0]))
    return complex(bases[0] * moved[0] - bases[1] * moved[1])


def test_gears_resonate_on_two_supports_at_the_modes_of_the_linear_system(soft: System, forces: MeshForce) -> None:
    """Beside each mode and on it: a mode misplaced by 1 % would change the two sides by 10 % each, one up and one down."""
    pair = soft.setup.pair
    bases = pair.pinion.base_radius, pair.wheel.base_radius
    _, drive = moving(soft.mesh, soft.drive)
    found = modes(drive, forces)
    plan = make_plan(Turns(mesh=soft.mesh), soft.drive, SPEED, TORQUE)
    assert found.frequency.size == 4
    steady = lags(soft)
    for frequency in found.frequency[1:]:
        order = 2.0 * math.pi * frequency / SPEED * np.array([0.9, 1.0, 1.1])
        exact = np.array([linear_response(drive, plan.stiffness, plan.damper, bases, one * SPEED) for one in order])
        stepped = np.array([response(soft, one, steady) for one in order])
        print(f"{frequency:.0f} Hz: {np.abs(stepped)} of {np.abs(exact)}, off by {np.abs(stepped / exact - 1.0)}")
        # The stiffness of the teeth varies by a fifth around the mean that the linear system has.
        assert np.abs(stepped / exact - 1.0)[[0, 2]].max() < 0.06
        assert np.abs(stepped[1]) == pytest.approx(np.abs(exact[1]), rel=0.1, abs=0.0)


def test_slow_gears_lag_by_what_their_supports_yield(setup: Setup, soft: System) -> None:
    angle = np.linspace(0.1, 0.5, 60)
    slow = [march_turns(Turns(mesh=one.mesh), one.drive, angle, speed=3.0, torque=TORQUE) for one in (soft, assemble(setup))]
    yielded = (SOFT.pinion + SOFT.wheel) * TORQUE / setup.pair.pinion.base_radius
    apart = (slow[0].transmission_error - slow[1].transmission_error) / yielded - 1.0
    # Where pairs hand over the teeth ring a little, otherwise on supports.
    assert np.median(np.abs(apart)) < 1e-4
    assert np.abs(apart).max() < 1e-2


def test_a_stiff_support_may_lose_its_mass(setup: Setup) -> None:
    """Across the switch the motion changes by some 1/64 of what the yield does, and nothing of it is left in the drive."""
    angle = np.arange(800) / 800 * 2.0 * math.pi
    plain = assemble(setup)
    motions = []
    for share in (None, STIFF * 1.001, STIFF * 0.999):
        pinion, wheel = (0.0, 0.0) if share is None else compliances_of(plain, share)
        system = assemble(setup, [SupportCompliance(pinion=pinion, wheel=wheel)])
        assert (moving(system.mesh, system.drive)[1].pinion_support is None) is (share is None or share > STIFF)
        found = march_turns(Turns(mesh=system.mesh), system.drive, angle, speed=SPEED, torque=TORQUE)
        motions.append(found.transmission_error - found.transmission_error.mean())
    effect, jump = np.std(motions[1] - motions[0]), np.std(motions[2] - motions[1])
    print(f"jump {jump:.2e} m of {effect:.2e} m that the yield does")
    assert jump < 0.05 * effect


def test_no_supports_leave_placement_and_drive_alone(setup: Setup) -> None:
    system = assemble(setup)
    mesh = system.mesh
    assert moving(mesh, system.drive) == (mesh, system.drive)
    placement, drive = on_supports(system.placement, system.drive, 1e4)
    assert placement.support == 0.0
    assert drive.pinion_support is None
    assert drive.wheel_support is None


def test_a_stated_support_and_the_effect_yield_one_after_the_other(setup: Setup) -> None:
    placement = SOFT.act(make_placement(setup), setup)
    stated = Support(compliance=1e-9, mass=2.0, damping=500.0)
    drive = dataclasses.replace(assemble(setup).drive, pinion_support=stated)
    rest, held = on_supports(placement, drive, 1e4)
    assert rest.support == 0.0
    assert held.pinion_support is not None
    assert held.pinion_support.compliance == pytest.approx(4e-9, rel=1e-12, abs=0.0)
    assert held.pinion_support.mass == 2.0
    # 500 N s/m on a quarter of the stretch, 2 zeta sqrt(m/c) on the rest.
    assert held.pinion_support.damping == pytest.approx(500.0 / 16.0 + 2.0 * RATIO * math.sqrt(2.0 / 3e-9) * 9.0 / 16.0, rel=1e-12, abs=0.0)


def test_two_effects_add_up(setup: Setup) -> None:
    half = SupportCompliance(pinion=1.5e-9, wheel=1e-9)
    placement: Placement = assemble(setup, [half, half]).placement
    assert (placement.pinion_support, placement.wheel_support) == pytest.approx((3e-9, 2e-9), rel=1e-12, abs=0.0)


def test_the_elastic_model_has_the_same_motion(setup: Setup, soft: System, forces: MeshForce) -> None:
    _, drive = moving(soft.mesh, soft.drive)
    elastic = elastic_motion(forces, drive, unloaded_transport(forces, drive), cycles=1)
    assert elastic.periodic
    assert elastic.stretch_names == ("support of the pinion", "support of the wheel")
    motion = march_turns(Turns(mesh=soft.mesh), soft.drive, elastic.pinion_angle, speed=SPEED, torque=TORQUE)
    # As in the motion of equal teeth on any train: tables of the same teeth laid out differently.
    assert np.abs(motion.transmission_error - elastic.transmission_error).max() < 0.02 * np.ptp(elastic.transmission_error)


def test_a_train_over_a_number_moves_as_before(soft: System, forces: MeshForce) -> None:
    """Forces, masses and springs over s on a mesh that is s times softer: the modes stay where they were."""
    stated = dataclasses.replace(soft.drive, pinion_support=Support(compliance=1e-9, mass=2.0, damping=500.0))
    _, drive = moving(soft.mesh, stated)
    before, after = modes(drive, forces), modes(drive.over(1.7), dataclasses.replace(forces, mean_stiffness=forces.mean_stiffness / 1.7))
    assert after.frequency[1:] == pytest.approx(before.frequency[1:], rel=1e-9, abs=0.0)
    assert after.damping_ratio[1:] == pytest.approx(before.damping_ratio[1:], rel=1e-9, abs=0.0)


@pytest.mark.parametrize("quantity", ["dynamic_transmission_error", "pinion_angular_acceleration"])
def test_errors_of_teeth_come_through_on_supports_as_the_motion_has_them(soft: System, quantity: str) -> None:
    pair, bench = soft.setup.pair, SystemBench(system=soft, errors=())
    angle = 2.0 * math.pi + np.arange(600) / 600 * 2.0 * math.pi
    record = make_record(quantity, angle, pinion_torque=TORQUE, pinion_speed=SPEED)
    columns = tooth_columns(record, bench, neutral(pair), Scatter(terms=1))
    small, tooth = 2e-8, 7
    late = np.where(np.arange(pair.pinion.teeth) == tooth, small, 0.0)
    settings = Settings(pinion_late=late, wheel_late=np.zeros(pair.wheel.teeth))
    exact = (bench.predict(record, settings) - bench.predict(record, neutral(pair))) / small
    off = np.std(columns[:, 2 * tooth] - exact) / np.std(exact)
    print(f"{quantity}: off by {off:.3f}")
    assert off < (0.03 if quantity == "dynamic_transmission_error" else 0.12)


def test_the_largest_kw_changes_with_the_tooth_where_it_is_largest(soft: System) -> None:
    """Of the two speeds, one lies on the modes: derivatives over single index errors are those of the acceleration at the peak."""
    pair, bench = soft.setup.pair, SystemBench(system=soft, errors=())
    speeds = np.array([SPEED, 2.3 * SPEED])
    kw = make_record("dynamic_factor", speeds, pinion_torque=TORQUE)
    # Late teeth make one peak the largest, which small errors do not change.
    base = np.where(np.arange(pair.pinion.teeth) == 7, 2e-6, 0.0)
    start = Settings(pinion_late=base, wheel_late=np.zeros(pair.wheel.teeth))
    (columns, _), small, exact = at_peaks(kw, bench, start, Scatter(terms=1)), 2e-8, []
    for tooth in range(pair.pinion.teeth):
        late = base + np.where(np.arange(pair.pinion.teeth) == tooth, small, 0.0)
        moved = Settings(pinion_late=late, wheel_late=np.zeros(pair.wheel.teeth))
        exact.append((bench.predict(kw, moved) - bench.predict(kw, start)) / small)
    off = np.linalg.norm(columns[:, : 2 * pair.pinion.teeth : 2] - np.array(exact).T, axis=1) / np.linalg.norm(exact, axis=0)
    print(f"largest Kw: off by {off}")
    assert off.max() < 0.15
