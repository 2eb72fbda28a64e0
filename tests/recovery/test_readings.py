"""Resonances and delays of an instrument, found without a fit."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from gearfem.diagnosis.ranking.candidate import View
from gearfem.diagnosis.ranking.readings import APART, _added, _tried, likeliest_readings
from gearfem.diagnosis.ranking.shapes import shapes_of, spread_of
from gearfem.effects.effect import Effect
from gearfem.effects.sensor_gain import SensorGain
from gearfem.effects.sensor_lag import SensorLag
from gearfem.effects.sensor_resonance import SensorResonance
from gearfem.sensing import Instrument
from tests.recovery.rig import PLAN, beside_nuisances

SLOW = PLAN["record"][-1]
MOVING = SLOW | {"file": "motion.csv", "quantity": "dynamic_transmission_error", "pinion_speed_rpm": 2400.0, "samples_per_turn": 520}


def typical(shown: View) -> Effect:
    return SensorResonance.example(shown.problem.campaign.setup)


def test_a_resonance_is_found_near_its_frequency(tmp_path: Path) -> None:
    hidden = {"name": "sensor_resonance", "frequency_Hz": 1700.0, "ratio": 0.08}
    shown = beside_nuisances(tmp_path, [hidden], [SLOW, MOVING])
    first, *others = likeliest_readings(shown, typical(shown))
    assert isinstance(first, SensorResonance)
    # The best of frequencies 5 % apart, before anything else has moved.
    assert first.frequency == pytest.approx(1700.0, rel=0.08, abs=0.0)
    assert all(abs(other.frequency / first.frequency - 1.0) > 1.0 - 1.0 / APART for other in others)  # type: ignore[attr-defined]


def test_without_a_motion_over_the_angle_a_few_frequencies_are_tried(tmp_path: Path) -> None:
    shown = beside_nuisances(tmp_path, [], [SLOW])
    few = shapes_of(typical(shown), shown.problem.campaign.setup)
    assert [one.describe() for one in likeliest_readings(shown, typical(shown))] == [one.describe() for one in few]


def test_a_delay_much_shorter_than_a_typical_one_is_found(tmp_path: Path) -> None:
    # Of 65 us between pairs of teeth; from 20 us, the least of typical sizes, a fit goes elsewhere.
    fast = MOVING | {"pinion_speed_rpm": 71000.0}
    shown = beside_nuisances(tmp_path, [{"name": "sensor_lag", "delay_s": 7e-6}], [SLOW, fast])
    first, *_ = likeliest_readings(shown, SensorLag.example(shown.problem.campaign.setup))
    assert isinstance(first, SensorLag)
    # As the nuisances, which are still to move, have it: a sixteenth of that time is near enough.
    assert abs(first.delay - 7e-6) < 65e-6 / 16.0


def test_what_an_instrument_adds_is_that_of_the_model(tmp_path: Path) -> None:
    shown = beside_nuisances(tmp_path, [], [MOVING])
    problem, point, setup = shown.problem, shown.base.point, shown.problem.campaign.setup
    (record,), settings = problem.records, problem.settings(shown.base.point.stood)
    for effect in (SensorLag(delay=3e-4), SensorResonance(frequency=1700.0, ratio=0.2)):
        without, under = (problem.bench(effects).predict(record, settings) for effects in (point.effects, (effect,)))
        added = _added(shown, record, [effect.act(Instrument(), setup)])
        # Kinks of the motion, where contact begins, lie between the angles of the spline.
        np.testing.assert_allclose(added[:, 0], under - without, rtol=0.0, atol=2e-3 * np.ptp(under - without))


def test_a_gain_is_tried_at_its_usual_sizes(tmp_path: Path) -> None:
    shown = beside_nuisances(tmp_path, [], [MOVING])
    usual = SensorGain.example(shown.problem.campaign.setup)
    tried = likeliest_readings(shown, usual)
    assert [one.describe() for one in tried] == [one.describe() for one in spread_of(usual, shown.problem.campaign.setup)]


def test_what_gains_nothing_is_still_tried_once(tmp_path: Path) -> None:
    """So that what records can show of it is said."""
    shown = beside_nuisances(tmp_path, [], [SLOW, MOVING])
    shown = dataclasses.replace(shown, freed=lambda vectors: (np.eye(vectors.shape[1]), np.zeros(vectors.shape[1])))
    assert len(likeliest_readings(shown, SensorLag.example(shown.problem.campaign.setup))) == 1


def test_no_delay_is_tried_that_means_over_the_pitch_take_for_a_shorter_one(tmp_path: Path) -> None:
    """But for usual sizes: a delay of 109 us was taken for one of 2.7 ms, a pitch later, and single teeth were then missed."""
    fast = MOVING | {"pinion_speed_rpm": 71000.0}
    shown = beside_nuisances(tmp_path, [], [SLOW, fast])
    usual = SensorLag.example(setup := shown.problem.campaign.setup)
    tried = [effect.delay for _, effect in _tried(shown, usual) if isinstance(effect, SensorLag)]
    pitch = 60.0 / 71000.0 / setup.pair.pinion.teeth
    longer = {delay for delay in tried if delay > pitch * (1.0 + 1e-12)}
    assert longer < {effect.delay for effect in spread_of(usual, setup) if isinstance(effect, SensorLag)}
    assert len(tried) == 68
