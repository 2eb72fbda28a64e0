"""The dynamic studies in small mode: their files and headline numbers."""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
from pathlib import Path

import numpy as np
import pytest

from gearfem.dynamics import DriveTrain, elastic_motion, uniform_transport, unloaded_transport

STUDIES = Path(__file__).parents[2] / "studies"


@pytest.fixture
def rig():
    spec = importlib.util.spec_from_file_location("myga_unknowns", STUDIES / "myga_rig" / "unknowns.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_what_the_variable_ratio_adds(tmp_path, capsys):
    study = importlib.import_module("three_models")
    rows = study.main(["--out", str(tmp_path), "--small"])
    kw = {(row["ratio_ripple"], row["model"]): row["largest_dynamic_factor"] for row in rows}
    added = kw[0.03, "elastic"] - kw[0.03, "elastic, no error"]
    # With the drive's inertias the ratio governs; its arms swing by 3 % and no more; light gears hardly feel it.
    assert added > 0.3
    assert abs(kw[0.03, "elastic"] - kw[0.03, "elastic, constant arms"]) < 0.03 * kw[0.03, "elastic"]
    assert abs(kw[0.03, "classical"] - kw[0.03, "classical, no error"]) < 0.1 * added
    assert kw[0.03, "elastic, no error"] == pytest.approx(kw[0.0, "elastic"], rel=1e-6)
    assert f"{added:+.3f}" in capsys.readouterr().out
    for name in ("three_models.csv", "three_models.png"):
        assert (tmp_path / name).stat().st_size > 200


def test_ripple_of_the_ratio_is_that_of_the_transport(mesh_factory, coal_drive):
    """The flank error of the study makes the ratio it says, and work of the normal force is the same on both gears."""
    study = importlib.import_module("three_models")
    plain = mesh_factory(16, (0.06, 0.19), lambda phi: 1e9 + 0.0 * phi)
    mesh = study.with_error(plain, *study.swinging(plain, 0.03))
    motion = unloaded_transport(mesh, dataclasses.replace(coal_drive, pinion_inertia=1e3))
    wheel_speed = np.gradient(np.append(motion.wheel_angle, motion.wheel_angle[-1]), edge_order=2)[1:-2]
    ratio = np.diff(motion.pinion_angle)[0] / wheel_speed
    exact = 0.19 / 0.06 / (1.0 - 0.03 * np.sin(16 * motion.pinion_angle[1:-1]))
    # Central differences over 256 angles: (2 pi/256)^2/6 of the ripple.
    assert np.allclose(ratio, exact, rtol=2e-5)
    loaded = mesh.normal_force > 0.0
    arm1, arm2 = (
        np.divide(table, mesh.normal_force, where=loaded, out=np.zeros_like(table)) for table in (mesh.pinion_moment, mesh.wheel_moment)
    )
    i = 0.19 / 0.06 / (1.0 - 0.03 * np.sin(16 * mesh.pinion_angle))
    assert np.allclose(arm2[:, -1] / arm1[:, -1], i, rtol=1e-9)


def test_softening_resonance_with_jump(tmp_path, capsys):
    study = importlib.import_module("kahraman_blankenship")
    (row,) = study.main(["--out", str(tmp_path), "--small"])
    assert row["two_motions"]
    assert 0.5 < row["jump_down_at"] < row["jump_up_at"] < 1.0
    assert row["rms_down_um"] > 2.0 * row["rms_up_um"]
    assert row["contact_loss_down"] > 0.2
    # Discs of 7.6e-3 kg m2 on some 5e8 N/m: around 3 kHz, where the experiments have their resonance too.
    assert row["natural_frequency_Hz"] == pytest.approx(3000.0, rel=0.1)
    assert "softening" in capsys.readouterr().out
    for name in ("kahraman_blankenship.csv", "features.csv", "kahraman_blankenship.png"):
        assert (tmp_path / name).stat().st_size > 200


@pytest.mark.slow
def test_unknowns_of_the_rig(rig, tmp_path, capsys):
    result = rig.main(["--out", str(tmp_path), "--small"])
    held = {row["unknown"]: (row["least"], row["largest"]) for row in result["ranges"]}
    low, high = held["grid of all"]
    assert low < 1.20 < 1.36 < high
    assert held["four pinions"][0] < 1.25
    assert [row["grade"] for row in result["norms"]] == [5, 6, 7, 8]
    assert all(row["range"] == "subcritical" for row in result["norms"])
    assert "1.20 measured" in capsys.readouterr().out
    for name in ("unknowns.csv", "ranges.csv", "iso6336.csv", "unknowns.png"):
        assert (tmp_path / name).stat().st_size > 200


def test_four_pinions_in_step_share_the_wheel(rig, mesh_factory):
    """By symmetry they are one pinion on a quarter of the wheel; the damping is that of the whole pair in both."""
    mesh = mesh_factory(35, (0.05, 0.051), lambda phi: 5e8 * (1.0 + 0.1 * np.cos(35 * phi)))
    drive = DriveTrain(
        pinion_inertia=2.6e-3,
        wheel_inertia=2.9e-3,
        pinion_torque=75.4,
        wheel_torque=76.9,
        efficiency=1.0,
        pinion_speed=400.0,
        friction_coefficient=0.0,
        damping_ratio=0.06,
    )
    one, four = (1.0 / (0.05**2 / 2.6e-3 + part * 0.051**2 / 2.9e-3) for part in (1.0, 4.0))
    quarter = dataclasses.replace(drive, wheel_inertia=2.9e-3 / 4.0, damping_ratio=0.06 * np.sqrt(one / four))
    exact = elastic_motion(mesh, quarter, uniform_transport(mesh, quarter), cycles=1, samples=2000).largest_dynamic_factor
    found = rig.four_pinions(mesh, drive, (0.0, 0.0, 0.0, 0.0))
    # Classical Runge-Kutta at 0.05 of a radian: 1e-6 a period; the last of 8 cycles misses exp(-0.06 2 pi 8/W), W below 1.
    assert found == pytest.approx(exact, rel=5e-3)
