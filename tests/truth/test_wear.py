"""Wear against closed forms: Archard's depth per passage, metal neither lost nor made, volumes as areas between outlines."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gearfem.assembly import assemble
from gearfem.engagement.engage import engage
from gearfem.flank import Deviation, Outline, make_flanks
from gearfem.foundation import InputError
from gearfem.wear import Archard, depth_for_volume, removed_volume, wear_over, wear_rates

WIDTH = 0.075
MM3 = 1e-9


@pytest.fixture(scope="module")
def loaded(coal_combine):
    """The coal combine pair under load over one pitch."""
    mesh = assemble(coal_combine).mesh
    angles = (np.arange(240) + 0.5) / 240 * coal_combine.pair.pinion.pitch_angle
    return mesh, engage(mesh, angles, 1605.0)


def at(gear, rate, roll):
    return np.interp(roll, Deviation.none(gear).roll, rate)


def test_depth_of_a_passage_is_coefficient_times_load_times_sliding_over_rolling(coal_combine, loaded):
    pair, law = coal_combine.pair, Archard(pinion_coefficient=1e-17, wheel_coefficient=3e-17)
    rates = wear_rates(*loaded, law, finest=1e-3)
    load = 1605.0 / pair.pinion.base_radius / pair.face_width
    pitch1, pitch2 = (gear.base_radius * math.tan(pair.working_pressure_angle) for gear in (pair.pinion, pair.wheel))
    # One pair carries here, and involutes roll at s1 and s2/i per angle of the pinion (ISO 21771).
    along = np.array([-4e-3, -2e-3, 3e-3, 6e-3])
    roll1, roll2 = pitch1 + along, pitch2 - along
    sliding = np.abs(roll1 - roll2 / pair.ratio)
    # The bell of Hertz's width, 0.3 mm of roll length, sees the bend of the curve: s^2 f''/2, 0.4 % of the depth at most here.
    assert at(pair.pinion, rates["pinion"], roll1) == pytest.approx(1e-17 * load * sliding / roll1, rel=6e-3, abs=0.0)
    assert at(pair.wheel, rates["wheel"], roll2) * pair.ratio == pytest.approx(
        3e-17 * load * sliding / (roll2 / pair.ratio), rel=6e-3, abs=0.0
    )


def test_rolling_dirt_wears_a_flank_evenly_where_one_pair_carries(coal_combine, loaded):
    pair = coal_combine.pair
    plain = wear_rates(*loaded, Archard(pinion_coefficient=1e-17, wheel_coefficient=1e-17))
    dirty = wear_rates(*loaded, Archard(pinion_coefficient=1e-17, wheel_coefficient=1e-17, rolling=0.5))
    load = 1605.0 / pair.pinion.base_radius / pair.face_width
    roll = pair.pinion.base_radius * math.tan(pair.working_pressure_angle) + np.array([-2e-3, 0.0, 6e-3])
    added = at(pair.pinion, dirty["pinion"] - plain["pinion"], roll)
    assert added == pytest.approx(0.5e-17 * load, rel=1e-3, abs=0.0)


def test_no_metal_is_lost_or_made(coal_combine, loaded):
    """The area worn off a section is that of k w |v_s| over the passage, wherever the bell and the ends of the flank leave it."""
    mesh, engagement = loaded
    pair, contacts = coal_combine.pair, engagement.contacts
    step = pair.pinion.pitch_angle / contacts.pinion_angle.size
    way = float(np.sum(engagement.force / pair.face_width * np.abs(contacts.sliding_velocity))) * step
    rates = wear_rates(mesh, engagement, Archard(pinion_coefficient=1e-17, wheel_coefficient=1e-17))
    for member, gear, passages in (("pinion", pair.pinion, 1.0), ("wheel", pair.wheel, 1.0 / pair.ratio)):
        outline = mesh.flanks.of(member)
        roll = np.linspace(outline.flank_start, outline.flank_end, 20_001)
        # Nodes 0.1 mm apart, read between them as straight.
        area = np.trapezoid(at(gear, rates[member], roll) * roll / gear.base_radius, roll)
        assert area == pytest.approx(1e-17 * passages * way, rel=2e-3, abs=0.0)


def test_volume_is_the_area_between_the_outlines(coal_combine):
    outline = make_flanks(coal_combine).pinion
    worn = Outline(
        gear=outline.gear, deviation=Deviation.none(outline.gear).plus(lambda roll: 2e-4 + 5e-3 * np.clip(roll - 0.03, -0.02, 0.02))
    )

    def section(one: Outline) -> float:
        # Between the tooth's axis, form circle and tip circle, by Gauss's shoelace; edges of the tip are 0.02 modules.
        points = one.point(np.linspace(2.0, 5.0, 60_001))
        start = np.array([[one.form_radius, 0.0]])
        arc = np.arctan2(points[0, 1], points[0, 0]) * np.linspace(0.0, 1.0, 2001)[:, None]
        inner = one.form_radius * np.concatenate([np.cos(arc), np.sin(arc)], axis=1)
        x, y = np.concatenate([start, inner, points]).T
        return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))

    difference = (section(outline) - section(worn)) * WIDTH
    # Runs clockwise from the axis to the flank, or not: the sign of the area is that of the whole section.
    difference = math.copysign(difference, section(outline) * difference)
    assert difference == pytest.approx(removed_volume(worn, WIDTH), rel=2e-3, abs=0.0)


def test_a_shape_takes_the_volume_asked_for(coal_combine):
    outline = make_flanks(coal_combine).wheel
    shape = 1.0 + np.linspace(0.0, 1.0, 513) ** 2
    once = depth_for_volume(outline, shape, 142.0 * MM3, WIDTH)
    twice = depth_for_volume(once, np.ones(513), 58.0 * MM3, WIDTH)
    assert removed_volume(once, WIDTH) == pytest.approx(142.0 * MM3, rel=1e-9, abs=0.0)
    assert removed_volume(twice, WIDTH) == pytest.approx(200.0 * MM3, rel=1e-9, abs=0.0)
    with pytest.raises(InputError, match="shape"):
        depth_for_volume(outline, -shape, 142.0 * MM3, WIDTH)
    with pytest.raises(InputError, match="volume"):
        depth_for_volume(outline, shape, 1.0, WIDTH)


def test_a_short_life_is_its_rate_times_its_turns(coal_combine, loaded):
    law, turns = Archard(pinion_coefficient=1e-17, wheel_coefficient=2e-17), 1e3
    life = wear_over(coal_combine, law, turns, angles=240)
    rates = wear_rates(*loaded, law)
    # Two nanometres shift hardly any load, most of it on a tip edge, which is stiff.
    assert life.pinion_depth[-1] == pytest.approx(turns * rates["pinion"], rel=2e-3, abs=1e-15)
    assert life.wheel_depth[-1] == pytest.approx(turns * rates["wheel"], rel=2e-3, abs=1e-15)
    assert life.hours[-1] == pytest.approx(turns * 2.0 * math.pi / 53.0 / 3600.0, rel=1e-12, abs=0.0)
