"""Resonances of an instrument, found over their frequencies without a fit."""

from __future__ import annotations

from pathlib import Path

import pytest

from gearfem.diagnosis.candidate import View
from gearfem.diagnosis.ringing import APART, rung
from gearfem.diagnosis.shapes import shapes_of
from gearfem.effects.effect import Effect
from gearfem.effects.sensor_resonance import SensorResonance
from tests.recovery.rig import PLAN, beside_nuisances

SLOW = PLAN["record"][-1]
MOVING = SLOW | {"file": "motion.csv", "quantity": "dynamic_transmission_error", "pinion_speed_rpm": 2400.0, "samples_per_turn": 520}


def typical(shown: View) -> Effect:
    return SensorResonance.example(shown.problem.campaign.setup)


def test_a_resonance_is_found_near_its_frequency(tmp_path: Path) -> None:
    hidden = {"name": "sensor_resonance", "frequency_Hz": 1700.0, "ratio": 0.08}
    shown = beside_nuisances(tmp_path, [hidden], [SLOW, MOVING])
    first, *others = rung(shown, typical(shown))
    assert isinstance(first, SensorResonance)
    # The best of frequencies 5 % apart, before anything else has moved.
    assert first.frequency == pytest.approx(1700.0, rel=0.08, abs=0.0)
    assert all(abs(other.frequency / first.frequency - 1.0) > 1.0 - 1.0 / APART for other in others)  # type: ignore[attr-defined]


def test_without_a_motion_over_the_angle_a_few_frequencies_are_tried(tmp_path: Path) -> None:
    shown = beside_nuisances(tmp_path, [], [SLOW])
    few = shapes_of(typical(shown), shown.problem.campaign.setup)
    assert [one.describe() for one in rung(shown, typical(shown))] == [one.describe() for one in few]
