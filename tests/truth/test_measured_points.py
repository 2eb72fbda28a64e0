"""Measured points and the involute: the mapping is exact both ways, in both systems, with thinned teeth."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gearfem.definition.measured_points import from_points, read_flank, tip_roll, to_points
from gearfem.flank import Deviation, Outline
from gearfem.foundation.units import MM, UM


def write(path, header, columns):
    path.write_text(f"# probe\n{header}\n" + "".join(f"{a:.17g},{b:.17g}\n" for a, b in zip(*columns, strict=True)))
    return path


def test_points_and_depths_return(coal_combine):
    rng = np.random.default_rng(1)
    for gear in (coal_combine.pair.pinion, coal_combine.pair.wheel):
        roll = rng.uniform(2e-3, tip_roll(gear), 500)
        depth = rng.uniform(-0.2e-3, 0.7e-3, 500)
        back = from_points(to_points(roll, depth, gear), gear)
        np.testing.assert_allclose(back[0], roll, rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(back[1], depth, rtol=0.0, atol=1e-14)


def test_points_of_a_worn_outline_lie_their_depth_below_the_involute(coal_combine):
    # The outline adds the depth by its own formulas, with normals; the mapping knows neither.
    gear = coal_combine.pair.pinion
    worn = Deviation.none(gear).plus(lambda roll: 0.3e-3 * (roll / 30e-3) ** 2)
    outline = Outline(gear=gear, deviation=worn)
    u = np.linspace(2.0, 3.0, 40)
    roll, depth = from_points(outline.point(u), gear)
    np.testing.assert_allclose(roll, outline.roll_length(u), rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(depth, worn.at(roll), rtol=0.0, atol=1e-15)


def test_a_point_moved_into_the_metal_is_deeper_by_that_much(coal_combine):
    gear = coal_combine.pair.wheel
    outline, u = Outline(gear=gear), np.linspace(2.05, 2.95, 9)
    _, depth = from_points(outline.point(u) - 70e-6 * outline.normal(u), gear)
    np.testing.assert_allclose(depth, 70e-6, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("system", ["the tooth's system", "the gear's system"])
def test_both_systems_are_told_apart(system, coal_combine, tmp_path):
    for member, gear in (("pinion", coal_combine.pair.pinion), ("wheel", coal_combine.pair.wheel)):
        outline = Outline(gear=gear)
        roll = np.linspace(1.05 * outline.flank_start, outline.flank_end, 20)
        depth = 0.2e-3 * np.sin(200.0 * roll) ** 2
        points = to_points(roll, depth, gear)
        if system == "the tooth's system":
            points[:, 0] -= gear.base_radius * math.cos(gear.base_half_angle)
        file = write(tmp_path / f"{member}.csv", "x_mm,y_mm", points.T / MM)
        found = read_flank(file, file.name, member, None, gear)
        assert found.system == system
        np.testing.assert_allclose(found.roll, roll, rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(found.depth, depth, rtol=0.0, atol=1e-14)


def test_tooth_system_is_that_of_the_paper(coal_combine, tmp_path):
    # Eq. 1 as it stands, with the pressure angle at the point as its parameter and the half angle of the thinned tooth.
    gear = coal_combine.pair.pinion
    alpha = np.linspace(0.2, 0.6, 12)
    turned = gear.base_half_angle - (np.tan(alpha) - alpha)
    x = gear.base_radius * (np.cos(turned) / np.cos(alpha) - math.cos(gear.base_half_angle))
    y = gear.base_radius * np.sin(turned) / np.cos(alpha)
    file = write(tmp_path / "unworn.csv", "x_mm,y_mm", (x / MM, y / MM))
    found = read_flank(file, file.name, "pinion", 3, gear)
    np.testing.assert_allclose(found.roll, gear.base_radius * np.tan(alpha), rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(found.depth, 0.0, rtol=0.0, atol=1e-14)


def test_roll_lengths_are_taken_as_they_are(coal_combine, tmp_path):
    roll, depth = np.linspace(15.0, 40.0, 9), np.linspace(-20.0, 300.0, 9)
    file = write(tmp_path / "a.csv", "roll_length_mm,deviation_um", (roll, depth))
    found = read_flank(file, "a.csv", "pinion", None, coal_combine.pair.pinion)
    np.testing.assert_allclose(found.roll / MM, roll, rtol=1e-12)
    np.testing.assert_allclose(found.depth / UM, depth, rtol=1e-12, atol=0.0)
    assert found.row.tolist() == list(range(1, 10))
    assert not found.below.size


def test_points_inside_the_base_circle_are_named(coal_combine, tmp_path):
    gear = coal_combine.pair.wheel
    points = Outline(gear=gear).point(np.concatenate([[1.0], np.linspace(2.05, 2.95, 10)]))
    low = np.array([[gear.base_radius - 0.1e-3, 0.01]]) if gear.root_radius < gear.base_radius else points[:0]
    file = write(tmp_path / "w.csv", "x_mm,y_mm", np.concatenate([low, points]).T / MM)
    found = read_flank(file, "w.csv", "wheel", None, gear)
    inside = np.flatnonzero(np.hypot(*np.concatenate([low, points]).T) < gear.base_radius) + 1
    assert found.below.tolist() == inside.tolist()
    assert sorted([*found.below.tolist(), *found.row.tolist()]) == list(range(1, len(low) + 12))
