"""Motions whose flanks hammer, and what names by the means leave of their rows."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from gearfem.diagnosis import Diagnosis, averaged
from gearfem.diagnosis.naming import hammering as module
from gearfem.diagnosis.naming.hammering import left_open, untold
from gearfem.effects.effect import Effect


def leave(monkeypatch: pytest.MonkeyPatch, with_names: float) -> None:
    """Let all flanks hammer, and names leave so much of every record for 1 of nuisances alone."""
    monkeypatch.setattr(module, "hammering", lambda record, bench, settings: 1.0)
    monkeypatch.setattr(module, "calibrated", lambda setup, settings, effects: effects)

    def left(record: Any, effects: tuple[Effect, ...]) -> Any:
        return np.full(len(record.axis), with_names if effects else 1.0), 0.0, 0

    monkeypatch.setattr(module, "left_of", left)


@pytest.mark.parametrize(("left", "lost"), [(1.3, True), (1.1, False), (0.3, False)])
def test_a_mean_tells_nothing_where_its_rows_are_left_worse(
    monkeypatch: pytest.MonkeyPatch, found: Diagnosis, left: float, lost: bool
) -> None:
    leave(monkeypatch, left)
    files = tuple(record.file for record in found.problem.records)
    assert untold(found.problem, found.naming) == (files if lost else ())
    assert untold(found.problem, dataclasses.replace(found.naming, fit=found.naming.alone)) == ()


def test_flanks_that_stay_together_are_not_asked(found: Diagnosis) -> None:
    assert untold(found.problem, found.naming) == ()


def test_means_leave_out_what_tells_nothing(found: Diagnosis) -> None:
    problem = found.problem.part(np.arange(len(found.problem.records)))
    problem.untold = (problem.records[1].file,)
    mean = averaged(problem, found.naming.alone.settings)
    assert [record.file for record in mean.records] == [record.file for record in problem.records if record.file not in problem.untold]


@pytest.mark.parametrize(("left", "verdict"), [(0.9, "partly_explained"), (0.3, "explained")])
def test_what_was_left_out_and_stays_open_is_not_explained(
    monkeypatch: pytest.MonkeyPatch, found: Diagnosis, left: float, verdict: str
) -> None:
    leave(monkeypatch, left)
    naming = dataclasses.replace(found.naming, verdict="explained")
    file = found.problem.records[0].file
    judged = left_open(found.problem, (file,), naming)
    assert judged.verdict == verdict
    assert (file in judged.reasons[-1]) is (verdict != "explained")
    assert left_open(found.problem, (), naming) is naming
