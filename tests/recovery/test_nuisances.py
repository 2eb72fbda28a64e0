"""Nuisances hidden in the records of a pair of springs: found, told from a gap, and the gap located."""

from __future__ import annotations

import contextlib
import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gearfem.assembly import assemble
from gearfem.diagnosis.comparing.compare import compare
from gearfem.diagnosis.comparing.comparison import Comparison
from gearfem.diagnosis.comparing.magnitudes import FIT, refuse_magnitudes, speed_misfits
from gearfem.diagnosis.localising.localise import localise
from gearfem.diagnosis.localising.zones import ZONES, in_zones, leading_teeth
from gearfem.diagnosis.modelling.bench import Oscillator, Settings, Swing, Weights, neutral
from gearfem.diagnosis.modelling.mesh_lines import mesh_lines
from gearfem.diagnosis.modelling.nuisances import BUILD
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.modelling.teeth import Scatter, respond, tooth_columns
from gearfem.diagnosis.proving.smooth import fit_smooth
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.diagnosis.reading.measurement import Measurement, make_record
from gearfem.diagnosis.reading.noise import measure_noise
from gearfem.diagnosis.reading.roles import Role
from gearfem.dynamics import DriveTrain
from gearfem.dynamics.linear_train import linear_train
from gearfem.engagement.turns import Turns, static
from gearfem.foundation import Array, InputError, SolveError
from gearfem.foundation.units import RPM, UM
from gearfem.model import make_setup

SETUP = make_setup(
    {
        "pair": {"module_mm": 3.0, "face_width_mm": 20.0},
        "pinion": {"teeth": 17},
        "wheel": {"teeth": 22},
        "operation": {"pinion_torque_Nm": 100.0, "pinion_speed_rpm": 1000.0},
    }
)
PAIR = SETUP.pair
PITCH = PAIR.pinion.pitch_angle
STD = 5e-8
SCATTER = Scatter(terms=2)


# 4 kg on both base circles, 2 kg on the line of action: psi1'' = 10 e''.
TWO_INERTIAS = linear_train(
    DriveTrain(
        pinion_inertia=4.0 * 0.05**2,
        wheel_inertia=4.0 * 0.1**2,
        pinion_torque=100.0,
        wheel_torque=200.0,
        efficiency=1.0,
        pinion_speed=100.0,
        friction_coefficient=0.0,
        damping_ratio=0.08,
    ),
    0.05,
    0.1,
)


class Springs(SystemBench):
    """Tooth pairs as springs of constant stiffness, with parabolic gaps beyond the path of contact: closed forms in place of the system."""

    stiffness = 2e8

    def shared(self, angle: Array, torque: float, settings: Settings) -> tuple[Array, Weights]:
        """Return transmission error and weights: the active pairs are the first n by gap, for the n that makes the error least."""
        place = angle / PITCH
        number = np.round(place).astype(int)[:, None] + np.arange(-2, 3)
        path = (place[:, None] - number) * PAIR.base_pitch
        beyond = np.maximum(path - PAIR.recess_length, 0.0) + np.maximum(-PAIR.approach_length - path, 0.0)
        gap = 6.0 * beyond**2 + settings.pinion_late[number % 17] + settings.wheel_late[number % 22]
        order = np.argsort(gap, axis=1)
        ranked = np.take_along_axis(gap, order, axis=1)
        own = self.stiffness * settings.stiffness_scale
        force = torque * settings.torque_scale / PAIR.pinion.base_radius
        count = np.arange(1, 6)
        error = (force / own + np.cumsum(ranked, axis=1)) / count
        best = np.argmin(error, axis=1)
        active = np.argsort(order, axis=1) <= best[:, None]
        weight = active / (best[:, None] + 1.0)
        return error[np.arange(len(angle)), best], Weights(pairs=number, pinion=weight, wheel=weight)

    def predict(self, record: Measurement, settings: Settings) -> Array:
        if record.quantity.moving:
            return accelerated(record.axis, record.pinion_speed)
        return settings.gain * self.shared(record.axis + settings.angle_offset, record.pinion_torque, settings)[0]

    def weights(self, angle: Array, torque: float, settings: Settings) -> Weights:
        return self.shared(angle, torque, settings)[1]

    def oscillator(self, torque: float, settings: Settings) -> Oscillator:
        return Oscillator(frequency=5e3, ratio=0.08, fastest=5e3, slowest=400.0, acceleration=10.0)

    def swing(self, angle: Array, torque: float, speed: float, settings: Settings, kick: tuple[float, float] = (0.0, 0.0)) -> Swing:
        steady = np.full(len(angle), 2.0 * 5e3**2)
        weights = self.weights(angle, torque, settings)
        return Swing(weights=weights, shares=weights, stiffness=steady, damping=2.0 * 800.0, train=TWO_INERTIAS, base1=0.05, base2=0.1)


# Without errors of the model: what these springs measure they also predict.
SPRINGS = Springs(system=assemble(SETUP), errors=())


def hidden(seed: int) -> Settings:
    rng = np.random.default_rng(seed)
    return Settings(
        pinion_late=rng.normal(0.0, 1e-6, 17),
        wheel_late=rng.normal(0.0, 1e-6, 22),
        angle_offset=-0.31 * PITCH,
        torque_scale=1.008,
        stiffness_scale=0.94,
        gain=1.01,
    )


def campaign(seed: int, extra: dict[float, Array] | None = None) -> Campaign:
    """Return four slow records of the springs with everything wrong that is wrong in every rig."""
    rng = np.random.default_rng(100 + seed)
    axis = 0.02 + np.arange(1400) * 4.1 * math.pi / 1400.0
    records = []
    for torque, role in ((10.0, "fit"), (60.0, "fit"), (150.0, "fit"), (100.0, "holdout")):
        stated = {"file": f"te_{torque:.0f}.csv", "pinion_torque": torque, "noise_std": STD, "role": role}
        record = make_record("static_transmission_error", axis, **stated)
        value = SPRINGS.predict(record, hidden(seed)) + rng.normal(0.0, STD, 1400) + rng.normal(0.0, 1e-5)
        records.append(dataclasses.replace(record, value=value + (extra or {}).get(torque, 0.0)))
    return Campaign(name="springs", path="campaign.toml", model="model.toml", setup=SETUP, angle_known=False, records=tuple(records))


def true_angle() -> Array:
    return campaign(1).records[0].axis + hidden(1).angle_offset


@pytest.fixture(scope="module")
def healthy() -> Comparison:
    return compare(campaign(1), SCATTER, lambda _: SPRINGS)


def test_hidden_nuisances_are_found_down_to_the_noise(healthy: Comparison) -> None:
    truth = hidden(1)
    for shift in healthy.shifts:
        assert shift.value == pytest.approx(getattr(truth, shift.name), rel=0.0, abs=4.0 * shift.stderr), shift.name
    late = np.concatenate([healthy.settings.pinion_late, healthy.settings.wheel_late])
    wanted = np.concatenate([truth.pinion_late, truth.wheel_late])
    problem = healthy.problem
    deviations = problem.linear.weighed(healthy.alone.point.weights).deviations
    stderr = SCATTER.index * deviations[problem.unknowns.late.start - problem.outer :: 3][: len(wanted)]
    # Only sums of both gears act, so that a part common to all teeth of one gear stays at its prior, and stderr holds it.
    assert np.sqrt(np.mean(((late - wanted) / stderr) ** 2)) < 1.5
    assert np.std(late[:17] - wanted[:17]) < 2e-7
    assert np.std(late[17:] - wanted[17:]) < 2e-7
    for record in healthy.records:
        assert record.rms(record.after) == pytest.approx(STD, rel=0.1, abs=0.0)
        assert record.rms(record.before) > 5.0 * STD


def test_chi_square_is_that_of_noise(healthy: Comparison) -> None:
    rows = len(healthy.alone.white)
    assert healthy.chi_square == pytest.approx(rows, abs=5.0 * math.sqrt(2.0 * rows))


def test_hold_out_records_are_not_looked_at(healthy: Comparison) -> None:
    assert [record.measurement.file for record in healthy.records] == ["te_10.csv", "te_60.csv", "te_150.csv"]
    blind = campaign(1)
    spoilt = dataclasses.replace(blind.records[3], value=2.0 * blind.records[3].value)
    again = compare(dataclasses.replace(blind, records=(*blind.records[:3], spoilt)), SCATTER, lambda _: SPRINGS)
    assert again.chi_square == healthy.chi_square


def test_no_gap_where_nothing_is_missing(healthy: Comparison) -> None:
    found = localise(healthy, draws=120)
    assert not found.gap
    assert found.where == ()
    assert found.p_value > 0.01


@pytest.mark.parametrize(("zone", "torques"), [("double_exit", (60.0, 150.0)), ("recess", (10.0, 60.0, 150.0))])
def test_a_gap_is_found_in_its_zone(zone: str, torques: tuple[float, ...]) -> None:
    inside = in_zones(true_angle(), PAIR)[:, ZONES.index(zone)]
    ripple = np.where(inside, 8e-8 * np.sin(40.0 * math.pi * true_angle() / PITCH), 0.0)
    found = localise(compare(campaign(1, dict.fromkeys(torques, ripple)), SCATTER, lambda _: SPRINGS), draws=120)
    assert found.gap
    named = {place.record: place.zone for place in reversed(found.where) if place.domain == "mesh_phase"}
    assert {named[f"te_{torque:.0f}.csv"] for torque in torques} == {zone}


def test_a_gap_of_one_tooth_is_found_there() -> None:
    tooth, _ = leading_teeth(true_angle(), PAIR)
    ripple = np.where(tooth == 5, 1.5e-7 * np.sin(40.0 * math.pi * true_angle() / PITCH), 0.0)
    found = localise(compare(campaign(1, {60.0: ripple, 150.0: ripple}), SCATTER, lambda _: SPRINGS), draws=120)
    teeth = [place.zone for place in found.where if place.domain == "tooth" and place.zone.startswith("pinion")]
    assert teeth[0] == "pinion:5"
    assert found.sentence.startswith("Cells stand out")


def test_columns_of_teeth_are_derivatives() -> None:
    record = campaign(1).records[1]
    settings = hidden(1)
    columns = tooth_columns(record, SPRINGS, settings, SCATTER)
    for tooth in (3, 17 + 9):
        moved = []
        for sign in (1.0, -1.0):
            late = [settings.pinion_late.copy(), settings.wheel_late.copy()]
            late[tooth >= 17][tooth % 17 if tooth < 17 else tooth - 17] += sign * 1e-12
            moved.append(SPRINGS.predict(record, dataclasses.replace(settings, pinion_late=late[0], wheel_late=late[1])))
        slope = (moved[0] - moved[1]) / 2e-12
        assert np.quantile(np.abs(columns[:, 3 * tooth] - slope), 0.99) < 1e-5


def test_errors_come_through_at_speed_as_the_oscillator_says() -> None:
    step, rate = 1e-5, 3.1e3
    time = step * np.arange(60000)
    swing = SPRINGS.swing(time, 1.0, 1.0, neutral(PAIR))
    errors, rates = np.sin(rate * time)[:, None], rate * np.cos(rate * time)[:, None]
    moving = respond(errors, rates, swing, step, acceleration=False)[40000:, 0]
    damped = 2j * 0.08 * rate / 5e3
    gain = (1.0 + damped) / (1.0 - (rate / 5e3) ** 2 + damped)
    # Newmark's waves are (5e3 step)^2/12 too long, which a gain of 1.6 below resonance doubles.
    assert moving == pytest.approx(np.imag(gain * np.exp(1j * rate * time[40000:])), abs=8e-4)
    shaken = respond(errors, rates, swing, step, acceleration=True)[40000:, 0]
    assert shaken == pytest.approx(-10.0 * rate**2 * np.imag(gain * np.exp(1j * rate * time[40000:])), abs=1e-3 * 10.0 * rate**2)


def test_errors_come_through_a_stiffness_that_varies_as_an_integrator_says() -> None:
    step, rate, natural = 2e-6, 3.1e3, 5e3
    time = step * np.arange(20000)
    stiffness = 2.0 * natural**2 * (1.0 + 0.2 * np.sin(2.1 * rate * time))
    swing = dataclasses.replace(SPRINGS.swing(time, 1.0, 1.0, neutral(PAIR)), stiffness=stiffness)
    errors, rates = np.sin(rate * time)[:, None], rate * np.cos(rate * time)[:, None]

    def slope(t: float, state: Array) -> list[float]:
        stiff, off, fast = np.interp(t, time, stiffness), np.sin(rate * t) - state[0], rate * np.cos(rate * t) - state[1]
        return [state[1], (stiff * off + 1600.0 * fast) / 2.0]

    wanted = solve_ivp(slope, (0.0, time[-1]), [0.0, 0.0], t_eval=time, rtol=1e-8, atol=1e-10, max_step=step).y[0]
    # Straight lines between the samples of the stiffness, and waves (omega step)^2/12 too long.
    assert respond(errors, rates, swing, step, acceleration=False)[:, 0] == pytest.approx(wanted, abs=2e-3)


def test_zones_cover_the_cycle_once() -> None:
    phase = (np.arange(5000) + 0.5) / 5000.0
    inside = in_zones(phase * PITCH, PAIR)
    share = dict(zip(ZONES, inside.mean(axis=0), strict=True))
    assert share["double_entry"] + share["double_exit"] == pytest.approx(PAIR.contact_ratio - 1.0, abs=1e-3)
    assert share["approach"] + share["recess"] == pytest.approx(share["single"], abs=1e-12)
    weights = SPRINGS.weights(phase * PITCH, 1e-3, neutral(PAIR)).pinion
    alone = (weights > 0.0).sum(axis=1) == 1
    assert np.mean(alone == inside[:, ZONES.index("single")]) > 0.99


@pytest.mark.parametrize("noise", [1.0, 1e3])
def test_a_record_in_nanometres_is_refused(noise: float) -> None:
    """Whatever unit its noise is stated in."""
    whole = campaign(1)
    records = tuple(dataclasses.replace(record, value=1e3 * record.value, noise_std=noise * STD) for record in whole.records)
    with pytest.raises(InputError, match=r"te_10.csv: column transmission_error_um.*wrong by 10\^3"):
        compare(dataclasses.replace(whole, records=records), SCATTER, lambda _: SPRINGS)


def accelerated(axis: Array, speed: float) -> Array:
    """Return the pinion's acceleration at a speed [rad/s], rung down from ninety pitches before the record on."""
    step = axis[1] - axis[0]
    angle = axis[0] + step * np.arange(-8000, len(axis))
    slow = SPRINGS.shared(angle, 100.0, neutral(PAIR))[0][:, None]
    return respond(slow, np.zeros_like(slow), SPRINGS.swing(angle, 100.0, speed, neutral(PAIR)), step / speed, acceleration=True)[8000:, 0]


def shaken(speed: float, stated: float) -> Measurement:
    """Return a record of the acceleration at one speed [rad/s] that states another one."""
    axis = np.arange(3000) * PITCH / 90.0
    value = accelerated(axis, speed) + np.random.default_rng(1).normal(0.0, 0.1, 3000)
    return make_record("pinion_angular_acceleration", axis, value, pinion_torque=100.0, pinion_speed=stated, noise_std=0.1)


def test_a_speed_that_no_mesh_line_fits_is_refused() -> None:
    whole = campaign(1)
    right = dataclasses.replace(whole, angle_known=True, records=(shaken(60.0, 60.0),))
    refuse_magnitudes(right, SPRINGS)
    wrong = dataclasses.replace(right, records=(shaken(60.0, 60.0 * RPM),))
    with pytest.raises(InputError, match=r"pinion_speed_rpm.*given in rad/s"):
        refuse_magnitudes(wrong, SPRINGS)


def test_lines_that_single_teeth_make_tell_nothing_of_a_speed() -> None:
    """Far above resonance, where the mesh moves little: scatter that returns with each turn is no noise."""
    record, turn = shaken(400.0, 400.0), PAIR.pinion.teeth * 90
    scatter = np.resize(np.random.default_rng(2).normal(0.0, 3000.0, turn), record.value.size)
    lines, made = (np.abs(mesh_lines(record.axis, value, PITCH)) for value in (record.value, scatter))
    assert lines[0] > 5.0 * made[0]
    assert made[4:].max() > 2.0 * lines[4:].max()
    assert speed_misfits(dataclasses.replace(record, value=record.value + scatter), SPRINGS)["rpm"] < 0.5 * FIT


@pytest.mark.parametrize("role", ["fit", "holdout"])
@pytest.mark.parametrize("factor", [0.1, 10.0, 1000.0])
def test_values_and_noise_in_another_unit_are_refused(factor: float, role: Role) -> None:
    whole = campaign(1)
    last = whole.records[3]
    refuse_magnitudes(whole, SPRINGS)
    wrong = dataclasses.replace(last, value=factor * last.value, role=role)
    with pytest.raises(InputError, match=r"te_100.csv: column transmission_error_um.*(noise_std|wrong by 10)"):
        refuse_magnitudes(dataclasses.replace(whole, records=(*whole.records[:3], wrong)), SPRINGS)


def test_the_smooth_correction_stays_as_large_as_the_gap_over_a_part_of_a_turn() -> None:
    """A mesh stiffness has no constant of its own that could hide what the slow waves of a short record add up to."""
    axis = np.linspace(0.3, 0.9, 300)
    true = 1e7 * (1.0 + 0.5 * np.cos(17.0 * axis))
    record = make_record("mesh_stiffness", axis, true, pinion_torque=100.0, noise_std=2e5)
    left = true + np.random.default_rng(4).normal(0.0, 2e5, len(axis))
    noise = measure_noise(record, PAIR)
    smooth = fit_smooth((record,), (noise,), (left,), PAIR, 0.0)["mesh_stiffness"]
    assert np.sqrt(np.mean((left - smooth.at(record)) ** 2)) < 2.2e5


def test_the_smooth_correction_leaves_lines_that_few_rows_confuse_as_small_as_they_are() -> None:
    """At eight rows to a pitch line 5 of the mesh looks like line 3 but for the last digit of the angle; shares of either are anything."""
    pitch, random = PAIR.pinion.pitch_angle, np.random.default_rng(4)

    def record(torque: float, rows: float) -> Measurement:
        axis = np.round(np.arange(0.0, 40.0, 1.0 / rows) * pitch, 8)
        return make_record("static_transmission_error", axis, pinion_torque=torque, noise_std=1e-7)

    fitted, planned = (record(20.0, 72.0), record(150.0, 8.0)), record(80.0, 72.0)
    left = tuple(1e-6 * np.cos(PAIR.pinion.teeth * one.axis) + random.normal(0.0, 1e-7, len(one.axis)) for one in fitted)
    smooth = fit_smooth(fitted, tuple(measure_noise(one, PAIR) for one in fitted), left, PAIR, 0.0)["static_transmission_error"]
    assert smooth.at(planned) == pytest.approx(1e-6 * np.cos(PAIR.pinion.teeth * planned.axis), rel=0.0, abs=1e-6)


@pytest.mark.parametrize(("beyond", "solved"), [(0.0, True), (0.6, False)])
def test_load_sharing_has_a_solution_as_far_as_coupling_may_go(beyond: float, solved: bool) -> None:
    """Bodies soft and contact hard by four deviations, edges nearly sharp, and teeth five times as uneven as usual; farther it has none."""
    gears = {
        "pinion": {"teeth": 23, "profile_shift": 0.3, "bore_radius_mm": 10.0},
        "wheel": {"teeth": 41, "profile_shift": 0.1, "bore_radius_mm": 20.0},
    }
    rated = {"pinion_torque_Nm": 120.0, "pinion_speed_rpm": 1000.0}
    bench = SystemBench(system=assemble(make_setup({"pair": {"module_mm": 2.5, "face_width_mm": 25.0}, **gears, "operation": rated})))
    (coupling,) = (nuisance for nuisance in BUILD if nuisance.name == "coupling_scale")
    wild, random = {"contact_scale": -4.0, "body_scale": 4.0}, np.random.default_rng(5)
    settings = dataclasses.replace(
        neutral(bench.system.setup.pair),
        coupling_scale=coupling.value(coupling.room[1] + beyond),
        tip_edge_scale=0.05,
        evenness=0.8,
        errors=tuple(wild.get(variant.name, 0.0) for variant in bench.errors),
        pinion_late=5.0 * UM * random.standard_normal(23),
        wheel_late=5.0 * UM * random.standard_normal(41),
    )
    angles = np.linspace(0.0, 24.0 * math.pi / 23.0, 720)
    with contextlib.nullcontext() if solved else pytest.raises(SolveError):
        assert np.isfinite(static(Turns(mesh=bench._system(settings).mesh), angles, 120.0, 0.1).transmission_error).all()
