"""The outline: what generates it is known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gearfem.definition.setup import Rack, involute
from gearfem.flank import Outline
from gearfem.foundation import InputError

# teeth, profile shift, tip radius in modules: one free of undercut, a large shift, two undercut, a big wheel
GEARS = [(16, 0.8, 9.52), (51, 1.175, 27.396), (10, 0.0, 6.0), (17, 0.0, 9.5), (150, -0.2, 75.8)]


@pytest.fixture(params=GEARS, ids=lambda values: f"z{values[0]}x{values[1]}")
def outline(request, gear_factory) -> Outline:
    teeth, shift, tip = request.param
    return Outline(gear=gear_factory(teeth, 8e-3, tip * 8e-3, shift, flank_thinning=0.05e-3))


def test_segments_join_without_gap(outline: Outline) -> None:
    for joint in (1.0, 2.0, 3.0, 4.0):
        gap = np.linalg.norm(outline.point(np.nextafter(joint, 0.0)) - outline.point(joint))
        # Rounding of the radius, some hundred times the spacing of floats.
        assert gap < 1e-13 * outline.gear.tip_radius / 0.1


def test_segments_join_without_kink_unless_undercut(outline: Outline) -> None:
    for joint in (1.0, 3.0, 4.0) if outline.undercut else (1.0, 2.0, 3.0, 4.0):
        turn = outline.normal(joint - 1e-10) - outline.normal(joint)
        assert np.abs(turn).max() < 1e-8


def test_normal_is_square_to_the_curve(outline: Outline) -> None:
    u = np.linspace(0.05, 4.95, 99)
    u = u[np.abs(u - np.round(u)) > 1e-3]
    step = 1e-6
    tangent = outline.point(u + step) - outline.point(u - step)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    # Central difference: order step^2 times the turn of the curve.
    assert np.abs((tangent * outline.normal(u)).sum(axis=1)).max() < 1e-6
    left_of_travel = tangent[:, 0] * outline.normal(u)[:, 1] - tangent[:, 1] * outline.normal(u)[:, 0]
    assert (left_of_travel > 0.9).all()


def test_involute_is_the_paper_s(outline: Outline) -> None:
    """Eq. (1) of Wojnarowski & Onishchenko in the gear's system: thickness by the involute function."""
    u = np.linspace(2.0, 3.0, 11)
    point = outline.point(u)
    for x, y in point:
        assert math.atan2(y, x) == pytest.approx(outline.gear.half_angle(math.hypot(x, y)), abs=1e-12)


def test_curvature_is_that_of_three_points(outline: Outline) -> None:
    for u in (2.3, 2.7, 3.4):
        a, b, c = outline.point(np.array([u - 1e-3, u, u + 1e-3]))
        ab, bc, ca = b - a, c - b, a - c
        # The outline runs clockwise around the metal, so that convex turns to the right.
        area = ab[1] * bc[0] - ab[0] * bc[1]
        circle = 2.0 * area / (np.linalg.norm(ab) * np.linalg.norm(bc) * np.linalg.norm(ca))
        # The circle through three points differs by the square of their distance.
        assert outline.curvature(u) == pytest.approx(circle, rel=1e-4, abs=0.0)


def test_fillet_is_cut_by_the_rack(outline: Outline) -> None:
    """Brute force: roll the rounded rack over the blank; the fillet is where its round reaches deepest."""
    gear = outline.gear
    module, alpha = gear.module, gear.pressure_angle
    radius = gear.rack.tip_radius * module
    height = gear.profile_shift * module - gear.rack.dedendum * module + radius
    half = math.pi * module / 4.0 + gear.flank_thinning / math.cos(alpha)
    across = half - (gear.rack.dedendum * module - radius) * math.tan(alpha) - radius / math.cos(alpha)
    rolled = np.linspace(-1.2, 1.2, 400001) * module * 2.0 / gear.reference_radius
    # Centre of the round in the gear's frame, where the space's middle is the x axis.
    x, y = gear.reference_radius + height, across + gear.reference_radius * rolled
    centres = np.stack([x * np.cos(rolled) + y * np.sin(rolled), y * np.cos(rolled) - x * np.sin(rolled)], axis=-1)
    for u in (1.0, 1.3, 1.6, 1.9):
        px, py = outline.point(u)
        polar, distance = math.pi / gear.teeth - math.atan2(py, px), math.hypot(px, py)
        point = distance * np.array([math.cos(polar), math.sin(polar)])
        nearest = np.linalg.norm(centres - point, axis=1).min()
        # On the envelope the nearest centre is one radius away; the grid of angles misses it by its square.
        assert nearest == pytest.approx(radius, abs=1e-9)


def test_a_planted_sign_error_would_show(gear_factory) -> None:
    """Thinning must take metal away: with the wrong sign the tooth would grow."""
    thick = Outline(gear=gear_factory(20, 2e-3, 22e-3))
    thin = Outline(gear=gear_factory(20, 2e-3, 22e-3, flank_thinning=0.1e-3))
    u = thin.parameter(thin.gear.base_radius * math.tan(math.radians(20.0)))
    normal = thin.normal(u)
    moved = (thick.point(u) - thin.point(u)) @ normal
    # Equal roll lengths on parallel involutes turn by 0.1 mm / r_b: along the normal by 0.1 mm to second order.
    assert moved == pytest.approx(0.1e-3, rel=5e-3, abs=0.0)
    assert thick.gear.root_radius == thin.gear.root_radius == pytest.approx(math.hypot(*thin.point(0.0)))


def test_form_circle_of_an_unshifted_gear(gear_factory) -> None:
    """Without undercut the involute begins at r_b (tan a - 4 (h_f0 - x)/(z sin 2a)), ISO 21771."""
    gear = gear_factory(40, 1e-3, 21e-3)
    straight = gear.rack.dedendum - gear.rack.tip_radius * (1.0 - math.sin(gear.pressure_angle))
    angle = math.atan(math.tan(gear.pressure_angle) - 4.0 * straight / (40 * math.sin(2.0 * gear.pressure_angle)))
    assert Outline(gear=gear).flank_start == pytest.approx(gear.base_radius * math.tan(angle), rel=1e-12, abs=0.0)
    assert involute(0.0) == 0.0


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"rack": Rack(tip_radius=0.6)}, "rack.tip_radius"),
        ({"tip_radius": 14e-3}, "tip_radius_mm"),
        ({"tip_edge_radius": 2e-3}, "tip_edge_radius_mm"),
    ],
)
def test_impossible_outlines_are_refused(gear_factory, changes, where) -> None:
    values = {"tip_radius": 11e-3, **changes}
    gear = gear_factory(10, 2e-3, values.pop("tip_radius"), **values)
    with pytest.raises(InputError, match=where):
        Outline(gear=gear)
