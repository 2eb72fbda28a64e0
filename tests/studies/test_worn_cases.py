"""The cases of Table 2: what the reconstructions hold to, and the paper's statements beside ours."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest

from gearfem.flank import make_flanks
from gearfem.model import load_model
from gearfem.pipeline import run
from gearfem.wear import removed_volume

STUDIES = Path(__file__).parents[2] / "studies"
VOLUMES = {1: {"pinion": 242.0, "wheel": 142.0}, 2: {"pinion": 642.0, "wheel": 328.0}}


def study(name: str):
    spec = importlib.util.spec_from_file_location(Path(name).stem, STUDIES / name)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("number", [1, 2])
def test_volumes_and_depths_are_those_of_table_2(number):
    path = STUDIES / "coal_combine" / f"case_{number}.toml"
    setup = load_model(path)
    flanks = make_flanks(setup)
    sound = make_flanks(load_model(STUDIES / "coal_combine" / "case_0.toml"))
    for member, stated in VOLUMES[number].items():
        outline = flanks.of(member)
        volume = removed_volume(outline, setup.pair.face_width) * 1e9
        print(f"case {number}, {member}: {volume:.1f} mm3, Table 2: {stated:g} mm3")
        assert volume == pytest.approx(stated, rel=1e-3, abs=0.0)
        # To first order, depth over the arc of the flank; where the flank ends, at 0.6 mm, is worth 2 %.
        roll = np.linspace(outline.flank_start, outline.flank_end, 4001)
        simple = np.trapezoid(outline.deviation.at(roll) * roll / outline.gear.base_radius, roll) * setup.pair.face_width * 1e9
        assert simple == pytest.approx(stated, rel=0.03, abs=0.0)
        mate = sound.of("wheel" if member == "pinion" else "pinion")
        lowest = setup.pair.centre_distance * math.sin(setup.pair.working_pressure_angle) - mate.flank_end
        depth = outline.deviation.at(np.linspace(lowest, sound.of(member).flank_end, 400))
        assert depth.min() >= 0.1e-3
        assert depth.max() <= 0.7e-3
        assert np.ptp(depth) > 0.05e-3
    assert "reconstructed" in setup.name
    assert "RECONSTRUCTION" in path.read_text(encoding="utf-8")


def test_the_line_of_action_is_straight_without_wear_and_curved_with_it():
    worn = study("worn_dynamics.py")
    off = {}
    for number in (0, 1):
        results = run(load_model(STUDIES / "coal_combine" / f"case_{number}.toml"), "engagement")
        off[number] = worn.off_the_line(results)
    assert off[0] < 1e-12
    assert off[1] > 1e-4


@pytest.mark.slow
def test_the_papers_statements_stand_beside_ours(tmp_path, capsys):
    table, said = study("worn_dynamics.py").main(["--out", str(tmp_path)])
    assert [row["case"] for row in table] == [0, 1, 2]
    zero, one, two = table
    # Two pairs carry ever less, and what vibrates grows: the paper's main statements.
    assert zero["two_pairs"] > one["two_pairs"] > two["two_pairs"]
    assert min(one["elastic"], two["elastic"]) > zero["elastic"] > 1.0
    assert max(abs(row["ratio_mean"]) for row in table) < 1e-9
    verdicts = {one.paper: one.verdict for one in said}
    assert verdicts["the line of action is straight for unworn teeth, curved for worn ones"] == "agrees"
    assert set(verdicts.values()) <= {"agrees", "differs"}
    assert "Fig. 11" in capsys.readouterr().out
    for name in ("worn_cases.csv", "worn_statements.csv", "worn_dynamics.png", "case_2/line_of_action.png"):
        assert (tmp_path / name).stat().st_size > 200
