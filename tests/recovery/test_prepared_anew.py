"""Fits that are prepared anew where they end."""

from __future__ import annotations

import copy
import dataclasses
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gearfem.diagnosis import read_campaign
from gearfem.diagnosis.fitting import parameters
from gearfem.diagnosis.fitting.eased import eased, to_a_factor
from gearfem.diagnosis.fitting.fit import again
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.bench import neutral
from gearfem.diagnosis.ranking.rank import _led_on, rank
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.effects.effect import Effect
from gearfem.effects.pitting import Pitting
from gearfem.effects.sensor_resonance import SensorResonance
from gearfem.foundation import Array, SolveError
from gearfem.foundation.units import MM, UM
from tests.recovery.rig import PLAN, beside_nuisances


def test_what_a_fit_prepared_anew_promises_holds(tmp_path: Path) -> None:
    hidden = {"name": "tip_relief", "gear": "wheel", "amount_um": 6.0, "length_mm": 2.0}
    problem = beside_nuisances(tmp_path, [hidden], [PLAN["record"][0], PLAN["record"][-1]]).problem
    start = problem.prepare((), problem.unknowns.of(neutral(problem.campaign.setup.pair)))
    before = problem.attained(problem.at((), start))
    found = again(problem, (), start)
    assert found.point.objective <= found.objective < before
    # What bends has settled: what it would still promise if all were linear is next to nothing.
    assert found.objective - found.point.objective < 0.02 * (before - found.objective)


def test_a_fit_counts_by_the_columns_of_where_it_stands(tmp_path: Path) -> None:
    """Those of where it came from foretell more than there is: by 380 here, a tenth, for nuisances that do the work of wear."""
    hidden = {"name": "profile_wear", "gear": "wheel", "tip_um": 20.0, "root_um": 40.0, "pitch_um": 2.0}
    problem = beside_nuisances(tmp_path, [hidden], [PLAN["record"][0], PLAN["record"][-1]]).problem
    found = again(problem, (), problem.prepare((), problem.unknowns.of(neutral(problem.campaign.setup.pair))))
    problem.prepare((), found.point.stood)
    point = problem.at((), found.point.stood, found.point.weights)
    assert problem.attained(point) == pytest.approx(found.objective, rel=2e-3, abs=0.0)


def test_fits_from_different_places_end_alike(tmp_path: Path) -> None:
    hidden = {"name": "tip_relief", "gear": "wheel", "amount_um": 6.0, "length_mm": 2.0}
    problem = beside_nuisances(tmp_path, [hidden], [PLAN["record"][0], PLAN["record"][-1]]).problem
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
    problem = beside_nuisances(tmp_path, [], [PLAN["record"][0], PLAN["record"][-1]]).problem
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


class _Saturating:
    """Stands for a problem: a pit of the pinion takes all load off its part of a flank from 100 um on, and explains 900."""

    def __init__(self, campaign: Campaign) -> None:
        self.campaign = campaign

    def at(self, effects: tuple[Effect, ...], unknown: Array, weights: Array) -> SimpleNamespace:
        return SimpleNamespace(effects=effects, stood=unknown, weights=weights)

    def attained(self, point: SimpleNamespace) -> float:
        shares = [1.0 - min(pit.depth / (100.0 * UM), 1.0) for pit in point.effects]
        return 100.0 + 900.0 * min([share**2 for share in shares], default=1.0)


@pytest.mark.parametrize(("depth", "ends"), [(300.0, 150.0), (290.0, 145.0), (160.0, 160.0)])
def test_nothing_speaks_for_the_deepest_pit_if_a_shallower_one_does_as_much(campaign: Path, depth: float, ends: float) -> None:
    """Whether it ends at its bound or not; it stays as it is where half of it explains less."""
    problem: Any = _Saturating(read_campaign(campaign))
    deepest = Pitting(gear="pinion", tooth=3, depth=depth * UM, centre=7.0 * MM, width=1.5 * MM)
    bound = parameters.at_bounds((deepest,), problem.campaign.setup)
    assert bound == (((0, "depth"),) if depth == 300.0 else ())
    stood: Any = problem.at((deepest,), np.zeros(3), np.ones(2))
    point, attained = eased(problem, stood, 100.0)
    assert point.effects[0].depth == pytest.approx(ends * UM, rel=1e-12, abs=0.0)  # type: ignore[attr-defined]
    assert attained == 100.0


def test_a_depth_that_was_halved_is_known_to_a_factor_of_two(campaign: Path) -> None:
    """So that it is no reason to call the pit none; a depth that stood, and where the pit lies, are known as they were."""
    before = Pitting(gear="pinion", tooth=3, depth=290.0 * UM, centre=7.0 * MM, width=1.5 * MM)
    after, setup = dataclasses.replace(before, depth=145.0 * UM), read_campaign(campaign).setup
    known = {"depth": 5.0 * UM, "centre": 0.2 * MM, "width": 0.1 * MM}
    fit: Any = SimpleNamespace(effects=(after, before), deviations=(known, known))
    halved, stood = to_a_factor(fit, (before, before), setup)
    assert halved == known | {"depth": pytest.approx(0.33 * 145.0 * UM, rel=1e-12, abs=0.0)}
    assert stood == known
    assert not parameters.faint(after, halved, setup)


@pytest.mark.parametrize(
    ("begun", "ends", "led", "left"),
    [
        ([500.0, 225.0, 290.0], {225.0: 144.0}, [225.0], [144.0]),
        ([500.0, 359.0, 363.0], {359.0: 410.0, 363.0: 361.0}, [359.0, 363.0], [410.0, 361.0]),
        ([700.0, 680.0], {680.0: 640.0}, [680.0], [640.0]),
    ],
    ids=["the second began above the end of the first", "the first led nowhere", "the second began above the fit without it"],
)
def test_fits_of_a_candidate_go_on_where_they_stand_below_what_has_been_found(
    monkeypatch: pytest.MonkeyPatch, begun: list[float], ends: dict[float, float], led: list[float], left: list[float]
) -> None:
    """Places are what a few rounds from there leave."""
    gone = list[float]()

    def again(problem: object, effects: object, place: float, hopeless: float) -> Any:
        gone.append(place)
        return SimpleNamespace(objective=ends[place])

    module = sys.modules[rank.__module__]
    monkeypatch.setattr(module, "again", again)
    monkeypatch.setattr(module, "moves_otherwise", lambda *_: True)
    view: Any = SimpleNamespace(problem=SimpleNamespace(), base=SimpleNamespace(objective=586.0))
    fits: Any = [SimpleNamespace(effects=(), objective=place, point=SimpleNamespace(stood=place)) for place in begun]
    assert [fit.objective for fit in _led_on(view, fits)] == left
    assert gone == led


def test_what_is_ranked_again_beside_known_effects_begins_from_the_size_it_had(monkeypatch: pytest.MonkeyPatch, campaign: Path) -> None:
    """Under each set of nuisances; what was not ranked before is tried at sizes of its own."""
    module, begun = sys.modules[rank.__module__], list[Any]()
    setup, before, own = read_campaign(campaign).setup, *(SensorResonance(frequency=hertz, ratio=0.1) for hertz in (700.0, 3000.0))
    monkeypatch.setattr(module, "_elsewhere", lambda view, start: [np.ones(3)])
    monkeypatch.setattr(module, "_sizes", lambda view, start, unknown: [own])
    monkeypatch.setattr(module, "_begun", lambda view, start: begun.append(start))
    monkeypatch.setattr(module, "view_of", lambda problem, base, *_: SimpleNamespace(problem=problem, base=base))
    monkeypatch.setattr(module, "starts_of", lambda problem, base, kind, member: [kind.example(setup, member)])
    monkeypatch.setattr(module, "late_tooth", lambda *_: [])
    monkeypatch.setattr(module, "counted", lambda work, items, *_: map(work, items))
    moving = SimpleNamespace(quantity=SimpleNamespace(moving=True))
    problem: Any = SimpleNamespace(campaign=SimpleNamespace(setup=setup), records=[moving], left_at=lambda effects, unknown: unknown.sum())
    stood = SimpleNamespace(unknown=np.zeros(3), weights=np.ones(1))
    base: Any = SimpleNamespace(effects=(), objective=10.0, squares=np.ones(1), point=stood)
    for known, begins in (([before], before), ([], own)):
        begun.clear()
        rank(problem, base, {"sensor_resonance": SensorResonance}, before=known)
        assert [(effects, unknown.sum()) for effects, unknown in begun] == [((begins,), 0.0), ((begins,), 3.0)]
