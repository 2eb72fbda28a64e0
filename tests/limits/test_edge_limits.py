"""Contact near a tip edge becomes the contact of Hertz on either side, and joins both smoothly."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.contact import EdgedLine, Line
from gearfem.contact.band import edge_band
from gearfem.definition.setup import Material
from gearfem.foundation import SolveError

STEEL = EdgedLine(pinion=Material(), wheel=Material())
FLANK, ROUND = 0.029, 0.16e-3
LOADS = np.array([0.0, 1e-5, 1.0, 1e3, 3.56e5, 1.4e6])


def line(edge, flank=FLANK):
    return Line(*np.broadcast_arrays(flank, 3e-3, 2e-3, edge, ROUND))


def test_flank_before_its_edge_is_hertz_bit_for_bit():
    edge = 1.000001 * STEEL.hertz.half_width(LOADS, FLANK)
    for place in (line(edge), line(10.0 * edge), line(0.05)):
        assert (STEEL.approach(LOADS, place) == STEEL.hertz.approach(LOADS, FLANK, 3e-3, 2e-3)).all()
        assert (STEEL.centre(LOADS, place) == 0.0).all()
    # Slopes count loads from 1 mN/m on: an edge at 0 is one for the load 0 too.
    assert (STEEL.compliance(LOADS[2:], line(edge[2:])) == STEEL.hertz.compliance(LOADS[2:], FLANK, 3e-3, 2e-3)).all()


def test_round_past_its_edge_is_hertz_on_the_round():
    radius = 1.0 / (1.0 / FLANK + 1.0 / ROUND)
    edge = -1.000001 * STEEL.hertz.half_width(LOADS[1:], radius)
    np.testing.assert_allclose(STEEL.effective_radius(LOADS[1:], line(edge)), radius, rtol=1e-15)
    expected = STEEL.hertz.approach(LOADS[1:], radius, 3e-3, 2e-3)
    np.testing.assert_allclose(STEEL.approach(LOADS[1:], line(edge)), expected, rtol=1e-15)


def test_without_load_nothing_approaches():
    edge = np.array([-1e-4, -1e-7, 0.0, 1e-7, 1e-2])
    assert (STEEL.approach(0.0, line(edge)) == 0.0).all()
    assert np.isfinite(STEEL.compliance(0.0, line(edge))).all()


def test_equal_curvatures_on_both_sides_of_a_far_edge():
    """A round as blunt as a plane is no edge."""
    band = edge_band(np.linspace(-0.9, 0.9, 7), np.full(7, 1e-9))
    np.testing.assert_allclose(band.radius, 1.0, atol=2e-9)
    np.testing.assert_allclose(band.half_width, 1.0, atol=2e-9)
    np.testing.assert_allclose(band.centre, 0.0, atol=2e-9)


@pytest.mark.parametrize("sharpness", [0.3, 10.0, 180.0, 2000.0])
def test_radius_joins_both_limits_with_continuous_slope(sharpness):
    """Over the distance q of flanks that go on past the edge; at the ends the difference to Hertz grows with power 5/2."""
    start = -np.sqrt(1.0 + sharpness)
    for joint in (start, 0.0, 1.0):
        gaps = np.array([1e-3, 1e-4, 1e-5])
        slopes = []
        for side in (-1.0, 1.0):
            q = joint + side * gaps
            inside = (q >= start) & (q <= 1.0)
            clipped = np.clip(np.stack([q, np.full(3, joint)]), start, 1.0)
            radius = edge_band((np.where(clipped < 0.0, clipped / (1.0 + sharpness), clipped)).ravel(), np.full(6, sharpness)).radius
            rate = np.log(radius.reshape(2, 3))
            slopes.append(np.where(inside, side * (rate[0] - rate[1]) / gaps, 0.0))
        jump = np.abs(slopes[1] - slopes[0])
        # Both slopes are one-sided differences: what is left falls with the step, by 10^(3/2) at the ends and 10 at the edge.
        assert (jump[1:] < 0.12 * jump[:-1] + 1e-9).all()


@pytest.mark.parametrize("sharpness", [1e-6, 1.0, 50.0, 180.0, 1e3, 1e5])
def test_radius_grows_with_the_distance(sharpness):
    lowest = -1.0 / np.sqrt(1.0 + sharpness)
    edge = np.unique(np.concatenate([np.linspace(lowest, 0.0, 400), np.linspace(0.0, 1.0, 400), 1.0 - np.geomspace(1e-14, 0.1, 50)]))
    band = edge_band(edge, np.full_like(edge, sharpness))
    # Rounding of terms as large as k that cancel.
    assert (np.diff(band.radius) > -4e-16 * (10.0 + sharpness) * band.radius[1:]).all()
    assert band.radius[0] == pytest.approx(1.0 / (1.0 + sharpness), rel=1e-11, abs=0.0)
    assert band.radius[-1] == pytest.approx(1.0, rel=1e-11, abs=0.0)
    assert (band.middle <= 1e-15).all()
    assert (band.centre <= 1e-15).all()


def test_approach_grows_with_the_load_and_is_concave():
    load = np.geomspace(1.0, 5e6, 2000)
    for edge in (-2e-4, -5e-5, -1e-5, -1e-6, -1e-8, 0.0, 1e-8, 1e-5, 1e-4, 4e-4):
        slope = STEEL.compliance(load, line(edge))
        assert (slope > 0.0).all()
        assert (np.diff(slope) < 0.0).all()
        assert (np.diff(STEEL.approach(load, line(edge)) / load) < 0.0).all()


def test_edge_outside_the_band_is_no_silent_answer():
    with pytest.raises(SolveError, match="band of contact"):
        edge_band(np.array([1.5]), np.array([180.0]))
