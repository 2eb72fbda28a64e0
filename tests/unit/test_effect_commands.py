"""Effects of a model file act in every command, and wrong ones end in one line."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from gearfem import InputError, make_setup, run
from gearfem.cli import main
from gearfem.effects.catalogue import catalogue, effects_from, read_effects
from gearfem.effects.sensor_gain import SensorGain
from gearfem.foundation import EffectError
from gearfem.foundation.toml import to_toml

PAIR = {
    "pair": {"module_mm": 3.0, "face_width_mm": 20.0, "normal_backlash_mm": 0.06},
    "pinion": {"teeth": 20},
    "wheel": {"teeth": 30},
    "operation": {"pinion_torque_Nm": 120.0, "pinion_speed_rpm": 2000.0},
}
RELIEF = {"name": "tip_relief", "gear": "wheel", "amount_um": 20.0, "length_mm": 2.0}
LATE = {"name": "pitch_error", "gear": "pinion", "tooth": 1, "amount_um": 8.0}


def call(folder: Path, command: str, *effects: dict, more: tuple[str, ...] = (), **tables: object) -> tuple[Path, str]:
    """Run a command; return its folder and what it says."""
    (folder / "model.toml").write_text(to_toml({**PAIR, "effect": list(effects), **tables}))
    out = folder / f"{command}{len(effects)}{len(tables)}"
    result = CliRunner().invoke(main, [command, str(folder / "model.toml"), "--out", str(out), *more])
    assert result.exit_code == 0, result.output
    return out, result.output


def table(path: Path, column: str) -> np.ndarray:
    """Return a column of a table."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    place = lines[0].split(",").index(column)
    return np.array([float(line.split(",")[place]) for line in lines[1:]])


def test_commands_follow_effects_of_one_tooth_and_of_all(tmp_path):
    folders = (call(tmp_path, "kinematics", *effects)[0] for effects in ((), (RELIEF,), (RELIEF, LATE)))
    plain, relieved, late = (table(folder / "kinematics.csv", "gear_ratio") for folder in folders)
    # Rows differ in number with the pairs in contact; their spread does not depend on that.
    assert abs(relieved.std() - plain.std()) > 0.01 * plain.std()
    assert abs(late.std() - relieved.std()) > 0.01 * plain.std()


def test_the_elastic_model_runs_over_whole_turns_where_teeth_differ():
    uneven = run(make_setup({**PAIR, "effect": [LATE]}))
    assert uneven.elastic is not None
    turns = uneven.elastic.pinion_angle[-1] / (2.0 * np.pi)
    assert turns == pytest.approx(1.0, rel=1e-3, abs=0.0)
    # The lag is largest while the late tooth carries, once a turn.
    angle = uneven.elastic.pinion_angle[uneven.elastic.transmission_error.argmax()] % (2.0 * np.pi)
    assert angle / (2.0 * np.pi / 20.0) == pytest.approx(1.0, abs=0.5)
    assert uneven.elastic.pinion_speed.mean() == pytest.approx(uneven.setup.operation.pinion_speed, rel=1e-9, abs=0.0)
    assert any(sentence.startswith("Effect: Pitch error of tooth 1") for sentence in uneven.assumptions)
    assert any("all three models run over 20 pitches" in sentence for sentence in uneven.assumptions)


def test_fitted_values_act():
    """A stiffness scale is one of Young's moduli: twice of both, and of the torque, leaves every deflection as it is."""
    plain, doubled = (
        run(make_setup({**PAIR, "calibration": fitted}), "engagement").engagement
        for fitted in ({}, {"stiffness_scale": 2.0, "torque_scale": 2.0})
    )
    assert plain is not None
    assert doubled is not None
    assert doubled.transmission_error == pytest.approx(plain.transmission_error, rel=1e-9, abs=0.0)
    assert doubled.mesh_stiffness == pytest.approx(2.0 * plain.mesh_stiffness, rel=1e-7, abs=0.0)
    late = run(make_setup({**PAIR, "calibration": {"pinion_index_error_um": [3.0] + 19 * [0.0]}}), "engagement", angles=np.zeros(1))
    assert late.engagement is not None
    middle = plain.transmission_error[plain.contacts.pinion_angle == 0.0][0]
    assert late.engagement.transmission_error[0] == pytest.approx(middle + 3e-6, rel=1e-3, abs=0.0)


WRONG = [
    ([{**RELIEF, "name": "tip_releif"}], "effect[1].name", "tip_relief (the nearest valid name)"),
    ([{**RELIEF, "gear": "gear"}], "effect[1].gear", '"pinion" or "wheel"'),
    ([RELIEF, {**RELIEF, "amount_um": -1.0}], "effect[2].amount_um", "from 0 to 150 um"),
    ([{**RELIEF, "amount_um": "much"}], "effect[1].amount_um", "a number"),
    ([{**RELIEF, "amount_um": float("inf")}], "effect[1].amount_um", "a number"),
    ([{**RELIEF, "amount": 1.0}], "effect[1].amount", "amount_um (the nearest valid name)"),
    ([{"name": "tip_relief", "gear": "wheel", "amount_um": 1.0}], "effect[1].length_mm", "needs this key"),
    ([{**LATE, "tooth": 20}], "effect[1].tooth", "0 to 19"),
    ([{**LATE, "tooth": 2.0}], "effect[1].tooth", "an integer"),
    ([{}], "effect[1].name", "backlash"),
    ({"name": "runout"}, "effect", "tables [[effect]]"),
    ([7], "effect[1]", "a table [[effect]]"),
]


@pytest.mark.parametrize(("effects", "where", "allowed"), WRONG)
def test_wrong_effects_are_refused_by_their_keys(effects, where, allowed):
    with pytest.raises(InputError) as refusal:
        make_setup({**PAIR, "effect": effects})
    assert refusal.value.where == where
    assert allowed in refusal.value.allowed
    assert "\n" not in str(refusal.value)


CALIBRATIONS = [
    ({"stiffness_scale": 0.0}, "calibration.stiffness_scale"),
    ({"pinion_index_error_um": [1.0, 2.0]}, "calibration.pinion_index_error_um"),
    ({"wheel_index_error_um": [1.0, "x"]}, "calibration.wheel_index_error_um[2]"),
    ({"record": [{"file": "a.csv"}]}, "calibration.record[1].offset_um"),
    ({"record": 2 * [{"file": "a.csv", "offset_um": 1.0}]}, "calibration.record[2].file"),
    ({"record": [{"file": "a.csv", "offset_um": 1.0, "kick": [0.0, 1000.0]}]}, "calibration.record[1].kick[2]"),
]


@pytest.mark.parametrize(("table", "where"), CALIBRATIONS)
def test_wrong_calibrations_are_refused_by_their_keys(table, where):
    with pytest.raises(InputError) as refusal:
        make_setup({**PAIR, "calibration": table})
    assert refusal.value.where == where


def test_a_list_that_is_too_short_is_told_how_long_it_is():
    with pytest.raises(InputError, match=r"calibration\.record\[1\]\.kick: found \[0\.0\]; allowed: a list of 2, each a number"):
        make_setup({**PAIR, "calibration": {"record": [{"file": "a.csv", "offset_um": 1.0, "kick": [0.0]}]}})


def test_files_and_classes_that_are_no_effects_are_refused(tmp_path):
    broken, empty = tmp_path / "broken.py", tmp_path / "empty.py"
    broken.write_text("import no_such_module\n")
    empty.write_text('"""Nothing."""\n')
    for path, words in ((broken, "ModuleNotFoundError"), (empty, "without an effect"), (tmp_path / "none.py", "none.py")):
        with pytest.raises(InputError, match=words):
            effects_from(path)
    relief = catalogue()["tip_relief"]
    twin = type("Twin", (relief,), {"name": "tip_relief"})
    with pytest.raises(InputError, match="a second class of this name"):
        read_effects([], make_setup(PAIR), [twin])
    with pytest.raises(InputError, match="stage"):
        catalogue([type("Lost", (relief,), {"name": "lost", "stage": "nowhere"})])


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("return 1.0 / 0.0 * flanks", "ZeroDivisionError"),
        ("flanks.no_such_thing()", "AttributeError"),
        ("return setup", "act returns Setup("),
        ("pass", "act returns None, no Instrument as it is given"),
        ("return dataclasses.replace(flanks, gain=float('nan'))", "gain of the Instrument is no number"),
    ],
)
def test_an_effect_of_ones_own_that_fails_is_named_in_one_line(tmp_path, code, words):
    line, status = _run_with_own(tmp_path, code, "1.0")
    assert line.startswith('error: effect "deaf": ')
    assert words in line
    assert status == (1 if "number" in words else 2)


@pytest.mark.parametrize(
    ("high", "words"),
    [
        ("lambda setup, member: setup.no_such_thing", "its size fails with AttributeError"),
        ("lambda setup: 1.0", "its size fails with TypeError"),
        ("lambda setup, member: float('nan')", "its size is nan, no number"),
        ("lambda setup, member: None", "its size is None, no number"),
    ],
)
def test_a_bound_of_ones_own_that_fails_is_named_in_one_line(tmp_path, high, words):
    line, status = _run_with_own(tmp_path, "return flanks", high)
    assert line.startswith(f'error: effect parameter "share of the sound": {words}')
    assert status == 2


@pytest.mark.parametrize("method", ["check(self, setup)", "describe(self)"])
def test_any_method_of_ones_own_that_fails_is_named_in_one_line(tmp_path, method):
    line, status = _run_with_own(tmp_path, f"return flanks\n\n    def {method}:\n        return self.no_such_thing", "1.0")
    assert line.startswith(f'error: effect "deaf": {method.partition("(")[0]} fails with AttributeError (')
    assert status == 2


def test_what_an_effect_of_ones_own_says_wrongly_of_itself_is_named():
    @dataclasses.dataclass(frozen=True, kw_only=True)
    class Lost(SensorGain):
        name = "lost"
        sentence = "The instrument reads {no_such_key} times."

        def unlikely(self):
            return (1.0 / 0.0,)

    lost = Lost(scale=1.1)
    with pytest.raises(EffectError, match=r'effect "lost": describe fails with KeyError'):
        lost.describe()
    with pytest.raises(EffectError, match=r'effect "lost": unlikely fails with ZeroDivisionError'):
        lost.unlikely()


def _run_with_own(tmp_path, code, high):
    """Run a model with an effect whose act is of this code and whose largest share is this one; return what is said, and the status."""
    (tmp_path / "own.py").write_text(f"""import dataclasses
from gearfem.effects.effect import Effect, parameter


@dataclasses.dataclass(frozen=True, kw_only=True)
class Deaf(Effect):
    name = "deaf"
    stage = "sensing"
    repeats = "every tooth"
    sentence = "The instrument hears {{share}}."
    source = "none"
    share: float = parameter("share of the sound", low=0.0, high={high}, typical=0.5, neutral=0.0)

    def act(self, flanks, setup):
        {code}
""")
    (tmp_path / "model.toml").write_text(to_toml({**PAIR, "effect": [{"name": "deaf", "share": 0.5}]}))
    words_of = ["run", str(tmp_path / "model.toml"), "--effects", str(tmp_path / "own.py"), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(main, words_of)
    (line,) = result.output.splitlines()
    assert not (tmp_path / "out").exists()
    return line, result.exit_code
