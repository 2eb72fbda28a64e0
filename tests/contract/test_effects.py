"""What every effect of the catalogue has to keep to: one suite over all of them, and over one from outside."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from gearfem import InputError, make_setup
from gearfem.assembly import assemble
from gearfem.definition.setup import Setup
from gearfem.dynamics import make_drive
from gearfem.effects import Effect
from gearfem.effects.catalogue import catalogue, effects_from, in_history
from gearfem.foundation import Array, Record
from gearfem.pipeline import run
from gearfem.report.effect_plots import has_effects, plot_effects
from gearfem.sensing import System, observe, requests

MODEL = {
    "name": "stock rig",
    "pair": {"module_mm": 3.0, "face_width_mm": 20.0, "normal_backlash_mm": 0.004},
    "pinion": {"teeth": 20, "profile_shift": 0.1},
    "wheel": {"teeth": 30},
    "operation": {
        "pinion_torque_Nm": 120.0,
        "pinion_speed_rpm": 2000.0,
        "friction_coefficient": 0.05,
        "damping_ratio": 0.04,
        "pinion_inertia_kg_m2": 0.004,
        "wheel_inertia_kg_m2": 0.012,
    },
}
OUTSIDE = Path(__file__).parents[2] / "studies" / "effects" / "burr.py"
KNOWN = catalogue(effects_from(OUTSIDE))
EFFECTS = [(name, member) for name, kind in KNOWN.items() for member in ("pinion", "wheel") if member == "pinion" or kind.of_one_gear()]
# One gear of each in turn, where the other costs time and says the same.
EACH = [one for place, one in enumerate(EFFECTS) if place % 2 or not KNOWN[EFFECTS[place][0]].of_one_gear()]
STEP = 0.05
ANGLES = np.linspace(0.0, 2.0 * math.pi, 241)[:-1] + 0.003
SLOW = {"pinion_torque": 120.0}
FAST = {"pinion_torque": 120.0, "pinion_speed": 8000.0 * math.pi / 30.0}


@functools.cache
def rig() -> Setup:
    """Return the stock rig."""
    return make_setup(MODEL)


@functools.cache
def readings(*effects: Effect) -> dict[str, Array]:
    """Return everything that is measured on the stock rig."""
    system = assemble(rig(), effects)
    kinds = requests()
    asked = [
        kinds["static_transmission_error"](axis=ANGLES, **SLOW),
        kinds["mesh_stiffness"](axis=ANGLES, **SLOW),
        kinds["dynamic_transmission_error"](axis=ANGLES, **FAST),
        kinds["pinion_angular_acceleration"](axis=ANGLES, **FAST),
        kinds["dynamic_factor"](axis=np.array([300.0, 520.0]), **SLOW),
        *(kinds[name](axis=np.arange(20.0), gear=gear) for name in ("radial_runout", "pitch_deviation") for gear in ("pinion", "wheel")),
        *(kinds["flank_profile"](axis=np.linspace(7e-3, 14e-3, 50), gear=gear, tooth=3) for gear in ("pinion", "wheel")),
    ]
    return {f"{request.quantity} {request.gear}": observe(system, request) for request in asked}


@functools.cache
def example(name: str, member: str) -> Effect:
    """Return a typical effect on tooth 3."""
    return KNOWN[name].example(rig(), member, 3)


@functools.cache
def at(name: str, member: str, strength: float) -> Effect:
    """Return the same object for the same strength, so that its readings are taken once."""
    return example(name, member).scaled(strength, rig())


def numbers(record: object) -> Iterator[Array]:
    """Walk over all numbers of a record."""
    if isinstance(record, Record):
        for field in dataclasses.fields(record):
            yield from numbers(getattr(record, field.name))
    elif isinstance(record, tuple):
        for part in record:
            yield from numbers(part)
    elif isinstance(record, (int, float, np.ndarray)):
        yield np.asarray(record, float)


def stated(system: System, stage: str) -> object:
    """Return the record of a stage."""
    return {"contact": system.law, "flank": system.flanks, "sensing": system.instrument}.get(stage) or getattr(system, stage)


@pytest.mark.parametrize(("name", "member"), EACH)
def test_neutral_strength_gives_the_baseline_bit_for_bit(name, member):
    neutral, baseline = readings(at(name, member, 0.0)), readings()
    assert [key for key in baseline if not np.array_equal(neutral[key], baseline[key])] == []


@pytest.mark.parametrize(("name", "member"), EACH)
def test_typical_strength_shows_somewhere_and_only_where_it_can(name, member):
    changed, baseline = readings(at(name, member, 1.0)), readings()
    shown = {key for key in baseline if np.abs(changed[key] - baseline[key]).max() > 1e-4 * np.abs(baseline[key]).max()}
    assert shown
    slow = {key for key in shown if not key.startswith(("dynamic", "pinion_angular"))}
    if name in ("damping", "backlash", "sensor_lag", "sensor_resonance"):
        assert not slow


@pytest.mark.parametrize(("name", "member"), EACH)
def test_response_starts_with_a_finite_slope(name, member):
    """Differences over h and 2 h agree to the order h: nothing jumps and nothing waits at neutral strength."""
    baseline, full = readings(), readings(at(name, member, 1.0))
    near, far = readings(at(name, member, STEP)), readings(at(name, member, 2.0 * STEP))
    for key, rest in baseline.items():
        # The largest of a turn's values has a kink wherever it changes its place; accelerations jump where teeth meet.
        if key.startswith(("dynamic_factor", "pinion_angular")):
            continue
        one, two = (near[key] - rest) / STEP, (far[key] - rest) / (2.0 * STEP)
        # Splines of worn flanks differ from those of unworn ones by 1e-8; the slow engagement is solved to 1e-11.
        floor = 1e-8 * rms(rest) / STEP
        assert rms(one - two) <= 3.0 * STEP * (rms(one) + rms(full[key] - rest)) + floor, key


def rms(values: Array) -> float:
    """Return the root mean square."""
    return math.sqrt(float(np.mean(values**2)))


@pytest.mark.parametrize("stage", ["flank", "compliance", "placement", "contact", "drive", "sensing"])
def test_effects_of_a_stage_commute(stage):
    """Or their order is that of the part's history, whatever order they are given in."""
    kinds = [(name, member) for name, member in EFFECTS if KNOWN[name].stage == stage]
    plain = assemble(rig())
    for first, second in itertools.combinations(kinds, 2):
        pair = example(*first), example(*second)
        if pair[0].name == pair[1].name and pair[0].replaces:
            continue
        results = []
        for order in (pair, pair[::-1]):
            record = make_drive(rig()) if stage == "drive" else stated(plain, stage)
            for effect in in_history(order):
                record = effect.act(record, rig())
            results.append(sorted(float(part.sum()) for part in numbers(record)))
        assert results[0] == pytest.approx(results[1], rel=1e-12, abs=0.0), (first, second)


@pytest.mark.parametrize("name", [name for name, kind in KNOWN.items() if kind.either_gear])
def test_what_either_gear_may_have_reads_the_same_on_both(name):
    effect = example(name, "pinion")
    own, other = readings(effect), readings(dataclasses.replace(effect, gear="wheel"))
    assert all(np.array_equal(values, other[quantity]) for quantity, values in own.items())
    assert any(not np.array_equal(values, other) for values, other in zip(own.values(), readings().values(), strict=True))


@pytest.mark.parametrize(("name", "member"), EFFECTS)
def test_a_model_file_holds_every_effect(name, member):
    effect = example(name, member)
    read = make_setup({**MODEL, "effect": [effect.table()]}, effects=[KNOWN[name]]).effects
    assert [type(found) for found in read] == [type(effect)]
    assert [float(part) for part in numbers(read[0])] == pytest.approx([float(part) for part in numbers(effect)], rel=1e-11, abs=0.0)
    assert name in KNOWN
    assert not effect.of_one_gear() or member in effect.describe()


@pytest.mark.parametrize(("name", "member"), EFFECTS)
def test_nothing_beyond_the_bounds_is_taken(name, member):
    effect = example(name, member)
    effect.check(rig())
    for field, known in effect.parameters().items():
        for bound, beyond in zip(known.bounds(rig(), member), (-1.0, 1.0), strict=True):
            if not math.isfinite(bound):
                continue
            dataclasses.replace(effect, **{field: bound}).check(rig())
            with pytest.raises(InputError) as refusal:
                dataclasses.replace(effect, **{field: bound + beyond * (1e-9 + 0.01 * abs(bound))}).check(rig())
            assert refusal.value.where == effect.key(field)
    with pytest.raises(InputError, match="nearest valid name"):
        make_setup({**MODEL, "effect": [{**effect.table(), "name": name[:-1] + "x"}]}, effects=[KNOWN[name]])


def test_effects_outside_the_package_are_found_by_their_file_alone():
    (kind,) = effects_from(OUTSIDE)
    assert kind.name not in catalogue()
    assert len(OUTSIDE.read_text().splitlines()) < 60
    readme = Path(__file__).parents[2] / "README.md"
    assert OUTSIDE.read_text() in readme.read_text()


def test_an_effect_from_outside_gets_its_row_and_picture_in_the_report():
    burr = KNOWN["burr"].example(rig(), "wheel", 7)
    results = run(make_setup({**MODEL, "effect": [burr.table()]}, effects=[KNOWN["burr"]]), until="compliance")
    assert f"Effect: {burr.describe()}." in results.assumptions
    assert has_effects(results)
    before, after = (line.get_ydata() for line in plot_effects(results).axes[0].get_lines())
    # The wheel's tooth comes early: it runs ahead by up to the height of the burr.
    assert -3.0 * 2.0 <= (after - before).min() < -1.0


def test_an_effect_from_outside_is_recovered_by_fitting_within_its_bounds():
    """Least squares over its declared parameters, from its typical values: all that a fit needs is in the class."""
    kind = KNOWN["burr"]
    fields = kind.parameters()
    bounds = np.array([known.bounds(rig(), "pinion") for known in fields.values()])
    start = np.array([known.typically(rig(), "pinion") for known in fields.values()])
    true = start * (1.6, 0.8)
    angle = np.linspace(-1.0, 1.5, 150) * math.pi / 10.0

    def reading(values: Array) -> Array:
        effect = kind(gear="pinion", tooth=0, **dict(zip(fields, values, strict=True)))
        request = requests()["static_transmission_error"](axis=angle, pinion_torque=20.0)
        return observe(assemble(rig(), [effect]), request)

    measured = reading(true)
    fit = least_squares(
        lambda part: (reading(part * start) - measured) * 1e6, np.ones(2), bounds=(bounds / start[:, None]).T, diff_step=1e-3
    )
    assert fit.x * start == pytest.approx(true, rel=1e-3, abs=0.0)
