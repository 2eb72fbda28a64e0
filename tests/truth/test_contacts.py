"""Contacts of unworn teeth: the straight line of action on the path, exact corners off it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem.definition.setup import Setup
from gearfem.engagement.contacts import find_contacts
from gearfem.engagement.record import Contacts
from gearfem.flank import Flanks, make_flanks, path_of_contact
from gearfem.foundation import Array
from gearfem.placement import Placement, make_placement


@pytest.fixture(scope="module", params=["coal_combine", "small_pair"])
def setup(request) -> Setup:
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="module")
def stage(setup) -> tuple[Flanks, Placement]:
    return make_flanks(setup), make_placement(setup)


@pytest.fixture(scope="module")
def contacts(setup, stage) -> Contacts:
    pitch = setup.pair.pinion.pitch_angle
    return find_contacts(*stage, np.linspace(-1.1, 1.1, 1501) * pitch, (-1, 0, 1))


def on_path(contacts: Contacts) -> Array:
    return contacts.reach & (contacts.gap == 0.0)


def off_path(contacts: Contacts) -> Array:
    return contacts.reach & (contacts.gap > 0.0)


def turned(points: Array, angle: Array) -> Array:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([points[..., 0] * cosine - points[..., 1] * sine, points[..., 0] * sine + points[..., 1] * cosine], axis=-1)


def axes_of_teeth(setup, placement, contacts) -> tuple[Array, Array]:
    """Return polar angles of both tooth axes where each pair touches; the wheel's seen from O2, half a turn away."""
    number = np.array(contacts.pairs)
    wheel_angle = contacts.pinion_angle[:, None] / setup.pair.ratio - contacts.gap / setup.pair.wheel.base_radius
    axis1 = contacts.pinion_angle[:, None] + placement.pinion_start - number * setup.pair.pinion.pitch_angle
    return axis1, -(wheel_angle + placement.wheel_start - number * setup.pair.wheel.pitch_angle)


def test_contact_on_the_path_lies_on_the_line_of_action(setup, contacts) -> None:
    inside = on_path(contacts)
    pitch_point = setup.pair.centre_distance / (1.0 + setup.pair.ratio)
    angle = setup.pair.working_pressure_angle
    x, y = contacts.point[inside].T
    aside = (x - pitch_point) * math.cos(angle) - y * math.sin(angle)
    assert inside.any()
    assert np.abs(aside).max() < 1e-9 * setup.pair.pinion.module


def test_both_outlines_touch_in_the_contact_point(setup, stage, contacts) -> None:
    flanks, placement = stage
    axis1, axis2 = axes_of_teeth(setup, placement, contacts)
    reach = contacts.reach
    first = turned(flanks.pinion.point(contacts.u1), axis1)
    second = turned(flanks.wheel.point(contacts.u2), axis2)
    second = np.stack([setup.pair.centre_distance - second[..., 0], -second[..., 1]], axis=-1)
    tolerance = 1e-9 * setup.pair.pinion.module
    assert np.abs(first - contacts.point)[reach].max() < tolerance
    assert np.abs(second - contacts.point)[reach].max() < tolerance
    normal1 = turned(flanks.pinion.normal(contacts.u1), axis1)
    normal2 = -turned(flanks.wheel.normal(contacts.u2), axis2)
    assert np.abs(normal1 + normal2)[reach].max() < 1e-9


def test_corner_contact_penetrates_nowhere(setup, stage, contacts) -> None:
    """Brute force: dense points of the wheel's outline against the pinion's, at every twentieth corner contact."""
    flanks, placement = stage
    axis1, axis2 = axes_of_teeth(setup, placement, contacts)
    dense = np.linspace(2.0, 4.0, 20001)
    pinion, wheel = flanks.pinion.point(dense), flanks.wheel.point(dense)
    rows = np.argwhere(off_path(contacts) & (contacts.gap < 0.05 * setup.pair.pinion.module))
    assert len(rows) > 40
    for row, column in rows[::20]:
        seen = turned(wheel, axis2[row, column])
        seen = turned(np.stack([setup.pair.centre_distance - seen[:, 0], -seen[:, 1]], axis=-1), -axis1[row, column])
        radius, polar = np.hypot(*seen.T), np.arctan2(seen[:, 1], seen[:, 0])
        limits = np.hypot(*pinion.T)
        inside = (radius > limits[0]) & (radius < limits[-1])
        boundary = np.interp(radius[inside], limits, np.arctan2(pinion[:, 1], pinion[:, 0]))
        clearance = (polar[inside] - boundary) * radius[inside]
        # The nearest of the points is up to 1e-4 modules from the contact of radius 0.02 modules: 1e-8/(2 x 0.02).
        assert abs(clearance.min()) < 3e-7 * setup.pair.pinion.module


def test_involute_identity_of_pressure_angles(setup, stage, contacts) -> None:
    """z1 tan a1 + z2 tan a2 = (z1 + z2) tan a_w at every contact on the path."""
    flanks, _ = stage
    inside = on_path(contacts)
    pair = setup.pair
    tangent1 = flanks.pinion.roll_length(contacts.u1[inside]) / pair.pinion.base_radius
    tangent2 = flanks.wheel.roll_length(contacts.u2[inside]) / pair.wheel.base_radius
    total = pair.pinion.teeth * tangent1 + pair.wheel.teeth * tangent2
    expected = (pair.pinion.teeth + pair.wheel.teeth) * math.tan(pair.working_pressure_angle)
    assert total == pytest.approx(expected, rel=1e-12, abs=0.0)


def test_arms_give_the_ratio_and_the_travel(setup, contacts) -> None:
    pair = setup.pair
    inside = on_path(contacts)
    assert contacts.arm2[inside] / contacts.arm1[inside] == pytest.approx(pair.ratio, rel=1e-12, abs=0.0)
    assert contacts.arm1[inside] == pytest.approx(pair.pinion.base_radius, rel=1e-12, abs=0.0)
    width = contacts.friction_arm1 + contacts.friction_arm2
    assert width[inside] == pytest.approx(pair.centre_distance * math.sin(pair.working_pressure_angle), rel=1e-12, abs=0.0)


def test_rigid_contact_turns_the_wheel_by_its_arms(setup, stage) -> None:
    """dphi2/dphi1 = l1/l2 also in corner contact; a central difference of the gap confirms it."""
    pair, pitch = setup.pair, setup.pair.pinion.pitch_angle
    angle, step = np.linspace(-0.6, 1.0, 401) * pitch, 1e-5 * pitch
    before, here, after = (find_contacts(*stage, angle + shift * step, (0,)) for shift in (-1, 0, 1))
    inside = (off_path(before) & off_path(here) & off_path(after))[:, 0]
    slope = (after.gap - before.gap)[:, 0] / (2.0 * step) / pair.wheel.base_radius
    ratio = (here.arm1 / here.arm2)[:, 0]
    # Rounding of the gap over the difference: 1e-16 / 1e-6.
    assert (1.0 / pair.ratio - slope)[inside] == pytest.approx(ratio[inside], abs=2e-7)


def test_sliding_is_the_difference_of_the_material_velocities(contacts) -> None:
    """Rolling from the travel along each flank (12) and the footnote's velocities differ, their sliding agrees."""
    reach = contacts.reach
    material = contacts.friction_arm1 - contacts.arm1 / contacts.arm2 * contacts.friction_arm2
    scale = np.abs(contacts.sliding_velocity[reach]).max()
    assert np.abs(material - contacts.sliding_velocity)[reach].max() < 1e-12 * scale
    inside = on_path(contacts)
    assert contacts.rolling_velocity1[inside] == pytest.approx(contacts.friction_arm1[inside], rel=1e-12, abs=0.0)
    corner = off_path(contacts)
    assert np.abs(contacts.rolling_velocity1 - contacts.friction_arm1)[corner].max() > 0.1 * scale


def test_sliding_is_negative_in_approach(setup, contacts) -> None:
    path = setup.pair.pinion.base_radius * contacts.pinion_angle
    inside = on_path(contacts)[:, 1]
    approach = inside & (path < -1e-9)
    assert (contacts.sliding_velocity[approach, 1] < 0.0).all()
    assert (contacts.sliding_velocity[inside & (path > 1e-9), 1] > 0.0).all()


def test_next_pair_repeats_one_pitch_later(setup, stage) -> None:
    pitch = setup.pair.pinion.pitch_angle
    angle = np.linspace(-0.5, 0.5, 41) * pitch
    now, later = find_contacts(*stage, angle, (0,)), find_contacts(*stage, angle + pitch, (1,))
    assert later.gap == pytest.approx(now.gap, abs=1e-15)
    assert later.u1 == pytest.approx(now.u1, abs=1e-12)


UNDERCUT = [(14, 14), (12, 12), (10, 40)]


@pytest.mark.parametrize(("teeth1", "teeth2"), UNDERCUT)
def test_undercut_cuts_the_path_and_nothing_penetrates(gear_factory, coal_combine, teeth1, teeth2) -> None:
    """The path begins at the form circle; before it the tip touches the flank again, or the edge of the undercut touches."""
    module = 3e-3
    pinion, wheel = (gear_factory(teeth, module, (teeth / 2.0 + 1.0) * module) for teeth in (teeth1, teeth2))
    pair = dataclasses.replace(
        coal_combine.pair, pinion=pinion, wheel=wheel, centre_distance=(teeth1 + teeth2) / 2.0 * module, normal_backlash=0.0
    )
    setup = dataclasses.replace(coal_combine, pair=pair)
    flanks, placement = make_flanks(setup), make_placement(setup)
    approach, recess = path_of_contact(flanks, pair)
    assert flanks.pinion.undercut
    assert approach < pair.approach_length
    contacts = find_contacts(flanks, placement, np.linspace(-0.9, 0.9, 721) * pinion.pitch_angle, (0,))
    length = pinion.base_radius * contacts.pinion_angle[on_path(contacts)[:, 0]]
    step = pinion.base_radius * np.diff(contacts.pinion_angle[:2])[0]
    assert -approach - step < length.min() < -approach + 2.0 * step
    assert recess - 2.0 * step < length.max() < recess + step
    axis1, axis2 = axes_of_teeth(setup, placement, contacts)
    dense = np.linspace(1.6, 4.0, 12001)
    pinion_side, wheel_side = flanks.pinion.point(dense), flanks.wheel.point(dense)
    limits = np.hypot(*pinion_side.T)
    assert (np.diff(limits) > 0.0).all()
    for row in np.flatnonzero(contacts.reach[:, 0] & (contacts.gap[:, 0] < 0.02 * module))[::7]:
        seen = turned(wheel_side, axis2[row, 0])
        seen = turned(np.stack([pair.centre_distance - seen[:, 0], -seen[:, 1]], axis=-1), -axis1[row, 0])
        radius, polar = np.hypot(*seen.T), np.arctan2(seen[:, 1], seen[:, 0])
        inside = (radius > limits[0]) & (radius < limits[-1])
        boundary = np.interp(radius[inside], limits, np.arctan2(pinion_side[:, 1], pinion_side[:, 0]))
        clearance = ((polar[inside] - boundary) * radius[inside]).min()
        # Points on both outlines stand 2e-4 modules apart; at edges that costs a part of their distance.
        assert -1e-4 * module < clearance < 2e-4 * module
