"""Records of very many rows: which are used, and what is said of the others."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import gearfem
from gearfem.diagnosis.reading import thinning
from gearfem.diagnosis.reading.measurement import Measurement, make_record
from gearfem.diagnosis.reading.thinning import thinned

PAIR, HUNTING = (
    gearfem.make_setup(
        {
            "pair": {"module_mm": 2.5, "face_width_mm": 25.0},
            "pinion": {"teeth": 20},
            "wheel": {"teeth": wheel},
            "operation": {"pinion_torque_Nm": 120.0, "pinion_speed_rpm": 1000.0},
        }
    ).pair
    for wheel in (41, 40)
)


def measured(to_a_pitch: int, pitches: float, masked: tuple[int, ...] = ()) -> Measurement:
    axis = np.arange(0.0, pitches, 1.0 / to_a_pitch) * PAIR.pinion.pitch_angle
    record = make_record("static_transmission_error", axis, np.random.default_rng(1).normal(size=len(axis)), pinion_torque=50.0)
    return dataclasses.replace(record, keep=~np.isin(np.arange(len(axis)), masked))


def test_an_encoder_of_3600_lines_is_thinned_to_no_less_than_48_rows_to_a_pitch() -> None:
    record = measured(180, 160.0)
    found, remarks = thinned([record] * 8, PAIR)
    first = found[0]
    assert [len(one.axis) for one in found] == [9600] * 8
    assert first.axis == pytest.approx(record.axis[::3], rel=0.0, abs=0.0)
    assert first.value == pytest.approx(record.value[::3], rel=0.0, abs=0.0)
    assert list(first.line) == list(record.line[::3])
    assert len(remarks) == 8
    assert remarks[0].kind == "thinned"
    assert remarks[0].sentence.startswith("one of 3 rows is used, 9600 of 28800, since")


def test_rows_are_left_out_only_as_far_as_the_campaign_has_too_many() -> None:
    """Of 57 600 rows every second one is enough, though a third would leave 48 to the pitch."""
    records, _ = thinned([measured(180, 160.0), measured(180, 160.0)], PAIR)
    assert [len(record.axis) for record in records] == [14400, 14400]


@pytest.mark.parametrize("records", [[measured(500, 2.0)], [measured(64, 400.0)] * 3], ids=["few rows", "64 to a pitch"])
def test_few_rows_and_usual_ones_are_all_used(records: list[Measurement]) -> None:
    found, remarks = thinned(records, PAIR)
    assert all(one is other for one, other in zip(found, records, strict=True))
    assert remarks == []


def test_a_masked_row_makes_room_for_its_neighbour(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(thinning, "MANY", 480)
    record = measured(100, 9.0, masked=(0, 5, 6, 7))
    (found,), _ = thinned([record], PAIR)
    assert len(found.axis) == 450
    assert list(found.line[:5]) == [1, 2, 4, 6, 8]
    assert list(found.keep[:5]) == [True, True, True, False, True]


def test_other_axes_are_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(thinning, "MANY", 10)
    record = make_record("flank_profile", np.linspace(0.0, 0.01, 5000), np.zeros(5000), gear="pinion", tooth=0)
    found, remarks = thinned([record], PAIR)
    assert found[0] is record
    assert remarks == []


CYCLE = 4.0 * np.pi


def hunting(to_a_turn: float, cycles: float, masked: tuple[int, ...] = ()) -> Measurement:
    """Return hunting cycles, of two turns each, of a pair of 20 and 40 teeth: a wave of a cycle, one of the mesh, a spike and noise."""
    axis = np.round(np.arange(0.0, cycles * to_a_turn * 2.0) * 2.0 * np.pi / to_a_turn, 7)
    noise = np.random.default_rng(5).normal(0.0, 0.5e-6, len(axis))
    noise[list(masked)] += 60e-6
    record = make_record("static_transmission_error", axis, smooth(axis) + noise, pinion_torque=50.0, noise_std=0.5e-6)
    return dataclasses.replace(record, keep=~np.isin(np.arange(len(axis)), masked))


def smooth(axis: np.ndarray) -> np.ndarray:
    return 8e-6 * np.sin(0.5 * axis) + 3e-6 * np.cos(20.0 * axis)


@pytest.mark.parametrize("cycles", [5.0, 5.2])
def test_hunting_cycles_with_rows_at_the_same_angles_are_taken_as_their_mean(monkeypatch: pytest.MonkeyPatch, cycles: float) -> None:
    monkeypatch.setattr(thinning, "MANY", 4000)
    whole = hunting(800.0, cycles, masked=(5000,))
    # Single rows may be missing.
    whole = thinning._at(whole, np.delete(np.arange(len(whole.axis)), [3000, 3001]))
    (record,), (remark,) = thinned([whole], HUNTING)
    assert remark.sentence.startswith(f"the mean of 5 hunting cycles is taken, 1600 of {len(whole.axis)} rows")
    assert record.axis == pytest.approx(np.arange(1600) * np.pi / 400.0, rel=0.0, abs=1e-7)
    assert record.keep.all()
    assert record.noise_std == pytest.approx(0.5e-6 / np.sqrt(5.0), rel=1e-9)
    assert np.std(record.value - smooth(record.axis)) == pytest.approx(0.5e-6 / np.sqrt(5.0), rel=0.05)


def test_of_hunting_cycles_with_rows_elsewhere_the_first_two_are_used_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """What stands between rows is not met by them: half a micrometre of five where pairs hand over, at 30 rows to a pitch."""
    monkeypatch.setattr(thinning, "MANY", 4000)
    whole = hunting(800.2, 5.2)
    (record,), (remark,) = thinned([whole], HUNTING)
    rows = len(record.axis)
    assert remark.sentence.startswith(f"the first 2 of 5 hunting cycles are used, {rows} of {len(whole.axis)} rows")
    assert CYCLE * 2.0 - 0.01 < record.axis[-1] < CYCLE * 2.0
    assert record.value == pytest.approx(whole.value[:rows], rel=0.0, abs=0.0)
    assert record.noise_std == whole.noise_std
