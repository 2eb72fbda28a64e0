"""The factors of the ISO stiffness one by one, against hand calculations, and where it warns."""

from __future__ import annotations

import dataclasses

import pytest

from gearfem.definition.setup import Material
from gearfem.engagement.iso6336 import iso6336_stiffness, tooth_stiffness
from gearfem.foundation import InputError
from gearfem.foundation.units import DEG

USUAL = {"virtual_teeth": (20, 20), "profile_shift": (0.0, 0.0), "dedendum": (1.2, 1.2), "contact_ratio": 1.5, "line_load": 200e3}


def stiffness(**changes):
    return tooth_stiffness(**{**USUAL, **changes})


def test_all_nine_coefficients():
    """By hand, z 20/20, x 0.5/0.4: the published example has x2 = 0 and so says nothing on C6, C7 and C9."""
    by_hand = 0.04723 + 0.0077755 + 0.0128955 - 0.003175 - 0.0029135 - 0.000772 - 0.0048376 + 0.0013225 + 0.0002912
    assert by_hand == pytest.approx(0.0578166, rel=1e-12, abs=0.0)
    # Sums of nine decimals: rounding alone.
    assert stiffness(profile_shift=(0.5, 0.4)).theoretical_stiffness == pytest.approx(1e9 / 0.0578166, rel=1e-12, abs=0.0)


def test_factors_of_rack_helix_blank_and_material():
    plain = stiffness()
    assert plain.single_stiffness == pytest.approx(0.8 * plain.theoretical_stiffness, rel=1e-15, abs=0.0)
    assert stiffness(dedendum=(1.4, 1.4)).rack_factor == pytest.approx(0.9, rel=1e-14, abs=0.0)
    assert stiffness(pressure_angle=25 * DEG).rack_factor == pytest.approx(1.1, rel=1e-14, abs=0.0)
    assert stiffness(helix_angle=60 * DEG).single_stiffness == pytest.approx(0.5 * plain.single_stiffness, rel=1e-14, abs=0.0)
    assert stiffness(blank_factor=0.9).single_stiffness == pytest.approx(0.9 * plain.single_stiffness, rel=1e-14, abs=0.0)
    # 2 * 206 * 103/(309) is two thirds of 206.
    assert stiffness(youngs_modulus=(206e9, 103e9)).single_stiffness == pytest.approx(
        plain.single_stiffness * 2.0 / 3.0, rel=1e-14, abs=0.0
    )


def test_low_load_softens_by_the_fourth_root():
    assert stiffness(line_load=6.25e3).single_stiffness == pytest.approx(0.5 * stiffness().single_stiffness, rel=1e-14, abs=0.0)
    assert stiffness(line_load=100e3).load_factor == 1.0


def test_mesh_stiffness_from_the_contact_ratio():
    assert stiffness(contact_ratio=5.0 / 3.0).mesh_stiffness == pytest.approx(1.5 * stiffness().single_stiffness, rel=1e-14, abs=0.0)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"profile_shift": (0.1, 0.2)}, "x1 >= x2"),
        ({"profile_shift": (1.2, 0.9)}, "sum is 2.1"),
        ({"profile_shift": (-0.2, -0.4)}, "sum is -0.6"),
        ({"contact_ratio": 1.19}, "10 % too high"),
        ({"contact_ratio": 2.0}, "below 2"),
        ({"line_load": 99e3}, "lowered"),
        ({"line_load": 1601e3}, "1600 N/mm"),
        ({"helix_angle": 31 * DEG}, "30 deg"),
        ({"dedendum": (1.25, 1.4)}, "mean of C_B"),
    ],
)
def test_each_range_left_gives_its_sentence(changes, sentence):
    assert stiffness().warnings == ()
    (warning,) = stiffness(**changes).warnings
    assert sentence in warning


def test_edges_of_the_ranges_are_inside():
    assert stiffness(profile_shift=(1.0, 1.0), contact_ratio=1.2, line_load=1600e3).warnings == ()
    assert stiffness(profile_shift=(-0.25, -0.25), line_load=100e3).warnings == ()


def test_pair_is_read_as_the_standard_means_it(small_pair):
    """Spur: z_n = z. F_t on the reference circle: 50 N m/0.02 m/0.02 m = 125 N/mm; 12.5 N m is below 100 N/mm."""
    pair = small_pair.pair
    ours = iso6336_stiffness(pair, 50.0)
    expected = stiffness(virtual_teeth=(20, 30), dedendum=(1.25, 1.25), contact_ratio=pair.contact_ratio)
    # The dedendum comes from differences of radii of ten modules.
    assert ours.single_stiffness == pytest.approx(expected.single_stiffness, rel=1e-14, abs=0.0)
    assert ours.mesh_stiffness == pytest.approx(expected.mesh_stiffness, rel=1e-14, abs=0.0)
    assert iso6336_stiffness(pair, 12.5).load_factor == pytest.approx(0.3125**0.25, rel=1e-14, abs=0.0)
    assert any("C_R = 1" in sentence for sentence in ours.assumptions)


def test_pair_with_its_own_roots_and_materials(coal_combine):
    pair = coal_combine.pair
    assert iso6336_stiffness(pair, 1605.0).rack_factor == pytest.approx(0.975, rel=1e-13, abs=0.0)
    deeper = dataclasses.replace(pair.wheel, root_radius=pair.wheel.root_radius - 0.15 * 8e-3, material=Material(youngs_modulus=103e9))
    changed = iso6336_stiffness(dataclasses.replace(pair, wheel=deeper), 1605.0)
    assert changed.rack_factor == pytest.approx(0.5 * (0.975 + 0.9), rel=1e-13, abs=0.0)
    assert changed.material_factor == pytest.approx(2.0 / 3.0, rel=1e-14, abs=0.0)
    assert "mean of C_B" in changed.warnings[-1]


def test_the_paper_pair_lies_outside_the_fit(coal_combine):
    """x1 = 0.8 < x2 = 1.175 and a contact ratio of 1.1455."""
    warnings = iso6336_stiffness(coal_combine.pair, 1605.0).warnings
    assert ["x1 >= x2" in warnings[0], "10 % too high" in warnings[1], len(warnings)] == [True, True, 2]


@pytest.mark.parametrize("torque", [0.0, -1.0, float("nan")])
def test_torque_must_be_positive(small_pair, torque):
    with pytest.raises(InputError, match="pinion_torque"):
        iso6336_stiffness(small_pair.pair, torque)


def test_shifts_beyond_sense_are_refused():
    """x2 = 4 on 8 teeth turns the regression negative."""
    with pytest.raises(InputError, match="profile_shift"):
        stiffness(virtual_teeth=(20, 8), profile_shift=(0.0, 4.0))
