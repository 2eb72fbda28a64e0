"""What a slow record shows of tooth friction that turns round elsewhere, or over some way."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.definition.setup import Setup
from gearfem.diagnosis.modelling.pitch_point import COEFFICIENT, WAYS, gradually, sooner_or_later
from gearfem.diagnosis.reading.measurement import make_record
from gearfem.foundation.units import UM

# What a coefficient of 1 does to a slow record [m].
SIZE = 4.0 * UM


def test_friction_turns_round_a_sample_sooner_or_later() -> None:
    rubbing = np.array([-1.1, -1.0, -0.9, 1.1, 1.0, 0.9])
    sooner, later = sooner_or_later(rubbing).T / COEFFICIENT
    assert sooner == pytest.approx([0.0, 0.0, 2.0, 0.0, 0.0, 0.0])
    assert later == pytest.approx([0.0, 0.0, 0.0, -2.0, 0.0, 0.0])


# Measured: 0.000, 0.136 and 0.088 of what a step would miss.
@pytest.mark.parametrize(("way", "limit"), [(WAYS[1], 1e-5), (0.04, 0.15), (0.06, 0.10)])
def test_friction_that_turns_round_over_any_usual_way_is_a_sum_of_both(small_pair: Setup, way: float, limit: float) -> None:
    pair = small_pair.pair
    place = (np.arange(-48, 240) + 0.5) / 96.0
    record = make_record("static_transmission_error", place * pair.pinion.pitch_angle, pinion_torque=50.0)
    beside = (place + 0.5) % 1.0 - 0.5
    # From pitch to pitch it comes back between two pairs, over a tenth of the pitch.
    back = np.interp(np.abs(beside), [0.4, 0.5], [1.0, 0.0])
    rubbing = SIZE * np.sign(beside) * back
    missed = 0.2 * SIZE * (np.tanh(beside / way) - np.sign(beside))
    columns = gradually(record, pair, rubbing)
    sizes = np.linalg.lstsq(columns, missed, rcond=None)[0]
    off = np.linalg.norm(columns @ sizes - missed) / np.linalg.norm(missed)
    print(f"over {way} base pitches: {off:.3f} is left, sizes {sizes}")
    assert off < limit
    assert sizes.sum() == pytest.approx(0.2 / COEFFICIENT, rel=0.15)


def test_what_moves_shows_nothing_of_it(small_pair: Setup) -> None:
    record = make_record("dynamic_transmission_error", np.linspace(0.0, 1.0, 50), pinion_torque=50.0, pinion_speed=100.0)
    assert not gradually(record, small_pair.pair, np.sign(record.axis - 0.5)).any()
