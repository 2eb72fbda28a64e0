"""An effect of one tooth, or a wave of one order, explains more there than anywhere else."""

from __future__ import annotations

import numpy as np

from gearfem.diagnosis.ranking.standing_out import standing_out


def test_an_effect_of_one_tooth_stands_out_of_what_all_others_look_like() -> None:
    gains = np.array([10.0, 60.0, 167.0, 70.0, 9.0, 22.0, 8.0, 19.0])
    assert standing_out(gains, 1) == [2, 3]
    # A third tooth where it explains half as much: waviness, or an error of the model.
    assert standing_out(np.where(gains > 15.0, 80.0, gains), 1) == []
    assert standing_out(np.array([0.0, 0.0, 5.0, 0.0, 0.0]), 1) == [2]


def test_an_order_that_explains_no_more_than_any_other_is_none() -> None:
    assert standing_out(np.array([2.0, 170.0, 0.0, 5.0, 4.0])) == [1]
    # Motions whose flanks part take another branch for any wave.
    assert standing_out(np.array([280.0, 300.0, 110.0, 150.0, 90.0])) == []
    assert standing_out(np.array([3.0, 1.0])) == [0, 1]
    assert standing_out(np.array([])) == []
