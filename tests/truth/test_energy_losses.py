"""The energy that one loss at a time takes from a drive train, against the work of that loss alone."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import simpson

from gearfem.definition.drive_parts import ShaftedInertia, Support
from gearfem.dynamics import rigid_motion, uniform_transport
from gearfem.dynamics.cycle import integrate_cycle
from gearfem.dynamics.relative import RelativeMotion

RADII = (60.14e-3, 191.7e-3)
TEETH = 16
PERIOD = 2.0 * math.pi / TEETH
STIFFNESS, SHAFT, HOLD = 1.4e9, 4e5, 2e8
TANGENT = math.tan(math.radians(26.57))
ARMS = (RADII[0] * TANGENT, RADII[1] * TANGENT)


def constant(angle):
    return np.full_like(angle, STIFFNESS)


def path(angle):
    return ((angle / PERIOD + 0.5) % 1.0 - 0.5) * PERIOD * RADII[0]


def sliding_arms(angle):
    s = path(angle)
    return np.sign(s) * (ARMS[0] + s), np.sign(s) * (ARMS[1] - s)


@pytest.mark.parametrize("loss", ["none", "teeth", "friction", "shaft", "support"])
def test_energy_lost_is_the_work_of_the_loss(mesh_factory, coal_drive, loss):
    """One cycle from a start off any orbit: kinetic plus elastic energy less outer work falls by the work of the loss."""
    drive = dataclasses.replace(
        coal_drive,
        pinion_inertia=2.0,
        damping_ratio=0.1 if loss == "teeth" else 0.0,
        friction_coefficient=0.1 if loss == "friction" else 0.0,
        pinion_chain=(ShaftedInertia(name="motor", inertia=8.0, stiffness=SHAFT, damping=500.0 if loss == "shaft" else 0.0),),
        pinion_support=Support(compliance=1.0 / HOLD, mass=30.0, damping=2e4 if loss == "support" else 0.0),
    )
    mesh = mesh_factory(TEETH, RADII, constant, friction=sliding_arms, sliding_reversals=np.array([0.0, 0.5 * PERIOD]), angles=512)
    system = RelativeMotion(mesh, drive, uniform_transport(mesh, drive))
    cycle = integrate_cycle(system, np.array([9.5, 0.3, 0.0, 0.0, 14.0, 7.5, 1.0, -0.2]), 1.05, 1e-11)
    lost = energy = 0.0
    for piece in cycle.pieces:
        assert piece.side == 1
        times = np.linspace(piece.steps[0], piece.steps[-1], 4001)
        x, rate, turn, turning, twist, gap, twisting, moving = piece.solution(times)
        speed = system.unit * system.natural
        one = 53.0 + speed * turning / RADII[0]
        two = 53.0 * RADII[0] / RADII[1] + speed * (turning - rate) / RADII[1]
        twist, twisting = twist * system.unit / RADII[0], twisting * speed / RADII[0]
        depth, closing = system.unit * (x - gap), speed * (rate - moving)
        angle = 53.0 * times / system.natural
        angle1, angle2 = angle + system.unit * turn / RADII[0], (RADII[0] * angle + system.unit * (turn - x)) / RADII[1]
        kinetic = 0.5 * (2.0 * one**2 + 8.0 * (one + twisting) ** 2 + 6.72 * two**2 + 30.0 * (speed * moving) ** 2)
        stored = 0.5 * (STIFFNESS * depth**2 + SHAFT * twist**2 + HOLD * (system.unit * gap) ** 2)
        whole = kinetic + stored - 1605.0 * (angle1 + twist) + 1.05 * system.balanced_torque * angle2
        damping = 2.0 * drive.damping_ratio * math.sqrt(STIFFNESS / (RADII[0] ** 2 / 2.0 + RADII[1] ** 2 / 6.72))
        s = path(np.clip(angle, angle[0] + 1e-12, angle[-1] - 1e-12))
        sliding = one * (ARMS[0] + s) - two * (ARMS[1] - s)
        power = {
            "none": 0.0 * depth,
            "teeth": damping * closing**2,
            "friction": 0.1 * STIFFNESS * depth * np.abs(sliding),
            "shaft": 500.0 * twisting**2,
            "support": 2e4 * (speed * moving) ** 2,
        }[loss]
        lost += simpson(power, x=times / system.natural)
        energy += whole[0] - whole[-1]
    scale = 0.5 * STIFFNESS * system.unit**2
    print(f"{loss}: lost {lost / scale:.6f}, energy fell by {energy / scale:.6f} of the elastic energy at rest")
    # Some thousand steps of 1e-11 and rounding of 20 kJ (1e-11 J of 0.26 J); splines of the friction arms beside their jumps.
    assert energy == pytest.approx(lost, rel=1e-5 if loss == "friction" else 1e-6, abs=1e-7 * scale)
    assert (lost > 1e-3 * scale) == (loss != "none")


def test_the_rigid_model_loses_what_its_efficiency_says(coal_drive):
    """Over one period the pinion's work times the efficiency is the wheel's, whatever the ratio does in between."""
    angle = PERIOD * np.arange(512) / 512
    ratio = 3.1875 * (1.0 + 0.03 * np.sin(TEETH * angle + 0.4 * np.cos(TEETH * angle)))
    motion = rigid_motion(angle, ratio, PERIOD, coal_drive)
    turn = PERIOD * np.mean(1.0 / ratio)
    # A periodic trapezium of 512 points is exact to rounding.
    assert motion.wheel_torque * turn == pytest.approx(0.96 * 1605.0 * PERIOD, rel=1e-12, abs=0.0)
