"""The study of measurements of others, on data made here in their layout, and the verdict on a single number."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

from gearfem.diagnosis import diagnose, read_campaign
from gearfem.diagnosis.write import nuisance_rows
from gearfem.effects.catalogue import catalogue

MODEL = """[pair]
module_mm = 3.0
pressure_angle_deg = 20.0
face_width_mm = 20.0
[pinion]
teeth = 24
bore_radius_mm = 12.0
[wheel]
teeth = 30
bore_radius_mm = 15.0
[operation]
pinion_torque_Nm = 60.0
pinion_speed_rpm = 900.0
"""
TURNS, SCALE, PHASE = 3, 1.3, 0.8


@pytest.fixture
def study():
    return importlib.import_module("real_measurements")


def campaign(folder, name, model, records):
    """Write a campaign: a file with columns, values, quantity and more keys for each record."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "nominal.toml").write_text(model)
    text = f'name = "{name}"\nmodel = "nominal.toml"\nangle_zero = "unknown"\n'
    for file, columns, rows, keys in records:
        (folder / file).write_text(columns + "\n" + "".join(f"{a:.10g},{b:.4f}\n" for a, b in rows))
        text += f'[[record]]\nfile = "{file}"\n{keys}\n'
    (folder / f"{name}.toml").write_text(text)
    return folder / f"{name}.toml"


def runouts(folder, rng):
    for size in (0.0, 40.0, 80.0):
        tooth = np.arange(24 * 2 * TURNS)
        value = 2.0 + SCALE * size * np.cos(2.0 * np.pi * tooth / 24 - PHASE) + 1.5 * rng.standard_normal(tooth.size)
        name = f"e{round(size / 10.0):02d}"
        both = np.split(np.column_stack([tooth, value]), 2)
        parts = [(f"{name}_{role}.csv", part, role) for role, part in zip(("fit", "holdout"), both, strict=True)]
        keys = 'quantity = "radial_runout"\ngear = "pinion"\ntooth_zero = "unknown"\nrole = "{}"'
        campaign(folder, name, MODEL, [(file, "tooth,radial_deviation_um", rows, keys.format(role)) for file, rows, role in parts])


def wear(folder, rng):
    for step, depth in (("00", 0.0), ("12", 150.0), ("20", 90.0)):
        roll = np.linspace(10.0, 22.0, 90)
        lost = depth * np.exp(-(((roll - 15.39) / 3.0) ** 2)) + 2.0 * rng.standard_normal(roll.size)
        keys = 'quantity = "flank_profile"\ngear = "wheel"\ntooth = 0\nnoise_std = 20.0\nrole = "fit"'
        campaign(folder, f"case_{step}", MODEL, [(f"case_{step}.csv", "roll_length_mm,deviation_um", np.column_stack([roll, lost]), keys)])


def test_what_is_in_the_data_is_found_with_its_flaws(study, tmp_path, capsys):
    rng = np.random.default_rng(3)
    runouts(tmp_path / study.RUNOUT, rng)
    wear(tmp_path / study.WORN, rng)
    found = study.main([str(tmp_path), "--out", str(tmp_path / "out"), "--campaigns", "0", "--without-rig"])
    text = "\n".join(found["lines"])
    assert text in capsys.readouterr().out
    rows = study.read_runouts(study.read_all(tmp_path / study.RUNOUT))
    for row in rows:
        assert row["amplitude_um"] == pytest.approx(SCALE * row["set_um"], rel=0.0, abs=1.0)
        assert row["left_um"] == pytest.approx(1.5, rel=0.3, abs=0.0)
        if row["set_um"]:
            assert np.radians(row["phase_deg"]) == pytest.approx(PHASE, rel=0.0, abs=0.05)
    assert "Flaw of the data: the gear runs out by 1.29 to 1.31 times" in text or "runs out by 1.30 to 1.30 times" in text
    # The wheel's pitch point is 15.39 mm up its flank, where the wear made here is deepest.
    worn, _ = study.read_wear(study.read_all(tmp_path / study.WORN))
    assert [row["deepest_um"] for row in worn] == pytest.approx([0.0, 150.0, 90.0], rel=0.0, abs=4.0)
    assert worn[1]["at_roll_mm"] == pytest.approx(worn[1]["pitch_roll_mm"], rel=0.05, abs=0.0)
    assert "metal grows back (case_12 to case_20 by 6" in text or "metal grows back (case_12 to case_20 by 5" in text
    assert "In 2 of the 2 deeper flanks" in text
    for name in (study.RUNOUT, study.WORN):
        for ending in ("csv", "png"):
            assert (tmp_path / "out" / f"{name}.{ending}").stat().st_size > 200


def test_data_as_they_should_be_show_no_flaw(study):
    rows = [{"role": "fit", "set_um": size, "amplitude_um": size + 1.0, "left_um": 2.0, "begins_um": 0.3} for size in (0.0, 50.0, 100.0)]
    assert not any("Flaw" in line for line in study.conclude_runouts(rows))


def test_absent_data_are_skipped_with_a_sentence(study, tmp_path):
    found = study.main([str(tmp_path), "--out", str(tmp_path / "out"), "--without-rig"])
    assert found["gaps"] == []
    assert [line.split(":")[0] for line in found["lines"]] == [f"No campaigns in {name}" for name in (study.RUNOUT, study.WORN)]


def test_campaign_of_the_rig_holds_its_one_number(study, tmp_path):
    (record,) = read_campaign(study.myga_campaign(tmp_path)).records
    assert record.quantity.name == "dynamic_factor"
    assert (record.value.tolist(), record.pinion_torque) == ([1.2], 75.4)


@pytest.mark.parametrize(("measured", "verdict"), [("1.2", "ambiguous"), ("1.39", "no_discrepancy")])
def test_one_number_is_explained_in_several_ways_or_needs_none(study, tmp_path, measured, verdict):
    path = study.myga_campaign(tmp_path)
    table = path.with_name("kw.csv")
    table.write_text(table.read_text().replace(",1.2", f",{measured}"))
    kinds = {name: catalogue()[name] for name in ("damping", "body_compliance", "friction", "sensor_gain")}
    found = diagnose(read_campaign(path), kinds)
    assert found.naming.verdict == verdict
    assert len(found.naming.p_values) == len(found.naming.fit.effects)
    names = [[effect.name for effect in effects] for effects in (found.naming.fit.effects, *(one.effects for one in found.alternatives))]
    # More friction only adds to the factor here: it is no explanation.
    assert sorted(names) == ([["body_compliance"], ["damping"], ["sensor_gain"]] if verdict == "ambiguous" else [[]])
    assert bool(found.suggestions) == (verdict == "ambiguous")
    assert 0.0 < next(row["value"] for row in nuisance_rows(found) if row["name"] == "kw_rise_scale") < 2.0
