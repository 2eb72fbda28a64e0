"""Responses per unit parameter: closed forms, their sum, and what they cost."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gearfem import InputError, make_setup
from gearfem.assembly import assemble
from gearfem.effects.catalogue import catalogue
from gearfem.sensing import observe, requests
from gearfem.templates import templates

KNOWN = catalogue()
MODEL = {
    "pair": {"module_mm": 3.0, "face_width_mm": 15.0, "normal_backlash_mm": 0.06},
    "pinion": {"teeth": 18, "profile_shift": 0.2},
    "wheel": {"teeth": 27},
    "operation": {"pinion_torque_Nm": 90.0, "pinion_speed_rpm": 6000.0},
}
ANGLES = np.linspace(0.0, 6.2, 400)


@pytest.fixture(scope="module")
def setup():
    return make_setup(MODEL)


@pytest.fixture(scope="module")
def asked():
    kinds = requests()
    return (
        kinds["static_transmission_error"](axis=ANGLES, pinion_torque=90.0),
        kinds["dynamic_transmission_error"](axis=ANGLES, pinion_torque=90.0, pinion_speed=500.0),
        kinds["radial_runout"](axis=np.arange(18.0), gear="pinion"),
    )


def test_closed_forms(setup, asked) -> None:
    """Runout reads its eccentricity; supports yield by the normal force; gain adds the reading itself; friction shows in no runout."""
    found = templates(setup, [KNOWN[name].example(setup) for name in ("runout", "support_compliance", "sensor_gain", "friction")], asked)
    assert found.names == (
        "runout_pinion_eccentricity_um",
        "support_compliance_pinion_um_per_kN",
        "support_compliance_wheel_um_per_kN",
        "sensor_gain_scale",
        "friction_coefficient",
    )
    slow, _, runout = found.response
    angle = KNOWN["runout"].example(setup).angle
    assert runout[:, 0] == pytest.approx(np.cos(2.0 * np.pi * np.arange(18) / 18 - angle), rel=0.0, abs=1e-12)
    force = 90.0 / setup.pair.pinion.base_radius
    # Where a corner touches off the path, its lever changes the force by a percent.
    assert np.median(slow[:, 1]) == pytest.approx(force, rel=1e-3, abs=0.0)
    assert slow[:, 1] == pytest.approx(slow[:, 2], rel=1e-9, abs=0.0)
    assert slow[:, 3] == pytest.approx(found.baseline[0], rel=1e-9, abs=0.0)
    assert not runout[:, 1:].any()


def test_small_responses_add_up(setup, asked) -> None:
    effects = [KNOWN[name].example(setup, "wheel", 3) for name in ("tip_relief", "pitch_error", "profile_slope")]
    found = templates(setup, effects, asked, strength=0.01)
    both = assemble(setup, [effect.scaled(0.01, setup) for effect in effects])
    for request, predicted, before in zip(asked[:2], found.predict(found.change), found.baseline, strict=False):
        added = observe(both, request) - before
        # Pairs take up load a little earlier or later: second order, a hundredth of the strength each.
        assert predicted - before == pytest.approx(added, rel=0.0, abs=0.05 * np.abs(added).max())


def test_full_size_responses_are_secants(setup, asked) -> None:
    crack = KNOWN["root_crack"].example(setup, "pinion", 3)
    secant, slope = (templates(setup, [crack], asked[:1], strength).response[0][:, 0] for strength in (1.0, 1e-3))
    assert secant * crack.depth == pytest.approx(observe(assemble(setup, [crack]), asked[0]) - observe(assemble(setup), asked[0]))
    # What a crack adds grows with the square of its depth.
    assert np.abs(slope).max() < 0.01 * np.abs(secant).max()


def test_reciprocal_parameters_count_from_no_effect(setup, asked) -> None:
    mount = KNOWN["sensor_resonance"].example(setup)
    found = templates(setup, [mount], asked[1:2], strength=0.1)
    assert found.change == pytest.approx([0.1 / mount.frequency], rel=1e-12, abs=0.0)
    assert np.isfinite(found.response[0]).all()


def test_what_has_no_response_per_unit_is_refused(setup, asked) -> None:
    gain = dataclasses.replace(KNOWN["sensor_gain"].example(setup), scale=1.0)
    with pytest.raises(InputError, match=r"sensor_gain\.scale"):
        templates(setup, [gain], asked)
    with pytest.raises(InputError, match="strength"):
        templates(setup, [], asked, strength=0.0)
    assert templates(setup, [], asked).response[0].shape == (len(ANGLES), 0)
