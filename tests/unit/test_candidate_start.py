"""Where a fit starts from a response that was scaled."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem import make_setup
from gearfem.diagnosis.ranking.candidate import Candidate
from gearfem.effects.effect import Effect
from gearfem.effects.profile_slope import ProfileSlope
from gearfem.effects.runout import Runout

SETUP = make_setup(
    {
        "pair": {"module_mm": 2.0, "face_width_mm": 15.0},
        "pinion": {"teeth": 17},
        "wheel": {"teeth": 22},
        "operation": {"pinion_torque_Nm": 100.0, "pinion_speed_rpm": 1000.0},
    }
)


def started(effect: Effect, amplitude: float) -> Effect:
    """Return where a fit of an effect starts whose response should be so many times larger."""
    seen = {"signature": np.ones(3), "share": 1.0}
    return Candidate(effect=effect, gain=50.0, amplitude=amplitude, unknown=None, **seen).start(SETUP)


def test_a_runout_starts_where_its_linear_response_says() -> None:
    found = started(Runout(gear="wheel", eccentricity=6e-6, angle=1.0), 30.0)
    assert (found.eccentricity, found.angle) == pytest.approx((1.8e-4, 1.0), rel=1e-12, abs=0.0)


def test_an_effect_that_bends_starts_at_three_times_what_was_tried_at_most() -> None:
    assert started(ProfileSlope(gear="wheel", amount=6e-6), 30.0).amount == pytest.approx(1.8e-5, rel=1e-12, abs=0.0)
    assert started(ProfileSlope(gear="wheel", amount=6e-6), -0.5).amount == pytest.approx(-3e-6, rel=1e-12, abs=0.0)


def test_a_start_is_within_the_bounds() -> None:
    most = Runout.parameters()["eccentricity"].bounds(SETUP, "wheel")[1]
    assert started(Runout(gear="wheel", eccentricity=0.5 * most, angle=0.0), 40.0).eccentricity == most
