"""Gears worn by more than their teeth yield: the zero of the angle under wear, and what wear at the pitch point is likely."""

from __future__ import annotations

from pathlib import Path

import pytest

from gearfem.diagnosis import Diagnosis
from gearfem.diagnosis.fitting.approach import unwound
from gearfem.diagnosis.fitting.parameters import unlikely, unlikely_slopes
from gearfem.diagnosis.naming.search import Search
from gearfem.effects.profile_wear import ProfileWear
from gearfem.effects.sensor_gain import SensorGain
from gearfem.foundation.units import UM

from .rig import PLAN, beside_nuisances

WORN = (
    ProfileWear(gear="pinion", tip=60.0 * UM, root=250.0 * UM, pitch=6.0 * UM),
    ProfileWear(gear="wheel", tip=180.0 * UM, root=50.0 * UM, pitch=4.0 * UM),
)


def test_the_zero_is_sought_with_the_wear_in_the_model(tmp_path: Path) -> None:
    """Worn flanks move the mesh lines: the zero that suits records without the wear is none to start from with it."""
    view = beside_nuisances(tmp_path, [effect.table() for effect in WORN], PLAN["record"][1:])
    problem, alone = view.problem, view.base
    place = [nuisance.name for nuisance in problem.nuisances].index("angle_offset")
    neutral = problem.unknowns.neutral(alone.point.unknown)
    least = problem.left_at(WORN, neutral)
    (sought, *_) = unwound(problem, WORN, neutral)
    start = Search(problem, alone).start((WORN, None), alone)
    assert problem.left_at(WORN, start) < 0.5 * least
    assert abs(sought[place] - neutral[place]) > 0.5
    assert unwound(problem, (SensorGain(scale=1.2),), neutral) == []


def test_wear_at_the_pitch_point_is_likely_to_be_a_tenth_of_that_elsewhere(found: Diagnosis) -> None:
    wear = ProfileWear(gear="pinion", tip=30.0 * UM, root=40.0 * UM, pitch=10.0 * UM)
    assert unlikely((wear, SensorGain(scale=3.0))) == pytest.approx([2.0], rel=1e-3, abs=0.0)
    (slopes,) = unlikely_slopes((SensorGain(scale=3.0), wear), found.problem.campaign.setup)
    # Over the gain, tip, root and pitch.
    assert slopes * UM == pytest.approx([0.0, -0.024, -0.032, 0.2], rel=1e-3, abs=1e-9)
    assert unlikely((ProfileWear(gear="pinion", tip=0.0, root=0.0, pitch=0.2 * UM),)) == pytest.approx([2.0], rel=1e-9, abs=0.0)
