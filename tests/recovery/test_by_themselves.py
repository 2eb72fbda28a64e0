"""What is named of single teeth and turns gains by itself, and not by what it makes of waviness."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from gearfem.diagnosis.comparing.averages import of_teeth, teeth_under
from gearfem.diagnosis.fitting.fit import again
from gearfem.diagnosis.naming.by_themselves import gained_by_themselves
from gearfem.diagnosis.naming.search import Search
from gearfem.effects.pitch_error import PitchError
from gearfem.effects.torque_ripple import TorqueRipple
from gearfem.foundation import SolveError
from gearfem.foundation.units import UM
from tests.recovery.rig import PLAN, beside_nuisances

LATE = PitchError(gear="pinion", tooth=3, amount=12.0 * UM)
RIPPLE = TorqueRipple(gear="pinion", order=2.0, amplitude=1.0, phase=0.0)


@dataclasses.dataclass(frozen=True, eq=False)
class Explanation:
    """What a search asks of a fit that it may not name."""

    effects: tuple[Any, ...]


def test_a_late_tooth_gains_by_itself_what_it_gains(tmp_path: Path) -> None:
    """Beside one that is not there too, which gains nothing; the problem stays as it is prepared."""
    hidden = {"name": "pitch_error", "gear": "pinion", "tooth": 3, "amount_um": 12.0}
    shown = beside_nuisances(tmp_path, [hidden], [PLAN["record"][0], PLAN["record"][-1]])
    teeth, alone = teeth_under(shown.problem, shown.base.settings, (), of_teeth(shown.problem))
    fit = again(teeth, (LATE,), alone.point.stood)
    teeth.prepare((), alone.point.stood)
    here = teeth.columns
    (gain,) = gained_by_themselves(teeth, fit)
    assert gain == pytest.approx(alone.objective - fit.objective, rel=0.1, abs=0.0)
    assert gain > teeth.detected
    assert teeth.columns is here
    both = again(teeth, (*fit.effects, PitchError(gear="wheel", tooth=5, amount=1.0 * UM)), fit.point.stood)
    teeth.prepare((), alone.point.stood)
    late, none = gained_by_themselves(teeth, both)
    assert late == pytest.approx(gain, rel=0.2, abs=0.0)
    assert none < 0.1 * teeth.detected


@pytest.mark.parametrize(
    ("effect", "gains", "outer", "words"),
    [
        (LATE, 79.0, 0, "gains 79 by itself, where a name needs 80"),
        (LATE, 81.0, 0, ""),
        # What turns with a shaft needs less, and where nuisances move what rows show is weighed otherwise.
        (RIPPLE, 39.0, 0, "gains 39 by itself, where a name needs 40"),
        (RIPPLE, 41.0, 0, ""),
        (LATE, 0.0, 9, ""),
    ],
)
def test_what_gains_by_the_columns_of_waviness_is_not_named(
    monkeypatch: pytest.MonkeyPatch, effect: Any, gains: float, outer: int, words: str
) -> None:
    problem, asked = SimpleNamespace(outer=outer, detected=80.0, wander=40.0, imitated=3.0), list[object]()

    def found(problem: object, fit: object) -> tuple[float, ...]:
        asked.append(fit)
        return (gains,)

    monkeypatch.setattr(sys.modules[Search.__module__], "gained_by_themselves", found)
    search, fit = Search(cast(Any, problem), cast(Any, Explanation(()))), cast(Any, Explanation((effect,)))
    monkeypatch.setattr(search, "gained", lambda fit: 154.0)
    why = [search._borrowed(fit) for _ in range(2)]
    assert (words in why[0] and effect.describe() in why[0]) if words else not why[0]
    assert why[1] == why[0]
    assert len(asked) == (outer == 0)


def test_where_it_cannot_be_computed_nothing_is_named_and_too_little_is_not_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(problem: object, fit: object) -> tuple[float, ...]:
        raise SolveError("no loads")

    monkeypatch.setattr(sys.modules[Search.__module__], "gained_by_themselves", fails)
    problem = SimpleNamespace(outer=0, detected=80.0, wander=40.0, imitated=3.0)
    search, fit = Search(cast(Any, problem), cast(Any, Explanation(()))), cast(Any, Explanation((LATE,)))
    monkeypatch.setattr(search, "gained", lambda fit: 79.0)
    assert search._borrowed(fit) == ""
    monkeypatch.setattr(search, "gained", lambda fit: 81.0)
    assert "cannot be computed" in search._borrowed(fit)
