"""Loads along the face width in files and pictures."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from click.testing import CliRunner

from gearfem.cli import main
from gearfem.compliance import Root, SolidElements
from gearfem.engagement.engage import engage
from gearfem.engagement.width import FaceSlices
from gearfem.engagement.width_load import load_over_width
from gearfem.flank.lead import Lead
from gearfem.pipeline import run
from gearfem.report import write_stiffness, write_width_picture
from gearfem.report.width_plots import plot_width
from tests.unit.shell import rows

MODEL = """
[pair]
module_mm = 2.0
face_width_mm = 6.0
[pinion]
teeth = 17
bore_radius_mm = 11.0
[wheel]
teeth = 19
bore_radius_mm = 11.0
[operation]
pinion_torque_Nm = 20.0
pinion_speed_rpm = 1000.0
[[effect]]
name = "lead_misalignment"
slope_um = 6.0
"""


def test_factor_and_picture_are_those_of_the_slices(small_pair, tmp_path) -> None:
    results = run(small_pair, until="compliance")
    slices = FaceSlices(count=4, positions=2, method=SolidElements(support=Root(), resolution=0.5, layers=2))
    lead = Lead().plus(lambda place: 10e-6 * (place + 0.5))
    mesh = dataclasses.replace(results.mesh, flanks=dataclasses.replace(results.mesh.flanks, lead=lead), slices=slices)
    loaded = engage(mesh, np.linspace(-1.0, 1.0, 21) * small_pair.pair.pinion.pitch_angle, 50.0)
    along = load_over_width(mesh, loaded)
    path = write_stiffness(dataclasses.replace(results, engagement=loaded), tmp_path, widths=[along])
    written = np.array([float(row["face_load_factor"]) for row in rows(path)])
    # Ten digits are written.
    assert written == pytest.approx(along.face_load_factor, rel=1e-9, abs=0.0)
    assert "face_load_factor" not in rows(write_stiffness(dataclasses.replace(results, engagement=loaded), tmp_path))[0]
    left, right = plot_width(small_pair, 50.0, along).axes[:2]
    assert f"{along.face_load_factor.max():.3f}" in left.get_title(loc="left")
    assert max(np.max(line.get_ydata()) for line in right.lines) == pytest.approx(1e-3 * along.line_load.max(), rel=1e-12, abs=0.0)
    assert write_width_picture(small_pair, 50.0, along, tmp_path).stat().st_size > 20_000


@pytest.mark.slow
def test_command_reports_the_factor_of_a_tilt(tmp_path) -> None:
    model = tmp_path / "model.toml"
    model.write_text(MODEL)
    result = CliRunner().invoke(main, ["stiffness", str(model), "--out", str(tmp_path / "out"), "--steps", "200"])
    assert result.exit_code == 0, result.output
    assert "face load factor K_Hbeta at 20 N m: " in result.output
    assert (tmp_path / "out" / "load_over_width.png").exists()
    factors = [float(row["face_load_factor"]) for row in rows(tmp_path / "out" / "mesh_stiffness.csv")]
    assert 1.2 < min(factors) < max(factors) < 5.0
