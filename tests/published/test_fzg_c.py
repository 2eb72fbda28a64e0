"""FZG test gears, type C: geometry, normal force and Hertz pressure at the pitch point."""

from __future__ import annotations

import math

import pytest

from gearfem.contact import HertzLine
from gearfem.definition.setup import GearPair


@pytest.fixture(scope="module")
def fzg_c(gear_factory) -> GearPair:
    return GearPair(
        pinion=gear_factory(16, 4.5e-3, 41.318e-3, 0.1817),
        wheel=gear_factory(24, 4.5e-3, 59.272e-3, 0.1715),
        centre_distance=91.5e-3,
        face_width=14e-3,
        normal_backlash=0.0,
    )


def test_fzg_c_to_the_digits_given(fzg_c):
    force = 200.0 / fzg_c.pinion.base_radius
    tangent = math.tan(fzg_c.working_pressure_angle)
    pinion_radius, wheel_radius = fzg_c.pinion.base_radius * tangent, fzg_c.wheel.base_radius * tangent
    radius = pinion_radius * wheel_radius / (pinion_radius + wheel_radius)
    law = HertzLine(pinion=fzg_c.pinion.material, wheel=fzg_c.wheel.material)
    rows = [
        ("working pressure angle, deg", math.degrees(fzg_c.working_pressure_angle), 22.4388, 4),
        ("contact ratio", fzg_c.contact_ratio, 1.4625, 4),
        ("normal force, N", force, 5912.1, 1),
        ("Hertz pressure, MPa", float(law.pressure(force / fzg_c.face_width, radius)) / 1e6, 1347.3, 1),
    ]
    for name, ours, published, digits in rows:
        print(f"FZG C, {name}: {ours:.6g}, published {published}, deviation {ours / published - 1.0:+.1e}")
        assert round(ours, digits) == published, name
