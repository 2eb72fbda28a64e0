"""Worn outlines: closed, tangent, their normals and curvatures those of the curve; and refused where no tooth is left."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gearfem.engagement import search_kernel
from gearfem.flank import Deviation, Outline
from gearfem.foundation import Array, InputError

GEARS = [(16, 8e-3, 76.17e-3, 0.8), (51, 8e-3, 219.17e-3, 1.175), (10, 3e-3, 18e-3, 0.0), (20, 2e-3, 22e-3, 0.0)]


def waves(gear) -> Deviation:
    """A parabola, a hollow and a constant: up to 0.1 modules."""
    tip = math.sqrt(gear.tip_radius**2 - gear.base_radius**2)
    shape = lambda part: 0.02 + 0.05 * np.exp(-(((part - 0.7) / 0.1) ** 2)) + 0.04 * (part - 0.5) ** 2  # noqa: E731
    return Deviation.none(gear).plus(lambda roll: gear.module * shape(roll / tip))


@pytest.fixture(scope="module", params=GEARS, ids=lambda values: f"z{values[0]}")
def gear(request, gear_factory):
    return gear_factory(*request.param)


@pytest.fixture(scope="module")
def worn(gear) -> Outline:
    return Outline(gear=gear, deviation=waves(gear))


def inside(low: float) -> Array:
    return np.linspace(low + 1e-3, low + 1.0 - 1e-3, 4001)


def test_no_depth_is_the_involute_bit_for_bit(gear) -> None:
    unworn, neutral = Outline(gear=gear), Outline(gear=gear, deviation=Deviation.none(gear))
    u = np.linspace(0.0, 5.0, 1001)
    assert not neutral.worn
    assert (unworn.point(u) == neutral.point(u)).all()
    assert (unworn.normal(u) == neutral.normal(u)).all()
    assert (unworn.curvature(u[400:]) == neutral.curvature(u[400:])).all()


def test_worn_points_miss_the_depth_along_the_normal(gear, worn) -> None:
    u = inside(2.0)
    roll = worn.roll_length(u)
    unworn = Outline(gear=gear)
    nominal, normal = (np.asarray(values) for values in (unworn.point(unworn.parameter(roll)), unworn.normal(unworn.parameter(roll))))
    on_flank = (roll > unworn.flank_start) & (roll < unworn.flank_end)
    assert on_flank.sum() > 3000
    missing = ((nominal - worn.point(u)) * normal).sum(axis=-1)
    assert missing[on_flank] == pytest.approx(worn.deviation.at(roll)[on_flank], rel=1e-9, abs=0.0)


def test_worn_outline_is_closed(gear, worn) -> None:
    for joint in (1.0, 2.0, 3.0, 4.0):
        assert np.abs(worn.point(joint) - worn.point(joint - 1e-12)).max() < 1e-11 * gear.module
    for joint in (1.0, 3.0, 4.0):
        assert np.abs(worn.normal(joint) - worn.normal(joint - 1e-12)).max() < 1e-11
    assert worn.point(4.0) @ worn.point(4.0) == pytest.approx(gear.tip_radius**2, rel=1e-14, abs=0.0)


@pytest.mark.parametrize("segment", [1.0, 2.0, 3.0])
def test_normals_curvatures_and_arcs_are_those_of_the_curve(gear, worn, segment) -> None:
    u, step = inside(segment), 1e-6
    travel = (worn.point(u + step) - worn.point(u - step)) / (2.0 * step)
    speed, normal = np.hypot(*travel.T), worn.normal(u)
    # Rounding of the points over the difference: 1e-16 r/(1e-6 arc); the round of 0.02 modules is the worst.
    assert np.abs((travel * normal).sum(axis=-1) / speed).max() < 5e-7
    assert (travel[:, 1] * normal[:, 0] < travel[:, 0] * normal[:, 1]).all()
    if segment == 1.0:
        return
    turn = np.diff(np.unwrap(np.arctan2(*np.moveaxis(worn.normal(u[:, None] + [-step, step]), -1, 0)[::-1])), axis=1)[:, 0]
    numeric = -turn / (2.0 * step) / speed
    assert numeric == pytest.approx(worn.curvature(u), rel=1e-6, abs=1e-5 / gear.module)
    assert worn.stretch(u) == pytest.approx(speed, rel=1e-6, abs=0.0)
    assert -np.gradient(worn.edge_distance(u), u)[1:-1] == pytest.approx(speed[1:-1], rel=1e-5, abs=0.0)


def test_hollow_has_negative_curvature(worn) -> None:
    assert worn.curvature(inside(2.0)).min() < 0.0


def test_radius_rises_and_leads_back(worn) -> None:
    u = np.linspace(2.0, 3.9, 801)
    radius = np.hypot(*worn.point(u).T)
    assert (np.diff(radius) > 0.0).all()
    assert worn.at_radius(radius) == pytest.approx(u, abs=1e-10)


def test_round_is_tangent_to_flank_and_tip_circle(gear, worn) -> None:
    angle, radius = worn.round_centre
    centre = radius * np.array([math.cos(angle), math.sin(angle)])
    assert radius == gear.tip_radius - gear.tip_edge_radius
    junction = worn.point(3.0) - gear.tip_edge_radius * worn.normal(3.0)
    assert junction == pytest.approx(centre, abs=1e-12 * gear.module)


@pytest.mark.parametrize(
    ("depth", "message"),
    [
        (lambda part: 0.3 + 0.0 * part, "0.25 modules"),
        (lambda part: -0.1 + 0.0 * part, "-0.05"),
        (lambda part: 0.1 + 0.1 * np.tanh((part - 0.5) / 0.02), "radius has to rise"),
        (lambda part: 0.24 * part**4, "pointed"),
    ],
)
def test_impossible_depths_are_refused(gear_factory, depth, message) -> None:
    gear = gear_factory(12, 2e-3, 14.9e-3, 0.5)
    tip = math.sqrt(gear.tip_radius**2 - gear.base_radius**2)
    with pytest.raises(InputError, match=message) as refusal:
        Outline(gear=gear, deviation=Deviation.none(gear).plus(lambda roll: gear.module * depth(roll / tip)))
    assert refusal.value.where == "deviation"


def test_deviations_that_begin_above_the_flank_are_refused(gear_factory) -> None:
    gear = gear_factory(30, 2e-3, 32e-3)
    with pytest.raises(InputError, match="covers the flank"):
        Outline(gear=gear, deviation=Deviation(roll=np.linspace(8e-3, 14e-3, 50), depth=np.linspace(0.0, 20e-6, 50)))


@pytest.mark.parametrize("depth", ["waves", "none"])
def test_compiled_search_sees_the_same_outline(gear, worn, depth) -> None:
    outline = worn if depth == "waves" else Outline(gear=gear)
    u = np.concatenate([inside(2.0), inside(3.0)])
    points, normals = outline.evaluate(u)
    found = np.array([search_kernel.place(outline.curve, one) for one in u])
    assert found[:, :2] == pytest.approx(points, rel=0.0, abs=1e-14 * gear.tip_radius)
    assert found[:, 2] == pytest.approx(normals, rel=0.0, abs=1e-12)
    bent = np.array([search_kernel.bent(outline.curve, one) for one in u])
    assert bent[:, 0] == pytest.approx(outline.curvature(u), rel=1e-9)
    assert bent[:, 1] == pytest.approx(outline.stretch(u), rel=1e-12)
    radius = np.linspace(outline.form_radius, gear.tip_radius, 501)
    at = [search_kernel.at_radius(outline.curve, one) for one in radius]
    assert np.interp(at, u, np.hypot(*points.T)) == pytest.approx(np.interp(outline.at_radius(radius), u, np.hypot(*points.T)), rel=1e-13)
