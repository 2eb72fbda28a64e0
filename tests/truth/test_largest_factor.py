"""What single teeth do to the largest Kw of a turn: the largest of many peaks rises where no single one does."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gearfem.assembly import assemble
from gearfem.definition.setup import Setup
from gearfem.diagnosis.modelling.bench import Settings, neutral
from gearfem.diagnosis.modelling.largest import at_peaks, largest_of
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.modelling.teeth import Scatter
from gearfem.diagnosis.reading.measurement import make_record
from gearfem.foundation.units import UM

TORQUE, SPEEDS = 50.0, np.array([250.0, 500.0])
INDEX = 0.3 * UM


@pytest.fixture(scope="module")
def bench(small_pair: Setup) -> SystemBench:
    return SystemBench(system=assemble(small_pair), errors=())


def test_the_largest_of_independent_values() -> None:
    peaks = np.array([1.3, 1.32, 1.25, 1.31, 1.1])
    draws = peaks + 0.02 * np.random.default_rng(3).normal(size=(200_000, 5))
    assert largest_of(peaks, 0.02) == pytest.approx(draws.max(axis=1).mean(), abs=2e-4, rel=0.0)
    assert largest_of(peaks, 0.0) == 1.32
    assert largest_of(peaks, 1e-6) == pytest.approx(1.32, abs=1e-5, rel=0.0)
    # The expected largest of two equal ones lies 1/sqrt(pi) deviations above them.
    assert largest_of(np.full(2, 1.2), 0.05) == pytest.approx(1.2 + 0.05 / np.sqrt(np.pi), abs=1e-5, rel=0.0)


def test_errors_of_single_teeth_raise_the_largest_factor_as_expected(bench: SystemBench) -> None:
    """Forty builds of the pair with random index errors: their mean largest Kw against the largest of the peaks of one motion."""
    pair, rng, kw = bench.pair, np.random.default_rng(7), make_record("dynamic_factor", SPEEDS, pinion_torque=TORQUE)
    start = neutral(pair)
    builds = [
        Settings(pinion_late=INDEX * rng.normal(size=pair.pinion.teeth), wheel_late=INDEX * rng.normal(size=pair.wheel.teeth))
        for _ in range(40)
    ]
    found = np.array([bench.predict(kw, build) for build in builds]) - bench.predict(kw, start)
    columns, _ = at_peaks(kw, bench, start, Scatter(terms=1))
    for place, speed in enumerate(SPEEDS.tolist()):
        peaks = bench.peaks(TORQUE, speed, start).factors
        one = INDEX * float(np.linalg.norm(columns[place, ::2]))
        expected = largest_of(peaks, one) - peaks.max()
        print(f"{speed} rad/s: +{expected:.4f} expected, +{found[:, place].mean():.4f} found, one peak moves by {one:.4f}")
        # Measured: 28 % too high and 8 % too low, where what is expected is taken to be known to half: neighbours move together.
        assert expected == pytest.approx(found[:, place].mean(), rel=0.4, abs=0.0)
        # What one peak does alone is nearly as often down as up; the largest is hardly ever lower.
        assert np.mean(found[:, place] < 0.0) < 0.05


def test_waviness_raises_less_where_one_peak_stands_out(bench: SystemBench) -> None:
    pair, kw = bench.pair, make_record("dynamic_factor", SPEEDS, pinion_torque=TORQUE)
    late = np.where(np.arange(pair.pinion.teeth) == 7, 2.0 * UM, 0.0)
    alike = at_peaks(kw, bench, neutral(pair), Scatter())[1]
    apart = at_peaks(kw, bench, dataclasses.replace(neutral(pair), pinion_late=late), Scatter())[1]
    assert (alike > 0.0).all()
    assert (apart < 0.6 * alike).all()
