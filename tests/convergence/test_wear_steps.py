"""A life of wear against its steps, its angles and the width of its bell."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.wear import Archard, wear_over


def life(setup, **changes):
    return wear_over(setup, Archard(pinion_coefficient=2e-17, wheel_coefficient=3e-17), 1e7, **changes)


@pytest.mark.slow
def test_the_depth_does_not_depend_on_steps_or_angles(coal_combine):
    """About 22 um at the pinion: tolerances of 3, 1 and 0.3 % of the deflection, and twice the angles."""
    fine = life(coal_combine, tolerance=0.001, angles=120)

    def away(other):
        return float(np.sqrt(np.mean((other.pinion_depth[-1] - fine.pinion_depth[-1]) ** 2)))

    coarse, usual, more = (life(coal_combine, **changes) for changes in ({"tolerance": 0.03}, {}, {"angles": 240}))
    assert coarse.turns.size < usual.turns.size < fine.turns.size
    assert away(usual) < away(coarse)
    # A step may err by 1 % of some 24 um; errors of steps do not add up, since what wears too much then carries less.
    assert away(usual) < 0.25e-6
    assert float(np.abs(more.pinion_depth[-1] - usual.pinion_depth[-1]).max()) < 0.5e-6


def test_a_coarse_life_is_near_a_fine_one(coal_combine):
    coarse, fine = (life(coal_combine, tolerance=tolerance, angles=60) for tolerance in (0.1, 0.01))
    assert coarse.turns.size < fine.turns.size
    assert coarse.pinion_volume[-1] == pytest.approx(fine.pinion_volume[-1], rel=5e-3, abs=0.0)
    assert coarse.pinion_depth[-1] == pytest.approx(fine.pinion_depth[-1], rel=0.0, abs=2e-6)
