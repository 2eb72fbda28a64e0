"""The study that puts the paper's figures beside ours."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

STUDY = Path(__file__).parents[2] / "studies" / "paper_figures.py"


@pytest.mark.slow
def test_figures_stand_beside_the_papers(tmp_path, capsys) -> None:
    spec = importlib.util.spec_from_file_location("paper_figures", STUDY)
    study = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(study)
    tables = study.main(["--out", str(tmp_path)])
    factors = {label: ours for label, ours, *_ in tables["myga_rig"]}
    # The authors call a difference under 15 % satisfactory; ours against theirs, with assumed inertias.
    assert factors["largest Kw, computed by the authors"] == pytest.approx(1.36, rel=0.15, abs=0.0)
    printed = capsys.readouterr().out
    assert "inertias" in printed
    assert "1.200" in printed
    for name in ("coal_combine/report.html", "myga_rig/report.html", "published.csv"):
        assert (tmp_path / name).stat().st_size > 500
    assert "measured by Myga" in (tmp_path / "myga_rig" / "report.html").read_text(encoding="utf-8")
