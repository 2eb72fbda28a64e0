"""The virtual rig: what a plan asks for is in the campaign, spoilt by the stated errors, the same from the same seed."""

from __future__ import annotations

import csv
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from gearfem import InputError, load_model
from gearfem.cli import main
from gearfem.diagnosis import read_campaign
from gearfem.foundation.toml import to_toml
from gearfem.rig import read_plan
from gearfem.rig.plan import EXAMPLE

MODEL = {
    "name": "on the rig",
    "pair": {"module_mm": 3.0, "face_width_mm": 20.0, "normal_backlash_mm": 0.06},
    "pinion": {"teeth": 20},
    "wheel": {"teeth": 30},
    "operation": {"pinion_torque_Nm": 120.0, "pinion_speed_rpm": 2000.0, "pinion_inertia_kg_m2": 0.004, "wheel_inertia_kg_m2": 0.012},
    "effect": [{"name": "runout", "gear": "wheel", "eccentricity_um": 12.0, "angle_rad": 0.7}],
}
STATIC = {"file": "te.csv", "quantity": "static_transmission_error", "pinion_torque_Nm": 120.0, "turns": 2.0, "samples_per_turn": 1000}
RUNOUT = {"file": "runout.csv", "quantity": "radial_runout", "gear": "wheel", "turns": 1.0}
ROLL = {"file": "flank.csv", "quantity": "flank_profile", "gear": "wheel", "tooth": 3}


def write(path: Path, tables: dict) -> Path:
    """Write tables as TOML."""
    path.write_text(to_toml(tables))
    return path


def measured(folder: Path, *records: dict, name: str = "campaign", status: int = 0, **plan: object) -> Path:
    """Measure records by the command; return the folder of the campaign."""
    model = write(folder / "true.toml", MODEL)
    tables = {"name": "plan", "seed": 1, "record": list(records), **plan}
    words = ["measure", str(model), "--plan", str(write(folder / "plan.toml", tables)), "--out", str(folder / name)]
    result = CliRunner().invoke(main, words)
    assert result.exit_code == status, result.output
    return folder / name


def column(path: Path, place: int = 1) -> np.ndarray:
    """Return a column of a record."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return np.array([row[place] for row in list(csv.reader(lines))[1:]], float)


def test_a_campaign_is_read_again_and_hides_what_is_to_be_found(tmp_path):
    out = measured(tmp_path, STATIC, RUNOUT, ROLL, angle_zero="pitch_point", instrument={"noise_std": 0.2})
    campaign = read_campaign(out / "campaign.toml")
    assert [record.quantity.name for record in campaign.records] == ["static_transmission_error", "radial_runout", "flank_profile"]
    assert campaign.setup.effects == ()
    assert campaign.records[0].noise_std == pytest.approx(0.2e-6, rel=1e-12, abs=0.0)
    assert "effect" not in tomllib.loads((out / "nominal.toml").read_text())
    assert json.loads((out / "truth.json").read_text())["effects"] == MODEL["effect"]
    assert sorted(path.name for path in out.iterdir()) == [
        "campaign.toml", "flank.csv", "nominal.toml", "runout.csv", "te.csv", "truth.json"
    ]  # fmt: skip


def test_a_seed_is_a_campaign(tmp_path):
    spoilt = {"scatter": {"index_error_um": 0.5}, "instrument": {"noise_std": 0.3}}
    first, again = (measured(tmp_path, STATIC, RUNOUT, name=name, **spoilt) for name in ("first", "again"))
    assert all((again / path.name).read_bytes() == path.read_bytes() for path in first.iterdir())
    other = measured(tmp_path, STATIC, RUNOUT, name="other", **{**spoilt, "seed": 2})
    assert np.abs(column(other / "te.csv") - column(first / "te.csv")).max() > 1.0
    fewer = measured(tmp_path, STATIC, name="fewer", **spoilt)
    assert np.array_equal(column(fewer / "te.csv"), column(first / "te.csv"))


def test_instruments_spoil_as_they_say(tmp_path):
    """With 2000 samples a standard deviation is met to 1.6 %, three times that is asked; a correlation of e^(-1/20) to 0.02."""
    true = column(measured(tmp_path, {**STATIC, "constant": 0.0}, angle_zero="pitch_point") / "te.csv")
    errors = {
        "white": ({"noise_std": 0.3}, lambda e: (e.std(), 0.3, 0.05)),
        "coloured": (
            {"coloured_noise_std": 0.3, "coloured_noise_samples": 20.0},
            lambda e: (np.corrcoef(e[1:], e[:-1])[0, 1], 0.951, 0.02),
        ),
        "steps": ({"resolution": 2.0}, lambda e: (np.abs(e).max(), 1.0, 0.05)),
        "drift": ({"drift_per_turn": 5.0}, lambda e: (e[1500] - e[500], 5.0, 1e-6)),
        "constant": ({"constant": -7.0}, lambda e: (e.mean(), -7.0, 1e-6)),
        "gain": ({"gain": 1.5}, lambda e: ((e / true).mean(), 0.5, 1e-6)),
    }
    for name, (keys, check) in errors.items():
        found, stated, within = check(
            column(measured(tmp_path, {**STATIC, "constant": 0.0, **keys}, name=name, angle_zero="pitch_point") / "te.csv") - true
        )
        assert found == pytest.approx(stated, rel=within, abs=0.0), name


def test_an_unknown_zero_is_common_to_all_records(tmp_path):
    out = measured(tmp_path, {**STATIC, "constant": 0.0}, {**STATIC, "file": "more.csv", "constant": 0.0})
    assert np.array_equal(column(out / "te.csv"), column(out / "more.csv"))
    offset = json.loads((out / "truth.json").read_text())["angle_offset_rad"]
    known = measured(tmp_path, {**STATIC, "constant": 0.0}, name="known", angle_zero="pitch_point")
    angle = column(out / "te.csv", 0)
    shifted = np.interp(angle[:1900] + offset, column(known / "te.csv", 0), column(known / "te.csv"))
    assert np.sqrt(np.mean((shifted - column(out / "te.csv")[:1900])[abs(int(offset * 1000)) + 10 :] ** 2)) < 0.05
    assert 0.0 < abs(offset) < np.pi / 20.0


REFUSED = [
    ({"record": [{**STATIC, "quantity": "static_transmission_eror"}]}, "record[1].quantity", "static_transmission_error"),
    ({"record": [{**STATIC, "pinion_torque_Nm": -1.0}]}, "record[1].pinion_torque_Nm", "above 0"),
    ({"record": [{**STATIC, "turn": 2.0}]}, "record[1].turn", "turns"),
    ({"record": [{**STATIC, "file": "../te.csv"}]}, "record[1].file", "without folders"),
    ({"record": [STATIC, STATIC]}, "record[2].file", "of its own"),
    ({"record": [{**ROLL, "tooth": 30}]}, "record[1].tooth", "0 to 29"),
    ({"record": [{**RUNOUT, "tooth": 3}]}, "record[1].tooth", "no such key"),
    ({"record": [{"file": "kw.csv", "quantity": "dynamic_factor", "pinion_torque_Nm": 5.0}]}, "record[1].pinion_speeds_rpm", "needs it"),
    ({"record": [STATIC], "sed": 3}, "sed", "seed"),
    ({"record": [STATIC], "scatter": {"index_error_um": "much"}}, "scatter.index_error_um", "from 0 um"),
    ({"record": []}, "record", "at least one"),
]


@pytest.mark.parametrize(("changes", "where", "allowed"), REFUSED)
def test_a_wrong_plan_is_one_line_and_nothing_is_written(tmp_path, changes, where, allowed):
    setup = load_model(write(tmp_path / "true.toml", MODEL))
    plan = write(tmp_path / "plan.toml", {"name": "plan", "seed": 1, **changes})
    with pytest.raises(InputError) as refusal:
        read_plan(plan, setup.pair)
    assert refusal.value.where == where
    assert allowed in refusal.value.allowed
    result = CliRunner().invoke(main, ["measure", str(tmp_path / "true.toml"), "--plan", str(plan), "--out", str(tmp_path / "out")])
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert str(plan) in result.stderr
    assert not (tmp_path / "out").exists()


def test_the_example_of_a_plan_can_be_read(tmp_path):
    (tmp_path / "plan.toml").write_text(EXAMPLE)
    plan = read_plan(tmp_path / "plan.toml", load_model(write(tmp_path / "true.toml", MODEL)).pair)
    assert [record.quantity for record in plan.record] == ["static_transmission_error", "dynamic_transmission_error", "radial_runout"]
    assert plan.instrument_of(plan.record[0]).noise_std == 0.3


def test_responses_of_planned_records_are_written_per_unit(tmp_path: Path) -> None:
    model = write(tmp_path / "model.toml", MODEL)
    plan = write(tmp_path / "plan.toml", {"name": "plan", "seed": 1, "record": [STATIC, RUNOUT]})
    words = ["templates", str(model), "--plan", str(plan), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(main, [*words, "--only", "runout", "--only", "sensor_gain"])
    assert result.exit_code == 0, result.output
    files = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert files == ["templates_runout.csv", "templates_te.csv"]
    lines = [line for line in (tmp_path / "out" / files[0]).read_text().splitlines() if not line.startswith("#")]
    # A wheel that is as far off its centre again reads as much more, whatever the direction, at its largest.
    assert np.abs(column(tmp_path / "out" / files[0], 3)).max() == pytest.approx(1.0, rel=0.01, abs=0.0)
    assert lines[0].split(",")[2:] == ["runout_pinion_eccentricity_um", "runout_wheel_eccentricity_um", "sensor_gain_scale"]
    for wrong, option in ((["--tooth", "999"], "--tooth"), (["--strength", "2"], "--strength"), (["--only", "run_out"], "run_out")):
        refused = CliRunner().invoke(main, [*words, *wrong])
        assert refused.exit_code == 2
        assert option in refused.output
