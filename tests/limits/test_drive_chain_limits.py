"""A chain of stiff shafts is two inertias; a slow pair on yielding supports is the same pair, displaced."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem.definition.drive_parts import ShaftedInertia, Support
from gearfem.dynamics import elastic_motion, rigid_motion, uniform_transport

RADII = (60.14e-3, 191.7e-3)
TEETH = 16


def varying(angle):
    return 1.4e9 * (1.0 + 0.15 * np.cos(TEETH * angle))


def reduced(one, two):
    return 1.0 / (RADII[0] ** 2 / one + RADII[1] ** 2 / two)


def split(drive, stiffness):
    """Return the drive with most of its inertias moved onto shafts, the damping of its teeth kept."""
    # D = 2 zeta sqrt(C M) with the reduced mass of the gears alone.
    zeta = drive.damping_ratio * math.sqrt(reduced(10.16, 6.72) / reduced(4.16, 2.72))
    parts = [
        ShaftedInertia(name=name, inertia=inertia, stiffness=stiffness, damping=1e-4 * stiffness)
        for name, inertia in (("c", 2.0), ("m", 4.0), ("load", 4.0))
    ]
    return dataclasses.replace(
        drive, pinion_inertia=4.16, wheel_inertia=2.72, damping_ratio=zeta, pinion_chain=tuple(parts[:2]), wheel_chain=(parts[2],)
    )


def test_stiff_shafts_leave_two_inertias(mesh_factory, coal_drive):
    """The difference falls as the compliance of the shafts."""
    mesh = mesh_factory(TEETH, RADII, varying)
    rigid = elastic_motion(mesh, coal_drive, uniform_transport(mesh, coal_drive), cycles=1)
    differences = []
    for stiffness in (3e8, 3e9, 3e10):
        drive = split(coal_drive, stiffness)
        motion = elastic_motion(mesh, drive, uniform_transport(mesh, drive), cycles=1)
        differences.append(np.abs(motion.dynamic_factor - rigid.dynamic_factor).max())
    print("largest difference of Kw over stiffness:", differences)
    ripple = np.ptp(rigid.dynamic_factor)
    # First order in the compliance: a tenth each time, within 20 %, once it is small beside the teeth's (C r^2 = 5e6 N m/rad).
    assert differences[1] / differences[0] == pytest.approx(0.1, rel=0.2, abs=0.0)
    assert differences[2] / differences[1] == pytest.approx(0.1, rel=0.2, abs=0.0)
    assert differences[2] < 2e-3 * ripple


def test_rigid_model_turns_whole_sides(coal_drive):
    angle = np.arange(64) / 64
    ratio = 3.0 * (1.0 + 0.02 * np.sin(2.0 * math.pi * angle))
    one, two = (rigid_motion(angle, ratio, 1.0, drive) for drive in (coal_drive, split(coal_drive, 1e5)))
    # Sums of the same inertias: rounding.
    assert np.allclose(one.dynamic_factor, two.dynamic_factor, rtol=1e-12)


@pytest.mark.slow
def test_supports_displace_a_slow_pair(mesh_factory, coal_drive):
    """Quasi-statically the transmission error grows by P (c1 + c2), and the forces stay."""
    slow = dataclasses.replace(coal_drive, pinion_speed=4.0)
    held = dataclasses.replace(
        slow,
        pinion_support=Support(compliance=5e-9, mass=20.0, damping=1e4),
        wheel_support=Support(compliance=2e-9, mass=50.0, damping=1e4),
    )
    mesh = mesh_factory(TEETH, RADII, varying)
    one, two = (elastic_motion(mesh, drive, uniform_transport(mesh, drive), cycles=1, samples=64) for drive in (slow, held))
    lift = two.transmission_error - one.transmission_error
    push = 1605.0 / RADII[0]
    # Inertia of ripples of 3 um at 8 rad/s beside a stiffness of 1e9: 1e-5; supports follow with their damping: 1e-4 of ripples.
    assert np.allclose(lift, 7e-9 * push, rtol=1e-4)
    assert np.allclose(two.stretch_load, push, rtol=1e-3)
