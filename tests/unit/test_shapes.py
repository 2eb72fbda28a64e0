"""Strengths at which an effect is tried before it is fitted."""

from __future__ import annotations

import pytest

from gearfem.definition.setup import Setup
from gearfem.diagnosis.shapes import shapes_of
from gearfem.effects.profile_slope import ProfileSlope


def test_an_effect_on_all_flanks_is_tried_from_a_quarter_of_its_typical_strength_on(small_pair: Setup) -> None:
    """Small ones beside nuisances that stray do not look like large ones, scaled."""
    typical = ProfileSlope.example(small_pair, "wheel")
    tried = [effect.amount for effect in shapes_of(typical, small_pair)]
    assert tried == pytest.approx([typical.amount * share for share in (1.0, 0.25, 4.0, 16.0)], rel=1e-12, abs=0.0)
