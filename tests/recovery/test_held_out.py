"""What records held out decide: names withdrawn, gaps left open, and how sure that is."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem.diagnosis import Diagnosis
from gearfem.diagnosis.held_out import as_held_out_leaves
from gearfem.diagnosis.prove import Gap, _doubt


@pytest.mark.parametrize(
    ("share", "doubt", "stays", "verdict"),
    [
        (0.9, 0.04, True, "unexplained"),
        (0.9, 0.06, True, "explained"),
        (0.9, 0.04, False, "explained"),
        (0.4, 0.04, False, "unexplained"),
        (1.0, 0.0, True, "explained"),
    ],
)
def test_a_name_that_does_worse_than_nuisances_where_nobody_looked_is_withdrawn(
    found: Diagnosis, share: float, doubt: float, stays: bool, verdict: str
) -> None:
    """By two standard errors; and by far worse, where these stray so far that they do the work of an effect themselves."""
    held = as_held_out_leaves(found.naming, dataclasses.replace(found.proof, over_nuisances=share, stderr=doubt), stays)
    assert held.verdict == verdict
    assert bool(held.fit.effects) == (verdict == "explained")


@pytest.mark.parametrize(("share", "floors", "verdict"), [(0.9, 3.0, "unexplained"), (0.9, 1.0, "explained"), (1.1, 3.0, "explained")])
def test_a_name_that_leaves_open_what_straying_nuisances_foretell_better_is_withdrawn(
    found: Diagnosis, share: float, floors: float, verdict: str
) -> None:
    """However much of its gap the named effects close, unless they bring it to its floor."""

    def left(gap: Gap) -> Gap:
        series = np.full(gap.after.shape, floors * gap.floor_rms)
        return dataclasses.replace(gap, before=30.0 * series, after=series) if gap.role == "holdout" else gap

    proof = dataclasses.replace(found.proof, over_nuisances=share, records=tuple(map(left, found.proof.records)))
    held = as_held_out_leaves(found.naming, proof, sound=False)
    assert held.verdict == verdict
    assert bool(held.fit.effects) == (verdict == "explained")


def test_what_one_place_of_a_record_tells_is_doubted_more_than_what_all_of_it_tells(found: Diagnosis) -> None:
    """The same mean square lost evenly, or in one tenth of each record."""
    held = [gap for gap in found.proof.records if gap.role == "holdout"]

    def doubt(share: float) -> float:
        gaps = []
        for gap in held:
            keep, after = np.flatnonzero(gap.measurement.keep), np.zeros(gap.after.shape)
            after[keep[: round(share * keep.size)]] = gap.floor_rms / math.sqrt(share)
            gaps.append(dataclasses.replace(gap, nuisances_only=np.zeros(gap.after.shape), after=after))
        return _doubt(gaps)

    assert doubt(1.0) == pytest.approx(0.0, abs=1e-12)
    # Ten blocks, one of which holds ten times the mean: a standard error as large as the mean itself.
    assert doubt(0.1) == pytest.approx(1.0 / math.sqrt(len(held)), rel=0.05, abs=0.0)
    assert found.proof.stderr is not None
    assert found.proof.over_nuisances is not None
    assert found.proof.over_nuisances - 2.0 * found.proof.stderr > 1.0
