"""What records held out decide: names withdrawn, gaps left open, and how sure that is."""

from __future__ import annotations

import dataclasses
import math
import sys

import numpy as np
import pytest

from gearfem.diagnosis import Diagnosis
from gearfem.diagnosis.diagnose import _opened
from gearfem.diagnosis.fitting.score import label
from gearfem.diagnosis.modelling.calibrate import Left
from gearfem.diagnosis.naming.naming import Rival
from gearfem.diagnosis.proving.held_out import as_held_out_leaves, without
from gearfem.diagnosis.proving.proof import Gap, _doubt, judged
from gearfem.diagnosis.proving.prove import prove
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.quantities import QUANTITIES
from gearfem.effects.profile_slope import ProfileSlope
from gearfem.effects.profile_wear import ProfileWear
from gearfem.effects.runout import Runout
from gearfem.foundation import SolveError
from gearfem.foundation.progress import quiet
from gearfem.foundation.units import UM
from gearfem.sensing import System


@pytest.mark.parametrize(
    ("share", "foretold", "doubt", "stays", "verdict"),
    [
        (0.9, 1.2, 0.04, True, "no_discrepancy"),
        (1.05, 1.2, 0.03, True, "no_discrepancy"),
        (1.05, 1.05, 0.03, True, "explained"),
        (1.05, 1.08, 0.03, True, "explained"),
        (1.03, 1.08, 0.03, True, "no_discrepancy"),
        (0.99, 1.05, 0.03, True, "explained"),
        (0.9, 1.05, 0.04, True, "no_discrepancy"),
        (1.0, 1.2, 0.0, True, "explained"),
        (1.1, 1.2, 0.03, True, "explained"),
        (0.9, 1.2, 0.04, False, "explained"),
        (0.4, 1.2, 0.04, False, "unexplained"),
    ],
)
def test_a_name_that_does_not_surely_do_better_where_nobody_looked_is_withdrawn(
    found: Diagnosis, share: float, foretold: float, doubt: float, stays: bool, verdict: str
) -> None:
    """By two standard errors, where records could tell; where nuisances stray so far that they do the work of an effect, by far."""
    proof = dataclasses.replace(found.proof, over_nuisances=share, foretold=foretold, stderr=doubt)
    held = as_held_out_leaves(dataclasses.replace(found.naming, without="no_discrepancy"), proof, stays)
    assert held.verdict == verdict
    assert bool(held.fit.effects) == (verdict == "explained")


@pytest.mark.parametrize(
    ("share", "stays", "verdict"), [(0.7, True, "no_discrepancy"), (0.7, False, "unexplained"), (0.9, True, "explained")]
)
def test_a_name_that_leaves_far_more_of_what_was_fitted_is_withdrawn(found: Diagnosis, share: float, stays: bool, verdict: str) -> None:
    """Whatever records held out say: a hammering motion may be met row by row as if all were linear, and missed by the model."""
    proof = dataclasses.replace(found.proof, over_fitted=share)
    held = as_held_out_leaves(dataclasses.replace(found.naming, without="no_discrepancy"), proof, stays)
    assert held.verdict == verdict
    assert bool(held.fit.effects) == (verdict == "explained")
    assert any("records that were fitted" in reason for reason in held.reasons) == (verdict != "explained")


@pytest.mark.parametrize(
    ("share", "smooth", "verdict"), [(1.0, 0.7, "unexplained"), (1.0, 0.9, "explained"), (1.2, 0.7, "explained"), (1.0, None, "explained")]
)
def test_a_name_that_beats_nothing_where_nobody_looked_is_withdrawn(
    found: Diagnosis, share: float, smooth: float | None, verdict: str
) -> None:
    """Neither nuisances that stray nor a smooth correction: what it leaves has another cause."""
    proof = dataclasses.replace(found.proof, over_nuisances=share, over_smooth=smooth, stderr=0.02)
    held = as_held_out_leaves(found.naming, proof, sound=False)
    assert held.verdict == verdict
    assert held.reasons[-1].endswith("A free smooth correction leaves 0.70 times as much.") == (verdict == "unexplained")


@pytest.mark.parametrize(
    ("share", "foretold", "smooth", "gapless", "stays"),
    [
        (1.03, 1.2, 1.1, True, False),
        (1.07, 1.2, 1.1, True, True),
        (1.03, 1.05, 1.1, True, False),
        (1.0, 1.01, 1.1, True, False),
        (1.07, 1.2, None, True, True),
        (1.07, 1.2, 0.92, True, False),
        (1.03, 1.01, 0.92, True, False),
        (1.07, 1.2, 0.98, True, True),
        (1.03, 1.2, 0.92, False, True),
    ],
)
def test_waves_that_index_errors_hold_as_well_must_surely_beat_them_where_nobody_looked(
    found: Diagnosis, share: float, foretold: float, smooth: float | None, gapless: bool, stays: bool
) -> None:
    """By two standard errors, whether these records would show it or not; nor may a smooth correction do much better there."""
    runout = Runout(gear="pinion", eccentricity=5.0 * UM, angle=0.0)
    naming = dataclasses.replace(found.naming, fit=dataclasses.replace(found.naming.fit, effects=(runout,)), without="no_discrepancy")
    proof = dataclasses.replace(found.proof, over_nuisances=share, foretold=foretold, over_smooth=smooth, stderr=0.02)
    held = as_held_out_leaves(dataclasses.replace(naming, level=1.0 if gapless else 3.0), proof, sound=False)
    assert held.verdict == ("explained" if stays else "no_discrepancy")
    teeth = as_held_out_leaves(dataclasses.replace(found.naming, level=1.0 if gapless else 3.0), proof, sound=False)
    assert teeth.verdict == "explained"


@pytest.mark.parametrize(
    ("standing", "verdict", "named"),
    [
        (("tip_relief",), "explained", "tip_relief"),
        (("tip_relief", "profile_wear"), "ambiguous", "tip_relief"),
        ((), "unexplained", None),
        (("profile_slope", "tip_relief"), "ambiguous", "profile_slope"),
    ],
)
def test_an_explanation_as_good_stands_where_the_simplest_is_withdrawn(
    found: Diagnosis, monkeypatch: pytest.MonkeyPatch, standing: tuple[str, ...], verdict: str, named: str | None
) -> None:
    """Each of those that fit alike is asked by records held out; those that these leave are told apart then."""
    right, setup = found.naming.fit, found.campaign.setup
    slope, wear = (dataclasses.replace(right, effects=(kind.example(setup, "pinion"),)) for kind in (ProfileSlope, ProfileWear))
    beaten = dataclasses.replace(found.proof, over_nuisances=0.4, stderr=0.01)
    module = sys.modules["gearfem.diagnosis.diagnose"]
    monkeypatch.setattr(module, "fit", lambda problem, effects, start, progress: start)
    monkeypatch.setattr(
        module, "prove", lambda problem, fit, *other: found.proof if {e.name for e in fit.effects} <= set(standing) else beaten
    )
    near = [Rival(effects=fit.effects, score_difference=-1.0, why="", near=True, fit=fit) for fit in (right, wear)]
    naming = dataclasses.replace(found.naming, verdict="ambiguous", fit=slope, rivals=tuple(near))
    held, proof = _opened(found.problem, naming, quiet)
    assert held.verdict == verdict
    assert [effect.name for effect in held.fit.effects] == ([named] if named else [])
    if named:
        assert proof is found.proof
        others = {rival.effects[0].name: rival for rival in held.rivals}
        assert set(others) == {"tip_relief", "profile_wear", "profile_slope"} - {named}
        if named == "tip_relief":
            assert {name for name, rival in others.items() if rival.near} == set(standing) - {named}
            assert "records held out" in others["profile_slope"].why
            assert any("is left with profile_slope" in reason for reason in held.reasons)


@pytest.mark.parametrize(("level", "verdict"), [(9.0, "partly_explained"), (1.2, "explained")])
def test_one_explanation_that_is_left_explains_as_much_as_if_it_had_been_alone(found: Diagnosis, level: float, verdict: str) -> None:
    """Half of a wide gap closed is a part of it; where nuisances leave as little as in some healthy pairs no share need be."""
    near = Rival(effects=found.naming.fit.effects, score_difference=1.0, why="", near=True, fit=found.naming.fit)
    naming = dataclasses.replace(found.naming, verdict="ambiguous", level=level, closed=0.5, left=1.2, rivals=(near,))
    assert without(naming, {label(near.effects): "withdrawn"}).verdict == verdict


def test_a_record_held_out_that_no_model_has_is_left_out_of_the_proof(found: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that was fitted is not."""
    module, (held,) = sys.modules[prove.__module__], found.proof.of("holdout")
    left_of = module.left_of

    def none_of(role: str) -> None:
        def left(record: Measurement, system: System) -> Left:
            if record.role == role:
                raise SolveError("load sharing did not converge")
            return left_of(record, system)

        monkeypatch.setattr(module, "left_of", left)

    none_of("holdout")
    proof = prove(found.problem, found.naming.fit, found.naming.alone)
    assert [gap.role for gap in proof.records] == ["fit"] * len(found.problem.records)
    assert proof.over_nuisances is None
    assert proof.reasons[-1].startswith(f"{held.measurement.file} is left out of the proof")
    none_of("fit")
    with pytest.raises(SolveError, match="load sharing"):
        prove(found.problem, found.naming.fit, found.naming.alone)


def test_what_names_leave_of_the_fitted_records_is_counted_in_their_floors(found: Diagnosis) -> None:
    fitted = found.proof.of("fit")
    before, after = (
        np.sqrt(np.mean([(gap.rms(getattr(gap, word)) / gap.floor_rms) ** 2 for gap in fitted])) for word in ("nuisances_only", "after")
    )
    assert found.proof.over_fitted == pytest.approx(before / after, rel=1e-12, abs=0.0)
    assert found.proof.over_fitted > 1.0


def test_only_records_held_out_may_begin_otherwise_in_the_proof(found: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    """A fit has the fitted ones as they begin: a name that meets one from elsewhere alone has not been fitted to it."""
    asked, module = [], sys.modules[prove.__module__]
    monkeypatch.setattr(module, "nearest", lambda record, *other: asked.append(record.role) or record)
    prove(found.problem, found.naming.fit, found.naming.alone)
    assert asked == ["holdout"] * (3 * len(found.proof.of("holdout")))


@pytest.mark.parametrize(
    ("share", "floors", "doubt", "verdict"),
    [
        (0.9, 3.0, 0.02, "unexplained"),
        (0.9, 3.0, 0.06, "explained"),
        (0.9, 1.0, 0.02, "explained"),
        (1.1, 3.0, 0.02, "explained"),
    ],
)
def test_a_name_that_leaves_open_what_straying_nuisances_surely_foretell_better_is_withdrawn(
    found: Diagnosis, share: float, floors: float, doubt: float, verdict: str
) -> None:
    """However much of its gap the named effects close, unless they bring it to its floor."""

    def left(gap: Gap) -> Gap:
        series = np.full(gap.after.shape, floors * gap.expected_rms)
        return dataclasses.replace(gap, before=30.0 * series, after=series) if gap.role == "holdout" else gap

    proof = dataclasses.replace(found.proof, over_nuisances=share, stderr=doubt, records=tuple(map(left, found.proof.records)))
    held = as_held_out_leaves(found.naming, proof, sound=False)
    assert held.verdict == verdict
    assert bool(held.fit.effects) == (verdict == "explained")


def test_what_parameters_foretell_badly_opens_no_gap(found: Diagnosis) -> None:
    """Three times the floor is left, as much as a deviation of the parameters of the named effect does."""

    def left(gap: Gap, doubt: float) -> Gap:
        series = np.full(gap.after.shape, 3.0 * gap.floor_rms)
        return dataclasses.replace(gap, after=series, before=series, doubt_rms=doubt * gap.floor_rms) if gap.role == "holdout" else gap

    for doubt, verdict in ((0.0, "unexplained"), (3.0, "explained")):
        records = tuple(left(gap, doubt) for gap in found.proof.records)
        proof = dataclasses.replace(found.proof, over_nuisances=0.9, stderr=0.02, records=records)
        held = as_held_out_leaves(found.naming, proof, sound=False)
        assert held.verdict == verdict
        assert ("no better than the parameters are known" in held.reasons[-1]) == (doubt > 0.0)


def test_the_doubt_of_parameters_is_that_of_what_they_foretell(found: Diagnosis) -> None:
    """What half a deviation more does is half of it; records that were fitted have none."""
    problem, fit = found.problem, found.naming.fit
    doubts = [gap.doubt_rms for gap in found.proof.records]
    assert all((doubt > 0.0) == (gap.role == "holdout") for doubt, gap in zip(doubts, found.proof.records, strict=True))
    half = dataclasses.replace(fit, deviations=tuple({key: 0.5 * one for key, one in own.items()} for own in fit.deviations))
    again = [gap.doubt_rms for gap in prove(problem, half, found.naming.alone).records]
    assert again == pytest.approx([0.5 * doubt for doubt in doubts], rel=0.1, abs=0.0)


@pytest.mark.parametrize("share", [1.0, 0.1])
def test_the_doubt_is_what_chance_makes_of_what_records_held_out_tell(found: Diagnosis, share: float) -> None:
    """Noise alike over neighbouring rows, drawn again and again, beside an effect that acts all over a record or on a tenth of it."""
    (gap, *_) = (gap for gap in found.proof.records if gap.role == "holdout")
    rows, random = gap.after.size, np.random.default_rng(8)
    does = np.where(np.arange(rows) < share * rows, gap.expected_rms * np.sin(0.3 * np.arange(rows)), 0.0)
    told, doubts = [], []
    for _ in range(300):
        noise = gap.expected_rms * random.standard_normal(rows + 4)
        left = np.convolve(noise, np.full(5, 1.0 / math.sqrt(5.0)), "valid")
        keep = gap.measurement.keep
        told.append(float(np.mean((left + does)[keep] ** 2 - left[keep] ** 2)) / gap.expected_rms**2)
        doubts.append(_doubt([dataclasses.replace(gap, nuisances_only=left + does, after=left)]))
    assert np.median(doubts) == pytest.approx(np.std(told), rel=0.2, abs=0.0)


def test_a_record_that_neither_explains_does_not_outvote_one_that_the_name_closes(found: Diagnosis) -> None:
    """One falls from 1.3 times what is expected to it; the other stays 2.5 times as far off either way, and tells little."""
    (gap, *_) = (gap for gap in found.proof.records if gap.role == "holdout")
    rows = gap.after.size
    one, two = (gap.expected_rms * math.sqrt(2.0) * np.sin(rate * np.arange(rows)) for rate in (0.3, 0.7))
    closed = dataclasses.replace(gap, after=one, nuisances_only=one + math.sqrt(1.3**2 - 1.0) * two)
    open_either_way = dataclasses.replace(gap, after=2.51 * one, nuisances_only=2.46 * one)
    alone, both = judged((closed,), True), judged((closed, open_either_way), True)
    assert alone.over_nuisances == pytest.approx(1.3, rel=0.02, abs=0.0)
    assert both.over_nuisances == pytest.approx(math.sqrt((1.3**2 + 1.0) / (1.0 + (2.51 / 2.46) ** 2)), rel=0.02, abs=0.0)
    assert both.stderr is not None
    assert both.over_nuisances is not None
    assert both.over_nuisances - 2.0 * both.stderr > 1.0


def test_a_right_name_surely_does_better_where_nobody_looked(found: Diagnosis) -> None:
    """By more than two standard errors."""
    assert found.proof.stderr is not None
    assert found.proof.over_nuisances is not None
    assert found.proof.over_nuisances - 2.0 * found.proof.stderr > 1.0


def test_a_handful_of_numbers_withdraws_no_name(found: Diagnosis) -> None:
    """Nuisances meet it as well, at values that are less likely: what is left of it says nothing."""
    few = tuple(
        dataclasses.replace(gap, measurement=dataclasses.replace(gap.measurement, quantity=QUANTITIES["dynamic_factor"]))
        for gap in found.proof.of("fit")
    )
    assert judged(few, True).over_fitted is None
    assert judged((*few, *found.proof.of("fit")), True).over_fitted is not None
