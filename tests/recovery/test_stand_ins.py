"""Scales and errors of the model that do just what an effect does: none of them beside it, and its value as unknown as they are."""

from __future__ import annotations

import copy
import math
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gearfem.diagnosis import Diagnosis
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.parameters import faint
from gearfem.diagnosis.modelling.stand_ins import stand_ins
from gearfem.diagnosis.naming.search import Search
from gearfem.effects.body_compliance import BodyCompliance
from gearfem.effects.contact_compliance import ContactCompliance
from gearfem.effects.effect import Effect
from gearfem.effects.lead_misalignment import LeadMisalignment
from gearfem.effects.sensor_gain import SensorGain
from gearfem.effects.tip_relief import TipRelief
from gearfem.foundation.progress import quiet
from gearfem.foundation.units import MM, UM


def test_beside_an_effect_what_does_the_same_is_not_there(found: Diagnosis) -> None:
    problem, effects = found.problem, (ContactCompliance(scale=1.5), SensorGain(scale=1.1))
    names = [*(nuisance.name for nuisance in problem.nuisances), *(variant.name for variant in problem.unknowns.errors)]
    places = np.array([*range(problem.outer), *range(problem.unknowns.wrong.start, problem.unknowns.wrong.stop)])
    served = [names.index("gain"), names.index("contact_scale")]
    unknown = np.zeros_like(found.naming.fit.point.unknown)
    unknown[places[served]] = 1.0
    start = problem.prepare(effects, unknown)
    assert np.flatnonzero(start).size == 0
    there = problem.fit(effects, unknown, rounds=1).point.unknown[places]
    assert there[served].tolist() == [0.0, 0.0]
    assert np.count_nonzero(there) > len(places) // 2
    # Columns made without the effects say the same.
    problem.prepare((), unknown)
    assert problem.fit(effects, unknown, rounds=1).point.unknown[places[served]].tolist() == [0.0, 0.0]
    assert problem.at((), unknown).stood[places[served]].tolist() == [1.0, 1.0]


def test_what_an_effect_holds_still_moves_without_it(found: Diagnosis) -> None:
    """Whatever the problem was prepared under; at no strength an effect changes no column."""
    problem, unknown = copy.copy(found.problem), np.zeros_like(found.naming.fit.point.unknown)
    none, effects = (), (ContactCompliance(scale=1.0), SensorGain(scale=1.0))
    start = problem.prepare(none, unknown)
    costs = [problem.at(chosen, start).objective for chosen in (none, effects)]
    assert costs[1] > costs[0] + 1e-3
    problem.prepare(effects, unknown)
    assert [problem.at(chosen, start).objective for chosen in (none, effects)] == pytest.approx(costs, rel=1e-9, abs=0.0)
    assert problem.beside(none).whole.deviations[problem.unknowns.wrong.start - problem.outer] < 1.0
    assert problem.whole.deviations[problem.unknowns.wrong.start - problem.outer] == 1.0


@pytest.mark.parametrize(
    ("effect", "field", "doubt"),
    [
        (ContactCompliance(scale=3.0), "scale", 3.0 * 0.3),
        (BodyCompliance(scale=2.0), "scale", 2.0 * 0.2),
        (SensorGain(scale=0.5), "scale", 0.5 * math.expm1(0.02)),
        (LeadMisalignment(slope=20.0 * UM), "slope", 1.0 * UM),
    ],
)
def test_an_effect_is_as_unknown_as_what_does_the_same(found: Diagnosis, effect: Effect, field: str, doubt: float) -> None:
    (one,) = (one for one in found.problem.stand_ins if one.serves(effect))
    assert one.doubt(effect, field) == pytest.approx(doubt, rel=1e-9, abs=0.0)


def test_an_unknown_is_where_it_does_the_same_as_an_effect(found: Diagnosis) -> None:
    effects = [(one, one.cause(moved), moved) for one in found.problem.stand_ins for moved in (0.0, 1.7)]
    serving = [(one, effect, moved) for one, effect, moved in effects if isinstance(effect, Effect)]
    assert len(serving) >= 10
    for one, effect, moved in serving:
        assert one.moved(effect) == pytest.approx(moved, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(("scale", "gained", "led"), [(1.3**2.5, 50.0, True), (1.3**3.5, 50.0, False), (1.3**2.5, 5.0, False)])
def test_nuisances_are_led_to_where_an_effect_gained_by_a_likely_value_of_one(
    found: Diagnosis, monkeypatch: pytest.MonkeyPatch, scale: float, gained: float, led: bool
) -> None:
    """The contact of a model is 30 % off: 2.5 deviations are likely, 3.5 the work of an effect, and what gains little is left alone."""
    problem, effect = found.problem, ContactCompliance(scale=scale)
    place = problem.unknowns.wrong.start
    fit = SimpleNamespace(effects=(effect,), point=SimpleNamespace(stood=np.zeros(place + 3)))
    pair = SimpleNamespace(effects=(effect, SensorGain(scale=1.1)))
    begun: list[np.ndarray] = []
    search = Search(problem, cast(Fit, SimpleNamespace(objective=100.0)))
    monkeypatch.setattr(search, "first", lambda most: [fit, pair])
    monkeypatch.setattr(search, "gained", lambda one: gained)

    def settle_from(starts: list[tuple[tuple[Effect, ...], np.ndarray]], *words: object) -> None:
        begun.extend(unknown for effects, unknown in starts if effects == ())
        search.fits[()] = cast(Fit, SimpleNamespace(objective=100.0 - problem.wander - 1.0 if starts else 100.0))

    monkeypatch.setattr(search, "settle_from", settle_from)
    assert search.instead(quiet) is led
    assert search.alone is search.fits[()]
    assert [np.flatnonzero(unknown).tolist() for unknown in begun] == ([[place]] if led else [])
    assert [unknown[place] for unknown in begun] == pytest.approx([2.5] if led else [], rel=1e-9, abs=0.0)


@pytest.mark.parametrize(
    ("effect", "deviation", "weak"),
    [(BodyCompliance(scale=3.0), 0.7, False), (BodyCompliance(scale=1.5), 0.35, True), (ContactCompliance(scale=0.4), 0.22, True)],
)
def test_what_multiplies_is_faint_by_its_logarithm(found: Diagnosis, effect: Effect, deviation: float, weak: bool) -> None:
    """From once as much three times as much is as far as a third is, at the same share of doubt."""
    setup = found.campaign.setup
    assert faint(effect, {"scale": deviation}, setup, multiplies=True) is weak
    # By its distance from 1 the strong one would be as doubtful.
    assert faint(BodyCompliance(scale=3.0), {"scale": 0.7}, setup)


def test_a_shape_of_a_flank_has_no_stand_in(found: Diagnosis) -> None:
    relief = TipRelief(gear="pinion", amount=3.0 * UM, length=2.0 * MM)
    assert not any(one.serves(relief) for one in stand_ins(found.problem.unknowns, found.campaign.setup))
