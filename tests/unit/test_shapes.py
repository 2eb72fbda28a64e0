"""Strengths at which an effect is tried before it is fitted."""

from __future__ import annotations

import pytest

from gearfem.definition.setup import Setup
from gearfem.diagnosis.ranking.shapes import shapes_of, spread_of
from gearfem.effects.profile_slope import ProfileSlope
from gearfem.effects.support_compliance import SupportCompliance
from gearfem.foundation.units import UM_PER_KN


def test_an_effect_on_all_flanks_is_tried_from_a_quarter_of_its_typical_strength_on(small_pair: Setup) -> None:
    """Small ones beside nuisances that stray do not look like large ones, scaled."""
    typical = ProfileSlope.example(small_pair, "wheel")
    tried = [effect.amount for effect in shapes_of(typical, small_pair)]
    assert tried == pytest.approx([typical.amount * share for share in (1.0, 0.25, 4.0, 16.0)], rel=1e-12, abs=0.0)


@pytest.mark.parametrize(("pinion", "wheel"), [(2.3, 1.4), (0.8, 6.0), (0.0, 3.0)])
def test_two_supports_are_tried_with_yields_of_their_own(small_pair: Setup, pinion: float, wheel: float) -> None:
    """Whatever they are, a pair is near: within a fifth of each, and so a tenth of the natural frequencies."""
    typical = SupportCompliance(pinion=2.0 * UM_PER_KN, wheel=2.0 * UM_PER_KN)
    tried = [(effect.pinion / UM_PER_KN, effect.wheel / UM_PER_KN) for effect in spread_of(typical, small_pair)]
    assert any(abs(a - pinion) <= 0.2 * pinion and abs(b - wheel) <= 0.2 * wheel for a, b in tried)
    assert (0.0, 0.0) not in tried


def test_what_has_one_strength_is_spread_as_it_is(small_pair: Setup) -> None:
    slope = ProfileSlope.example(small_pair, "wheel")
    assert [e.amount for e in spread_of(slope, small_pair)] == [e.amount for e in shapes_of(slope, small_pair)]
