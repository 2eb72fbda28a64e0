"""The study of the published mesh, in small: its headline numbers."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

STUDY = Path(__file__).parents[2] / "studies" / "paper_mesh.py"


@pytest.fixture(scope="module")
def study():
    spec = importlib.util.spec_from_file_location("paper_mesh_study", STUDY)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_coarse_mesh_is_too_stiff_by_some_per_cent(study, coal_combine, tmp_path: Path) -> None:
    tables = study.main(["--out", str(tmp_path), "--refinement", "3", "--resolution", "0.75"])
    assert len((tmp_path / "paper_mesh.csv").read_text().splitlines()) > 40
    bands = {
        # Full study (refinement 4, resolution 1.5): -2.8 ... -2.0, -7.0 ... -6.4, -2.0 ... -1.0, -5.3 ... -5.0 %; elements divided by
        # three instead of four stay up to 0.5 % stiffer themselves.
        ("pinion", "two_layers"): (-2.9, -1.4),
        ("pinion", "layer_and_sides"): (-7.1, -5.2),
        ("wheel", "two_layers"): (-2.1, -0.6),
        ("wheel", "layer_and_sides"): (-5.4, -3.9),
    }
    for table in tables:
        upper = table["radius_mm"] >= table["radius_mm"].mean()
        coarse, whole = table["coarse_elements_percent"][upper], table["paper_over_root_percent"][upper]
        low, high = bands[table["gear"][0], table["held"][0]]
        assert low < coarse.min()
        assert coarse.max() < high
        # Beside the refined tooth on the root circle it is stiffer by 2 to 11 % there, and off by tens of per cent at the lowest row.
        assert (whole < -1.5).all()
        assert (whole > -11.5).all()
        assert np.abs(table["paper_over_root_percent"][0]) > 8.0
