"""What a campaign takes from its model; what it cannot mean, and results in the place of what was read: one line each."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gearfem.cli.diagnoses import run_diagnosis
from gearfem.diagnosis import read_campaign
from gearfem.diagnosis.comparing.magnitudes import refuse_magnitudes
from gearfem.diagnosis.modelling.system_bench import bench_of
from gearfem.diagnosis.write import refuse_to_replace
from gearfem.foundation import InputError
from gearfem.foundation.progress import quiet
from gearfem.foundation.toml import write_toml

MODEL: dict[str, Any] = {
    "pair": {"module_mm": 2.5, "face_width_mm": 25.0},
    "pinion": {"teeth": 23},
    "wheel": {"teeth": 41},
    "operation": {"pinion_torque_Nm": 120.0, "pinion_speed_rpm": 1000.0},
}
ANGLE = np.linspace(0.0, 2.0 * math.pi, 600)
SLOW: dict[str, Any] = {
    "file": "a.csv",
    "quantity": "static_transmission_error",
    "pinion_torque_Nm": 60.0,
    "pinion_speed_rpm": 0.0,
    "role": "fit",
}
FAST = SLOW | {"quantity": "dynamic_transmission_error", "pinion_speed_rpm": 900.0}
RUNOUT = {"file": "b.csv", "quantity": "radial_runout", "gear": "wheel"}
OWN = '''"""An effect of one's own."""

from __future__ import annotations

import dataclasses

from gearfem.effects import Effect, parameter


@dataclasses.dataclass(frozen=True, kw_only=True)
class Lighter(Effect):
    """A wheel that is lighter than the model says."""

    share: float = parameter("share", low=0.0, high=0.5, typical=0.1, neutral=0.0)

    name = "lighter"
    stage = "drive"
    repeats = "not periodic"
    sentence = "The wheel is lighter by {share}"
    source = "a test"

    def act(self, record, setup):
        return dataclasses.replace(record, wheel_inertia=(1.0 - self.share) * record.wheel_inertia)
'''


def write(folder: Path, *records: dict[str, Any], name: str = "campaign.toml", model: dict[str, Any] = MODEL, **series: str) -> Path:
    """Write a campaign of records; a.csv and b.csv are made up where they are not given."""
    value = 3.0 * np.sin(23.0 * ANGLE) + 8.0 * np.sin(ANGLE) + np.random.default_rng(1).normal(0.0, 0.1, ANGLE.size)
    teeth = np.random.default_rng(2).normal(0.0, 5.0, 41)
    texts = {
        "a": "pinion_angle_rad,transmission_error_um\n" + "".join(f"{x:.8f},{y:.5f}\n" for x, y in zip(ANGLE, value, strict=True)),
        "b": "tooth,radial_deviation_um\n" + "".join(f"{tooth},{y:.4f}\n" for tooth, y in enumerate(teeth)),
    }
    for own, text in (texts | series).items():
        (folder / f"{own}.csv").write_text(text)
    write_toml(folder / "model.toml", model)
    write_toml(folder / name, {"model": "model.toml", "angle_zero": "unknown", "record": list(records)})
    return folder / name


def test_the_base_is_read_and_is_not_refused(tmp_path: Path) -> None:
    campaign = read_campaign(write(tmp_path, SLOW | {"noise_std": 0.1}, RUNOUT))
    refuse_magnitudes(campaign, bench_of(campaign))
    refuse_to_replace(campaign, tmp_path / "out")
    assert [record.file for record in campaign.records] == ["a.csv", "b.csv"]


def test_a_motion_begins_as_the_model_has_fitted_it(tmp_path: Path) -> None:
    """Held out or not."""
    kicks = {"a.csv": [1.5, 0.0], "b.csv": [-2.0, 0.0]}
    calibration = {"record": [{"file": file, "offset_um": 0.0, "kick": kick} for file, kick in kicks.items()]}
    angle = "\n".join(f"{x:.8f},{y:.5f}" for x, y in zip(ANGLE, 9.0 * np.sin(23.0 * ANGLE + 1.0) + np.cos(ANGLE), strict=True))
    held = FAST | {"file": "b.csv", "role": "holdout", "pinion_speed_rpm": 700.0}
    file = write(tmp_path, FAST, held, model=MODEL | {"calibration": calibration}, b=f"pinion_angle_rad,transmission_error_um\n{angle}\n")
    assert [record.kick for record in read_campaign(file).records] == [(1.5, 0.0), (-2.0, 0.0)]


@pytest.mark.parametrize(("stated", "ends"), [(100.0, False), (10.0, True), (1e-9, False), (1e-4, True)])
def test_noise_that_a_record_cannot_hold_is_refused(tmp_path: Path, stated: float, ends: bool) -> None:
    """Nanometres written for micrometres, and metres: the record varies by 6 um, its noise included."""
    file = write(tmp_path, SLOW | {"noise_std": stated})
    if ends:
        assert read_campaign(file).records[0].noise_std == pytest.approx(stated * 1e-6, rel=1e-12, abs=0.0)
        return
    with pytest.raises(InputError, match=rf"record\[1\]\.noise_std: found {stated:g}; allowed: from 6.*e-08 to 18.*vary by 6"):
        read_campaign(file)


@pytest.mark.parametrize(("by", "first"), [(100.0, 300), (-100.0, 300), (20.0, 300), (100.0, 575), (0.0, 300)])
def test_a_record_that_goes_on_at_another_level_is_refused_from_its_row_on(tmp_path: Path, by: float, first: int) -> None:
    """Not where it varies as much as it steps, nor over the last pitch alone, which may be that of a tooth out of place."""
    value = 3.0 * np.sin(23.0 * ANGLE) + by * (np.arange(ANGLE.size) >= first)
    text = "pinion_angle_rad,transmission_error_um\n" + "".join(f"{x:.8f},{y:.5f}\n" for x, y in zip(ANGLE, value, strict=True))
    path = write(tmp_path, SLOW, a=text)
    if abs(by) > 50.0 and first == 300:
        sign = "-" if by < 0.0 else ""
        with pytest.raises(InputError, match=rf"a\.csv: row 301 \(line 302\), column transmission_error_um: found a step of {sign}\d"):
            read_campaign(path)
    else:
        assert len(read_campaign(path).records) == 1


@pytest.mark.parametrize("rows", ["0,1.0\n", "0,1.0\n1,2.0\n", "".join(f"{tooth},4.0\n" for tooth in range(41))])
def test_teeth_that_say_nothing_beside_a_constant_are_refused(tmp_path: Path, rows: str) -> None:
    with pytest.raises(InputError, match=r"b\.csv: column radial_deviation_um: found .*allowed: 3 rows or more that vary"):
        read_campaign(write(tmp_path, RUNOUT, b="tooth,radial_deviation_um\n" + rows))


def test_no_campaign_is_none() -> None:
    with pytest.raises(InputError, match='campaign: found "";'):
        read_campaign("")


def test_a_model_that_is_not_there_is_a_key_of_the_campaign(tmp_path: Path) -> None:
    file = write(tmp_path, SLOW)
    (tmp_path / "model.toml").unlink()
    with pytest.raises(InputError, match=r'campaign\.toml: model: found "model\.toml"; allowed: .*no such file'):
        read_campaign(file)


@pytest.mark.parametrize(
    ("record", "words"),
    [
        (SLOW | {"pinion_torque_Nm": 1e-4}, r"record\[1\] \(a\.csv\)\.pinion_torque_Nm: found 0\.0001 N m; allowed: from 0\.0012 N m on"),
        (SLOW | {"pinion_torque_Nm": 1e-300}, r"pinion_torque_Nm: found 1e-300 N m"),
        (SLOW | {"pinion_torque_Nm": 9e8}, r"record\[1\] \(a\.csv\)\.pinion_torque_Nm: found 9e\+08 N m"),
        (SLOW | {"pinion_speed_rpm": 3000.0}, r"pinion_speed_rpm: found 3000 rpm, at which the mesh meets .* allowed: 0 or a slow speed"),
        (FAST | {"pinion_speed_rpm": 1.0}, r"pinion_speed_rpm: found 1 rpm, at which the gears swing more than 500000 times"),
    ],
)
def test_what_no_model_is_asked_for_is_refused_by_record_and_key(tmp_path: Path, record: dict[str, Any], words: str) -> None:
    campaign = read_campaign(write(tmp_path, record))
    with pytest.raises(InputError, match=words):
        refuse_magnitudes(campaign, bench_of(campaign))


@pytest.mark.parametrize("torque", [1e-4, 9e8])
def test_the_torque_of_a_largest_factor_is_asked_about_too(tmp_path: Path, torque: float) -> None:
    rows = "pinion_speed_rpm,dynamic_factor\n" + "".join(f"{speed},1.2\n" for speed in range(500, 3000, 250))
    record = {"file": "a.csv", "quantity": "dynamic_factor", "pinion_torque_Nm": torque, "role": "fit"}
    campaign = read_campaign(write(tmp_path, record, a=rows))
    with pytest.raises(InputError, match=rf"record\[1\] \(a\.csv\)\.pinion_torque_Nm: found {re.escape(f'{torque:g}')} N m"):
        refuse_magnitudes(campaign, bench_of(campaign))


@pytest.mark.parametrize("name", ["updated.toml", "diagnosis.json"])
def test_results_do_not_replace_the_campaign(tmp_path: Path, name: str) -> None:
    file = write(tmp_path, SLOW, name="updated.toml").rename(tmp_path / name) if name.endswith("toml") else write(tmp_path, SLOW)
    if not name.endswith("toml"):
        (tmp_path / name).mkdir()
    with pytest.raises(InputError, match=r"--out: found .*(the campaign; .*would replace it|a folder; .*can be written)"):
        refuse_to_replace(read_campaign(file), tmp_path)


def test_results_do_not_replace_a_record(tmp_path: Path) -> None:
    file = write(tmp_path, SLOW | {"file": "maps.csv"})
    text = (tmp_path / "a.csv").read_text()
    (tmp_path / "maps.csv").write_text(text)
    with pytest.raises(InputError, match=r"a record of the campaign; allowed: another folder: maps\.csv would replace it"):
        run_diagnosis(str(file), tmp_path, (), (), (), quiet)
    assert (tmp_path / "maps.csv").read_text() == text
    assert not (tmp_path / "diagnosis.json").exists()


def test_the_model_of_a_campaign_may_name_an_effect_of_ones_own(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(OWN)
    file = write(tmp_path, SLOW, model=MODEL | {"effect": [{"name": "lighter", "share": 0.2}]})
    with pytest.raises(InputError, match='found "lighter"'):
        run_diagnosis(str(file), tmp_path / "out", (), (), (), quiet)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "report.html").mkdir()
    # Read with it, it ends where the results cannot be written.
    with pytest.raises(InputError, match=r"report\.html, a folder"):
        run_diagnosis(str(file), tmp_path / "out", (), (), (str(tmp_path / "own.py"),), quiet)


@pytest.mark.parametrize(
    ("before", "after", "found"),
    [
        ("    def act(self, record, setup):", "    def does(self, record, setup):", "no method act"),
        ("@dataclasses.dataclass(frozen=True, kw_only=True)\n", "", "no dataclass"),
    ],
)
def test_an_effect_that_can_do_nothing_is_refused_where_it_is_read(tmp_path: Path, before: str, after: str, found: str) -> None:
    (tmp_path / "own.py").write_text(OWN.replace(before, after))
    with pytest.raises(InputError, match=f"effect lighter: found {found}; allowed: a frozen dataclass"):
        run_diagnosis(str(write(tmp_path, SLOW)), tmp_path / "out", (), (), (str(tmp_path / "own.py"),), quiet)
