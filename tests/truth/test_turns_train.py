"""Motion over turns of longer drive trains, and what drives make of torque ripples at low speed."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem.definition.drive_parts import ShaftedInertia, Support
from gearfem.dynamics import DriveTrain, elastic_motion, unloaded_transport
from gearfem.dynamics.record import Ripple
from gearfem.dynamics.turns import march_turns
from gearfem.dynamics.waves import slow_torque
from gearfem.engagement import mesh_force
from gearfem.foundation import InputError

TORQUE = 50.0
SHAFT = ShaftedInertia(name="motor", inertia=2e-3, stiffness=2e4, damping=0.5)
LOAD = ShaftedInertia(name="load", inertia=5e-3, stiffness=3e4, damping=0.8)
SOFT = Support(compliance=2e-9, mass=0.5, damping=800.0)
CHAINS = {
    "shafts on both sides": {"pinion_chain": (SHAFT,), "wheel_chain": (LOAD,)},
    "yielding supports": {"pinion_support": SOFT, "wheel_support": SOFT},
    "all of them": {"pinion_chain": (SHAFT,), "wheel_chain": (LOAD,), "pinion_support": SOFT},
}


@pytest.fixture(scope="module")
def drive(small_pair) -> DriveTrain:
    operation = small_pair.operation
    return DriveTrain(
        pinion_inertia=5.0 * operation.pinion_inertia,
        wheel_inertia=5.0 * operation.wheel_inertia,
        pinion_torque=TORQUE,
        wheel_torque=75.0,
        efficiency=1.0,
        pinion_speed=300.0,
        friction_coefficient=0.05,
        damping_ratio=0.06,
    )


@pytest.mark.parametrize("parts", CHAINS.values(), ids=CHAINS)
def test_equal_teeth_move_as_the_elastic_model_on_any_train(mesh, turns, drive, parts) -> None:
    train = dataclasses.replace(drive, **parts)
    forces = mesh_force(mesh, TORQUE)
    reference = elastic_motion(forces, train, unloaded_transport(forces, train), cycles=1)
    assert reference.periodic
    angle = np.linspace(0.0, 1.0, 241)[:-1] * mesh.placement.pair.pinion.pitch_angle
    motion = march_turns(turns, train, angle)
    error = np.interp(angle, reference.pinion_angle, reference.transmission_error, period=mesh.placement.pair.pinion.pitch_angle)
    swing = np.ptp(reference.dynamic_factor)
    off = abs(motion.dynamic_factor.max() - reference.largest_dynamic_factor), np.abs(motion.transmission_error - error).max()
    print(f"Kw {motion.dynamic_factor.max():.4f}, off by {off[0]:.1e}; lag off by {off[1] / np.ptp(error):.1e} of its swing")
    # Both step the tables of the same teeth: cells of one against levels of the other, each within 2e-3.
    assert off[0] < 0.01 * swing
    assert off[1] < 0.02 * np.ptp(error)
    assert motion.wheel_torque == pytest.approx(reference.wheel_torque, rel=2e-4, abs=0.0)


def test_stiff_shafts_leave_two_inertias(turns, drive) -> None:
    """The difference falls as the compliance of the shaft."""
    angle, off = np.linspace(0.0, 0.6, 200), []
    whole = march_turns(turns, drive, angle).dynamic_factor
    for stiffness in (3e6, 3e7):
        half = 0.5 * drive.pinion_inertia
        part = ShaftedInertia(name="other half", inertia=half, stiffness=stiffness, damping=1e-5 * stiffness)
        # The damping ratio counts the two gears alone.
        ratio = drive.damping_ratio * math.sqrt(masses(drive, 1.0) / masses(drive, 0.5))
        split = dataclasses.replace(drive, pinion_inertia=half, pinion_chain=(part,), damping_ratio=ratio)
        off.append(np.abs(march_turns(turns, split, angle).dynamic_factor - whole).max())
    print("difference of Kw over the stiffness of the shaft", off)
    assert off[1] < 0.15 * off[0] < 0.02


def masses(drive: DriveTrain, share: float) -> float:
    """Return the reduced mass on base circles in the ratio 2 to 3 with a share of the pinion's inertia, but for a factor."""
    one, two = share * drive.pinion_inertia / 4.0, drive.wheel_inertia / 9.0
    return one * two / (one + two)


@pytest.mark.parametrize("member", ["pinion", "wheel"])
def test_free_inertias_pass_on_their_share_of_a_slow_ripple(mesh, turns, drive, member) -> None:
    """The shaft that the ripple acts on takes its own share of it: what reaches the teeth goes as the other side's mass.

    With m = J/r_b^2 and both sides speeding up together, F = T/r_b1 + A/r_b1 m2/(m1 + m2) for A on the pinion's shaft, and
    T/r_b1 + B/r_b2 m1/(m1 + m2) for B on the wheel's.
    """
    pair = mesh.placement.pair
    order, amplitude = 2.0, 4.0
    rippled = dataclasses.replace(
        drive, friction_coefficient=0.0, ripples=(Ripple(member=member, order=order, amplitude=amplitude, phase=0.3),)
    )
    plain = dataclasses.replace(drive, friction_coefficient=0.0)
    own = np.arange(6007) / 6007 * 2.0 * math.pi
    angle = own if member == "pinion" else own * pair.ratio
    # 5 Hz against a mesh mode of kilohertz; the difference to steady torques leaves the teeth's own excitation out.
    moved, steady = (march_turns(turns, one, angle, speed=15.0).mesh_force for one in (rippled, plain))
    radius = pair.pinion.base_radius if member == "pinion" else pair.wheel.base_radius
    m1, m2 = drive.pinion_inertia / pair.pinion.base_radius**2, drive.wheel_inertia / pair.wheel.base_radius**2
    share = (m2 if member == "pinion" else m1) / (m1 + m2)
    wave = 2.0 * np.mean((moved - steady) * np.exp(-1j * order * own))
    print(f"share of the teeth: {abs(wave) * radius / amplitude:.4f}, {share:.4f} expected")
    # Where pairs hand over, the teeth ring a little otherwise under another load.
    assert abs(wave / (share * amplitude / radius * np.exp(0.3j)) - 1.0) < 5e-3
    # Gears that are held to their speed pass the ripple on whole.
    held = (slow_torque(rippled, TORQUE, angle, pair.ratio) - TORQUE) / pair.pinion.base_radius
    assert np.ptp(held) / 2.0 == pytest.approx(amplitude / radius, rel=1e-4, abs=0.0)


def test_shafts_without_damping_are_refused(turns, drive) -> None:
    free = dataclasses.replace(SHAFT, damping=0.0)
    far = dataclasses.replace(LOAD, damping=0.0, stiffness=1.0)
    with pytest.raises(InputError, match="damping"):
        march_turns(turns, dataclasses.replace(drive, damping_ratio=1e-6, pinion_chain=(free,), wheel_chain=(far,)), [0.0])
