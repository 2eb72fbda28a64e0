"""What the report shows of measured flanks: every point, its use, its residual; the sentence among the assumptions."""

from __future__ import annotations

import csv
import dataclasses
import warnings

import numpy as np
import pytest

from gearfem import make_setup, run
from gearfem.flank import fitted_flanks
from gearfem.report.flank_plots import plot_measured_flanks, write_measured_flanks
from gearfem.report.html import write_report
from gearfem.report.kinematics_plots import away_from_line, has_worn_flanks


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    rng = np.random.default_rng(4)
    roll = np.linspace(7.0, 14.5, 40)
    depth = 30.0 + 5.0 * (roll - 10.0) ** 2 + 2.0 * rng.standard_normal(40)
    depth[11] += 40.0
    file = tmp_path_factory.mktemp("flank") / "worn.csv"
    lines = [f"{a:.6f},{b:.6f}" for a, b in zip([3.0, *roll], [0.0, *depth], strict=True)]
    file.write_text("roll_length_mm,deviation_um\n" + "\n".join(lines) + "\n")
    setup = make_setup(
        {
            "pair": {"module_mm": 2.0, "face_width_mm": 20.0},
            "pinion": {"teeth": 20},
            "wheel": {"teeth": 30, "flank": [{"file": str(file)}, {"file": str(file), "tooth": 4}]},
            "operation": {"pinion_torque_Nm": 50.0, "pinion_speed_rpm": 1000.0},
        }
    )
    return run(setup, until="flank")


def test_the_table_holds_every_point_and_its_use(results, tmp_path):
    path = write_measured_flanks(results, tmp_path)
    lines = path.read_text().splitlines()
    comments = [line for line in lines if line.startswith("#")]
    assert sum("outliers in rows 13" in line for line in comments) == 2
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert len(rows) == 2 * 41
    assert [row["row"] for row in rows if row["use"] == "outlier"] == ["13", "13"]
    assert [row["row"] for row in rows if row["use"] == "aside"] == ["1", "1"]
    for row in rows:
        left = float(row["deviation_um"]) - float(row["fit_um"])
        assert float(row["residual_um"]) == pytest.approx(left, rel=0.0, abs=1e-6)


def test_the_fit_is_among_the_assumptions(results):
    said = [sentence for sentence in results.assumptions if "cross-validation" in sentence]
    assert said == [flank.sentence for flank in fitted_flanks(results.setup)]


def test_the_picture_shows_fit_residuals_and_outlier(results):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure = plot_measured_flanks(results)
        figure.canvas.draw()
    assert len(figure.axes) == 4
    texts = [text.get_text() for axis in figure.axes for text in axis.texts]
    assert texts == ["13"] * 4
    assert "standard deviation" in figure.axes[2].get_title(loc="left")


def test_worn_flanks_bring_their_kinematics_into_the_report(results, tmp_path):
    engaged = run(results.setup, until="engagement")
    page = write_report(engaged, tmp_path).read_text()
    assert all(title in page for title in ("Worn flanks", "Line of action", "Gear ratios"))
    assert all((tmp_path / f"{name}.png").exists() for name in ("flank_outlines", "line_of_action", "gear_ratios"))
    # 30 to 140 um of metal missing bend the line of action by more than their share along the normal.
    assert 10e-6 < away_from_line(engaged) < 2e-3
    sound = dataclasses.replace(results.setup, flanks_given=())
    assert not has_worn_flanks(run(sound, until="engagement"))
