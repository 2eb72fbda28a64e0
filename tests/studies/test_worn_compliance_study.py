"""The study of what wear changes, in small: its headline numbers."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

STUDY = Path(__file__).parents[2] / "studies" / "worn_compliance.py"


def load():
    spec = importlib.util.spec_from_file_location("worn_compliance_study", STUDY)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_response_serves_up_to_its_bound_and_contact_does_not_change_alone(tmp_path: Path) -> None:
    study = load()
    study.SHAPES = {"root_and_tip": study.SHAPES["root_and_tip"]}
    little, deep = study.main(["--out", str(tmp_path), "--depths", "0.16", "0.7", "--angles", "7"])
    lines = (tmp_path / "worn_compliance.csv").read_text().splitlines()
    assert lines[0].startswith("# root_and_tip")
    # A bound of 0.02 modules is 0.16 mm here: without any response the transmission error would be 0.5 % off.
    assert little["error_in_proportion_percent"] < 0.1 < little["error_without_wear_percent"]
    # The contact yields 5 to 15 % more under the deepest wear, and bending changes by as much: not much less, as the paper has it.
    assert 5.0 < deep["contact_most_percent"] < 15.0
    assert deep["bending_least_percent"] < -5.0
    assert 1.0 < deep["bending_same_points_percent"] < 10.0
