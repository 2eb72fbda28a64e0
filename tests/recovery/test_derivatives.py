"""Derivatives over the parameters of effects, as fits take them."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from gearfem.diagnosis.fitting import parameters
from gearfem.diagnosis.fitting.fit import _corrected, jacobian
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.bench import neutral
from gearfem.diagnosis.modelling.columns import make_columns
from gearfem.effects.effect import Effect
from gearfem.effects.pitting import Pitting
from gearfem.effects.sensor_lag import SensorLag
from gearfem.effects.tip_relief import TipRelief
from gearfem.foundation import Array
from gearfem.foundation.units import MM, UM
from tests.recovery.rig import PLAN, beside_nuisances

SLOW = PLAN["record"][-1]
ACCELERATION = {"file": "motion.csv", "quantity": "pinion_angular_acceleration", "pinion_torque_Nm": 100.0, "pinion_speed_rpm": 40000.0} | {
    "samples_per_turn": 520,
    "turns": 1.4,
}


def over_much_shorter_steps(problem: Problem, effect: Effect, unknown: Array) -> Array:
    """Return the whitened derivatives by central differences of a hundred-thousandth of the parameters' sizes."""
    values, sizes = parameters.values((effect,)), parameters.sizes((effect,), problem.campaign.setup)
    columns = []
    for place, size in enumerate(1e-5 * sizes):
        sides = []
        for step in (size, -size):
            ahead = values.copy()
            ahead[place] += step
            sides.append(problem.whiten(problem.predict(parameters.moved((effect,), ahead), unknown)))
        columns.append((sides[0] - sides[1]) / (2.0 * size))
    return np.column_stack(columns)


@pytest.mark.parametrize(
    ("effect", "record", "most", "leaps", "most_else"),
    [
        (Pitting(gear="pinion", tooth=3, depth=3.0 * UM, centre=7.0 * MM, width=4.0 * MM), SLOW, 0.3, 5, 0.06),
        (TipRelief(gear="wheel", amount=14.0 * UM, length=2.5 * MM), SLOW, 0.1, 0, 0.1),
        (SensorLag(delay=12e-6), ACCELERATION, 0.1, 0, 0.1),
    ],
    ids=["pit", "relief", "delay"],
)
def test_derivatives_are_those_of_what_is_predicted(
    tmp_path: Path, effect: Effect, record: dict[str, object], most: float, leaps: int, most_else: float
) -> None:
    """Steps ten times as long put those over a pit off by half, and those over a delay by more: fits stood still.

    Contact leaps over the ends of a pit, so that some rows leap too as it moves: no step is short enough for these. All others are met more
    closely; steps ten times as long put them off by a tenth.
    """
    shown = beside_nuisances(tmp_path, [], [record])
    problem = shown.problem
    point = problem.at((effect,), shown.base.point.stood)
    found = jacobian(problem, point)[:, : len(effect.fitted())]
    exact = over_much_shorter_steps(problem, effect, point.stood)
    apart = np.linalg.norm(found - exact, axis=0) / np.linalg.norm(exact, axis=0)
    assert apart.max() < most, apart
    for own, column in zip(found.T, exact.T, strict=True):
        stay = np.argsort(np.abs(own - column))[: len(column) - leaps]
        assert np.linalg.norm((own - column)[stay]) < most_else * np.linalg.norm(column[stay])


def test_derivatives_stay_where_only_index_errors_have_moved(tmp_path: Path) -> None:
    """What a step of no parameter shows is nothing that they could be corrected by: they became no numbers."""
    shown = beside_nuisances(tmp_path, [], [SLOW])
    problem, effect, unknown = shown.problem, TipRelief(gear="wheel", amount=14.0 * UM, length=2.5 * MM), shown.base.point.stood
    elsewhere = unknown.copy()
    elsewhere[problem.unknowns.late] += 0.5
    before, after = problem.at((effect,), unknown), problem.at((effect,), elsewhere)
    found = jacobian(problem, before)
    assert np.array_equal(_corrected(problem, found, before, after), found)


def test_columns_of_all_nuisances_are_the_same_on_one_core_and_on_several(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of nuisances and errors of the model, in the places that both have among the unknowns: each child makes one of them."""
    problem = beside_nuisances(tmp_path, [], [SLOW, ACCELERATION]).problem
    unknown = problem.unknowns.of(neutral(problem.campaign.setup.pair))
    arguments = (problem.records, problem.noises, problem.unknowns, problem.bench(()), unknown)
    shared = make_columns(*arguments)
    monkeypatch.setattr(sys.modules[make_columns.__module__], "side_by_side", map)
    for several, one in zip(shared, make_columns(*arguments), strict=True):
        for part, own in zip(several, one, strict=True):
            assert np.abs(part - own).max() <= 1e-9 * np.abs(own).max()
            assert (np.linalg.norm(part - own, axis=0) <= 1e-6 * np.linalg.norm(own, axis=0)).all()
