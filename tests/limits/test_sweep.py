"""Sweeps: the linear limit over frequency, jumps with both branches, subharmonics, impacts on both flanks, several processes."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.special import mathieu_a, mathieu_b

from gearfem.definition.drive_parts import ShaftedInertia
from gearfem.dynamics import DriveTrain, SweepPoint, elastic_motion, sweep, uniform_transport, unloaded_transport
from gearfem.dynamics.measures import read_off_reference
from gearfem.foundation import InputError, digest

RADIUS, TEETH, STIFFNESS, INERTIA = 0.0705, 50, 4e8, 0.0076
NATURAL = math.sqrt(STIFFNESS * 2.0 * RADIUS**2 / INERTIA)


def light_drive(damping: float = 0.02) -> DriveTrain:
    """An equal pair of light gears; the speed is the sweep's."""
    return DriveTrain(
        pinion_inertia=INERTIA,
        wheel_inertia=INERTIA,
        pinion_torque=150.0,
        wheel_torque=150.0,
        efficiency=1.0,
        pinion_speed=1.0,
        friction_coefficient=0.0,
        damping_ratio=damping,
    )


def speeds(first: float, last: float, count: int) -> np.ndarray:
    """Pinion speeds from tuning to tuning."""
    return np.linspace(first, last, count) * NATURAL / TEETH


@pytest.fixture
def pulsating(mesh_factory):
    """Tables whose stiffness pulsates by a share, with a backlash."""

    def make(share=0.3, backlash=1.0, **changes):
        return mesh_factory(
            TEETH,
            (RADIUS, RADIUS),
            lambda angle: STIFFNESS * (1.0 + share * np.cos(TEETH * angle)),
            columns=np.linspace(0.0, 30e-6, 13),
            normal_backlash=backlash,
            **changes,
        )

    return make


def test_linear_limit_over_frequency(pulsating):
    """Amplitude and phase of the deflection under e_u = A cos(z phi): M A W^2/(C - M W^2 + i D W), from a tenth to three times."""
    amplitude, drive = 0.1e-6, light_drive(0.05)
    mesh = pulsating(0.0, angles=512, offset=0.4, unloaded=lambda phi: amplitude * (1.0 + np.cos(TEETH * phi)))
    result = sweep(mesh, drive, speeds(0.1, 3.0, 30))
    tuning = result.column("tuning", "rest")
    found = result.column("harmonic_amplitude", "rest")[:, 0] * np.exp(1j * result.column("harmonic_phase", "rest")[:, 0])
    expected = amplitude * (1.0 + tuning**2 / (1.0 - tuning**2 + 0.1j * tuning))
    # The transport is the rigid motion: its angle leads by A sin(z phi)/r, so that harmonics of second order enter, A z/r = 7e-5.
    assert np.abs(found - expected).max() < 2e-4 * np.abs(expected).max()
    # Kw is 1 + what moves the pinion: C d + D d' over the mean load.
    deflection = np.abs(amplitude * tuning**2 / (1.0 - tuning**2 + 0.1j * tuning))
    load = STIFFNESS * deflection * np.abs(1.0 + 0.1j * tuning) / (150.0 / RADIUS)
    assert np.allclose(result.column("dynamic_factor_max", "rest") - 1.0, load, rtol=5e-4, atol=1e-5)
    assert np.allclose(result.column("dynamic_factor_max", "rest") + result.column("dynamic_factor_min", "rest"), 2.0, atol=1e-3)
    # |multiplier| = exp(-zeta L) of the damped oscillator.
    decay = np.exp(-0.05 * 2.0 * math.pi / tuning)
    assert np.allclose(result.column("growth", "rest"), decay, atol=1e-6)


def test_both_branches_of_the_softening_jump(pulsating):
    """The loss of contact bends the resonance to lower speeds: falling speed keeps the high branch that rising speed misses."""
    result = sweep(pulsating(), light_drive(), speeds(0.6, 1.3, 36), both_ways=True)
    tuning = result.column("tuning", "up")
    up, down = (result.column("dynamic_factor_max", name) for name in ("up", "down"))
    apart = np.abs(up - down) > 1e-6 * up
    print(
        f"up and down differ from tuning {tuning[apart].min():.2f} to {tuning[apart].max():.2f}; largest {up.max():.2f}, {down.max():.2f}"
    )
    assert apart[tuning < 0.82].all()
    assert not apart[tuning > 0.86].any()
    assert (down >= up - 1e-9).all()
    # The branches are two motions of one speed: contact throughout on the lower, half the time on the upper.
    inside = (tuning > 0.6) & (tuning < 0.82)
    assert (result.column("contact_loss", "up")[inside] == 0.0).all()
    assert (result.column("contact_loss", "down")[inside] > 0.5).all()
    jump = np.diff(up)[np.argmax(np.diff(up))]
    assert jump > 1.5
    assert (result.column("growth", "up") < 1.0).all()
    assert (result.column("growth", "down") < 1.0).all()
    assert (result.column("period_cycles", "up") == 1).all()


def test_both_branches_are_motions_of_the_reference(pulsating):
    """Gear's method, started on either branch, stays there and has the same largest Kw."""
    mesh, drive = pulsating(), light_drive()
    result = sweep(mesh, drive, speeds(0.75, 1.15, 17), both_ways=True)
    for direction in ("up", "down"):
        point = result.branch(direction)[0]
        slow = dataclasses.replace(drive, pinion_speed=point.pinion_speed)
        motion = elastic_motion(mesh, slow, uniform_transport(mesh, slow), cycles=1, samples=2000, start=tuple(point.state[:2]))
        # Samples miss the peak by (pi/2000)^2 of it; 1e-4 is what the steps promise.
        assert point.dynamic_factor_max == pytest.approx(motion.largest_dynamic_factor, rel=1e-4, abs=0.0)
        assert np.allclose(np.sort(np.abs(motion.multipliers))[::-1], point.multiplier_magnitude, atol=1e-4)


def test_parametric_resonance_doubles_the_period(pulsating):
    """Twice the natural frequency: beyond the tongue |1 - W/2| ~ share/4 the motion repeats after each cycle, inside after two.

    First order of Mathieu's tongue with damping: (W/2 - 1)^2 < (share/4)^2 - zeta^2.
    """
    share, zeta = 0.1, 0.01
    half = 2.0 * math.sqrt((share / 4.0) ** 2 - zeta**2)
    result = sweep(pulsating(share), light_drive(zeta), speeds(1.85, 2.15, 61))
    tuning, period = result.column("tuning", "rest"), result.column("period_cycles", "rest")
    inside = tuning[period == 2]
    print(f"period two from {inside.min():.3f} to {inside.max():.3f}; first order: {2.0 - half:.3f} to {2.0 + half:.3f}")
    # Second order of the tongue, share^2/8 or so, and a grid of 0.005; below it the softened motion reaches out to the left.
    assert inside.max() == pytest.approx(2.0 + half, abs=0.008)
    assert set(period) <= {1, 2}
    lines = result.column("line_amplitude", "rest")
    assert (lines[period == 2][:, 11] > 1e-6).all()
    assert (lines[period == 1][:, 11] == 0.0).all()


def test_small_backlash_brings_the_back_flank_into_play(pulsating):
    result = sweep(pulsating(0.3, 4e-6), light_drive(), speeds(0.7, 1.2, 26), both_ways=True)
    back, loss = result.column("back_contact", "down"), result.column("contact_loss", "down")
    assert back.max() > 0.005
    assert (back <= loss + 1e-12).all()
    struck = [point for point in result.branch("down") if point.back_contact > 0.0]
    assert all(point.dynamic_factor_min < 0.0 for point in struck)
    # Without friction the mean load is the torque's whatever flank carries; sums over nodes beside impacts err by a step.
    assert np.allclose(result.column("mesh_force_mean", "down"), 150.0 / RADIUS, rtol=5e-3)


def test_a_motion_that_does_not_repeat_is_said_to(pulsating):
    """Impacts on both flanks under strong excitation: neighbouring motions part, and the statistics stay finite."""
    result = sweep(pulsating(0.6, 15e-6), light_drive(), speeds(0.45, 0.6, 13))
    wild = [point for point in result.points if point.period_cycles == 0 and point.growth > 1.0]
    print(f"{len(wild)} of 13 motions are chaotic, growth {[round(point.growth, 2) for point in wild]}")
    assert max(point.growth for point in wild) > 1.2
    assert all(point.multiplier_magnitude.size == 0 for point in wild)
    # Every line of the continuous spectrum holds something.
    assert all(np.count_nonzero(point.line_amplitude) == 144 for point in wild)
    # The mean load over 96 cycles is the torque's but for what the speed has changed meanwhile, and impacts between nodes.
    assert all(point.mesh_force_mean == pytest.approx(150.0 / RADIUS, rel=0.1, abs=0.0) for point in wild)


def test_unbounded_growth_is_a_failure_of_its_speed_alone(pulsating):
    """Far beyond the play both flanks make a linear oscillator; inside its first tongue by Mathieu's functions nothing bounds it.

    x'' + (1 + share cos(W t)) x = 0 is Mathieu's equation with a = 4/W^2, q = 2 share/W^2, unstable for b1(q) < a < a1(q).
    """
    share = 0.6
    result = sweep(pulsating(share, 15e-6), light_drive(0.005), speeds(1.4, 2.0, 13))
    failed = [failure.pinion_speed * TEETH / NATURAL for failure in result.failures]
    print(f"no bounded motion at tuning {', '.join(f'{tuning:.2f}' for tuning in failed)}")
    assert failed
    assert all("without bound" in failure.reason for failure in result.failures)
    assert all(mathieu_b(1, 2.0 * share / w**2) < 4.0 / w**2 < mathieu_a(1, 2.0 * share / w**2) for w in failed)
    assert len(result.points) + len(failed) == 13
    assert result.points[0].tuning == pytest.approx(1.4, rel=1e-12, abs=0.0)


def test_known_points_are_kept_and_the_rest_comes_out_the_same(pulsating):
    """Stopped after any point, up or down, a sweep goes on to the same last bit."""
    mesh, drive, range_of = pulsating(), light_drive(), speeds(0.8, 1.0, 6)
    new: list[SweepPoint] = []
    whole = sweep(mesh, drive, range_of, both_ways=True, finished=new.append)
    assert len(new) == 12
    for count in (1, 5, 8):
        more: list[SweepPoint] = []
        resumed = sweep(mesh, drive, range_of, both_ways=True, known=new[:count], finished=more.append)
        assert len(more) == 12 - count
        assert digest(resumed) == digest(whole)


@pytest.mark.slow
def test_processes_change_nothing(pulsating):
    mesh, drive = pulsating(), light_drive()
    for both_ways in (False, True):
        alone, shared = (sweep(mesh, drive, speeds(0.7, 1.2, 12), both_ways=both_ways, workers=count) for count in (1, 2))
        assert digest(alone) == digest(shared)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"speeds": []}, "speeds"),
        ({"speeds": [2.0, 1.0]}, "speeds"),
        ({"speeds": [0.0, 1.0]}, "speeds"),
        ({"speeds": [math.nan]}, "speeds"),
        ({"steps": 8}, "steps"),
        ({"workers": 0}, "workers"),
    ],
)
def test_what_cannot_be_swept_is_refused(pulsating, changes, word):
    with pytest.raises(InputError, match=word):
        sweep(pulsating(), light_drive(), changes.pop("speeds", [100.0]), **changes)


def test_columns_by_name(pulsating):
    result = sweep(pulsating(), light_drive(), speeds(0.5, 0.6, 2))
    assert result.directions == ("rest",)
    assert result.column("harmonic_amplitude", "rest").shape == (2, 6)
    with pytest.raises(InputError, match="loudness"):
        result.column("loudness", "rest")


def test_larger_drives_are_swept_by_the_reference(pulsating):
    """A motor on a soft shaft: the point is the reference's; and of two inertias both ways report the same numbers."""
    mesh = pulsating(0.1, angles=128, offset=0.5)
    two = dataclasses.replace(light_drive(0.1), pinion_speed=speeds(0.8, 0.9, 2)[0])
    motor = ShaftedInertia(name="motor", inertia=0.05, stiffness=2e4, damping=1.0)
    drive = dataclasses.replace(two, pinion_chain=(motor,))
    (point,) = sweep(mesh, drive, [two.pinion_speed]).points
    motion = elastic_motion(mesh, drive, unloaded_transport(mesh, drive), cycles=1, samples=800)
    assert point.dynamic_factor_max == pytest.approx(motion.largest_dynamic_factor, abs=1e-6)
    assert point.multiplier_magnitude.size == 4
    alone = elastic_motion(mesh, two, uniform_transport(mesh, two), cycles=1, samples=800)
    slow, (fast,) = read_off_reference(mesh, two, alone, "rest"), sweep(mesh, two, [two.pinion_speed]).points
    for name in (field.name for field in dataclasses.fields(SweepPoint) if field.name not in ("direction", "steps", "harmonic_phase")):
        scale = np.abs(getattr(fast, name)).max()
        # The samples miss extremes by (pi/800)^2/2 of the swing, the rate is a central difference over 1/400 of a cycle.
        assert np.abs(getattr(slow, name) - getattr(fast, name)).max() <= 1e-4 * scale + 1e-9, name
    waves = [one.harmonic_amplitude * np.exp(1j * one.harmonic_phase) for one in (slow, fast)]
    assert np.abs(waves[0] - waves[1]).max() < 1e-6 * np.abs(waves[0]).max()
    assert np.abs(point.harmonic_amplitude[0] - fast.harmonic_amplitude[0]) > 1e-3 * fast.harmonic_amplitude[0]
