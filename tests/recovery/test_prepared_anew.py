"""Fits that are prepared anew where they end."""

from __future__ import annotations

import copy
import dataclasses
from pathlib import Path

import pytest

from gearfem.diagnosis.bench import neutral
from gearfem.diagnosis.fit import again
from gearfem.diagnosis.problem import Problem
from gearfem.foundation import Array, SolveError
from tests.recovery.rig import PLAN, beside_nuisances


def test_what_a_fit_prepared_anew_promises_holds(tmp_path: Path) -> None:
    hidden = {"name": "tip_relief", "gear": "wheel", "amount_um": 6.0, "length_mm": 2.0}
    problem = beside_nuisances(tmp_path, hidden, [PLAN["record"][0], PLAN["record"][-1]]).problem
    start = problem.prepare((), problem.unknowns.of(neutral(problem.campaign.setup.pair)))
    before = problem.attained(problem.at((), start))
    found = again(problem, (), start)
    assert found.point.objective <= found.objective < before
    # What bends has settled: what it would still promise if all were linear is next to nothing.
    assert found.objective - found.point.objective < 0.02 * (before - found.objective)


def test_fits_from_different_places_end_alike(tmp_path: Path) -> None:
    hidden = {"name": "tip_relief", "gear": "wheel", "amount_um": 6.0, "length_mm": 2.0}
    problem = beside_nuisances(tmp_path, hidden, [PLAN["record"][0], PLAN["record"][-1]]).problem
    level = neutral(problem.campaign.setup.pair)
    ends = []
    for errors in ((), (1.0, -1.0, 1.0, 1.0, 1.0, 1.0)):
        own = copy.copy(problem)
        start = own.unknowns.of(dataclasses.replace(level, errors=errors))
        before = own.attained(own.at((), own.prepare((), start)))
        ends.append(again(own, (), start).objective)
        assert ends[-1] < before
    assert abs(ends[0] - ends[1]) < 0.02 * (before - min(ends))


def test_where_a_round_ends_that_cannot_be_computed_the_one_before_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = beside_nuisances(tmp_path, {}, [PLAN["record"][0], PLAN["record"][-1]]).problem
    start = problem.unknowns.of(neutral(problem.campaign.setup.pair))
    prepare, prepared = Problem.prepare, []

    def twice(self: Problem, effects: tuple[()], unknown: Array) -> Array:
        prepared.append(unknown)
        if len(prepared) > 2:
            raise SolveError("no third time")
        return prepare(self, effects, unknown)

    monkeypatch.setattr(Problem, "prepare", twice)
    found = again(problem, (), start)
    assert len(prepared) == 3
    monkeypatch.undo()
    assert found.objective < problem.attained(problem.at((), problem.prepare((), start)))
