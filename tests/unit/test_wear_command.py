"""The command that wears flanks, the pictures of kinematics, and how they refuse."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from PIL import Image

from gearfem.cli import wearing as work
from gearfem.definition.model_file import read_tables
from gearfem.flank import Deviation, make_flanks
from gearfem.foundation import InputError, SolveError
from gearfem.foundation.columns import read_columns
from gearfem.model import load_model
from gearfem.report.kinematics_plots import enlargement
from gearfem.report.wear_table import write_worn_model
from gearfem.wear import Archard, Worn, life, removed_volume
from tests.unit.shell import MODEL, call


def test_wear_writes_a_model_that_runs(tmp_path):
    done = call("wear", MODEL, "--hours", 50, "--coefficient", "2e-17", "--wheel-coefficient", "3e-17", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    worn = load_model(tmp_path / "worn.toml")
    flanks = make_flanks(worn)
    header = (tmp_path / "wear.csv").read_text().splitlines()[2]
    history = read_columns(tmp_path / "wear.csv", (tuple(header.split(",")),))
    last = dict(zip(history.names, history.values[-1], strict=True))
    assert last["time_h"] == pytest.approx(50.0, rel=1e-9, abs=0.0)
    for member in ("pinion", "wheel"):
        # The fit of 400 points stands for the flank; it is worn by 4 um.
        volume = removed_volume(flanks.of(member), worn.pair.face_width) * 1e9
        assert volume == pytest.approx(last[f"{member}_volume_mm3"], rel=5e-3, abs=0.0)
    result = call("kinematics", tmp_path / "worn.toml", "--out", tmp_path / "k", "--steps", 200, "--gif")
    assert result.exit_code == 0, result.output
    with Image.open(tmp_path / "k" / "engagement.gif") as film:
        assert film.n_frames > 10
    for name in ("flank_outlines.png", "measured_flanks.png", "measured_flanks.csv"):
        assert (tmp_path / "k" / name).stat().st_size > 1000


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["--hours", "0", "--coefficient", "1e-17"], "--hours"),
        (["--hours", "nan", "--coefficient", "1e-17"], "--hours"),
        (["--hours", "10", "--coefficient", "-1"], "--coefficient"),
        (["--hours", "10", "--coefficient", "1e-17", "--rolling", "-1"], "--rolling"),
        (["--hours", "1e6", "--coefficient", "2e-17"], "--hours: found 3.037e+10 turns of the pinion, in which the pinion would lose"),
        (["--hours", "10", "--coefficient", "1e-17", "--set", "effect=[{name='lead_misalignment',slope_um=5.0}]"], "width"),
    ],
)
def test_what_cannot_wear_is_one_line(tmp_path, words, found):
    result = call("wear", MODEL, "--out", tmp_path / "out", *words)
    assert result.exit_code in (1, 2)
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert found in result.stderr
    assert not (tmp_path / "out").exists()


def test_teeth_that_differ_wear_as_the_others(tmp_path):
    odd = tmp_path / "odd.csv"
    odd.write_text(
        "roll_length_mm,deviation_um\n" + "\n".join(f"{roll:.4f},{20.0 + 0.1 * roll:.4f}" for roll in np.linspace(17.0, 46.0, 60))
    )
    late = "effect=[{name='pitch_error',gear='wheel',tooth=3,amount_um=5.0}]"
    flank = f"pinion.flank=[{{file='{odd}',tooth=4}}]"
    done = call("wear", MODEL, "--hours", 20, "--coefficient", "2e-17", "--out", tmp_path / "w", "--set", late, "--set", flank)
    assert done.exit_code == 0, done.output
    assert "all teeth, those that differ too" in done.output
    even = call("wear", MODEL, "--hours", 20, "--coefficient", "2e-17", "--out", tmp_path / "even")
    assert even.exit_code == 0
    same = [(tmp_path / folder / "worn_wheel.csv").read_text().splitlines()[-400:] for folder in ("w", "even")]
    assert same[0] == same[1]
    setup = load_model(tmp_path / "w" / "worn.toml")
    assert [effect.name for effect in setup.effects] == ["pitch_error"]
    flanks = make_flanks(setup)
    tooth, others = flanks.odd("pinion")[4].deviation, flanks.pinion.deviation
    roll = np.linspace(20.0e-3, 45.0e-3, 20)
    assert tooth.at(roll) - others.at(roll) == pytest.approx(20e-6 + 1e-4 * roll, rel=0.0, abs=0.3e-6)


def test_a_life_that_wears_teeth_out_ends_early(monkeypatch):
    setup = load_model(MODEL)
    real, count = life.loads, []

    def fails(*words):
        count.append(1)
        if len(count) > 9:
            raise SolveError("no load sharing")
        return real(*words)

    monkeypatch.setattr(life, "loads", fails)
    short = life.wear_over(setup, Archard(pinion_coefficient=2e-17, wheel_coefficient=2e-17), 1e7, angles=20)
    assert short.turns.size == 5
    assert 0.0 < short.turns[-1] < 1e7
    assert "no load sharing" in short.remarks[0]
    assert "The life ends after" in short.remarks[0]


def test_a_fitted_misalignment_is_left_out_of_wear_and_said():
    setup = load_model(MODEL)
    tilted = dataclasses.replace(setup, calibration=dataclasses.replace(setup.calibration, misalignment=2e-6))
    law = Archard(pinion_coefficient=2e-17, wheel_coefficient=2e-17)
    even, odd = (life.wear_over(one, law, 1e4, angles=20) for one in (setup, tilted))
    assert even.remarks == ()
    assert odd.remarks == (life.ALIGNED,)
    assert np.array_equal(even.pinion_depth, odd.pinion_depth)
    assert odd.setup.calibration.misalignment == 2e-6


def test_flanks_worn_deep_are_written_and_read_again(tmp_path):
    setup = load_model(MODEL)
    deep = {member: np.full((2, Deviation.none(getattr(setup.pair, member)).roll.size), 1.7e-3) for member in ("pinion", "wheel")}
    none = np.zeros(2)
    old = life.Life(
        setup=setup,
        law=Archard(pinion_coefficient=1e-17, wheel_coefficient=1e-17),
        turns=np.array([0.0, 1e9]),
        pinion_depth=deep["pinion"],
        wheel_depth=deep["wheel"],
        pinion_volume=none,
        wheel_volume=none,
        transmission_error=none,
        contact_pressure=none,
    )
    *_, model = write_worn_model(old, read_tables(MODEL), tmp_path, "old")
    assert make_flanks(load_model(model)).pinion.deepest == pytest.approx(1.7e-3, rel=1e-3, abs=0.0)


def test_an_interrupted_life_leaves_nothing(tmp_path, monkeypatch):
    def interrupted(*words, **changes):
        raise KeyboardInterrupt

    monkeypatch.setattr(work, "wear_over", interrupted)
    result = call("wear", MODEL, "--hours", 10, "--coefficient", "1e-17", "--out", tmp_path / "out")
    assert (result.exit_code, result.stderr) == (130, "interrupted\n")
    assert not (tmp_path / "out").exists()


def test_kinematics_of_other_pitches_and_of_odd_teeth(tmp_path):
    odd = "effect=[{name='pitting',gear='pinion',tooth=2,depth_um=200.0,centre_mm=35.0,width_mm=6.0}]"
    result = call("kinematics", MODEL, "--out", tmp_path, "--steps", 200, "--pitches", 1, 3, "--set", odd)
    assert result.exit_code == 0, result.output
    names = (tmp_path / "kinematics.csv").read_text().splitlines()[1].split(",")
    table = read_columns(tmp_path / "kinematics.csv", (tuple(names),))
    rows = dict(zip(table.names, table.values.T, strict=True))
    pitted = rows["pair"] == 2.0
    assert np.ptp(rows["gear_ratio_pair"][pitted]) > 1e-3
    single = rows["pair"] == 1.0
    # Pair 1 is sound: its normal passes through the pitch point wherever its flanks touch.
    assert np.median(np.abs(rows["gear_ratio_pair"][single] - 3.1875)) < 1e-9
    assert call("kinematics", MODEL, "--out", tmp_path, "--pitches", 1, 1).exit_code == 2


def test_a_flank_that_wears_too_deep_is_named():
    setup = load_model(MODEL)
    nodes = Deviation.none(setup.pair.wheel).roll
    with pytest.raises(InputError, match=r"flank of the wheel: found a depth of 3 mm"):
        Worn(gear="wheel", depth=np.full(nodes.size, 3e-3)).act(make_flanks(setup), setup)


def test_coefficients_and_factors_of_pictures():
    with pytest.raises(InputError, match="nothing wears"):
        Archard(pinion_coefficient=0.0, wheel_coefficient=0.0)
    assert [enlargement(depth, 8e-3) for depth in (1e-6, 1e-5, 4e-4)] == [500.0, 50.0, 2.0]
