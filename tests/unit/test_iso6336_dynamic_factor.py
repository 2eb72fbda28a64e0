"""Dynamic factor of ISO 6336-1, method B: each range of speed, joints between them, limits and refusals."""

from __future__ import annotations

import math

import pytest

from gearfem.dynamics.iso6336_kv import coefficients, dynamic_factor, form_deviation, iso6336_dynamic_factor, pitch_deviation
from gearfem.foundation import InputError

PARAMETERS = (2.0, 1.5, 1.0)


def test_each_range_by_hand():
    """Contact ratio 1.6: C_v7 = 0.875 - 0.125 sin(0.4 pi)."""
    seventh = 0.875 - 0.125 * math.sin(0.4 * math.pi)
    cases = {
        0.4: ("subcritical", 1.0 + 0.4 * (0.64 + 0.51 + 0.23)),
        1.0: ("main resonance", 1.0 + 0.64 + 0.51 + 0.9),
        2.0: ("supercritical", 0.94 + 0.705 + seventh),
        1.325: ("intermediate", 0.5 * (3.05 + 1.645 + seventh)),
    }
    for ratio, (name, value) in cases.items():
        found = dynamic_factor(ratio, 0.85, 1.6, PARAMETERS)
        assert found[0] == name
        assert found[1] == pytest.approx(value, rel=1e-12, abs=0.0)


def test_ranges_and_columns_join():
    small = 1e-9
    for edge in (1.15, 1.5):
        below, above = (dynamic_factor(edge + sign * small, 0.85, 1.6, PARAMETERS)[1] for sign in (-1, 1))
        assert below == pytest.approx(above, abs=1e-7)
    for edge in (1.5, 2.5):
        assert coefficients(edge - small)[6] == pytest.approx(coefficients(edge + small)[6], abs=1e-8)
    # The two columns of the standard's table meet at 2 only nearly: C_v4 by 7 %, the others by less.
    for one, two in zip(coefficients(2.0), coefficients(2.0 + small), strict=True):
        assert one == pytest.approx(two, rel=0.08, abs=0.0)


def test_resonance_ratio_is_mesh_over_natural_frequency(small_pair):
    """At the speed where N is 1 the mesh frequency is that of the discs on the standard's mesh stiffness."""
    pair, operation = small_pair.pair, small_pair.operation
    one = iso6336_dynamic_factor(pair, 50.0, 100.0, 6)
    at = iso6336_dynamic_factor(pair, 50.0, 100.0 / one.resonance_ratio, 6)
    assert at.resonance_ratio == pytest.approx(1.0, rel=1e-12, abs=0.0)
    assert at.range == "main resonance"
    mass1, mass2 = operation.pinion_inertia / pair.pinion.base_radius**2, operation.wheel_inertia / pair.wheel.base_radius**2
    assert one.reduced_mass == pytest.approx(mass1 * mass2 / (mass1 + mass2) / pair.face_width, rel=1e-12, abs=0.0)
    heavier = iso6336_dynamic_factor(pair, 50.0, 100.0, 6, inertias=(4.0 * operation.pinion_inertia, 4.0 * operation.wheel_inertia))
    assert heavier.resonance_ratio == pytest.approx(2.0 * one.resonance_ratio, rel=1e-12, abs=0.0)


def test_limit_of_light_loads_and_relief(small_pair):
    pair = small_pair.pair
    # F_t/b = T/(r b) with r = b = 20 mm: 125 N/mm at 50 N m, 25 N/mm at 10 N m.
    assert iso6336_dynamic_factor(pair, 50.0, 100.0, 6).lower_limit == 0.85
    assert iso6336_dynamic_factor(pair, 10.0, 100.0, 6).lower_limit == pytest.approx(0.5 + 0.35 * 0.5, rel=1e-12, abs=0.0)
    assert iso6336_dynamic_factor(pair, 50.0, 100.0, 6, tip_relief=5e-6).relief_parameter == 1.0
    assert iso6336_dynamic_factor(pair, 50.0, 100.0, 5, tip_relief=5e-6).relief_parameter < 1.0


def test_deviations_of_a_grade(gear_factory):
    """m 3 mm, d 105 mm, by hand; two grades double them."""
    gear = gear_factory(35, 3e-3, 55.5e-3)
    assert pitch_deviation(gear, 5) == pytest.approx((0.3 * (3.0 + 0.4 * math.sqrt(105.0)) + 4.0) * 1e-6, rel=1e-12, abs=0.0)
    assert form_deviation(gear, 5) == pytest.approx((2.5 * math.sqrt(3.0) + 0.17 * math.sqrt(105.0) + 0.5) * 1e-6, rel=1e-12, abs=0.0)
    assert pitch_deviation(gear, 7) == pytest.approx(2.0 * pitch_deviation(gear, 5), rel=1e-12, abs=0.0)


def test_refusals(small_pair):
    with pytest.raises(InputError, match="grade"):
        iso6336_dynamic_factor(small_pair.pair, 50.0, 100.0, 13)
    with pytest.raises(InputError, match="torque and speed"):
        iso6336_dynamic_factor(small_pair.pair, -50.0, 100.0, 6)
    with pytest.raises(InputError, match="contact ratio"):
        coefficients(1.0)
