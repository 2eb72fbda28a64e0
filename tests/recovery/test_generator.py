"""The generator of blind campaigns: does it obey mechanics, the file formats and its seed? Nothing of the package under test is used."""

from __future__ import annotations

import ast
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from .generator.effects import Effect
from .generator.gear import inv, make_pair
from .generator.mesh import reach, share, static
from .generator.motion import Table, masses, mesh_ratio, run, tabulate
from .generator.observe import Spec, measure, sense
from .generator.system import Sensor, System
from .generator.tooth import ContactLaw, crack_table, tooth_table

TORQUE = 74.0


def turns(system: System, count: float = 1.0, samples: int = 40) -> np.ndarray:
    return np.arange(int(count * system.pair.pinion.teeth * samples)) * system.pair.pitch / samples


def te(system: System, torque: float = TORQUE, count: float = 1.0) -> np.ndarray:
    """Slow transmission error in micrometres."""
    return static(system, turns(system, count), torque).lag * 1e6


def test_it_shares_nothing_with_the_package_under_test() -> None:
    for path in (Path(__file__).parent / "generator").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.startswith("gearfem") for name in names), path.name


class TestGeometry:
    def test_contact_ratio_and_lengths_close(self, shifted: System) -> None:
        pair = shifted.pair
        assert pair.pitch_roll(0) + pair.pitch_roll(1) == pytest.approx(pair.path, rel=1e-12, abs=0.0)
        clearance = pair.centre - pair.pinion.tip_radius - pair.wheel.root_radius
        assert clearance == pytest.approx(0.25 * pair.pinion.module, rel=1e-9, abs=0.0)

    def test_teeth_and_gaps_fill_the_pitch_circle_without_backlash(self) -> None:
        pair = make_pair((19, 50), 4e-3, (0.4, 0.1), 36e-3, (0.45, 0.4), 0.0)
        angles = [float(g.half_angle(g.base_radius / math.cos(pair.alpha))) for g in pair.gears]
        arcs = sum(2.0 * a * g.base_radius / math.cos(pair.alpha) for a, g in zip(angles, pair.gears, strict=True))
        assert arcs == pytest.approx(pair.base_pitch / math.cos(pair.alpha), rel=1e-9, abs=0.0)

    def test_corners_leave_the_path_smoothly_and_quadratically(self, shifted: System) -> None:
        for way, lag, _ in shifted.pair.corners:
            near = np.interp([0.02, 0.04], way / shifted.pair.base_pitch, lag)
            assert lag[0] == pytest.approx(0.0, abs=1e-12)
            assert np.all(np.diff(lag) >= 0.0)
            assert near[1] / near[0] == pytest.approx(4.0, rel=0.1, abs=0.0)

    def test_corner_touches_the_mate_without_cutting_into_it(self, healthy: System) -> None:
        """The flank of the pinion, drawn point by point, keeps clear of the wheel's tip corner at the tabulated lag."""
        pair = healthy.pair
        rb1, rb2, alpha = pair.pinion.base_radius, pair.wheel.base_radius, pair.alpha
        way, lag, _ = pair.corners[1]
        for k in (60, 120, 180):
            start = (pair.path - pair.wheel.tip_roll) / rb1 - math.tan(alpha)
            phi = start - way[k] / rb1
            turned = (rb1 * phi - lag[k] - rb1 * start) / rb2
            gamma = alpha - math.atan(pair.wheel.tip_roll / rb2) + turned
            corner = complex(pair.centre - pair.wheel.tip_radius * math.cos(gamma), pair.wheel.tip_radius * math.sin(gamma))
            s = np.linspace(0.0, pair.pinion.tip_roll, 20001)
            flank = (rb1 + 1j * s) * np.exp(1j * (phi + math.tan(alpha) - alpha - s / rb1))
            assert np.abs(flank - corner).min() < 2e-7

    def test_runout_is_first_order_the_normal_shift(self, healthy: System) -> None:
        """A centre out by d along the eccentricity shifts the flanks by its part along the line of action."""
        size = 2e-6
        system = Effect("runout", {"gear": "pinion", "eccentricity_um": size * 1e6, "angle_rad": 0.7}).apply(healthy)
        angle = turns(healthy)
        pair = healthy.pair
        half = float(pair.pinion.half_angle(pair.pinion.base_radius / math.cos(pair.alpha)))
        wanted = -size * np.sin(angle - half - 0.7 + pair.alpha)
        found = static(system, angle, TORQUE).lag - static(healthy, angle, TORQUE).lag
        assert np.abs(found - wanted).max() < 0.03 * size

    def test_centre_distance_moves_the_lag_like_the_involute_function(self, healthy: System) -> None:
        """Both centres apart by a fixed runout vector (drift) opens the working flanks by sum(rb) times the change of inv."""
        more = 40e-6
        pair = healthy.pair
        system = replace(healthy, drift=lambda angle: np.full_like(angle, more))
        alpha = math.acos(pair.base_sum / (pair.centre + more))
        gap = reach(system, np.array([0.0]), TORQUE).gap[0, 1]
        assert gap == pytest.approx(pair.base_sum * (inv(alpha) - inv(pair.alpha)), rel=1e-9, abs=0.0)
        assert gap == pytest.approx(more * math.sin(pair.alpha), rel=0.02, abs=0.0)


class TestCompliance:
    def test_single_pair_stiffness_is_a_steel_gears(self, healthy: System) -> None:
        slope = static(healthy, turns(healthy, 0.1), TORQUE).slope / healthy.pair.width * 1e-9
        assert 9.0 < slope.min() < 15.0
        assert 13.0 < slope.mean() < 21.0

    def test_tooth_softens_towards_its_tip(self, healthy: System) -> None:
        table = tooth_table(healthy.pair.pinion)
        assert np.all(np.diff(table.beam) > 0.0)
        assert table.beam[-1] > 3.0 * table.beam[0]

    def test_crack_grows_faster_when_deep(self, healthy: System) -> None:
        gear = healthy.pair.wheel
        section = tooth_table(gear).section
        small, middle, large = (crack_table(gear, x * section)[-1] for x in (0.1, 0.2, 0.4))
        assert 3.0 < middle / small < 5.0
        assert large / middle > 4.5

    @pytest.mark.parametrize("law", [ContactLaw(0.9), ContactLaw(None)])
    def test_contact_slope_is_the_derivative(self, law: ContactLaw) -> None:
        force, radius = np.array([50.0, 500.0, 4000.0]), np.full(3, 8e-3)
        value, slope = law.approach(force, radius, 206e9, 2.5e-3, 25e-3)
        more = law.approach(force * 1.0001, radius, 206e9, 2.5e-3, 25e-3)[0]
        assert slope == pytest.approx((more - value) / (1e-4 * force), rel=1e-3, abs=0.0)
        assert np.all(np.diff(value / force) < 0.0)


class TestLoadSharing:
    def test_forces_balance_and_gaps_are_respected(self, shifted: System) -> None:
        angle = turns(shifted, 1.0)
        at = reach(shifted, angle, 300.0)
        load = np.full(len(angle), 300.0 / shifted.pair.pinion.base_radius)
        found = share(shifted, at, load, friction=True)
        assert ((1.0 + at.arm1) * found.force).sum(1) == pytest.approx(load, rel=1e-7, abs=0.0)
        assert np.all(found.force >= -1e-6)
        approach = shifted.contact.approach(found.force, at.radius, shifted.youngs, 4e-3, shifted.pair.width)[0]
        left = found.lag[:, None] - at.gap - (at.matrix @ found.force[:, :, None])[:, :, 0] - approach
        assert np.abs(left[found.force > 1.0]).max() < 1e-10
        assert left[found.force <= 1e-6].max() < 1e-10

    @pytest.mark.parametrize("soft", [{"body_scale": (3.0, 3.0)}, {"contact_scale": 4.0}, {"lead": 12e-6 * np.linspace(0.0, 1.0, 25)}])
    def test_soft_pairs_lean_on_the_next_one_too(self, healthy: System, soft: dict[str, Any]) -> None:
        """Whatever the pair yields more than usual: no flank is in another one that does not push back."""
        system, angle = replace(healthy, **soft), turns(healthy)
        at, found = reach(system, angle, TORQUE), static(system, angle, TORQUE)
        apart = (at.matrix @ found.force[:, :, None])[:, :, 0] + at.gap - found.lag[:, None]
        assert apart[found.force == 0.0].min() > -1e-12

    def test_slope_is_the_derivative_of_force_over_lag(self, healthy: System) -> None:
        angle = turns(healthy, 0.05)
        low, high = (static(healthy, angle, TORQUE * x) for x in (0.9999, 1.0001))
        rate = 2e-4 * TORQUE / healthy.pair.pinion.base_radius / (high.lag - low.lag)
        assert rate == pytest.approx(static(healthy, angle, TORQUE).slope, rel=2e-3, abs=0.0)

    def test_mean_lag_is_a_few_micrometres_and_grows_with_torque(self, healthy: System) -> None:
        means = [te(healthy, torque, 0.1).mean() for torque in (5.0, 20.0, TORQUE, 150.0)]
        assert 3.0 < means[2] < 11.0
        assert np.all(np.diff(means) > 0.0)
        assert means[3] / means[2] < 150.0 / TORQUE

    def test_transitions_are_smooth(self, healthy: System) -> None:
        """Corners hand the load over in steps that shrink with the step of the angle."""
        coarse, fine = (np.abs(np.diff(static(healthy, turns(healthy, 0.1, n), TORQUE).lag)).max() for n in (60, 240))
        assert fine < 0.4 * coarse

    def test_work_of_the_torque_equals_elastic_energy(self, healthy: System) -> None:
        """Loading at a fixed angle: the lag's derivative by the gap of one pair is that pair's share of the stiffness."""
        angle = np.array([0.35 * healthy.pair.pitch])
        at = reach(healthy, angle, TORQUE)
        load = np.array([TORQUE / healthy.pair.pinion.base_radius])
        base = share(healthy, at, load, friction=False)
        for pair in range(4):
            gap = at.gap.copy()
            gap[:, pair] += 1e-9
            moved = share(healthy, replace(at, gap=gap), load, friction=False)
            assert float((moved.lag - base.lag)[0]) == pytest.approx(1e-9 * base.share[0, pair], rel=2e-3, abs=1e-13)

    def test_zero_of_the_torque_balance(self, healthy: System) -> None:
        """The torque that gives a wanted mean lag, found by bisection, returns it: static() is a function of torque alone."""
        target = te(healthy, 50.0, 0.05).mean()
        assert brentq(lambda t: te(healthy, t, 0.05).mean() - target, 20.0, 90.0) == pytest.approx(50.0, rel=1e-6, abs=0.0)


class TestMotion:
    def test_slow_motion_is_the_static_one(self, healthy: System) -> None:
        course = turns(healthy, 1.0)
        moved = run(healthy, tabulate(healthy, course, TORQUE), TORQUE, 4.0)
        still = static(healthy, course, TORQUE)
        assert np.abs(moved.lag - still.lag)[200:].max() < 0.03e-6
        assert moved.factor[200:].max() < 1.01

    def test_forced_linear_oscillator(self, healthy: System) -> None:
        """Constant stiffness under a sinusoidal unloaded error has a closed answer; the error falls with the square of the step."""
        stiff, size = 4e8, 1e-6
        mass = masses(healthy)[2]
        speed = 0.7 * math.sqrt(stiff / mass) / 23
        errors = []
        for samples in (12, 24):
            course = turns(healthy, 8.0, samples)
            force = np.array([0.0, 0.2, 0.5, 0.8, 0.9, 1.0, 1.5, 2.0, 3.0, 5.0]) * TORQUE / healthy.pair.pinion.base_radius
            lag = size * np.sin(23 * course)[:, None] + force / stiff
            table = Table(course, lag, force, np.zeros(len(course)), np.zeros(len(course)), stiff)
            found = run(healthy, table, TORQUE, speed).lag[-23 * samples :]
            w, d = 23 * speed, 2 * 0.06 * math.sqrt(stiff * mass)
            gain = (stiff + 1j * w * d) / (stiff - mass * w * w + 1j * w * d)
            exact = force[5] / stiff + size * np.imag(gain * np.exp(23j * course[-23 * samples :]))
            errors.append(np.abs(found - exact).max() / size)
        assert errors[1] < 0.03
        assert errors[1] < 0.4 * errors[0]

    def test_resonance_stands_where_stiffness_and_mass_put_it(self, healthy: System) -> None:
        system = replace(healthy, damping=0.03)
        table = tabulate(system, turns(system, 4.0, 30), TORQUE)
        speeds = np.linspace(0.7, 1.3, 13) * math.sqrt(table.mean / masses(system)[2]) / 23
        mesh = [np.abs(np.fft.rfft(run(system, table, TORQUE, s).lag[-23 * 30 :])[23]) for s in speeds]
        assert mesh_ratio(system, speeds[int(np.argmax(mesh))], table.mean) == pytest.approx(1.0, abs=0.16)
        assert max(mesh) > 3.0 * mesh[-1]

    def test_mean_of_kw_is_one(self, shifted: System) -> None:
        course = turns(shifted, 3.0)
        moved = run(shifted, tabulate(shifted, course, 300.0), 300.0, 150.0)
        assert moved.factor[-2 * 19 * 40 :].mean() == pytest.approx(1.0, abs=0.02)

    def test_teeth_part_and_do_not_pull(self, healthy: System) -> None:
        system = replace(healthy, damping=0.01)
        course = turns(system, 3.0)
        table = tabulate(system, course, 4.0)
        speed = 1.0 * math.sqrt(table.mean / masses(system)[2]) / 23
        factor = run(system, table, 4.0, speed).factor
        assert factor.min() > -1e-3
        assert factor.max() > 1.5

    def test_sensor(self) -> None:
        time = np.arange(2000) * 1e-5
        wave = np.sin(2 * np.pi * 300.0 * time)
        late = sense(Sensor(gain=1.1, delay=4e-5), wave, 1e-5)
        assert late[10:] == pytest.approx(1.1 * np.sin(2 * np.pi * 300.0 * (time[10:] - 4e-5)), abs=1e-3)
        rung = sense(Sensor(resonance=(300.0, 0.2)), wave, 1e-5)
        assert np.abs(rung[-400:]).max() == pytest.approx(2.5, rel=0.02, abs=0.0)


class TestSigns:
    """Metal missing and lateness make the wheel lag; what yields does so in proportion to the load."""

    @pytest.mark.parametrize("gear", ["pinion", "wheel"])
    @pytest.mark.parametrize(
        ("name", "more"),
        [
            ("pitch_error", {"tooth": 7, "amount_um": 10.0}),
            ("tip_relief", {"amount_um": 15.0, "length_mm": 2.0}),
            ("profile_wear", {"tip_um": 8.0, "root_um": 8.0, "pitch_um": 1.0}),
            ("profile_slope", {"amount_um": 8.0}),
            ("pitting", {"tooth": 7, "depth_um": 20.0, "centre_mm": 12.0, "width_mm": 2.0}),
            ("root_crack", {"tooth": 7, "depth_mm": 1.5}),
            ("crowning", {"amount_um": 10.0}),
            ("end_relief", {"amount_um": 10.0, "length_mm": 5.0}),
        ],
    )
    def test_lag_is_positive(self, healthy: System, gear: str, name: str, more: dict[str, float]) -> None:
        params = {"gear": gear, **more}
        if name == "pitting":
            pair = healthy.pair
            params["centre_mm"] = 1e3 * pair.pitch_roll(("pinion", "wheel").index(gear))
        change = te(Effect(name, params, 5).apply(healthy)) - te(healthy)
        assert change.max() > 0.2
        assert change.min() > -0.35 * change.max()
        if "tooth" in more:
            place = np.argmax(change) / 40.0
            assert 6.0 < place < 8.0
            assert np.abs(change[: 4 * 40]).max() < 1e-6

    def test_early_tooth_leads(self, healthy: System) -> None:
        change = te(Effect("pitch_error", {"gear": "wheel", "tooth": 5, "amount_um": -10.0}).apply(healthy)) - te(healthy)
        assert change.min() < -2.0

    def test_crack_is_proportional_to_load_and_pitch_error_is_not(self, healthy: System) -> None:
        def peak(effect: Effect, torque: float) -> float:
            return float((te(effect.apply(healthy), torque) - te(healthy, torque)).max())

        crack = Effect("root_crack", {"gear": "pinion", "tooth": 7, "depth_mm": 1.5})
        late = Effect("pitch_error", {"gear": "pinion", "tooth": 7, "amount_um": 2.0})
        assert peak(crack, 80.0) / peak(crack, 20.0) == pytest.approx(4.0, rel=0.15, abs=0.0)
        assert peak(late, 80.0) / peak(late, 20.0) < 1.6

    @pytest.mark.parametrize(("name", "params"), [("body_compliance", {"scale": 2.0}), ("contact_compliance", {"scale": 2.0})])
    def test_compliance_adds_lag_with_load(self, healthy: System, name: str, params: dict[str, float]) -> None:
        system = Effect(name, params).apply(healthy)
        low, high = ((te(system, t, 0.1) - te(healthy, t, 0.1)).mean() for t in (10.0, 80.0))
        assert 0.0 < low < high
        assert 5.5 < high / low < 8.3

    def test_supports_shift_the_mean_alone_and_lower_the_stiffness(self, healthy: System) -> None:
        system = Effect("support_compliance", {"pinion_um_per_kN": 0.5, "wheel_um_per_kN": 0.5}).apply(healthy)
        change = te(system, TORQUE, 0.2) - te(healthy, TORQUE, 0.2)
        assert np.ptp(change) < 1e-6
        assert change.mean() == pytest.approx(TORQUE / healthy.pair.pinion.base_radius / 1e3, rel=0.02, abs=0.0)
        assert static(system, turns(system, 0.1), TORQUE).slope.mean() < static(healthy, turns(healthy, 0.1), TORQUE).slope.mean()

    def test_misalignment_saturates(self, healthy: System) -> None:
        system = Effect("lead_misalignment", {"slope_um": 12.0}, 3).apply(healthy)
        change = [(te(system, t, 0.1) - te(healthy, t, 0.1)).mean() for t in (2.0, 20.0, 80.0, 160.0, 320.0)]
        assert np.all(np.array(change) > 0.0)
        assert change[4] - change[3] < 0.2 * (change[1] - change[0])

    def test_friction_jumps_at_the_pitch_point(self, healthy: System) -> None:
        """In approach friction helps the pinion, which then presses harder: the lag is larger before the pitch point."""
        system = Effect("friction", {"coefficient": 0.12}, 2).apply(healthy)
        pitch = healthy.pair.pitch
        angle = np.array([-0.12, 0.12]) * pitch
        change = static(system, angle, TORQUE).lag - static(healthy, angle, TORQUE).lag
        assert change[0] > 0.0 > change[1]

    def test_ripple_follows_its_shaft(self, healthy: System) -> None:
        params = {"gear": "wheel", "order": 3, "amplitude_Nm": 10.0, "phase_rad": 0.4}
        system = Effect("torque_ripple", params).apply(healthy)
        ratio = 23 / 41
        found = system.wobble(np.array([1.3]))
        assert found == pytest.approx(10.0 * ratio * math.cos(3 * ratio * 1.3 + 0.4), rel=1e-12, abs=0.0)

    def test_runout_readings_agree_with_the_teeth(self, healthy: System) -> None:
        """What the pitch bench reads as late is the lag at the moment that tooth stands at the pitch point."""
        for gear in (0, 1):
            params = {"gear": ("pinion", "wheel")[gear], "eccentricity_um": 6.0, "angle_rad": 1.1}
            system = Effect("runout", params).apply(healthy)
            bench = measure(system, Spec("x", "pitch_deviation", gear=gear, turns=1.0))[:20]
            angle = np.arange(20) * healthy.pair.pitch
            change = (static(system, angle, TORQUE).lag - static(healthy, angle, TORQUE).lag) * 1e6
            assert bench == pytest.approx(change, abs=0.25)
            radial = measure(system, Spec("x", "radial_runout", gear=gear, turns=1.0))
            count = healthy.pair.gears[gear].teeth
            assert int(np.argmax(radial)) == round(1.1 / (2 * math.pi) * count)
