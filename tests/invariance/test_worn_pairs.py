"""Contacts of random worn pairs: nothing penetrates, normals are opposite, names and roles of the teeth do not matter."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from gearfem.definition.setup import Gear, GearPair, zero_backlash_centre_distance
from gearfem.engagement.contacts import find_contacts
from gearfem.flank import Deviation, Flanks, Outline
from gearfem.foundation import Array, InputError
from gearfem.placement import Placement, make_placement

# Height, place and width of a hollow, wear at the tip and at the root, all in modules or parts of the roll length.
WEAR = st.tuples(st.floats(0.0, 0.06), st.floats(0.2, 1.0), st.floats(0.08, 0.4), st.floats(0.0, 0.05), st.floats(0.0, 0.05))


@st.composite
def worn_pairs(draw, make_gear) -> tuple[GearPair, Flanks]:
    """Draw an external pair with standard tips, shortened to keep the clearance, and wear on both gears."""
    teeth, module = (draw(st.integers(12, 45)), draw(st.integers(12, 45))), draw(st.sampled_from([1e-3, 3e-3, 8e-3]))
    shifts = (draw(st.floats(0.0, 0.6)), draw(st.floats(0.0, 0.6)))
    blanks = [make_gear(z, module, (z / 2.0 + 1.0 + x) * module, x) for z, x in zip(teeth, shifts, strict=True)]
    distance = zero_backlash_centre_distance(*blanks)
    shortening = sum(shifts) * module - (distance - sum(teeth) / 2.0 * module)
    gears = [make_gear(blank.teeth, module, blank.tip_radius - shortening, blank.profile_shift) for blank in blanks]
    pair = GearPair(pinion=gears[0], wheel=gears[1], centre_distance=distance, face_width=10.0 * module, normal_backlash=0.0)
    assume(pair.contact_ratio > 1.05)
    try:
        outlines = [Outline(gear=gear, deviation=deviation(gear, draw(WEAR))) for gear in gears]
    except InputError:
        assume(False)
    return pair, Flanks(pinion=outlines[0], wheel=outlines[1])


def deviation(gear: Gear, wear: tuple[float, ...]) -> Deviation:
    height, place, width, tip, root = wear
    end = math.sqrt(gear.tip_radius**2 - gear.base_radius**2)

    def depth(roll: Array) -> Array:
        part = roll / end
        hollow: Array = height * np.exp(-(((part - place) / width) ** 2))
        return gear.module * (hollow + tip * part**3 + root * (1.0 - part) ** 2)

    return Deviation.none(gear).plus(depth)


def placed(pair: GearPair, coal_combine) -> Placement:
    return make_placement(dataclasses.replace(coal_combine, pair=pair))


@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_random_worn_pairs(data, gear_factory, coal_combine, dense_gap) -> None:
    _assert_contacts_hold(*data.draw(worn_pairs(gear_factory)), coal_combine, dense_gap)


def test_contact_on_an_undercut_edge(gear_factory, coal_combine, dense_gap) -> None:
    """The edge of a heavily undercut tooth touches while its flank stands more than a radian off."""
    gears = [gear_factory(13, 1e-3, 7.4766e-3, 0.0), gear_factory(12, 1e-3, 7.2891e-3, 0.3125)]
    distance = zero_backlash_centre_distance(*gears)
    pair = GearPair(pinion=gears[0], wheel=gears[1], centre_distance=distance, face_width=10e-3, normal_backlash=0.0)
    worn = deviation(gears[1], (0.046875, 0.25, 0.25, 0.0, 0.0))
    flanks = Flanks(pinion=Outline(gear=gears[0]), wheel=Outline(gear=gears[1], deviation=worn))
    _assert_contacts_hold(pair, flanks, coal_combine, dense_gap)


def test_contact_on_an_edge_by_the_base_circle(gear_factory, coal_combine, dense_gap) -> None:
    """The flank turns with the root of the radius there: whichever gear drives, its edge is met at the edge itself."""
    gears = [gear_factory(18, 1e-3, 10e-3, 0.0), gear_factory(12, 1e-3, 7e-3, 0.0)]
    pair = GearPair(pinion=gears[0], wheel=gears[1], centre_distance=15e-3, face_width=10e-3, normal_backlash=0.0)
    worn = [deviation(gear, wear) for gear, wear in zip(gears, ((0.03125, 0.25, 0.25, 0.0, 0.0), (0.0, 0.5, 0.2, 0.0, 0.0)), strict=True)]
    outlines = [Outline(gear=gear, deviation=one) for gear, one in zip(gears, worn, strict=True)]
    _assert_contacts_hold(pair, Flanks(pinion=outlines[0], wheel=outlines[1]), coal_combine, dense_gap)


def _assert_contacts_hold(pair: GearPair, flanks: Flanks, coal_combine, dense_gap) -> None:
    placement, pitch = placed(pair, coal_combine), pair.pinion.pitch_angle
    angle = np.linspace(-0.8, 0.8, 49) * pitch
    contacts = find_contacts(flanks, placement, angle, (0,))
    reach, gap = contacts.reach[:, 0], contacts.gap[:, 0]
    assert reach[np.abs(angle) < 0.3 * pitch].all()
    _assert_nothing_penetrates(dense_gap, flanks, placement, contacts)
    _assert_normals_are_opposite(flanks, placement, contacts)
    # The same teeth under other numbers.
    later = find_contacts(flanks, placement, angle + 7.0 * pitch, (7,))
    assert later.gap[reach, 0] == pytest.approx(gap[reach], abs=1e-14)
    # The wheel drives: what touched at these angles of both gears touches again, the motion running backwards.
    swapped = GearPair(pinion=pair.wheel, wheel=pair.pinion, centre_distance=pair.centre_distance, face_width=1.0, normal_backlash=0.0)
    wheel_angle = angle / pair.ratio - gap / pair.wheel.base_radius
    mirrored = find_contacts(Flanks(pinion=flanks.wheel, wheel=flanks.pinion), placed(swapped, coal_combine), -wheel_angle, (0,))
    both = reach & mirrored.reach[:, 0]
    assert both.sum() > 0.9 * reach.sum()
    assert mirrored.gap[both, 0] == pytest.approx(gap[both], abs=1e-13)


def _assert_nothing_penetrates(dense_gap, flanks, placement, contacts) -> None:
    """Dense outlines of both teeth touch at the same lag, or a little later for standing between the points."""
    for row in np.flatnonzero(contacts.reach[:, 0])[::6]:
        found = dense_gap(flanks, placement, float(contacts.pinion_angle[row]))
        assert contacts.gap[row, 0] == pytest.approx(found, abs=1e-6 * placement.pair.pinion.module)


def _assert_normals_are_opposite(flanks, placement, contacts) -> None:
    pair, force = placement.pair, np.exp(1j * (np.pi / 2.0 - contacts.pressure_angle))
    axis1 = contacts.pinion_angle[:, None] + placement.pinion_start
    axis2 = -(contacts.pinion_angle[:, None] / pair.ratio - contacts.gap / pair.wheel.base_radius + placement.wheel_start)
    smooth = contacts.reach & (contacts.u1 > 2.0 + 1e-6) & (contacts.u2 > 2.0 + 1e-6)
    normal1 = (flanks.pinion.normal(contacts.u1) @ [1.0, 1j]) * np.exp(1j * axis1)
    normal2 = (flanks.wheel.normal(contacts.u2) @ [1.0, 1j]) * -np.exp(1j * axis2)
    assert np.abs(normal1 - force)[smooth].max() < 1e-8
    assert np.abs(normal2 + force)[smooth].max() < 1e-8
