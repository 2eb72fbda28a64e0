"""Nuisances that do the work of an effect: what they cost, and how the effect is found all the same."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np
import pytest

from gearfem.diagnosis import choose, compare, rank, read_campaign
from gearfem.diagnosis.comparing.averages import averaged
from gearfem.diagnosis.comparing.comparison import Comparison
from gearfem.diagnosis.fitting.approach import lost
from gearfem.diagnosis.fitting.fit import Fit, again
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.straying import beyond, halves
from gearfem.diagnosis.naming.screen import in_place, screened
from gearfem.effects.body_compliance import BodyCompliance
from gearfem.effects.catalogue import catalogue
from gearfem.effects.contact_compliance import ContactCompliance
from gearfem.effects.sensor_gain import SensorGain
from gearfem.effects.support_compliance import SupportCompliance
from gearfem.foundation.progress import quiet
from gearfem.variants import VARIANTS
from tests.recovery import rig
from tests.recovery.rig import PLAN, on_the_rig

KINDS = choose(catalogue(), ["body_compliance", "contact_compliance", "tip_relief"])
SCALE = 3.0
RECORD = {"samples_per_turn": 234, "turns": 1.4}
# Mesh stiffness has no constant of its own: without it nobody sees what bodies add to every load position alike.
RECORDS = [
    {"file": f"{name}_{torque:g}Nm.csv", "quantity": quantity, "pinion_torque_Nm": torque} | RECORD
    for name, quantity in (("te", "static_transmission_error"), ("stiffness", "mesh_stiffness"))
    for torque in (40.0, 120.0)
]


@pytest.fixture(scope="module")
def veiled(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    """Compare a pair whose bodies yield three times as much as computed."""
    hidden = {"effect": [{"name": "body_compliance", "scale": SCALE}]}
    return compare(read_campaign(on_the_rig(tmp_path_factory.mktemp("veiled"), hidden, PLAN | {"record": RECORDS})))


def test_a_nuisance_costs_more_than_its_prior_from_three_deviations_on() -> None:
    assert beyond(np.array([0.0, -2.0, 3.0, -4.0, 5.0, 7.0])).tolist() == [0.0, 0.0, 0.0, 0.5, 1.0, 2.0]


@pytest.mark.parametrize("moved", [0.0, 2.5, -3.7, 4.2, 6.0])
def test_its_slope_and_curvature_are_those_of_what_it_costs(moved: float) -> None:
    step = 1e-3
    below, here, above = beyond(moved + step * np.array([-1.0, 0.0, 1.0])) ** 2
    slope, bend = halves(np.array([moved]))
    assert 2.0 * slope[0] == pytest.approx((above - below) / (2.0 * step), abs=1e-9)
    assert 2.0 * bend[0] == pytest.approx((above - 2.0 * here + below) / step**2, abs=1e-6)


@pytest.mark.parametrize(("moved", "levels"), [(2.9, 0.0), (4.0, 0.25), (-5.0, 1.0)])
def test_the_objective_holds_what_straying_costs(veiled: Comparison, monkeypatch: pytest.MonkeyPatch, moved: float, levels: float) -> None:
    problem, unknown = veiled.problem, np.zeros_like(veiled.alone.point.unknown)
    unknown[next(i for i, nuisance in enumerate(problem.nuisances) if nuisance.name == "gain")] = moved
    with_cost, detected = problem.at((), unknown).objective, problem.detected
    monkeypatch.setattr(Problem, "detected", 0.0)
    assert with_cost - problem.at((), unknown).objective == pytest.approx(levels * detected, rel=1e-9, abs=1e-6)


def _in_means(veiled: Comparison) -> tuple[Problem, Fit]:
    mean = averaged(veiled.problem, veiled.alone.settings)
    return mean, again(mean, (), mean.unknowns.of(veiled.alone.settings))


def test_an_effect_whose_work_nuisances_do_is_found_where_they_stand_as_the_model_has_them(veiled: Comparison) -> None:
    problem, alone = _in_means(veiled)
    astray = beyond(alone.point.unknown[problem.unknowns.wrong])
    assert [variant.name for variant, far in zip(VARIANTS, astray, strict=True) if far > 0.0] == ["body_scale"]
    candidates = rank(problem, alone, KINDS)
    ((nearest,), _), *_ = screened(problem, alone, candidates, quiet)
    assert isinstance(nearest, BodyCompliance)
    assert nearest.scale == pytest.approx(SCALE, rel=0.1, abs=0.0)
    # Another one does what the error does, in its place.
    (((effect,), unknown),) = in_place(problem, alone.point.unknown, candidates)
    error = float(alone.point.unknown[problem.unknowns.wrong][1])
    assert isinstance(effect, BodyCompliance)
    assert effect.scale == pytest.approx(1.2**error, rel=1e-9, abs=0.0)
    assert unknown[problem.unknowns.wrong].tolist()[1] == 0.0
    assert np.count_nonzero(unknown != alone.point.unknown) == 1


def test_effects_in_the_place_of_what_strays_do_the_same(veiled: Comparison) -> None:
    problem, unknown = veiled.problem, np.zeros_like(veiled.alone.point.unknown)
    gain = next(i for i, nuisance in enumerate(problem.nuisances) if nuisance.name == "gain")
    unknown[[gain, problem.unknowns.wrong.start, problem.unknowns.wrong.start + 1]] = 4.0, -3.5, 2.0
    before = problem.predict((), unknown)
    kinds = {kind.name: kind for kind in (SensorGain, ContactCompliance, BodyCompliance)}
    starts = list(in_place(problem, unknown, rank(problem, veiled.alone, kinds)))
    assert [(type(effect), effect.scale) for (effect,), _ in starts] == [(SensorGain, np.exp(4.0 * 0.02)), (ContactCompliance, 1.3**-3.5)]
    for effects, without in starts:
        for one, other in zip(problem.predict(effects, without), before, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(other).max())


def test_effects_that_slow_records_do_not_feel_are_not_screened(veiled: Comparison) -> None:
    problem, alone = _in_means(veiled)
    assert screened(problem, alone, (), quiet) == []


@pytest.mark.slow
def test_what_motions_alone_show_is_found_where_nuisances_have_taken_its_resonance(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A little of it leaves less beside nuisances far off than all of it does beside right ones, until columns are taken there."""
    heavy = {"pinion_inertia_kg_m2": 0.0273, "wheel_inertia_kg_m2": 0.0327, "damping_ratio": 0.1}
    monkeypatch.setattr(rig, "NOMINAL", rig.NOMINAL | {"operation": rig.NOMINAL["operation"] | heavy})
    motion = {"quantity": "dynamic_transmission_error", "pinion_torque_Nm": 60.0, "samples_per_turn": 234, "turns": 1.4}
    motions = [motion | {"file": f"{speed:g}rpm.csv", "pinion_speed_rpm": speed} for speed in (3900.0, 6800.0)]
    supports = SupportCompliance(pinion=2.3e-9, wheel=1.4e-9)
    hidden = {"effect": [{"name": "support_compliance", "pinion_um_per_kN": 2.3, "wheel_um_per_kN": 1.4}]}
    comparison = compare(read_campaign(on_the_rig(tmp_path, hidden, PLAN | {"record": [*PLAN["record"][1:3], *motions]})))
    mean = averaged(comparison.problem, comparison.alone.settings)
    alone = again(mean, (), mean.unknowns.of(comparison.alone.settings))
    assert lost(mean, alone)
    right = again(copy.copy(mean), (supports,), mean.unknowns.neutral(alone.point.unknown))
    (found,) = rank(mean, alone, choose(catalogue(), ["support_compliance"]))
    assert found.gain > 0.9 * (alone.objective - right.objective)
