"""What a model file leaves open is completed from the rack, the shifts and the centre distance: closed forms and known pairs."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from gearfem.model import load_model, make_setup

STUDIES = Path(__file__).parents[2] / "studies"
OPERATION = {"pinion_torque_Nm": 200.0, "pinion_speed_rpm": 1000.0}


def test_coal_combine_pair():
    setup = load_model(STUDIES / "coal_combine" / "model.toml")
    pair = setup.pair
    # a - r_f(mate) - 0.25 m in millimetres: 281.57 - 203.4 - 2 and 281.57 - 60.4 - 2.
    assert [pair.pinion.tip_radius, pair.wheel.tip_radius] == pytest.approx([76.17e-3, 219.17e-3], abs=1e-12)
    assert [pair.pinion.root_radius, pair.wheel.root_radius] == pytest.approx([60.4e-3, 203.4e-3], abs=1e-12)
    # Half a unit of the last digit of the published values.
    assert math.degrees(pair.working_pressure_angle) == pytest.approx(26.568, abs=5e-4)
    assert pair.contact_ratio == pytest.approx(1.1455, abs=5e-5)
    assert pair.zero_backlash_centre_distance == pytest.approx(281.5686e-3, abs=5e-8)
    assert pair.pinion.flank_thinning == pytest.approx(0.055e-3, abs=1e-15)
    assert setup.operation.pinion_speed == pytest.approx(53.0, abs=0.005)
    assert [round(value, 6) for value in (setup.operation.pinion_inertia, setup.operation.wheel_inertia)] == [10.16, 6.72]


def test_fzg_c_pair():
    pair = make_setup(
        {
            "pair": {"module_mm": 4.5, "centre_distance_mm": 91.5, "face_width_mm": 14.0},
            "pinion": {"teeth": 16, "profile_shift": 0.1817, "tip_radius_mm": 41.318},
            "wheel": {"teeth": 24, "profile_shift": 0.1715, "tip_radius_mm": 59.272},
            "operation": OPERATION,
        }
    ).pair
    # Half a unit of the last digit given.
    assert math.degrees(pair.working_pressure_angle) == pytest.approx(22.4388, abs=5e-5)
    assert pair.contact_ratio == pytest.approx(1.4625, abs=5e-5)


def test_myga_rig_is_an_unshifted_pair_of_full_depth():
    setup = load_model(STUDIES / "myga_rig" / "model.toml")
    pair, operation = setup.pair, setup.operation
    # (z + 2) m/2 and (z - 2.5) m/2; the reference centre distance is the given one.
    assert [pair.pinion.tip_radius, pair.wheel.tip_radius] == pytest.approx([55.5e-3, 57e-3], abs=1e-12)
    assert [pair.pinion.bore_radius, pair.wheel.bore_radius] == pytest.approx([48.75e-3 / 2, 50.25e-3 / 2], abs=1e-12)
    assert operation.wheel_torque == pytest.approx(75.4 * 36 / 35, rel=1e-14, abs=0.0)
    # rho b pi/2 (r^4 - r_bore^4) of a steel disc between bore and reference circle.
    disc = math.pi / 2 * 7850 * 30e-3 * ((52.5e-3) ** 4 - (24.375e-3) ** 4)
    assert operation.pinion_inertia == pytest.approx(disc, rel=1e-13, abs=0.0)
    assert operation.pinion_speed == pytest.approx(157.0, abs=0.005)
    sentences = "\n".join(setup.assumptions)
    for words in (
        "Inertia of the pinion",
        "Inertia of the wheel",
        "Bore radius of the pinion",
        "backlash",
        "Torque of the wheel",
        "friction",
    ):
        assert words in sentences


def test_default_centre_distance_closes_the_backlash_of_the_unthinned_teeth():
    pair = make_setup(
        {
            "pair": {"module_mm": 2.0, "face_width_mm": 20.0, "normal_backlash_mm": 0.1},
            "pinion": {"teeth": 19, "profile_shift": 0.4},
            "wheel": {"teeth": 33, "profile_shift": -0.1},
            "operation": OPERATION,
        }
    ).pair
    working = pair.centre_distance / (19 + 33)
    # At the working pitch circles tooth and space fill the pitch but for the backlash, here along the circle: j_n/cos(alpha_w).
    pitch = 2.0 * math.pi * working
    thickness = [2.0 * working * gear.teeth * gear.half_angle(working * gear.teeth) for gear in (pair.pinion, pair.wheel)]
    backlash = (pitch - sum(thickness)) * math.cos(pair.working_pressure_angle)
    # Rounding of sums of a few millimetres.
    assert backlash == pytest.approx(0.1e-3, abs=1e-15)
    assert pair.working_backlash == pytest.approx(0.1e-3, abs=1e-15)


def test_play_grows_with_the_centre_distance():
    model = {
        "pair": {"module_mm": 2.0, "face_width_mm": 20.0, "centre_distance_mm": 50.01},
        "pinion": {"teeth": 20},
        "wheel": {"teeth": 30},
        "operation": OPERATION,
    }
    # First order 2 da sin(alpha_w); the next term is da^2/(a tan(alpha)), 5e-9 m.
    assert make_setup(model).pair.working_backlash == pytest.approx(2 * 10e-6 * math.sin(math.radians(20)), abs=1e-8)


def test_tips_are_shortened_to_the_clearance_and_never_lengthened():
    model = {
        "pair": {"module_mm": 2.0, "face_width_mm": 20.0},
        "pinion": {"teeth": 20, "profile_shift": 0.5},
        "wheel": {"teeth": 30, "profile_shift": 0.4},
        "operation": OPERATION,
    }
    pair = make_setup(model).pair
    for gear, mate in ((pair.pinion, pair.wheel), (pair.wheel, pair.pinion)):
        assert pair.centre_distance - gear.tip_radius - mate.root_radius == pytest.approx(0.25 * 2e-3, abs=1e-15)
    wider = make_setup({**model, "pair": {**model["pair"], "centre_distance_mm": 52.5}}).pair
    # r + (x + h_a) m: 20 + 1.5 * 2 and 30 + 1.4 * 2.
    assert [wider.pinion.tip_radius, wider.wheel.tip_radius] == pytest.approx([23e-3, 32.8e-3], abs=1e-15)


def test_a_gears_own_material_replaces_single_keys_of_the_common_one():
    setup = make_setup(
        {
            "pair": {"module_mm": 2.0, "face_width_mm": 20.0},
            "pinion": {"teeth": 20, "material": {"density_kg_per_m3": 7100.0}},
            "wheel": {"teeth": 30, "material": {"youngs_modulus_MPa": 170000.0}},
            "material": {"youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.28},
            "operation": OPERATION,
        }
    )
    pinion, wheel = setup.pair.pinion.material, setup.pair.wheel.material
    assert (pinion.youngs_modulus, pinion.poissons_ratio, pinion.density, pinion.yield_strength) == (210e9, 0.28, 7100.0, 1.2e9)
    assert (wheel.youngs_modulus, wheel.poissons_ratio, wheel.density, wheel.yield_strength) == (170e9, 0.28, 7850.0, 1.2e9)
    # Inertia by its own density: the disc of 7850 kg/m3 times 7100/7850.
    assert setup.operation.pinion_inertia == pytest.approx(
        math.pi / 2 * 7100 * 20e-3 * (20e-3**4 - setup.pair.pinion.bore_radius**4), rel=1e-13, abs=0.0
    )
