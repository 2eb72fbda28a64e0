"""What is named of single teeth and turns gains by itself, and not by what it makes of waviness."""

from __future__ import annotations

import copy
import dataclasses
import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from gearfem.diagnosis.comparing.averages import of_teeth, teeth_under
from gearfem.diagnosis.fitting.fit import Fit, again
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.naming.by_themselves import borrowed
from gearfem.diagnosis.naming.search import Search
from gearfem.effects.pitch_error import PitchError
from gearfem.effects.tip_relief import TipRelief
from gearfem.foundation import SolveError
from gearfem.foundation.units import MM, UM
from tests.recovery.rig import PLAN, beside_nuisances

LATE = PitchError(gear="pinion", tooth=3, amount=12.0 * UM)


@dataclasses.dataclass(frozen=True, eq=False)
class Explanation:
    """What a search asks of a fit that it may not name."""

    effects: tuple[Any, ...]


def beside_a_late_tooth(folder: Path) -> tuple[Problem, Fit]:
    """Measure a pair with that tooth; return what single teeth do, and their fit without it."""
    hidden = {"name": "pitch_error", "gear": "pinion", "tooth": 3, "amount_um": 12.0}
    shown = beside_nuisances(folder, [hidden], [PLAN["record"][0], PLAN["record"][-1]])
    return teeth_under(shown.problem, shown.base.settings, (), of_teeth(shown.problem))


def test_late_teeth_that_are_there_gain_by_themselves(tmp_path: Path) -> None:
    """One that is not does not, beside it or alone, whatever the whole gains; the problem stays as it is prepared."""
    teeth, alone = beside_a_late_tooth(tmp_path)
    own, there, none = copy.copy(teeth), (LATE,), (PitchError(gear="wheel", tooth=5, amount=1.0 * UM),)
    here = teeth.columns
    assert borrowed(teeth, again(own, there, alone.point.stood)) == ""
    words = borrowed(teeth, again(own, none, alone.point.stood))
    assert re.match(r"Pitch error of tooth 5 of the wheel.* by itself, less than 40; the rest", words), words
    words = borrowed(teeth, again(own, there + none, alone.point.stood))
    assert words.startswith("Pitch error of tooth 5 of the wheel"), words
    assert teeth.columns is here
    # What shows in the means is asked there.
    relief = TipRelief(gear="wheel", amount=1.0 * UM, length=2.0 * MM)
    assert borrowed(teeth, again(own, (relief,), alone.point.stood)) == ""


def test_a_first_fit_is_led_on_by_the_columns_that_it_is_asked_by(tmp_path: Path) -> None:
    """Far from its best size it gains too little where it stands."""
    teeth, alone = beside_a_late_tooth(tmp_path)
    first = teeth.fit((dataclasses.replace(LATE, amount=0.1 * UM),), alone.point.stood, rounds=0)
    assert alone.objective - first.objective < teeth.wander
    assert borrowed(teeth, first) == ""


@pytest.mark.parametrize(("outer", "gained", "asked"), [(0, 81.0, 1), (0, 79.0, 0), (9, 81.0, 0)])
def test_what_gains_enough_beside_standing_nuisances_is_asked_once(
    monkeypatch: pytest.MonkeyPatch, outer: int, gained: float, asked: int
) -> None:
    problem, fits = SimpleNamespace(outer=outer, detected=80.0, wander=40.0, imitated=3.0), list[object]()

    def found(problem: object, fit: object) -> str:
        fits.append(fit)
        raise SolveError("no loads")

    monkeypatch.setattr(sys.modules[Search.__module__], "borrowed", found)
    search, fit = Search(cast(Any, problem), cast(Any, Explanation(()))), cast(Any, Explanation((LATE,)))
    monkeypatch.setattr(search, "gained", lambda fit: gained)
    words = [search._borrows(fit) for _ in range(2)]
    assert words == ["what it scores by itself cannot be computed" if asked else ""] * 2
    assert len(fits) == asked
