"""Contacts by search: on the line of action without wear, at the smallest distance of dense outlines with it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem.definition.setup import GearPair, Setup
from gearfem.engagement.contacts import find_contacts
from gearfem.engagement.corners import Touch
from gearfem.engagement.engage import engage
from gearfem.engagement.record import Contacts
from gearfem.engagement.search import search_contacts
from gearfem.engagement.zones import unloaded_zones
from gearfem.flank import Deviation, Flanks, Outline, make_flanks
from gearfem.foundation import Array
from gearfem.pipeline import run
from gearfem.placement import Placement, make_placement, mounted, runout_gap


@pytest.fixture(scope="module", params=["coal_combine", "small_pair", "undercut"])
def setup(request, gear_factory, coal_combine) -> Setup:
    if request.param != "undercut":
        return request.getfixturevalue(request.param)
    pinion, wheel = gear_factory(12, 3e-3, 21e-3), gear_factory(14, 3e-3, 24e-3)
    pair = dataclasses.replace(coal_combine.pair, pinion=pinion, wheel=wheel, centre_distance=39e-3, normal_backlash=0.0)
    return dataclasses.replace(coal_combine, pair=pair)


def worn(gear, centre: float, width: float, depth: float = 0.05) -> Outline:
    """A hollow on a parabola, in modules over the part of the roll length at the tip."""
    tip = math.sqrt(gear.tip_radius**2 - gear.base_radius**2)
    shape = lambda part: depth * np.exp(-(((part - centre) / width) ** 2)) + 0.5 * depth * (part - 0.5) ** 2  # noqa: E731
    return Outline(gear=gear, deviation=Deviation.none(gear).plus(lambda roll: gear.module * shape(roll / tip)))


@pytest.fixture(scope="module")
def flanks(setup) -> Flanks:
    return Flanks(pinion=worn(setup.pair.pinion, 0.75, 0.1), wheel=worn(setup.pair.wheel, 0.85, 0.2))


@pytest.fixture(scope="module")
def placement(setup) -> Placement:
    return make_placement(setup)


@pytest.fixture(scope="module")
def contacts(setup, flanks, placement) -> Contacts:
    return find_contacts(flanks, placement, np.linspace(-1.1, 1.1, 1501) * setup.pair.pinion.pitch_angle, (-1, 0, 1))


def lag(pair: GearPair, angle: Array, touch: Touch) -> Array:
    return (angle / pair.ratio - touch.wheel_angle) * pair.wheel.base_radius


def test_search_puts_involutes_on_the_line_of_action(setup, placement) -> None:
    pair, pinion, wheel = setup.pair, Outline(gear=setup.pair.pinion), Outline(gear=setup.pair.wheel)
    exact = find_contacts(Flanks(pinion=pinion, wheel=wheel), placement, np.linspace(-0.9, 0.9, 601) * pair.pinion.pitch_angle, (0,))
    touch = search_contacts(pinion, wheel, placement, exact.pinion_angle)
    on_path = exact.on_flanks[:, 0]
    x, y = touch.point[on_path].T
    direction = placement.working_pressure_angle
    aside = (x - pair.centre_distance / (1.0 + pair.ratio)) * math.cos(direction) - y * math.sin(direction)
    assert on_path.sum() > 200
    assert touch.reach[on_path].all()
    assert np.abs(aside).max() < 1e-9 * pair.pinion.module
    assert np.abs(lag(pair, exact.pinion_angle, touch))[on_path].max() < 1e-14
    assert touch.u1[on_path] == pytest.approx(exact.u1[on_path, 0], abs=1e-10)


def test_search_agrees_with_closed_forms_of_corners(setup, placement) -> None:
    pair, pinion, wheel = setup.pair, Outline(gear=setup.pair.pinion), Outline(gear=setup.pair.wheel)
    if pinion.undercut:
        pytest.skip("corners of undercut teeth have no closed form")
    exact = find_contacts(Flanks(pinion=pinion, wheel=wheel), placement, np.linspace(-1.2, 1.2, 801) * pair.pinion.pitch_angle, (0,))
    touch = search_contacts(pinion, wheel, placement, exact.pinion_angle)
    both = exact.reach[:, 0]
    assert touch.reach[both].all()
    assert lag(pair, exact.pinion_angle, touch)[both] == pytest.approx(exact.gap[both, 0], abs=1e-14)
    for name, values in {"curvature": 1.0 / exact.equivalent_radius, "rolling1": exact.rolling_velocity1, "edge": exact.edge}.items():
        assert getattr(touch, name)[both] == pytest.approx(values[both, 0], rel=1e-8, abs=1e-12), name


def test_worn_teeth_touch_where_dense_outlines_do(dense_gap, flanks, placement, contacts) -> None:
    rows = np.flatnonzero(contacts.reach[:, 1])[::23]
    assert len(rows) > 30
    exact = np.array([dense_gap(flanks, placement, contacts.pinion_angle[row]) for row in rows])
    # Segments of the flank are 1/6000 of it long and bow by their square times the curvature: up to 1e-9 m here.
    assert contacts.gap[rows, 1] == pytest.approx(exact, abs=2e-9)


def test_hollows_are_bridged(setup, flanks, contacts) -> None:
    """The contact jumps over the hollow, whose deepest points never touch, and curvature stays positive."""
    touched = contacts.u1[contacts.on_flanks]
    hollow = flanks.pinion.curvature(np.linspace(2.0, 3.0, 2001)) < 0.0
    assert hollow.any()
    assert np.diff(np.sort(touched)).max() > 0.02
    assert contacts.equivalent_radius[contacts.reach].min() > 0.0


def test_normals_are_opposite_and_points_the_same(setup, flanks, placement, contacts) -> None:
    pair, number = setup.pair, np.array(contacts.pairs)
    wheel_angle = contacts.pinion_angle[:, None] / pair.ratio - contacts.gap / pair.wheel.base_radius
    axis1 = contacts.pinion_angle[:, None] + placement.pinion_start - number * pair.pinion.pitch_angle
    axis2 = -(wheel_angle + placement.wheel_start - number * pair.wheel.pitch_angle)
    force = np.exp(1j * (np.pi / 2.0 - contacts.pressure_angle))
    place = contacts.point[..., 0] + 1j * contacts.point[..., 1]
    for outline, u, turn, origin in (
        (flanks.pinion, contacts.u1, np.exp(1j * axis1), 0.0),
        (flanks.wheel, contacts.u2, -np.exp(1j * axis2), pair.centre_distance),
    ):
        point, normal = (outline.point(u) @ [1.0, 1j]) * turn + origin, (outline.normal(u) @ [1.0, 1j]) * turn
        assert np.abs(point - place)[contacts.reach].max() < 1e-9 * pair.pinion.module
        smooth = contacts.reach & (contacts.u1 > 2.0 + 1e-6) & (contacts.u2 > 2.0 + 1e-6)
        sign = 1.0 if outline is flanks.pinion else -1.0
        assert np.abs(normal - sign * force)[smooth].max() < 1e-8


def test_rolling_is_the_travel_along_the_flanks(setup, flanks, placement) -> None:
    """Eq. 12 by differences of the arcs between two angles; and the footnote's velocities give the same sliding."""
    pitch, step = setup.pair.pinion.pitch_angle, 1e-6
    angle = np.linspace(-0.5, 0.5, 401) * pitch
    before, here, after = (find_contacts(flanks, placement, angle + shift * step * pitch, (0,)) for shift in (-1, 0, 1))
    travel1 = (after.u1 - before.u1) / (2.0 * step * pitch) * flanks.pinion.stretch(here.u1)
    travel2 = -(after.u2 - before.u2) / (2.0 * step * pitch) * flanks.wheel.stretch(here.u2)
    # Where the contact passes a kink or jumps, and where the curvature is at its floor, there is no one velocity.
    floor = here.equivalent_radius[:, 0] > 0.99 * here.equivalent_radius.max()
    steady = (before.reach & here.reach & after.reach & (before.on_flanks == after.on_flanks))[:, 0] & ~floor
    scale = np.abs(here.rolling_velocity1[steady]).max()
    close1 = np.abs(travel1 - here.rolling_velocity1)[steady, 0] < 1e-4 * scale
    close2 = np.abs(travel2 - here.rolling_velocity2)[steady, 0] < 1e-4 * scale
    assert close1.mean() > 0.97
    assert close2.mean() > 0.97
    material = here.material_velocity1 - here.material_velocity2
    assert material[here.reach] == pytest.approx(here.sliding_velocity[here.reach], abs=1e-12 * scale)


def test_arms_are_the_slope_of_the_transmission_function(setup, flanks, placement) -> None:
    """Eq. 10: dphi1/dphi2 of the first pair is l2/l1; and its mean over phi2 is z2/z1."""
    pair, pitch, step = setup.pair, setup.pair.pinion.pitch_angle, 1e-6
    angle = (np.arange(2000) + 0.5) / 2000 * pitch
    sides = [find_contacts(flanks, placement, angle + shift * step * pitch, (-1, 0, 1, 2)) for shift in (-1, 0, 1)]
    before, here, after = sides
    first = [np.argmin(side.gap, axis=1) for side in sides]
    rows = np.arange(len(angle))
    slope = (after.gap.min(axis=1) - before.gap.min(axis=1)) / (2.0 * step * pitch) / pair.wheel.base_radius
    ratio = here.arm2[rows, first[1]] / here.arm1[rows, first[1]]
    # At one pair, and one contact point of it, throughout.
    jumps = np.abs(after.u1[rows, first[1]] - before.u1[rows, first[1]]) > 0.01
    same = (first[0] == first[1]) & (first[2] == first[1]) & ~jumps
    assert same.mean() > 0.95
    assert (1.0 / (1.0 / pair.ratio - slope))[same] == pytest.approx(ratio[same], rel=1e-6, abs=0.0)
    wheel_angle = angle / pair.ratio - here.gap.min(axis=1) / pair.wheel.base_radius
    advance = np.diff(wheel_angle, append=wheel_angle[0] + pitch / pair.ratio)
    mean = ((ratio + np.roll(ratio, -1)) / 2.0 * advance).sum() / advance.sum()
    # Where the first pair changes the ratio jumps by up to 5 % within a step of 1/2000 pitch.
    assert mean == pytest.approx(pair.ratio, rel=5e-5, abs=0.0)


def test_zones_follow_the_gaps(setup, contacts) -> None:
    zones = unloaded_zones(contacts)
    half = np.abs(contacts.pinion_angle) < 0.6 * setup.pair.pinion.pitch_angle
    assert set(zones.first[half]) <= {-1, 0, 1}
    assert (zones.backlash >= 0.0).all()
    before = np.searchsorted(contacts.pinion_angle, zones.changes) - 1
    crossing = np.diff(contacts.gap, axis=0)[before]
    assert zones.changes.size >= 2
    # The change lies where both gaps are the same, to the bend of the gaps within a step.
    for change, row in zip(zones.changes, before, strict=True):
        part = (change - contacts.pinion_angle[row]) / (contacts.pinion_angle[row + 1] - contacts.pinion_angle[row])
        gaps = contacts.gap[row] + part * crossing[list(before).index(row)]
        one, other = contacts.pairs.index(zones.first[row]), contacts.pairs.index(zones.first[row + 1])
        assert gaps[one] == pytest.approx(gaps[other], abs=1e-12)


def test_late_teeth_shift_their_pairs_exactly(setup, flanks, placement) -> None:
    pair, late = setup.pair, 7e-6
    angle = np.linspace(-0.4, 0.4, 41) * pair.pinion.pitch_angle
    here = find_contacts(flanks, placement, angle, (0, 1))
    late1, late2 = np.zeros(pair.pinion.teeth), np.zeros(pair.wheel.teeth)
    late1[0], late2[1] = late, 2.0 * late
    shifted = find_contacts(flanks, dataclasses.replace(placement, pinion_late=late1, wheel_late=late2), angle, (0, 1))
    back = find_contacts(flanks, placement, angle - late / pair.pinion.base_radius, (0,))
    both = here.reach[:, 1] & shifted.reach[:, 1]
    assert shifted.gap[:, 0] == pytest.approx(back.gap[:, 0] + late, abs=1e-15)
    assert shifted.u1[:, 0] == pytest.approx(back.u1[:, 0], abs=1e-11)
    assert shifted.gap[both, 1] == pytest.approx(here.gap[both, 1] + 2.0 * late, abs=1e-15)


def test_odd_teeth_touch_in_their_own_pairs_alone(setup, flanks, placement) -> None:
    pair = setup.pair
    odd = worn(pair.pinion, 0.8, 0.15, 0.08)
    uneven = dataclasses.replace(flanks, pinion_odd=((1, odd),))
    angle = np.linspace(-0.3, 1.3, 33) * pair.pinion.pitch_angle
    pairs = (-1, 0, 1, 1 + pair.pinion.teeth)
    plain, found = find_contacts(flanks, placement, angle, pairs), find_contacts(uneven, placement, angle, pairs)
    assert (found.gap[:, :2] == plain.gap[:, :2]).all()
    alone = find_contacts(dataclasses.replace(flanks, pinion=odd), placement, angle, (1,))
    assert (found.gap[:, 2] == alone.gap[:, 0]).all()
    later = find_contacts(uneven, placement, angle + 2.0 * math.pi, (1 + pair.pinion.teeth,))
    assert later.gap[:, 0] == pytest.approx(alone.gap[:, 0], abs=1e-13)


def test_changed_centre_distance_keeps_involutes_conjugate(setup, placement) -> None:
    pair, flanks = setup.pair, make_flanks(setup)
    apart = mounted(placement, placement.centre_distance + 0.02 * pair.pinion.module)
    angle = np.linspace(-0.3, 0.3, 31) * pair.pinion.pitch_angle
    contacts = find_contacts(flanks, apart, angle, (0,))
    touch = search_contacts(flanks.pinion, flanks.wheel, apart, angle)
    assert contacts.on_flanks.all()
    assert (contacts.gap == 0.0).all()
    assert np.abs(lag(pair, angle, touch)).max() < 1e-14
    assert contacts.pressure_angle == pytest.approx(apart.working_pressure_angle, rel=1e-12, abs=0.0)
    assert contacts.point[15, 0, 1] == pytest.approx(0.0, abs=1e-15)
    # Play of idle flanks: the mirrored idle flank of the pinion follows the working one by the space at the pitch point.
    moved = dataclasses.replace(pair, centre_distance=apart.centre_distance)
    assert apart.normal_backlash - placement.normal_backlash == pytest.approx(moved.working_backlash - pair.working_backlash, rel=1e-9)
    again = mounted(apart, placement.centre_distance)
    assert again.pinion_start == placement.pinion_start
    assert again.normal_backlash == pytest.approx(placement.normal_backlash, abs=1e-16)


@pytest.mark.parametrize("runout", [((30e-6, 0.0), (0.0, 0.0)), ((0.0, 30e-6), (0.0, 0.0)), ((0.0, 0.0), (25e-6, -15e-6))])
@pytest.mark.parametrize("shape", ["involute", "worn"])
def test_runout_is_the_gap_of_displaced_outlines(setup, flanks, placement, runout, shape) -> None:
    """Turn the real, displaced gears: their own line of centres moves, and the search knows nothing of runout."""
    pair, largest = setup.pair, 30e-6
    if shape == "involute":
        flanks = Flanks(pinion=Outline(gear=pair.pinion), wheel=Outline(gear=pair.wheel))
    displaced = dataclasses.replace(placement, pinion_runout=runout[0], wheel_runout=runout[1])
    pairs = tuple(range(0, pair.wheel.teeth, 7 if pair.wheel.teeth > 40 else 3))
    angle = (np.array(pairs) + 0.05) * pair.pinion.pitch_angle
    contacts = find_contacts(flanks, displaced, angle, pairs)
    exact = [_displaced_gap(flanks, placement, runout, phi, number) for phi, number in zip(angle, pairs, strict=True)]
    # E^2/a of the pressure angle; on worn flanks the contact point shifts by about E/sin(alpha_w), down the slope of the depth.
    tolerance = 4.0 * largest**2 / pair.centre_distance
    for outline in (flanks.pinion, flanks.wheel):
        if outline.deviation is not None:
            slope = np.abs(outline.deviation.slope(outline.roll_length(np.linspace(2.0, 3.0, 501)))).max()
            tolerance += largest / math.sin(placement.working_pressure_angle) * slope
    assert np.diag(contacts.gap) == pytest.approx(np.array(exact), abs=tolerance)
    assert np.ptp(np.diag(contacts.gap)) > 1.5 * largest


def _displaced_gap(flanks: Flanks, placement: Placement, runout, phi: float, number: int) -> float:
    """Return the gap of a pair of gears whose centres are displaced; counting runs clockwise on the pinion, anticlockwise on the wheel."""
    pair = placement.pair
    local = phi - number * pair.pinion.pitch_angle
    centre1 = complex(runout[0][0], -runout[0][1]) * np.exp(1j * (phi + placement.pinion_start))
    centre2 = placement.centre_distance + complex(*runout[1]) * np.exp(1j * (np.pi - phi / pair.ratio - placement.wheel_start))
    turned, apart = np.angle(centre2 - centre1), mounted(placement, float(np.abs(centre2 - centre1)))
    seen = local + placement.pinion_start - turned - apart.pinion_start
    touch = search_contacts(flanks.pinion, flanks.wheel, apart, np.array([seen]))
    wheel_angle = touch.wheel_angle[0] + apart.wheel_start - turned - placement.wheel_start
    return float((local / pair.ratio - wheel_angle) * pair.wheel.base_radius)


def test_runout_changes_the_ratio_by_its_slope(setup, placement) -> None:
    displaced = dataclasses.replace(placement, pinion_runout=(20e-6, 5e-6), wheel_runout=(-10e-6, 30e-6))
    angle, step = np.linspace(0.0, 20.0, 101), 1e-6
    (before, _), (_, slope), (after, _) = (runout_gap(displaced, angle + shift * step) for shift in (-1, 0, 1))
    assert (after - before) / (2.0 * step) == pytest.approx(slope, abs=1e-9)


def test_lag_under_a_small_torque_is_the_smallest_gap(coal_combine) -> None:
    mesh = run(coal_combine, until="compliance").mesh
    pair = coal_combine.pair
    mesh = dataclasses.replace(mesh, flanks=Flanks(pinion=worn(pair.pinion, 0.75, 0.1), wheel=worn(pair.wheel, 0.85, 0.2)))
    angle = np.linspace(-0.5, 0.5, 41) * pair.pinion.pitch_angle
    light, heavy = engage(mesh, angle, 1e-3), engage(mesh, angle, 1605.0)
    first = light.contacts.gap.min(axis=1)
    assert first.max() > 10e-6
    assert light.transmission_error == pytest.approx(first, abs=1e-10)
    assert (heavy.transmission_error > first + 1e-6).all()
    assert (heavy.force * heavy.contacts.arm1).sum(axis=1) == pytest.approx(1605.0, rel=1e-10, abs=0.0)


def test_specific_sliding_of_involutes(coal_combine) -> None:
    """1 - s2/(i s1) with the roll lengths s of both involutes, ISO 21771; equal and opposite signs about the pitch point."""
    pair = coal_combine.pair
    angle = np.linspace(-0.3, 0.3, 13) * pair.pinion.pitch_angle
    contacts = find_contacts(make_flanks(coal_combine), make_placement(coal_combine), angle, (0,))
    slope = math.tan(pair.working_pressure_angle)
    roll1, roll2 = pair.pinion.base_radius * (slope + angle), pair.wheel.base_radius * slope - pair.pinion.base_radius * angle
    assert contacts.specific_sliding1[:, 0] == pytest.approx(1.0 - roll2 / (pair.ratio * roll1), rel=1e-10, abs=1e-12)
    assert contacts.specific_sliding2[:, 0] == pytest.approx(1.0 - pair.ratio * roll1 / roll2, rel=1e-10, abs=1e-12)
