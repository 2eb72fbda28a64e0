"""The sign and size of every effect against a calculation by hand."""

from __future__ import annotations

import functools
import math
from pathlib import Path

import numpy as np
import pytest

from gearfem import make_setup
from gearfem.assembly import assemble
from gearfem.definition.setup import Setup
from gearfem.effects import Effect
from gearfem.effects.catalogue import catalogue
from gearfem.foundation import Array
from gearfem.sensing import System, observe, requests

MODEL = {
    "pair": {"module_mm": 3.0, "face_width_mm": 20.0, "normal_backlash_mm": 0.1},
    "pinion": {"teeth": 20},
    "wheel": {"teeth": 30},
    "operation": {
        "pinion_torque_Nm": 120.0,
        "pinion_speed_rpm": 9000.0,
        "pinion_inertia_kg_m2": 0.004,
        "wheel_inertia_kg_m2": 0.012,
        "damping_ratio": 0.1,
    },
}
PITCH = 2.0 * math.pi / 20.0
BASE = (30e-3 * math.cos(math.radians(20.0)), 45e-3 * math.cos(math.radians(20.0)))
# At the pitch point of each of the 20 pinion teeth, and a little beside it, one pair alone is in contact.
PITCH_POINTS = np.arange(20.0) * PITCH
LIGHT = 2.0


@functools.cache
def rig() -> Setup:
    """Return an unshifted pair of module 3 mm without friction."""
    return make_setup(MODEL)


@functools.cache
def plain() -> System:
    """Return the rig without effects."""
    return assemble(rig())


def effect(name: str, **values: object) -> Effect:
    """Return an effect as a model file would give it."""
    (found,) = make_setup({**MODEL, "effect": [{"name": name, **values}]}).effects
    assert isinstance(found, Effect)
    return found


def slow_error(system: System, angle: Array, torque: float = LIGHT) -> Array:
    """Return the slow transmission error [um]."""
    return 1e6 * observe(system, requests()["static_transmission_error"](axis=angle, pinion_torque=torque))


def change(angle: Array, *effects: Effect, torque: float = LIGHT) -> Array:
    """Return what effects change in the slow transmission error [um]."""
    return slow_error(assemble(rig(), effects), angle, torque) - slow_error(plain(), angle, torque)


def profile(gear: str, roll_mm: list[float], *effects: Effect, tooth: int = 0) -> list[float]:
    """Return the metal missing from a flank [um]."""
    request = requests()["flank_profile"](axis=np.array(roll_mm) * 1e-3, gear=gear, tooth=tooth)
    return [float(value) for value in 1e6 * observe(assemble(rig(), effects), request)]


def rolls(gear: str) -> tuple[float, float, float]:
    """Return roll lengths [mm] of lowest contact point, pitch point and tip, from the triangle of the base circles."""
    own, mate = (30.0, 45.0) if gear == "pinion" else (45.0, 30.0)
    tip, other = (math.sqrt((radius + 3.0) ** 2 - (radius * math.cos(math.radians(20.0))) ** 2) for radius in (own, mate))
    return 75.0 * math.sin(math.radians(20.0)) - other, own * math.sin(math.radians(20.0)), tip


@pytest.mark.parametrize("gear", ["pinion", "wheel"])
def test_metal_is_missing_where_it_should(gear):
    low, pitch, tip = rolls(gear)
    # Beside a kink the spline of the deviation rings by some thousandths of a micrometre.
    close = functools.partial(pytest.approx, rel=1e-3, abs=5e-3)
    worn = effect("profile_wear", gear=gear, tip_um=8.0, root_um=12.0, pitch_um=2.0)
    quarter = [2.0 + 10.0 / 4.0, 2.0 + 6.0 / 4.0]
    assert profile(gear, [low - 0.3, pitch, tip, (low + pitch) / 2, (pitch + tip) / 2], worn) == close([12.0, 2.0, 8.0, *quarter])
    relief = effect("tip_relief", gear=gear, amount_um=20.0, length_mm=2.0)
    assert profile(gear, [tip, tip - 1.0, tip - 2.0, pitch], relief) == close([20.0, 5.0, 0.0, 0.0])
    slope = effect("profile_slope", gear=gear, amount_um=-6.0)
    assert profile(gear, [tip, (low + tip) / 2, low - 0.3], slope) == close([-6.0, -3.0, 0.0])
    pit = effect("pitting", gear=gear, tooth=4, depth_um=30.0, centre_mm=pitch, width_mm=2.0)
    assert profile(gear, [pitch, pitch + 0.5, pitch - 1.0], pit, tooth=4) == close([30.0, 15.0, 0.0])
    assert profile(gear, [pitch], pit, tooth=5) == [0.0]
    assert profile("wheel" if gear == "pinion" else "pinion", [pitch], pit, worn, relief, tooth=4) == [0.0]
    # Missing metal lets the wheel lag by as much, where one pair alone touches there.
    assert change(PITCH_POINTS[:1], worn) == pytest.approx([2.0], rel=1e-3, abs=0.0)


@pytest.mark.parametrize("gear", ["pinion", "wheel"])
def test_pitting_lets_its_own_tooth_alone_fall_in(gear):
    pit = effect("pitting", gear=gear, tooth=4, depth_um=5.0, centre_mm=rolls(gear)[1], width_mm=4.0)
    fallen = change(PITCH_POINTS, pit)
    assert fallen[4] == pytest.approx(5.0, rel=5e-3, abs=0.0)
    assert np.abs(np.delete(fallen, 4)).max() < 1e-6


@pytest.mark.parametrize("gear", ["pinion", "wheel"])
def test_a_late_tooth_lets_the_wheel_lag_by_as_much(gear):
    lag = change(PITCH_POINTS, effect("pitch_error", gear=gear, tooth=7, amount_um=6.0))
    assert lag[7] == pytest.approx(6.0, rel=1e-4, abs=0.0)
    assert np.abs(np.delete(lag, 7)).max() < 1e-6
    read = observe(
        assemble(rig(), [effect("pitch_error", gear=gear, tooth=7, amount_um=6.0)]),
        requests()["pitch_deviation"](axis=np.arange(9.0), gear=gear),
    )
    assert 1e6 * read == pytest.approx(np.where(np.arange(9) == 7, 6.0, 0.0), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(("gear", "sign"), [("pinion", 1.0), ("wheel", -1.0)])
def test_runout_moves_the_flank_along_its_normal(gear, sign):
    """A tooth at the angle t from the largest radius stands out by e cos t and, seen in counting direction, back by -e sin t.

    Its working flank leads its centre by h on the pinion (trails it on the wheel) and its normal leans outward by alpha_w: the
    metal moves by e sin(t - h + alpha_w) towards the mate on the pinion, mirrored on the wheel; what it moves away is lag.
    """
    teeth, eccentricity, angle = (20, 10.0, 0.8) if gear == "pinion" else (30, 10.0, 0.8)
    moved = effect("runout", gear=gear, eccentricity_um=eccentricity, angle_rad=angle)
    place = np.arange(20.0) * 2.0 * math.pi / teeth - angle
    half = math.pi / 2.0 / teeth - 0.025e-3 / BASE[gear == "wheel"]
    lag = -sign * eccentricity * np.sin(place - sign * (half - math.radians(20.0)))
    assert change(PITCH_POINTS, moved) == pytest.approx(lag, rel=1e-3, abs=0.02)
    system = assemble(rig(), [moved])
    read = {name: 1e6 * observe(system, requests()[name](axis=np.arange(20.0), gear=gear)) for name in ("pitch_deviation", "radial_runout")}
    assert read["pitch_deviation"] == pytest.approx(lag, rel=1e-9, abs=1e-9)
    assert read["radial_runout"] == pytest.approx(eccentricity * np.cos(place), rel=1e-9, abs=1e-9)


def test_a_larger_centre_distance_shortens_contact_and_gives_play():
    farther = assemble(rig(), [effect("centre_distance", amount_um=100.0)])
    play = farther.placement.normal_backlash - plain().placement.normal_backlash
    # d(play)/da = 2 sin(alpha_w), at the middle of the change.
    middle = math.acos(75.0 * math.cos(math.radians(20.0)) / 75.05)
    assert play == pytest.approx(2.0 * 100e-6 * math.sin(middle), rel=1e-5, abs=0.0)
    angle = np.linspace(0.0, PITCH, 400, endpoint=False)
    # The path between both tip circles is shorter by what a sin(alpha_w), the distance of the base tangents' feet, has grown.
    stiff = [observe(system, requests()["mesh_stiffness"](axis=angle, pinion_torque=LIGHT)) for system in (plain(), farther)]
    shared = [np.mean(values > 0.5 * (values.min() + values.max())) for values in stiff]
    working = math.acos(75.0 * math.cos(math.radians(20.0)) / 75.1)
    lost = (75.1 * math.sin(working) - 75.0 * math.sin(math.radians(20.0))) / (math.pi * 3.0 * math.cos(math.radians(20.0)))
    assert shared[0] - shared[1] == pytest.approx(lost, rel=0.0, abs=0.004)


def test_gaps_along_the_face_width():
    place = np.array([-0.5, -0.3, 0.0, 0.5])
    for name, values, gap in (
        ("lead_misalignment", {"slope_um": 8.0}, [0.0, 1.6, 4.0, 8.0]),
        ("crowning", {"gear": "pinion", "amount_um": 8.0}, [8.0, 2.88, 0.0, 8.0]),
        ("end_relief", {"gear": "wheel", "amount_um": 8.0, "length_mm": 8.0}, [8.0, 2.0, 0.0, 8.0]),
    ):
        lead = assemble(rig(), [effect(name, **values)]).flanks.lead
        assert 1e6 * np.interp(place, lead.place, lead.gap) == pytest.approx(gap, rel=1e-2, abs=1e-9), name


def test_supports_yield_to_the_normal_force():
    moved = change(PITCH_POINTS, effect("support_compliance", pinion_um_per_kN=3.0, wheel_um_per_kN=2.0), torque=120.0)
    assert moved == pytest.approx(np.full(20, 5.0 * 0.120 / BASE[0]), rel=1e-9, abs=0.0)


def test_softer_bodies_contacts_and_roots_let_the_wheel_lag_in_proportion():
    for name, values in (("body_compliance", {}), ("contact_compliance", {})):
        once, twice = (change(PITCH_POINTS[:1], effect(name, scale=scale, **values), torque=120.0)[0] for scale in (1.5, 2.0))
        assert once > 0.1
        assert twice == pytest.approx(2.0 * once, rel=1e-4, abs=0.0), name
    for gear in ("pinion", "wheel"):
        cracked = change(PITCH_POINTS, effect("root_crack", gear=gear, tooth=6, depth_mm=1.5), torque=120.0)
        assert cracked.argmax() == 6
        assert cracked[6] > 0.5
        assert cracked[[0, 10, 15]] == pytest.approx(np.zeros(3), rel=0.0, abs=1e-6)


def test_friction_does_not_step_in_the_slope_of_the_normal_force():
    """The normal force steps by 2 f tan(alpha) at the pitch point; its slope goes with P^0.1 at most and follows by a tenth."""
    coefficient, beside = 0.2, 1e-3 * PITCH
    request = requests()["mesh_stiffness"](axis=np.array([-beside, beside]), pinion_torque=120.0)
    rubbing = observe(assemble(rig(), [effect("friction", coefficient=coefficient)]), request)
    step = 2.0 * coefficient * math.tan(math.radians(20.0))
    assert abs(rubbing[0] / rubbing[1] - 1.0) < 0.1 * step
    assert rubbing == pytest.approx(observe(plain(), request), rel=0.05 * step, abs=0.0)


def test_friction_loads_the_teeth_more_in_approach():
    """In approach friction helps the pinion turn the wheel: P (l1 - f h1) = T, in recess P (l1 + f h1) = T."""
    coefficient, beside = 0.1, 0.02 * PITCH
    rubbing = slow_error(assemble(rig(), [effect("friction", coefficient=coefficient)]), np.array([-beside, beside]), 120.0)
    smooth = slow_error(plain(), np.array([-beside, beside]), 120.0)
    share = coefficient * math.tan(math.radians(20.0))
    # Contact stiffens with the load, so that the deflection grows by a little less than the force.
    assert rubbing[0] / smooth[0] == pytest.approx(1.0 / (1.0 - share), rel=0.005, abs=0.0)
    assert rubbing[1] / smooth[1] == pytest.approx(1.0 / (1.0 + share), rel=0.005, abs=0.0)


@pytest.mark.parametrize(("gear", "seen"), [("pinion", 1.0), ("wheel", 20.0 / 30.0)])
def test_a_ripple_adds_its_torque(gear, seen):
    amplitude, order, phase = 6.0, 3.0, 0.4
    ripple = effect("torque_ripple", gear=gear, order=order, amplitude_Nm=amplitude, phase_rad=phase)
    added = change(PITCH_POINTS, ripple, torque=120.0)
    torque = seen * amplitude * np.cos(order * seen * PITCH_POINTS + phase)
    for value, more in zip(added, torque, strict=True):
        loaded = slow_error(plain(), PITCH_POINTS[:1], 120.0 + more)[0] - slow_error(plain(), PITCH_POINTS[:1], 120.0)[0]
        assert value == pytest.approx(loaded, rel=1e-6, abs=1e-7)


def test_backlash_and_damping_replace_those_of_the_model():
    first, last = effect("backlash", amount_um=30.0), effect("backlash", amount_um=40.0)
    assert assemble(rig(), [first, last]).placement.normal_backlash == pytest.approx(40e-6, rel=1e-12, abs=0.0)
    farther = assemble(rig(), [effect("centre_distance", amount_um=100.0), last]).placement.normal_backlash
    assert farther == pytest.approx(40e-6 + 2.0 * 100e-6 * math.sin(math.radians(20.0)), rel=1e-2, abs=0.0)
    assert assemble(rig(), [effect("damping", ratio=0.2)]).drive.damping_ratio == 0.2
    assert assemble(rig(), [effect("friction", coefficient=0.2)]).drive.friction_coefficient == 0.2


def at_speed(*effects: Effect, quantity: str = "dynamic_transmission_error", rpm: float = 9000.0) -> Array:
    """Return one turn of a motion at speed, 240 angles to the pitch."""
    angle = np.arange(4800) / 240 * PITCH
    request = requests()[quantity](axis=angle, pinion_torque=120.0, pinion_speed=rpm * math.pi / 30.0)
    return observe(assemble(rig(), effects), request)


def test_sensors_read_too_much_too_late_and_too_smoothly():
    true, omega = at_speed(), 300.0 * math.pi
    assert at_speed(effect("sensor_gain", scale=1.1)) == pytest.approx(1.1 * true, rel=1e-12, abs=0.0)
    # A delay of one tenth of the pitch shows 24 samples later what happened 24 samples before.
    late = at_speed(effect("sensor_lag", delay_s=0.1 * PITCH / omega))
    assert late[24:] == pytest.approx(true[:-24], rel=1e-4, abs=0.0)
    frequency, ratio = omega / PITCH / 2.0, 0.2
    spectra = [np.fft.rfft(values)[20::20] for values in (at_speed(effect("sensor_resonance", frequency_Hz=frequency, ratio=ratio)), true)]
    part = np.arange(1, 4) * 2.0 * math.pi * 2.0 / (2.0 * math.pi)
    response = 1.0 / (1.0 - part**2 + 2j * ratio * part)
    assert np.abs(spectra[0][:3] / spectra[1][:3] / response - 1.0).max() < 0.02


def test_slow_records_know_no_lag_and_no_resonance():
    system = assemble(rig(), [effect("sensor_lag", delay_s=1e-3), effect("sensor_resonance", frequency_Hz=100.0, ratio=0.1)])
    assert np.array_equal(slow_error(system, PITCH_POINTS), slow_error(plain(), PITCH_POINTS))
    louder = assemble(rig(), [effect("sensor_gain", scale=1.1)])
    assert slow_error(louder, PITCH_POINTS) == pytest.approx(1.1 * slow_error(plain(), PITCH_POINTS), rel=1e-12, abs=0.0)
    stiff = [observe(one, requests()["mesh_stiffness"](axis=PITCH_POINTS, pinion_torque=120.0)) for one in (louder, plain())]
    assert stiff[0] == pytest.approx(1.1 * stiff[1], rel=1e-12, abs=0.0)


@pytest.mark.parametrize(("ratio", "deviations"), [(0.01, -2.0), (0.084, 0.0), (0.7, 2.0)])
def test_sensors_are_damped_between_piezoelectric_ones_and_those_with_a_damper(ratio: float, deviations: float) -> None:
    assert effect("sensor_resonance", frequency_Hz=3000.0, ratio=ratio).unlikely() == pytest.approx((deviations,), rel=0.0, abs=0.01)


def test_no_effect_of_the_catalogue_is_left_out_here():
    text = Path(__file__).read_text()
    assert [name for name in catalogue() if f'"{name}"' not in text] == []
