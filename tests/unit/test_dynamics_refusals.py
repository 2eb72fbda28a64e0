"""What the dynamics refuse, and the small functions around them."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem.dynamics import elastic_motion, make_drive, rigid_motion, uniform_transport, wheel_torque_sentence
from gearfem.dynamics.flank_force import flank_force
from gearfem.foundation import InputError, SolveError

RADII = (0.06, 0.18)


def stiff(angle):
    return np.full_like(angle, 1e9)


def test_drive_repeats_the_operation(coal_combine):
    drive = make_drive(coal_combine)
    masses = {"pinion_mass", "wheel_mass"}
    stated = {field.name for field in dataclasses.fields(drive)} - {"ripples", *masses}
    assert {name: getattr(drive, name) for name in stated} == {name: getattr(coal_combine.operation, name) for name in stated}
    # Discs of steel from the bore to the reference circle.
    for gear, mass in ((coal_combine.pair.pinion, drive.pinion_mass), (coal_combine.pair.wheel, drive.wheel_mass)):
        ring = math.pi * (gear.reference_radius**2 - gear.bore_radius**2)
        assert mass == pytest.approx(gear.material.density * ring * coal_combine.pair.face_width, rel=1e-9)
    # Torques vary by an effect alone.
    assert drive.ripples == ()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("pinion_inertia", 0.0),
        ("wheel_torque", -1.0),
        ("pinion_speed", math.inf),
        ("damping_ratio", -0.1),
        ("efficiency", 1.1),
        ("efficiency", 0.0),
    ],
)
def test_drive_refuses_by_name(coal_drive, name, value):
    with pytest.raises(InputError, match=name):
        dataclasses.replace(coal_drive, **{name: value})


def test_sentence_names_both_torques(coal_drive):
    sentence = wheel_torque_sentence("elastic", coal_drive, 5031.25)
    assert "4911" in sentence
    assert "5031.25" in sentence
    assert "+2.449 %" in sentence


@pytest.mark.parametrize(
    ("angle", "ratio"),
    [
        (np.linspace(0.0, 1.0, 16), np.full(16, 3.0)),
        (np.arange(16) / 16, np.full(15, 3.0)),
        (np.arange(16) / 16, np.where(np.arange(16) == 3, -1.0, 3.0)),
        (np.arange(4) / 4, np.full(4, 3.0)),
    ],
)
def test_rigid_refuses(coal_drive, angle, ratio):
    with pytest.raises(InputError, match="rigid_motion"):
        rigid_motion(angle, ratio, 1.0, coal_drive)


def test_rigid_says_when_the_pinion_would_stop(coal_drive):
    angle = np.arange(64) / 64
    ratio = 3.0 * (1.0 + 0.1 * np.sin(2 * np.pi * angle))
    with pytest.raises(SolveError, match="nearly stops the pinion"):
        rigid_motion(angle, ratio, 1.0, dataclasses.replace(coal_drive, pinion_speed=0.1))


def test_elastic_refuses_counts_tolerance_and_a_foreign_transport(mesh_factory, coal_drive):
    mesh = mesh_factory(16, RADII, stiff)
    transport = uniform_transport(mesh, coal_drive)
    with pytest.raises(InputError, match="cycles"):
        elastic_motion(mesh, coal_drive, transport, cycles=0)
    with pytest.raises(InputError, match="tolerance"):
        elastic_motion(mesh, coal_drive, transport, tolerance=1e-2)
    with pytest.raises(InputError, match=r"transport\.period"):
        elastic_motion(mesh_factory(17, RADII, stiff), coal_drive, transport)


def test_tables_that_cannot_be_used_are_refused(mesh_factory):
    mesh = mesh_factory(16, RADII, stiff)
    with pytest.raises(InputError, match="no contact at the largest"):
        flank_force(dataclasses.replace(mesh, normal_force=0.0 * mesh.normal_force))
    with pytest.raises(InputError, match="unloaded_error"):
        flank_force(dataclasses.replace(mesh, unloaded_error=np.full(256, 20e-6)))
    with pytest.raises(InputError, match="sliding_reversals"):
        flank_force(dataclasses.replace(mesh, sliding_reversals=np.array([0.1, 0.105])))
    with pytest.raises(InputError, match="columns in contact"):
        flank_force(mesh_factory(16, RADII, stiff, columns=np.array([0.0, 1e-6, 2e-6])))


def test_force_is_linear_beyond_the_last_column(mesh_factory):
    force = flank_force(mesh_factory(16, RADII, stiff))
    values, slopes = force(np.array([0.01]), np.array([90e-6]), np.array([0.01]), False)
    assert values[0, 0] == pytest.approx(9e4, rel=1e-12, abs=0.0)
    assert slopes[0, 0] == pytest.approx(1e9, rel=1e-12, abs=0.0)
    assert values[0, 1] == pytest.approx(RADII[0], rel=1e-12, abs=0.0)


def test_progress_is_told(mesh_factory, coal_drive):
    mesh = mesh_factory(16, RADII, stiff)
    heard = []
    elastic_motion(mesh, coal_drive, uniform_transport(mesh, coal_drive), progress=lambda *words: heard.append(words))
    assert heard[-1][1] == heard[-1][2]
