"""Campaigns: what is read, what is repaired and listed, and what is refused with one line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gearfem.cli.diagnoses import run_diagnosis
from gearfem.diagnosis import Campaign, read_campaign
from gearfem.foundation import InputError
from gearfem.foundation.progress import quiet

MODEL = """
[pair]
module_mm = 2.5
face_width_mm = 25.0
[pinion]
teeth = 23
[wheel]
teeth = 41
[operation]
pinion_torque_Nm = 120.0
pinion_speed_rpm = 1000.0
"""
HEAD = 'model = "model.toml"\nangle_zero = "unknown"\n'
TE = "pinion_angle_rad,transmission_error_um"
PITCH = 2.0 * np.pi / 23.0


def curve(seed: int, angle: np.ndarray, torque: float) -> np.ndarray:
    """Return something like transmission error: a runout, a step in each pitch, noise."""
    phase = angle / PITCH
    step = 0.05 * torque * ((phase % 1.0) > 0.6)
    return 0.1 * torque + 8.0 * np.sin(angle) + step + np.random.default_rng(seed).normal(0.0, 0.1, len(angle))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "model.toml").write_text(MODEL)
    return tmp_path


@pytest.fixture
def campaign(folder: Path) -> Callable[..., Campaign]:
    """Write series and the tables of their records, and read the campaign."""

    def make(*records: str, head: str = HEAD, **series: str) -> Campaign:
        for name, text in series.items():
            (folder / f"{name}.csv").write_text(text)
        (folder / "campaign.toml").write_text(head + "".join(f"[[record]]\n{record}\n" for record in records))
        return read_campaign(folder / "campaign.toml")

    return make


def static(name: str, torque: float, more: str = "") -> str:
    return f'file = "{name}.csv"\nquantity = "static_transmission_error"\npinion_torque_Nm = {torque}\npinion_speed_rpm = 0.0\n{more}'


def table(axis: np.ndarray, value: np.ndarray, head: str = TE) -> str:
    return f"# a comment\n{head}\n" + "".join(f"{x:.9g},{y:.6g}\n" for x, y in zip(axis, value, strict=True))


ANGLE = np.linspace(0.03, 14.0, 1801)


def te(seed: int, torque: float) -> str:
    return table(ANGLE, curve(seed, ANGLE, torque))


def test_values_come_out_in_si(campaign: Callable[..., Campaign]) -> None:
    kw = 'file = "b.csv"\nquantity = "dynamic_factor"\npinion_torque_Nm = 40.0\nrole = "fit"'
    flank = 'file = "c.csv"\nquantity = "flank_profile"\ngear = "wheel"\ntooth = 40\nnoise_std = 0.5'
    read = campaign(
        static("a", 40.0, "noise_std = 0.1"),
        kw,
        flank,
        a=te(1, 40.0),
        b="pinion_speed_rpm,dynamic_factor\n600,1.2\n",
        c="roll_length_mm,deviation_um\n9.0,0\n12.0,2\n",
    )
    first, second, third = read.records
    assert first.axis == pytest.approx(ANGLE, rel=1e-8, abs=0.0)
    assert first.value[0] == pytest.approx(curve(1, ANGLE, 40.0)[0] * 1e-6, rel=1e-4, abs=0.0)
    assert first.noise_std == pytest.approx(1e-7, rel=1e-12, abs=0.0)
    assert second.axis[0] == pytest.approx(20.0 * np.pi, rel=1e-12, abs=0.0)
    assert (second.role_given, first.role_given) == (True, False)
    assert third.axis[1] == pytest.approx(0.012, rel=1e-12, abs=0.0)
    assert (third.gear, third.tooth, first.line[0], read.angle_known) == ("wheel", 40, 3, False)


def test_the_folder_stands_for_the_campaign_in_it(campaign: Callable[..., Campaign], folder: Path) -> None:
    read = campaign(static("a", 40.0), a=te(1, 40.0))
    assert read_campaign(folder).path == read.path


def test_program_holds_out_inside_the_range_and_says_so(campaign: Callable[..., Campaign]) -> None:
    torques = {"a": 20.0, "b": 120.0, "c": 60.0}
    read = campaign(
        *(static(name, torque) for name, torque in torques.items()), **{n: te(i, t) for i, (n, t) in enumerate(torques.items())}
    )
    assert [record.role for record in read.records] == ["fit", "fit", "holdout"]
    assert any(remark.record == "c.csv" and "held out by the program" in remark.sentence for remark in read.remarks)


def test_two_torques_are_both_fitted(campaign: Callable[..., Campaign]) -> None:
    read = campaign(static("a", 20.0), static("b", 60.0), a=te(1, 20.0), b=te(2, 60.0))
    assert read.of("holdout") == ()


def test_isolated_spike_is_masked_and_listed(campaign: Callable[..., Campaign]) -> None:
    value = curve(1, ANGLE, 60.0)
    value[700] += 25.0
    read = campaign(static("a", 60.0), a=table(ANGLE, value))
    assert np.flatnonzero(~read.records[0].keep).tolist() == [700]
    fault = next(remark for remark in read.remarks if remark.kind == "spike")
    assert fault.rows == (700,)
    assert "row 701 (line 703)" in fault.sentence


def test_steps_and_events_that_return_are_no_spikes(campaign: Callable[..., Campaign]) -> None:
    value = curve(1, ANGLE, 600.0)
    for turn in range(2):
        value[np.argmin(np.abs(ANGLE - 4.0 - 2.0 * np.pi * turn))] += 25.0
    read = campaign(static("a", 600.0), a=table(ANGLE, value))
    assert read.records[0].keep.all()


def test_a_campaign_of_very_many_rows_says_which_are_used(campaign: Callable[..., Campaign], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gearfem.diagnosis.reading.thinning.MANY", 4000)
    angle = np.arange(9000) * PITCH / 150.0
    read = campaign(static("a", 60.0, "noise_std = 0.1"), a=table(angle, curve(1, angle, 60.0)))
    (record,) = read.records
    assert len(record.axis) == 3000
    # A comment and the header come before.
    assert record.line[:2].tolist() == [3, 6]
    (remark,) = [one for one in read.remarks if one.kind == "thinned"]
    assert remark.sentence == "one of 3 rows is used, 3000 of 9000, since the campaign has more than 4000"


def test_more_rows_than_memory_holds_are_refused(campaign: Callable[..., Campaign], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gearfem.diagnosis.reading.campaign.ROWS", 64 * 1800)
    with pytest.raises(InputError, match="1801 rows in all; allowed: up to 1800"):
        campaign(static("a", 60.0), a=te(1, 60.0))


def test_single_missing_row_is_listed(campaign: Callable[..., Campaign]) -> None:
    keep = np.delete(np.arange(len(ANGLE)), 500)
    read = campaign(static("a", 60.0), a=table(ANGLE[keep], curve(1, ANGLE, 60.0)[keep]))
    assert [remark.rows for remark in read.remarks if remark.kind == "missing_rows"] == [(500,)]


def broken(change: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]) -> str:
    return table(*change(ANGLE.copy(), curve(1, ANGLE, 60.0)))


def swapped(angle: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    angle[[900, 901]] = angle[[901, 900]]
    return angle, value


def many_spikes(angle: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rows = np.random.default_rng(3).choice(np.arange(20, 1780), 30, replace=False)
    value[rows] += 60.0
    return angle, value


def wheel_angle(angle: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return angle * 23.0 / 41.0, 10.0 * (np.sin(46.0 * angle / 2.0) > 0.3) + 0.01 * value


def every_tenth_missing(angle: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    keep = np.arange(len(angle)) % 40 < 24
    return angle[keep], value[keep]


def few(angle: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    value[[7, 21]] = -9999.0
    return angle[:40], value[:40]


def missing_marks(angle: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    value[500:504] = -9999.0
    return angle, value


def short_marks(angle: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    value[(np.arange(len(angle)) % 50) < 3] = -999.0
    return angle, value


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (broken(short_marks), ("row 1 (line 3), column transmission_error_um", "-999 (", "near those of the other rows")),
        (broken(missing_marks), ("row 501 (line 503), column transmission_error_um", "-9999 (4 such rows", "near those of the other rows")),
        (broken(few), ("row 8 (line 10)", "-9999 (2 such rows")),
        (broken(every_tenth_missing), ("row 25", "a gap of")),
        (broken(lambda x, y: (x, 0.0 * y + 3.0)), ("column transmission_error_um", "3 in every row")),
        (broken(swapped), ("row 902 (line 904), column pinion_angle_rad", "above that of the row before")),
        (broken(lambda x, y: (np.delete(x, slice(400, 440)), np.delete(y, slice(400, 440)))), ("row 401", "a gap of")),
        (broken(lambda x, y: (np.degrees(x), y)), ("column pinion_angle_rad", "degrees")),
        (broken(wheel_angle), ("column pinion_angle_rad", "angles of the wheel")),
        (broken(many_spikes), (" spikes (row", "isolated")),
        (te(1, 60.0).replace("\n0.03,", "\n0.03,nan,", 1), ("row 1 (line 3)", "3 columns")),
        (te(1, 60.0).replace("transmission_error_um", "transmission_error_mm"), ("header (line 2)", TE)),
        (TE + "\n0.1,\n", ("row 1 (line 2), column transmission_error_um", "an empty cell")),
        (TE + "\n0.1,nan\n", ("row 1 (line 2), column transmission_error_um", "nan")),
        (TE + "\n0.1,1_0\n", ("1_0", "finite number")),
        (TE + "\n", ("rows", "0 of them", "from 1")),
        ("", ("header", "no line")),
    ],
)
def test_faults_are_refused_with_file_and_row(campaign: Callable[..., Campaign], text: str, words: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as refusal:
        campaign(static("a", 60.0), a=text)
    line = str(refusal.value)
    assert "a.csv" in line
    assert "\n" not in line
    for word in words:
        assert word in line


def test_a_first_row_far_outside_is_a_spike_and_a_step_there_is_none(campaign: Callable[..., Campaign]) -> None:
    value = curve(1, ANGLE, 600.0)
    value[0] += 400.0
    assert np.flatnonzero(~campaign(static("a", 600.0), a=table(ANGLE, value)).records[0].keep).tolist() == [0]
    value[0] -= 380.0
    assert campaign(static("a", 600.0), a=table(ANGLE, value)).records[0].keep.all()


def test_a_few_pitches_tell_no_unit_of_the_angle(campaign: Callable[..., Campaign]) -> None:
    """Over the wheel's pitch they are enough for a line, over the pinion's they are not."""
    angle = np.linspace(0.0, 3.95 * PITCH, 200)
    read = campaign(static("a", 60.0), a=table(angle, np.where((41.0 * angle / 2.0 / np.pi) % 1.0 < 0.5, 1.0, 2.0)))
    assert read.records[0].keep.all()


def test_a_second_pair_that_carries_for_one_sample_is_no_spike(campaign: Callable[..., Campaign]) -> None:
    stiff = static("a", 60.0).replace("static_transmission_error", "mesh_stiffness")
    angle = ANGLE[:400]
    value = np.where((angle / PITCH) % 1.0 < 0.4, 250.0, 155.0) + np.random.default_rng(1).normal(0.0, 1.0, 400)
    outside, inside = np.argmax((angle / PITCH) % 1.0 > 0.7), np.argmax((angle > 1.0) & ((angle / PITCH) % 1.0 > 0.7))
    value[inside] = 248.0
    value[outside] = 400.0
    read = campaign(stiff, a=table(angle, value, "pinion_angle_rad,mesh_stiffness_N_per_um"))
    assert np.flatnonzero(~read.records[0].keep).tolist() == [outside]


CHANGES: dict[str, Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]] = {
    "rows left out": lambda x, y: (x[7:-5], y[7:-5]),
    "every second row": lambda x, y: (x[::2], y[::2]),
    "half of it": lambda x, y: (x[:900], y[:900]),
    "one row changed": lambda x, y: (x, np.where(np.arange(len(y)) == 9, y + 0.5, y)),
    "rounded": lambda x, y: (x, np.round(y, 1)),
    "angles rounded": lambda x, y: (np.round(x, 4), y),
}


@pytest.mark.parametrize("change", CHANGES)
def test_changed_copies_are_refused(campaign: Callable[..., Campaign], change: str) -> None:
    value, more = curve(1, ANGLE, 60.0), "noise_std = 0.2"
    with pytest.raises(InputError, match=r"record\[2\] \(b.csv\).*the same data as record\[1\]"):
        campaign(static("a", 60.0, more), static("b", 60.0, more), a=table(ANGLE, value), b=table(*CHANGES[change](ANGLE, value)))


def test_repeats_and_like_forms_are_no_copies(campaign: Callable[..., Campaign]) -> None:
    """A measurement taken twice, spikes at the same row, and flanks of two teeth that have one form."""
    first, second = curve(1, ANGLE, 60.0), curve(2, ANGLE, 60.0)
    for value in (first, second):
        value[500] = 9.9e14
    more = "noise_std = 0.1"
    read = campaign(static("a", 60.0, more), static("b", 60.0, more), a=table(ANGLE, first), b=table(ANGLE, second))
    assert [np.flatnonzero(~record.keep).tolist() for record in read.records] == [[500], [500]]
    flanks = [f'file = "{name}.csv"\nquantity = "flank_profile"\ngear = "wheel"\ntooth = {tooth}' for tooth, name in enumerate("ab")]
    roll = np.linspace(9.0, 20.0, 40)
    forms = {name: table(roll, slope * (roll - 9.0), "roll_length_mm,deviation_um") for name, slope in (("a", 0.8), ("b", 0.5))}
    assert len(campaign(*flanks, **forms).records) == 2


def test_a_quieter_instrument_that_says_so_is_no_wrong_unit(campaign: Callable[..., Campaign]) -> None:
    quiet = 1e-2 * curve(4, ANGLE, 0.0) + curve(4, ANGLE, 9.0) - curve(4, ANGLE, 0.0)
    names = {"a": (60.0, 0.1), "b": (90.0, 0.1), "c": (120.0, 0.1), "d": (9.0, 0.001)}
    files = {name: te(seed, torque) for seed, (name, (torque, _)) in enumerate(names.items())} | {"d": table(ANGLE, quiet)}
    read = campaign(*(static(name, torque, f"noise_std = {noise}") for name, (torque, noise) in names.items()), **files)
    assert len(read.records) == 4


def test_copies_are_refused_under_another_torque_and_constant(campaign: Callable[..., Campaign]) -> None:
    value = curve(1, ANGLE, 60.0)
    with pytest.raises(InputError, match=r"record\[2\] \(b.csv\).*the same data as record\[1\]"):
        campaign(static("a", 60.0), static("b", 90.0), a=table(ANGLE, value), b=table(ANGLE, value + 3.0))


@pytest.mark.parametrize(
    ("head", "record", "words"),
    [
        (HEAD + "colour = 1\n", static("a", 60.0), ("colour", "an unknown key")),
        (HEAD, static("a", 60.0, "torque = 1"), ("record[1].torque", "an unknown key")),
        (HEAD, static("a", 60.0).replace("static_tr", "statick_tr"), ("record[1].quantity", "static_transmission_error")),
        (HEAD, static("a", -1.0), ("record[1].pinion_torque_Nm", "above 0")),
        (HEAD, static("a", 60.0).replace("static", "dynamic").replace("rpm = 0.0", "rpm = 1e-9"), ("pinion_speed_rpm", "1e-09")),
        (HEAD, static("a", 60.0).replace("static", "dynamic"), ("record[1].pinion_speed_rpm", "from 1 to 1e+06 rpm")),
        (HEAD, static("a", 60.0, 'role = "test"'), ("record[1].role", "holdout")),
        (HEAD, static("a", 60.0, "tooth = 1"), ("record[1].tooth", "no such key")),
        (HEAD, static("a", 60.0, "noise_std = nan"), ("record[1].noise_std", "above 0")),
        (HEAD, static("missing", 60.0), ("missing.csv", "no such file")),
        (HEAD, 'file = "a.csv"\nquantity = "flank_profile"\ngear = "wheel"\ntooth = 41', ("record[1].tooth", "0 to 40")),
        (HEAD, 'file = "a.csv"\nquantity = "flank_profile"\ntooth = 1', ("record[1].gear", "pinion")),
        ('model = "model.toml"\n', static("a", 60.0), ("angle_zero", "must be given")),
        ('model = "other.toml"\nangle_zero = "unknown"\n', static("a", 60.0), ("other.toml", "no such file")),
    ],
)
def test_wrong_keys_are_refused_by_name(campaign: Callable[..., Campaign], head: str, record: str, words: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as refusal:
        campaign(record, head=head, a=te(1, 60.0))
    for word in words:
        assert word in str(refusal.value)


def test_a_flank_may_have_gaps_but_not_metres(campaign: Callable[..., Campaign]) -> None:
    flank = 'file = "a.csv"\nquantity = "flank_profile"\ngear = "wheel"\ntooth = 1'
    roll = np.r_[np.linspace(9.0, 12.0, 30), np.linspace(15.0, 20.0, 40)]
    read = campaign(flank, a=table(roll, 0.0 * roll, "roll_length_mm,deviation_um"))
    assert read.records[0].keep.all()
    with pytest.raises(InputError, match="roll lengths from the base circle"):
        campaign(flank, a=table(roll / 1e3, 0.0 * roll, "roll_length_mm,deviation_um"))


def test_torque_and_speed_of_a_gear_off_the_rig_count_for_nothing(campaign: Callable[..., Campaign]) -> None:
    flank = 'file = "a.csv"\nquantity = "flank_profile"\ngear = "wheel"\ntooth = 1\npinion_torque_Nm = -5.0\npinion_speed_rpm = -5.0'
    roll = np.linspace(9.0, 20.0, 40)
    assert campaign(flank, a=table(roll, 0.0 * roll, "roll_length_mm,deviation_um")).records[0].pinion_torque == 0.0


def test_a_stiffness_below_nothing_is_refused_by_row(campaign: Callable[..., Campaign]) -> None:
    stiff = static("a", 60.0).replace("static_transmission_error", "mesh_stiffness")
    value = 300.0 + 40.0 * np.sign(np.sin(23.0 * ANGLE))
    assert campaign(stiff, a=table(ANGLE, value, "pinion_angle_rad,mesh_stiffness_N_per_um")).records[0].keep.all()
    with pytest.raises(InputError, match=r"row 1 \(line 3\), column mesh_stiffness_N_per_um.*above 0 N/um"):
        campaign(stiff, a=table(ANGLE, -value, "pinion_angle_rad,mesh_stiffness_N_per_um"))


def test_a_tooth_out_of_place_is_refused_and_a_late_one_is_not(campaign: Callable[..., Campaign]) -> None:
    pitch, head = 'file = "a.csv"\nquantity = "pitch_deviation"\ngear = "wheel"', "tooth,pitch_deviation_um"
    value = np.random.default_rng(1).normal(0.0, 0.1, 41)
    value[17] = 40.0
    assert campaign(pitch, a=table(np.arange(41.0), value, head)).records[0].keep.all()
    value[17] = 900.0
    with pytest.raises(InputError, match=r"row 18 \(line 20\), column pitch_deviation_um"):
        campaign(pitch, a=table(np.arange(41.0), value, head))


def test_runout_wider_than_the_module_is_refused(campaign: Callable[..., Campaign]) -> None:
    runout = 'file = "a.csv"\nquantity = "radial_runout"\ngear = "wheel"'
    teeth = np.arange(41.0)
    value, head = 20.0 * np.cos(2.0 * np.pi * teeth / 41.0), "tooth,radial_deviation_um"
    assert campaign(runout, a=table(teeth, value, head)).records[0].keep.all()
    with pytest.raises(InputError, match=r"column radial_deviation_um.*range up to the module"):
        campaign(runout, a=table(teeth, 1e3 * value, head))


def test_a_record_whose_first_tooth_is_unknown_has_no_part_in_the_fit_and_says_so(campaign: Callable[..., Campaign]) -> None:
    runout = 'file = "a.csv"\nquantity = "radial_runout"\ngear = "wheel"\ntooth_zero = "unknown"\nrole = "fit"'
    teeth = np.arange(41.0)
    read = campaign(static("b", 60.0), runout, b=te(1, 60.0), a=table(teeth, np.cos(teeth), "tooth,radial_deviation_um"))
    assert [record.file for record in read.fitted] == ["b.csv"]
    assert [remark.record for remark in read.remarks if "no part in the fit" in remark.sentence] == ["a.csv"]


@pytest.mark.parametrize("power", [-3, -1, 1, 3])
def test_a_record_in_another_power_of_ten_is_refused(campaign: Callable[..., Campaign], power: int) -> None:
    wrong = table(ANGLE, 10.0**power * curve(3, ANGLE, 90.0))
    with pytest.raises(InputError, match=rf"c.csv: column transmission_error_um.*10\^{power} times"):
        campaign(static("a", 20.0), static("b", 60.0), static("c", 90.0), a=te(1, 20.0), b=te(2, 60.0), c=wrong)


def test_results_do_not_replace_the_model_of_the_campaign(folder: Path, campaign: Callable[..., Campaign]) -> None:
    (folder / "updated.toml").write_text(MODEL)
    campaign(static("a", 60.0), head=HEAD.replace("model.toml", "updated.toml"), a=te(1, 60.0))
    with pytest.raises(InputError, match=r"--out: found the folder of .*updated.toml"):
        run_diagnosis(str(folder / "campaign.toml"), folder, (), (), (), quiet)
    assert (folder / "updated.toml").read_text() == MODEL
