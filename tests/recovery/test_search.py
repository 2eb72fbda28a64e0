"""The course of a search: what is fitted again, from where, and when it ends."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.naming.name import _unmoved, name
from gearfem.diagnosis.naming.search import Search
from gearfem.diagnosis.naming.select import _concluded, _settled_hopeless
from gearfem.foundation import Array
from gearfem.foundation.progress import quiet


@pytest.mark.parametrize(("detected", "kept"), [(40.0, [100.0, 21.0]), (100.0, [100.0, 21.0, 19.0])])
def test_what_is_left_far_behind_by_one_that_may_be_named_is_not_fitted_again(detected: float, kept: list[float]) -> None:
    gains: Any = SimpleNamespace(
        first=lambda most: [100.0, 21.0, 19.0, 18.0][:most], gained=float, problem=SimpleNamespace(detected=detected)
    )
    assert Search.ahead(gains, 3) == kept


@pytest.mark.parametrize(("gained", "ends"), [(30.0, False), (10.0, True)])
def test_what_first_fits_gain_is_looked_into_only_if_it_is_gained_by_fits_made_again(gained: float, ends: bool) -> None:
    """Half of what a name needs, 40; where the search ends the problem is prepared at the nuisances alone as they are then."""
    first, again = (SimpleNamespace(effects=(), point=SimpleNamespace(unknown=np.array([at]))) for at in (0.0, 1.0))
    prepared: list[float] = []
    search = SimpleNamespace(alone=first, ahead=lambda most: ["best"] * most, best=lambda most: "best")
    search.problem = SimpleNamespace(detected=40.0, prepare=lambda effects, unknown: prepared.append(unknown[0]))
    search.gained = lambda fit: 100.0 if search.alone is first else gained

    def settle(fits: list[object], *words: object) -> None:
        assert fits[0] is first
        search.alone = again

    search.settle = settle
    assert _settled_hopeless(cast(Search, search), quiet) is ends
    assert prepared == ([1.0] if ends else [])


def point_at(unknown: float, stood: float) -> Any:
    """Return a point of numbers for places: 0 is where the model has all nuisances."""
    return SimpleNamespace(unknown=unknown, stood=stood, weights=np.ones(2))


def fit_of(*effects: str, objective: float = 100.0, unknown: float = 2.0, stood: float = 1.0) -> Any:
    """Return a fit of effects that stands at such a point."""
    return SimpleNamespace(effects=effects, objective=objective, point=point_at(unknown, stood))


def searching(monkeypatch: pytest.MonkeyPatch, attempt: Callable[..., Any], alone: Any) -> tuple[Search, Any]:
    """Return a search whose fits are made by a function, and its problem."""
    module = sys.modules[Search.__module__]
    monkeypatch.setattr(module, "attempt", attempt)
    monkeypatch.setattr(module, "near_by", lambda problem, fit: False)
    monkeypatch.setattr(module, "counted", lambda work, items, *_: map(work, items))
    monkeypatch.setattr(module, "label", lambda effects: effects)
    problem = SimpleNamespace(wander=40.0, memory=np.ones(2), outer=3, unknowns=SimpleNamespace(neutral=lambda unknown: 0.0))
    search = Search(cast(Problem, problem), alone)
    monkeypatch.setattr(search, "score", lambda fit: fit.objective)
    return search, problem


@pytest.mark.parametrize(("stood", "ends", "begun"), [(120.0, 120.0, [1.0, 0.0]), (1500.0, 90.0, [1.0, 0.0, 5.0])])
def test_a_fit_that_leaves_far_more_than_it_promised_begins_where_nuisances_alone_stand_too(
    monkeypatch: pytest.MonkeyPatch, stood: float, ends: float, begun: list[float]
) -> None:
    """The first fit stood at 1, and nuisances alone do at 5."""
    leaves, tried, counting = {1.0: stood, 0.0: stood + 1.0, 5.0: 90.0}, list[float](), list[object]()

    def attempt(problem: object, effects: tuple[str, ...], place: float, weights: Array | None = None, **_: float) -> Any:
        tried.append(place)
        counting.append(weights)
        return fit_of(*effects, objective=leaves[place], unknown=place, stood=place)

    search, problem = searching(monkeypatch, attempt, fit_of(objective=2000.0, unknown=4.0, stood=5.0))
    promised = fit_of("pit")
    search.settle([promised], quiet, "again")
    assert search.fits[("pit",)].objective == ends  # type: ignore[index]
    assert tried == begun
    # What records count goes along from where the fit stood, and to no other place.
    assert [one is promised.point.weights for one in counting] == [place == 1.0 for place in begun]
    # It has begun there; where errors of the model stay alike for longer it has not.
    search.settle([promised], quiet, "these again")
    assert tried == [*begun, *(place for place in begun if place)]
    problem.memory = np.full(2, 4.0)
    search.settle([promised], quiet, "rivals again")
    assert tried[-len(begun) :] == begun
    # Of single teeth nuisances stand still.
    problem.outer, problem.memory = 0, np.full(2, 5.0)
    tried.clear()
    search.settle([promised], quiet, "single teeth again")
    assert tried == [place for place in begun if place]
    assert counting[-len(tried)] is None


def test_what_cannot_be_computed_where_it_stands_begins_from_nuisances_as_the_model_has_them(monkeypatch: pytest.MonkeyPatch) -> None:
    tried, fit = list[float](), fit_of("pit")

    def attempt(problem: object, effects: object, place: float, **_: object) -> None:
        tried.append(place)

    search, _ = searching(monkeypatch, attempt, fit)
    search.settle([fit], quiet, "again")
    assert tried == [1.0, 0.0]
    assert search.fits[("pit",)] is fit  # type: ignore[index]


def test_effects_are_given_up_that_do_not_promise_half_of_what_the_best_gains(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nuisances alone leave 1000 and the best effects 200; of 400 and 700 both are left, of which 400 is less than half way."""
    least = list[float]()

    def attempt(problem: object, effects: tuple[str, ...], place: float, hopeless: float = math.inf, **_: object) -> Any:
        least.append(hopeless)
        return fit_of(*effects, objective=400.0 if effects == ("wear",) else 700.0)

    alone = fit_of(objective=1000.0)
    search, _ = searching(monkeypatch, attempt, alone)
    search.fits[("pit",)] = fit_of("pit", objective=200.0)  # type: ignore[index]
    search.settle([fit_of("wear", objective=410.0), fit_of("relief", objective=710.0)], quiet, "again")
    # From where it stands, and from nuisances as the model has them: there it must come below what it has come to as well.
    assert least == [600.0, 400.0, 600.0, 600.0]
    search.settle([alone], quiet, "again")
    assert least[4:] == [math.inf, 700.0]
    search.settle_from([(("slope",), np.zeros(1))], quiet, "from elsewhere", search.worth)  # type: ignore[list-item]
    assert least[-1] == search.worth == 450.0


def test_rivals_fitted_again_know_where_nuisances_alone_stand(monkeypatch: pytest.MonkeyPatch) -> None:
    """On several cores each is fitted by a child, which does not learn what has become of these meanwhile."""
    module = sys.modules[_concluded.__module__]
    alone, best = (
        SimpleNamespace(effects=effects, point=SimpleNamespace(unknown=place)) for effects, place in (((), 5.0), (("pit",), 2.0))
    )
    monkeypatch.setattr(module, "label", lambda effects: effects)
    monkeypatch.setattr(module, "_prepare_at", lambda *_: None)

    class Settled(Exception):
        pass

    def settle(fits: list[object], *_: object) -> None:
        assert fits == [alone, best]
        assert search.alone is alone
        raise Settled

    problem = SimpleNamespace(memory=np.ones(2), remember=lambda fit: None)
    search = Search(cast(Problem, problem), cast(Fit, alone))
    search.fits[("pit",)] = cast(Fit, best)  # type: ignore[index]
    for method, own in (("score", lambda fit: 0.0), ("best", lambda: best), ("rivals", list), ("settle", settle)):
        monkeypatch.setattr(search, method, own)
    with pytest.raises(Settled):
        _concluded(search, (), quiet)


@pytest.mark.parametrize(
    ("means", "means_beside", "teeth_again", "course"),
    [
        ("crowning", "crowning", "pit", ["means", "teeth", "means beside pit", "teeth again"]),
        ("crowning", "crowning", "", ["means", "teeth", "means beside pit", "teeth again", "means again"]),
        ("", "", "pit", ["means", "teeth", "means beside pit"]),
    ],
    ids=["both stay", "pit made up for the crowning", "pit alone"],
)
def test_what_is_named_of_single_teeth_is_asked_again_beside_what_is_named_of_all(
    monkeypatch: pytest.MonkeyPatch, means: str, means_beside: str, teeth_again: str, course: list[str]
) -> None:
    """A crowning that is named too large makes a pit of waviness, which is none once the crowning has been fitted beside it."""
    module, done = sys.modules[name.__module__], list[str]()

    def naming(word: str) -> Any:
        fit = SimpleNamespace(effects=(word,) if word else ())
        return SimpleNamespace(fit=fit, best=fit, alone=fit, verdict="explained" if word else "unexplained", left=0.5, gains=bool(word))

    def step(word: str, result: str) -> Any:
        done.append(word)
        return naming(result)

    def of_teeth(problem: object, fit: object, kinds: object, progress: object, before: object = None) -> tuple[Any, bool]:
        return (step("teeth", "pit") if before is None else step("teeth again", teeth_again)), False

    for word, stub in {
        "has_means": lambda problem: True,
        "turns_often": lambda problem, alone: False,
        "untold": lambda problem, first: (),
        "_of_means": lambda *_, **__: step("means", means),
        "_of_teeth": of_teeth,
        "_of_all": lambda problem, first, single, *_: step(f"means beside {single.effects[0]}", means_beside),
        "_of_means_anew": lambda *_: step("means again", means),
        "left_open": lambda problem, untold, found: found,
        "joined": lambda problem, alone, first, second: (first.fit.effects, second.fit.effects),
    }.items():
        monkeypatch.setattr(module, word, stub)
    found = name(cast(Problem, SimpleNamespace()), cast(Fit, SimpleNamespace(settings=None)), {})
    assert done == course
    assert cast(Any, found) == ((means,) if means else (), (teeth_again,) if teeth_again else ())


@pytest.mark.parametrize(
    ("alone", "best", "named", "asked", "stands"),
    [
        (700.0, 227.0, True, True, True),
        (700.0, 200.0, True, True, False),
        (700.0, 227.0, False, True, False),
        (680.0, 227.0, True, False, False),
    ],
    ids=["all as it was", "the best leaves less", "nothing is named any more", "nuisances alone leave less"],
)
def test_means_that_single_teeth_leave_as_they_were_are_not_searched_again(
    monkeypatch: pytest.MonkeyPatch, alone: float, best: float, named: bool, asked: bool, stands: bool
) -> None:
    """But for 25: what a further name of means must gain."""

    def verdict(alone: float, best: float, named: bool = True) -> Any:
        near, far = (SimpleNamespace(near=near, fit=fit_of("crack", objective=left)) for near, left in ((True, best), (False, 1.0)))
        best_fit = fit_of("pit", objective=best + 4.0)
        return SimpleNamespace(alone=fit_of(objective=alone), best=best_fit, fit=best_fit if named else fit_of(), rivals=(near, far))

    tried = list[object]()

    def anew(mean: object, alone: object, found: object, *_: object) -> Any:
        tried.append(found)
        return verdict(700.0, best, named)

    monkeypatch.setattr(sys.modules[_unmoved.__module__], "_anew", anew)
    mean, found = cast(Problem, SimpleNamespace(wander=10.0)), [((), np.zeros(1))]
    naming = _unmoved(mean, fit_of(objective=alone), cast(Any, found), verdict(709.0, 243.0), quiet)
    assert (naming is not None) is stands
    assert tried == ([found] if asked else [])
