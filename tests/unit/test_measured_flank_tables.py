"""[[pinion.flank]] and [[wheel.flank]] of a model file: what they put on the teeth, and every way to refuse them."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem import load_model
from gearfem.definition.model_file import model_hash
from gearfem.flank import Outline, fitted_flanks, make_flanks
from gearfem.foundation import InputError

MODEL = """
name = "20/30"
[pair]
module_mm = 2.0
face_width_mm = 20.0
[pinion]
teeth = 20
[wheel]
teeth = 30
[operation]
pinion_torque_Nm = 50.0
pinion_speed_rpm = 1000.0
"""
HEADER = "roll_length_mm,deviation_um\n"
# The wheel's flank runs from 6.4 to 14.9 mm of roll length.
ROLL = np.linspace(7.0, 14.5, 31)


def rows(roll, depth):
    return "".join(f"{a:.6f},{b:.6f}\n" for a, b in zip(roll, depth, strict=True))


def model(tmp_path, tables, **files):
    for name, text in files.items():
        (tmp_path / f"{name}.csv").write_text(text)
    path = tmp_path / "model.toml"
    path.write_text(MODEL + tables)
    return path


def test_flanks_of_all_teeth_and_of_one(tmp_path):
    tables = '[[wheel.flank]]\nfile = "all.csv"\n[[wheel.flank]]\nfile = "one.csv"\ntooth = 7\n'
    deeper = 40.0 + 2.0 * (ROLL - 10.0) ** 2
    path = model(tmp_path, tables, all=HEADER + rows(ROLL, 0.0 * ROLL + 30.0), one=HEADER + rows(ROLL, deeper))
    setup = load_model(path)
    flanks = make_flanks(setup)
    np.testing.assert_allclose(flanks.wheel.deviation.at(ROLL * 1e-3), 30e-6, rtol=0.0, atol=1e-12)
    (tooth, odd), *others = flanks.wheel_odd
    assert (tooth, others) == (7, [])
    # A quadratic is a quartic too; what is left is the spline's error where the ends run out.
    np.testing.assert_allclose(odd.deviation.at(ROLL * 1e-3), deeper * 1e-6, rtol=0.0, atol=1e-9)
    assert flanks.pinion.deviation is None
    assert not flanks.pinion_odd
    # Fillet foot and tip circle stay.
    whole = Outline(gear=setup.pair.wheel)
    np.testing.assert_allclose(np.hypot(*flanks.wheel.point([1.0, 5.0]).T), np.hypot(*whole.point([1.0, 5.0]).T), rtol=1e-12)
    assert sum("measured points" in sentence for sentence in setup.assumptions) == 2
    assert [fit.points.tooth for fit in fitted_flanks(setup)] == [None, 7]


def test_points_count_for_the_hash_and_the_folder_does_not(tmp_path):
    tables = '[[wheel.flank]]\nfile = "a.csv"\n'
    for name, depth in (("one", 10.0), ("two", 10.0), ("three", 11.0)):
        (tmp_path / name).mkdir()
        model(tmp_path / name, tables, a=HEADER + rows(ROLL, 0.0 * ROLL + depth))
    one, two, three = (load_model(tmp_path / name / "model.toml") for name in ("one", "two", "three"))
    assert model_hash(one) == model_hash(two) != model_hash(three)


def test_an_override_counts_files_from_the_folder_of_the_model(tmp_path):
    path = model(tmp_path, "", b=HEADER + rows(ROLL, 0.0 * ROLL + 5.0))
    setup = load_model(path, ["wheel.flank=[{file='b.csv', tooth=3}]"])
    assert setup.flanks_given[0].tooth == 3


GOOD = HEADER + rows(ROLL, 0.0 * ROLL)
TABLE = '[[wheel.flank]]\nfile = "a.csv"\n'
POINTS = "x_mm,y_mm\n"
REFUSALS = {
    "no such file": ('[[wheel.flank]]\nfile = "b.csv"\n', GOOD, "wheel.flank[1].file", "folder of the model file"),
    "no name": ("[[wheel.flank]]\ntooth = 3\n", GOOD, "wheel.flank[1].file", "must be given"),
    "unknown key": (TABLE + "teeth = 3\n", GOOD, "wheel.flank[1].teeth", "valid name"),
    "tooth that is none": (TABLE + "tooth = 30\n", GOOD, "wheel.flank[1].tooth", "up to 29"),
    "negative tooth": (TABLE + "tooth = -1\n", GOOD, "wheel.flank[1].tooth", "from 0"),
    "tooth twice": (TABLE + "tooth = 3\n" + TABLE + "tooth = 3\n", GOOD, "wheel.flank[2].tooth", "one flank for each tooth"),
    "all teeth twice": (TABLE + TABLE, GOOD, "wheel.flank[2].tooth", "one flank for each tooth"),
    "one table instead of many": ('[wheel.flank]\nfile = "a.csv"\n', GOOD, "wheel.flank", "tables [[wheel.flank]]"),
    "wrong header": (TABLE, GOOD.replace("_um", "_mm"), "header (line 1)", "deviation_um"),
    "ragged": (TABLE, GOOD + "9.0\n", "row 32 (line 33)", "2 columns"),
    "NaN": (TABLE, GOOD + "9.0,nan\n", "row 32 (line 33), column deviation_um", "finite"),
    "seven points": (TABLE, HEADER + rows(ROLL[:7], ROLL[:7]), "rows", "from 8"),
    "seven on the flank": (
        TABLE,
        HEADER + rows(np.append(ROLL[:7], [1.0, 2.0]), np.zeros(9)),
        "flank of the wheel, all teeth (a.csv)",
        "at least 8",
    ),
    "beyond the tip": (TABLE, GOOD + "15.8,1\n", "row 32, column roll_length_mm", "tip circle"),
    "negative roll": (TABLE, GOOD + "-0.1,1\n", "row 32, column roll_length_mm", "from 0"),
    "through the tooth": (TABLE, GOOD + "10.0,4000\n", "row 32, column deviation_um", "tooth's axis"),
    "micrometres as millimetres": (TABLE, HEADER + rows(ROLL, 0.0 * ROLL + 600.0), "wheel.flank (a.csv)", "0.25 modules"),
    "neither system": (TABLE, POINTS + rows(ROLL, 0.0 * ROLL + 1.0), "row 1, columns x_mm and y_mm", "gear's system"),
    "other side": (TABLE, POINTS + rows(np.linspace(29.0, 31.0, 9), np.full(9, -1.5)), "row 1, columns x_mm and y_mm", "y > 0"),
}


@pytest.mark.parametrize("fault", REFUSALS)
def test_faults_are_refused_in_one_line(fault, tmp_path):
    tables, text, where, allowed = REFUSALS[fault]
    path = model(tmp_path, tables, a=text)
    with pytest.raises(InputError) as refusal:
        load_model(path)
    assert refusal.value.where == where
    assert allowed in refusal.value.allowed
    assert str(tmp_path) in str(refusal.value)
    assert "\n" not in str(refusal.value)
