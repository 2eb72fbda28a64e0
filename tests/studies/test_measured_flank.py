"""The study of tangents and curvatures from measured points: its formulas, its headline in few draws, points of others."""

from __future__ import annotations

import csv
import importlib
import itertools
import math

import numpy as np
import pytest

from gearfem import load_model
from gearfem.flank import Deviation, Outline


@pytest.fixture
def study():
    return importlib.import_module("measured_flank")


def test_derivatives_are_those_of_the_worn_outline(study):
    done = study.prepare(load_model(study.MODEL))
    outline = Outline(gear=done.gear, deviation=Deviation.none(done.gear).plus(done.wear.depth))
    # The outline's spline of 513 nodes meets the bell's second derivative, of 14 1/m, to some 1e-4 of it.
    np.testing.assert_allclose(outline.curvature(outline.parameter(done.places)), done.curvature, rtol=0.0, atol=5e-3)
    turned = outline.flank_direction(done.places) - math.pi / 2.0 - done.tangent
    np.testing.assert_allclose(np.angle(np.exp(1j * turned)), 0.0, atol=1e-7)


def test_circle_tends_to_the_derivatives_with_its_width_squared(study):
    done = study.prepare(load_model(study.MODEL))
    error = []
    for width in (0.4e-3, 0.2e-3, 0.1e-3):
        tangent, curvature = study.by_circle(done.wear, done.places, done.gear, width)
        error.append((np.abs(tangent - done.tangent).max(), np.abs(curvature - done.curvature).max()))
    for coarse, fine in itertools.pairwise(np.array(error)):
        assert np.log2(coarse / fine) == pytest.approx([2.0, 2.0], abs=0.1)


def test_few_draws_say_what_many_do(study, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(study, "SMALL", (study.Sampling(35, 50e-6, 12), study.Sampling(400, 1e-6, 3)))
    rng = np.random.default_rng(6)
    roll = np.linspace(18.0, 45.0, 35)
    points = tmp_path / "mine.csv"
    lines = (f"{a:.4f},{b:.2f}\n" for a, b in zip(roll, 200.0 + 50.0 * rng.standard_normal(35), strict=True))
    points.write_text("roll_length_mm,deviation_um\n" + "".join(lines))
    found = study.main(["--out", str(tmp_path), "--small", "--points", str(points)])
    printed = capsys.readouterr().out
    assert all(line in printed for line in found["conclusion"])
    for name in (
        "tangent_and_curvature.csv",
        "conclusion.txt",
        "curvature_35_points.png",
        "curvature_400_points.png",
        "fits.csv",
        "fits_1.png",
    ):
        assert (tmp_path / name).stat().st_size > 200, name
    rows = {(row["points"], row["way"]): row for row in found["rows"]}
    through, fit = "spline through the points, {}", "spline of the fit, {}"
    for number in (35, 400):
        # Full runs: the circle has 0.63 and 0.0003 of the error of the spline through the points, the fit at most 0.033 of it.
        twice = rows[number, through.format("derivatives")]["curvature_rms_1_per_m"]
        assert rows[number, through.format("circle")]["curvature_rms_1_per_m"] < 0.8 * twice
        assert rows[number, fit.format("derivatives")]["curvature_rms_1_per_m"] < 0.08 * twice
        # On a smooth fit it matters little how curvature is taken.
        ratio = (
            rows[number, fit.format("circle")]["curvature_rms_1_per_m"] / rows[number, fit.format("derivatives")]["curvature_rms_1_per_m"]
        )
        assert 0.7 < ratio < 1.3
    assert found["fits"][0]["points"] == 35
    assert found["fits"][0]["residual_std_um"] == pytest.approx(50.0, rel=0.4)


def test_a_folder_of_campaigns_is_fitted_record_by_record(study, tmp_path):
    (tmp_path / "nominal.toml").write_text(study.MODEL.read_text())
    for name, depth in (("a", 10.0), ("b", 20.0)):
        rows = "".join(f"{roll:.3f},{depth}\n" for roll in np.linspace(20.0, 40.0, 12))
        (tmp_path / f"{name}.csv").write_text("roll_length_mm,deviation_um\n" + rows)
        record = f'[[record]]\nfile = "{name}.csv"\nquantity = "flank_profile"\ngear = "pinion"\ntooth = 3\n'
        (tmp_path / f"{name}.toml").write_text(f'name = "{name}"\nmodel = "nominal.toml"\n{record}')
    fits = study.fits_of(tmp_path)
    assert [fit.points.file for fit in fits] == ["a.csv", "b.csv"]
    study.show_fits(fits, tmp_path)
    table = list(csv.DictReader(line for line in (tmp_path / "fits.csv").open() if not line.startswith("#")))
    assert [row["file"] for row in table] == ["a.csv", "b.csv"]
