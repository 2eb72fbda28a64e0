"""Noise of records: found under what repeats, made white, and kept apart from teeth that act on each other."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.signal import lfilter

from gearfem.diagnosis.fitting.marginal import marginal
from gearfem.diagnosis.reading.measurement import Measurement, make_record
from gearfem.diagnosis.reading.noise import measure_noise
from gearfem.diagnosis.reading.whitening import make_whitener
from gearfem.model import make_setup

SETUP = make_setup(
    {
        "pair": {"module_mm": 2.5, "face_width_mm": 25.0},
        "pinion": {"teeth": 23},
        "wheel": {"teeth": 41},
        "operation": {"pinion_torque_Nm": 100.0, "pinion_speed_rpm": 1000.0},
    }
)
PAIR = SETUP.pair
STEP = 2.0 * math.pi / 733.0


def measured(value: np.ndarray, **more: object) -> Measurement:
    axis = 0.1 + STEP * np.arange(len(value))
    return make_record("static_transmission_error", axis, value, **{"pinion_torque": 50.0, **more})


def repeating(count: int, seed: int = 5) -> np.ndarray:
    """Return steps of every tooth of both gears, runouts and a mesh wave, in metres."""
    angle = 0.1 + STEP * np.arange(count)
    rng = np.random.default_rng(seed)
    place = angle / PAIR.pinion.pitch_angle
    late1, late2 = rng.normal(0.0, 1e-6, 23), rng.normal(0.0, 1e-6, 41)
    teeth = late1[np.floor(place).astype(int) % 23] + late2[np.floor(place + 0.3).astype(int) % 41]
    return teeth + 2e-5 * np.sin(angle) + 1e-5 * np.sin(angle / PAIR.ratio) + 2e-6 * np.sin(46.0 * angle)


@pytest.mark.parametrize("name", ["static_transmission_error", "mesh_stiffness"])
def test_where_nothing_shows_noise_it_is_assumed(name: str) -> None:
    """Few rows, or digits so coarse that most neighbours are alike."""
    short = make_record(name, STEP * np.arange(20), 1.0 + np.sin(np.arange(20.0)))
    coarse = make_record(name, STEP * np.arange(300), np.round(np.linspace(1.0, 4.0, 300)))
    found = [measure_noise(record, PAIR) for record in (short, coarse)]
    assert [noise.basis for noise in found] == ["assumed", "assumed"]
    assert found[0].std == pytest.approx(0.02 * np.std(short.value), rel=1e-9)
    assert found[1].std == pytest.approx(1.0 / math.sqrt(12.0), rel=1e-9)


@pytest.mark.parametrize("memory", [0.0, 0.7])
def test_noise_is_found_under_what_repeats_and_made_white(memory: float) -> None:
    count, std = 3000, 1e-7
    noise = lfilter([math.sqrt(1.0 - memory**2)], [1.0, -memory], np.random.default_rng(2).normal(0.0, std, count + 100))[100:]
    found = measure_noise(measured(repeating(count) + noise), PAIR)
    assert found.basis == "repeats"
    # 980 double differences of four samples each: 3 % for one deviation, 8 % with this memory; steps between samples add 7 %.
    assert found.std == pytest.approx(std, rel=0.25, abs=0.0)
    white = found.whitener.apply(noise)
    assert np.std(white) == pytest.approx(1.0, abs=0.18)
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.15


def test_a_stated_deviation_is_a_floor_and_more_than_it_is_no_noise() -> None:
    quiet = measured(repeating(3000) + np.random.default_rng(3).normal(0.0, 1e-7, 3000))
    assert measure_noise(dataclasses.replace(quiet, noise_std=3e-7), PAIR).std == pytest.approx(3e-7, rel=1e-9, abs=0.0)
    mixed = repeating(3000) * (1.0 + 2.0 * np.sin(0.37 * quiet.axis))
    loud = dataclasses.replace(quiet, value=quiet.value + mixed, noise_std=1e-7)
    found = measure_noise(loud, PAIR)
    assert found.measured_std > 3e-7
    assert found.std == pytest.approx(1e-7, rel=1e-9, abs=0.0)
    assert "teeth act on each other" in found.sentence
    explained = measure_noise(dataclasses.replace(loud, noise_std=None), PAIR, mixed)
    assert explained.std == pytest.approx(1e-7, rel=0.2, abs=0.0)


def test_half_a_turn_has_its_roughness() -> None:
    value = repeating(360) + np.random.default_rng(4).normal(0.0, 2e-7, 360)
    found = measure_noise(measured(value), PAIR)
    assert found.basis == "roughness"
    assert found.std == pytest.approx(2e-7, rel=0.25, abs=0.0)
    assert found.freedom < 200.0


def coloured(count: int, std: float, memory: float = 0.8) -> np.ndarray:
    """Return noise of first order, in metres."""
    white = np.random.default_rng(6).normal(0.0, std, count + 100)
    return np.asarray(lfilter([math.sqrt(1.0 - memory**2)], [1.0, -memory], white)[100:])


def means(white: np.ndarray) -> float:
    """Return the standard deviation of means over 40 rows in parts of that of independent rows of variance 1."""
    return float(white[: white.size // 40 * 40].reshape(-1, 40).mean(axis=1).std() * math.sqrt(40.0))


def test_too_few_turns_smoother_than_the_stated_noise_have_coloured_noise() -> None:
    smooth, noise = 1e-6 * np.sin(0.03 * np.arange(900)), coloured(900, 2e-7)
    record = dataclasses.replace(measured(smooth + noise), noise_std=2e-7)
    assert measure_noise(record, PAIR).covariance == pytest.approx([4e-14], rel=1e-9, abs=0.0)
    found = measure_noise(record, PAIR, smooth)
    assert found.std == pytest.approx(2e-7, rel=1e-9, abs=0.0)
    assert found.covariance[1] / found.covariance[0] == pytest.approx(0.8, abs=0.1)
    # Taken as white it would be 2.5.
    assert means(found.whitener.apply(noise)) == pytest.approx(1.0, abs=0.35)


def test_too_few_turns_without_a_stated_noise_show_it_in_what_a_fit_leaves() -> None:
    noise, pitch = coloured(900, 2e-7), 2.0 * np.pi / PAIR.pinion.pitch_angle
    record = measured(repeating(900) + noise)
    missed = 3e-7 * np.sin(pitch * record.axis)
    found = measure_noise(dataclasses.replace(record, value=record.value + missed), PAIR, repeating(900))
    assert found.basis == "remainder"
    few = dataclasses.replace(record, axis=record.axis[:150], value=record.value[:150], keep=record.keep[:150])
    assert measure_noise(few, PAIR, repeating(150)).basis == "roughness"
    assert "fitted model leaves" in found.sentence
    assert found.std == pytest.approx(2e-7, rel=0.25, abs=0.0)
    assert means(found.whitener.apply(noise)) == pytest.approx(1.0, abs=0.35)


def test_whitener_makes_the_covariance_a_unit_matrix() -> None:
    process = 2.5 * 0.8 ** np.arange(30)
    covariance = process[np.abs(np.subtract.outer(np.arange(30), np.arange(30)))]
    whitener = make_whitener(process[:3], np.ones(30, bool))
    root = whitener.apply(np.linalg.cholesky(covariance))
    assert root @ root.T == pytest.approx(np.eye(30), abs=1e-12)


def test_masked_rows_break_the_run() -> None:
    keep = np.ones(30, bool)
    keep[[0, 11, 12]] = False
    whitener = make_whitener(2.5 * 0.8 ** np.arange(2), keep)
    value = np.random.default_rng(1).normal(size=(30, 2))
    white = whitener.apply(value)
    assert white.shape == (27, 2)
    assert white[10] == pytest.approx(value[13] / math.sqrt(2.5), rel=1e-12, abs=0.0)


def test_what_is_freed_of_nuisances_is_measured_in_the_metric_that_holds_them() -> None:
    rng = np.random.default_rng(7)
    columns, residual, other = rng.normal(size=(40, 6)), rng.normal(size=40), rng.normal(size=(40, 2))
    weights = np.array([0.3, 1.0])
    freed = marginal((columns[:15], columns[15:])).weighed(weights)
    rows = np.repeat(weights, (15, 25))
    metric = np.linalg.inv(np.diag(1.0 / rows) + columns @ columns.T)
    gram, pull = freed.measure(other, residual)
    assert gram == pytest.approx(other.T @ metric @ other, rel=1e-10, abs=1e-12)
    assert pull == pytest.approx(other.T @ metric @ residual, rel=1e-10, abs=1e-12)
    normal = columns.T @ (rows[:, None] * columns) + np.eye(6)
    solved = np.linalg.solve(normal, columns.T @ (rows * residual))
    assert freed.solve(residual) == pytest.approx(solved, rel=1e-10, abs=1e-12)
    assert freed.left(other)[:, 1] == pytest.approx((metric @ other)[:, 1] / rows, rel=1e-10, abs=1e-12)
    assert freed.deviations == pytest.approx(np.sqrt(np.diag(np.linalg.inv(normal))), rel=1e-10, abs=0.0)
    assert freed.root @ freed.root.T == pytest.approx(np.linalg.inv(normal), rel=1e-9, abs=1e-12)


def test_the_first_unknowns_alone_are_those_of_their_columns_alone() -> None:
    rng = np.random.default_rng(8)
    columns, residual = rng.normal(size=(40, 6)), rng.normal(size=40)
    few = marginal((columns,)).first(4)
    assert few.solve(residual) == pytest.approx(marginal((columns[:, :4],)).solve(residual), rel=1e-10, abs=1e-12)
