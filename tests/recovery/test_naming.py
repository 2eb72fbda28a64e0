"""What may be named: shapes, errors of our own model that imitate effects, contradictions, mirrors."""

from __future__ import annotations

import dataclasses
import math
import sys
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from gearfem.diagnosis import Diagnosis
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.inexact import inexact
from gearfem.diagnosis.fitting.parameters import at_bounds, overdone
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.score import label
from gearfem.diagnosis.modelling.model_form import form_errors
from gearfem.diagnosis.modelling.teeth import Scatter
from gearfem.diagnosis.naming.gap import wide
from gearfem.diagnosis.naming.mimic import _form_scales, mimicked
from gearfem.diagnosis.naming.name import _by_rows
from gearfem.diagnosis.naming.naming import Verdict, sentence_of
from gearfem.diagnosis.naming.search import Search
from gearfem.diagnosis.naming.suspects import improbable, misshapen
from gearfem.diagnosis.naming.verdict import _mirrored, _verdict_on, explains, judge, needed, remaining
from gearfem.diagnosis.reading.measurement import make_record
from gearfem.diagnosis.write import stderr
from gearfem.effects.body_compliance import BodyCompliance
from gearfem.effects.contact_compliance import ContactCompliance
from gearfem.effects.crowning import Crowning
from gearfem.effects.effect import Effect
from gearfem.effects.lead_misalignment import LeadMisalignment
from gearfem.effects.pitch_error import PitchError
from gearfem.effects.pitting import Pitting
from gearfem.effects.profile_slope import ProfileSlope
from gearfem.effects.profile_wear import ProfileWear
from gearfem.effects.runout import Runout
from gearfem.effects.sensor_resonance import SensorResonance
from gearfem.effects.tip_relief import TipRelief
from gearfem.foundation.progress import quiet
from gearfem.foundation.units import MM, UM
from gearfem.variants import VARIANTS


def test_a_shape_may_be_wrong_by_a_share_of_its_depth(found: Diagnosis) -> None:
    amount = 10.0 * UM
    bench = found.problem.bench((ProfileSlope(gear="pinion", amount=amount),))
    # A straight line over the path of contact, from nothing to the whole amount.
    assert bench.depth("pinion") == pytest.approx(amount / math.sqrt(3.0), rel=0.02, abs=0.0)
    assert bench.depth("wheel") == 0.0


def test_what_is_missing_all_over_has_no_form(found: Diagnosis) -> None:
    """Or a gear worn evenly, which only turns it, would widen what its flanks may be wrong by."""
    even = ProfileWear(gear="wheel", tip=12.0 * UM, root=12.0 * UM, pitch=12.0 * UM)
    assert found.problem.bench((even,)).depth("wheel") == pytest.approx(0.0, abs=0.01 * UM)


def test_a_frequency_is_in_doubt_by_a_tenth_too(found: Diagnosis) -> None:
    """It is smooth in its reciprocal, in which the doubt is."""
    effect = SensorResonance(frequency=1200.0, ratio=0.1)
    doubt = inexact(effect, found.problem)
    assert stderr(effect, "frequency", doubt["frequency"]) == pytest.approx(120.0, rel=1e-9, abs=0.0)
    assert doubt["ratio"] == 0.0


def test_half_a_lead_is_disputed_between_models(found: Diagnosis) -> None:
    """It is stated, and does not count against the name: a lead that is told from none by the data stays so."""
    effect = LeadMisalignment(slope=-10.0 * UM)
    doubt = inexact(effect, found.problem)["slope"]
    assert doubt < 2.5 * UM
    assert stderr(effect, "slope", doubt) == pytest.approx(math.hypot(5.0, doubt / UM), rel=1e-9, abs=0.0)


def test_place_and_length_are_in_doubt_by_a_tenth_of_the_length(found: Diagnosis) -> None:
    """A ragged pit ends nowhere in particular, and a rounded relief not where a straight one begins."""
    pit = Pitting(gear="pinion", tooth=1, depth=20.0 * UM, centre=9.0 * MM, width=3.0 * MM)
    assert inexact(pit, found.problem) == {
        "depth": pytest.approx(2.0 * UM, rel=1e-9, abs=0.0),
        "centre": pytest.approx(0.3 * MM, rel=1e-9, abs=0.0),
        "width": pytest.approx(0.3 * MM, rel=1e-9, abs=0.0),
    }
    relief = TipRelief(gear="pinion", amount=10.0 * UM, length=2.0 * MM)
    assert inexact(relief, found.problem)["length"] == pytest.approx(0.2 * MM, rel=1e-9, abs=0.0)


@pytest.mark.parametrize(("scale", "least", "most"), [(1.3, 0.99, 1.6), (3.0, 0.05, 0.4)])
def test_an_effect_as_strong_as_an_error_of_the_model_is_imitated_by_it(found: Diagnosis, scale: float, least: float, most: float) -> None:
    """One of the errors of the model is a contact that yields 1.3 times as much."""
    problem, effects = found.problem, (ContactCompliance(scale=scale),)
    start = problem.prepare((), np.zeros_like(found.naming.fit.point.unknown))
    (share,) = mimicked(problem, problem.fit(effects, start, rounds=0))
    assert least < share < most


def test_how_far_a_shape_may_be_wrong_imitates_another_effect_and_not_its_own(found: Diagnosis) -> None:
    problem, slope = found.problem, ProfileSlope(gear="pinion", amount=60.0 * UM)
    small = TipRelief(gear="pinion", amount=3.0 * UM, length=2.0 * MM)
    start = problem.prepare((slope, small), np.zeros_like(found.naming.fit.point.unknown))
    own, other = mimicked(problem, problem.fit((slope, small), start, rounds=0))
    start = problem.prepare((small,), np.zeros_like(found.naming.fit.point.unknown))
    (alone,) = mimicked(problem, problem.fit((small,), start, rounds=0))
    assert own < 0.2
    assert other > 3.0 * alone


def test_only_forms_of_the_gear_without_its_effect_are_smaller(found: Diagnosis) -> None:
    """Errors of the model stand before them, forms of the other gear and the rise of the largest Kw behind."""
    problem, slope = found.problem, ProfileSlope(gear="pinion", amount=60.0 * UM)
    problem.prepare((slope,), np.zeros_like(found.naming.fit.point.unknown))
    terms, first = problem.unknowns.scatter.terms, len(problem.unknowns.errors)
    scales = _form_scales(problem, (), first + 2 * terms + 1)
    pinion = scales[first : first + terms]
    assert pinion == pytest.approx(form_errors(problem.bench(()))[0] / form_errors(problem.bench((slope,)))[0], rel=1e-12, abs=0.0)
    assert pinion[0] < 0.1
    assert np.delete(scales, np.arange(first, first + terms)) == pytest.approx(1.0, rel=0.0, abs=0.0)


def _barred(found: Diagnosis, *effects: Effect, doubt: float = 0.0) -> str:
    """Return why effects may not be named, if each parameter is so far in doubt."""
    deviations = tuple(dict.fromkeys(effect.fitted(), doubt) for effect in effects)
    return Search(found.problem, found.naming.alone).barred(dataclasses.replace(found.naming.fit, effects=effects, deviations=deviations))


@pytest.mark.parametrize(
    ("effect", "doubt", "named"),
    [
        (ProfileSlope(gear="pinion", amount=-9.0 * UM), 2.9 * UM, True),
        (ProfileSlope(gear="pinion", amount=-9.0 * UM), 3.1 * UM, False),
        (ContactCompliance(scale=0.8), 0.07, False),
        (ProfileWear(gear="wheel", tip=1.0 * UM, root=9.0 * UM, pitch=0.0), 2.0 * UM, True),
        (SensorResonance(frequency=2000.0, ratio=0.1), 1.0 / 5900.0, False),
        (SensorResonance(frequency=2000.0, ratio=0.1), 1.0 / 6100.0, True),
    ],
)
def test_what_is_not_surely_there_is_not_named(found: Diagnosis, effect: Effect, doubt: float, named: bool) -> None:
    assert ("against its own doubt" in _barred(found, effect, doubt=doubt)) != named


def test_what_is_as_strong_as_can_be_is_not_named(found: Diagnosis) -> None:
    setup, slope = found.problem.campaign.setup, ProfileSlope(gear="pinion", amount=5.0 * UM)
    most = ContactCompliance(scale=0.05)
    assert overdone((slope, most), setup) == (most,)
    assert _barred(found, slope, most).startswith(most.describe())
    # At its neutral value it does nothing, and a length says where.
    longest = TipRelief.parameters()["length"].bounds(setup, "wheel")[1]
    none, long = (TipRelief(gear="wheel", amount=amount, length=longest) for amount in (1e-12, 9.0 * UM))
    assert at_bounds((none, long), setup) == ((0, "amount"), (0, "length"), (1, "length"))
    assert not overdone((none, long), setup)


@pytest.mark.parametrize(("tip", "root", "pitch", "named"), [(6.0, 9.0, 1.0, True), (1.0, 9.0, 1.8, True), (1.0, 9.0, 2.0, False)])
def test_wear_that_is_not_least_at_the_pitch_point_is_not_named(
    found: Diagnosis, tip: float, root: float, pitch: float, named: bool
) -> None:
    wear = ProfileWear(gear="wheel", tip=tip * UM, root=root * UM, pitch=pitch * UM)
    why = _barred(found, wear)
    assert ("nothing slides" in why) != named


@pytest.mark.parametrize(("scale", "words"), [(0.4, "only on a hub"), (0.6, ""), (4.9, ""), (5.1, "a third of the mesh stiffness")])
def test_no_blank_makes_a_body_yield_less_than_half_or_more_than_five_times(found: Diagnosis, scale: float, words: str) -> None:
    bodies = BodyCompliance(scale=scale)
    assert words in _barred(found, bodies)
    assert bool(bodies.contradicts()) == bool(words)


@pytest.mark.parametrize(
    ("common", "explained", "effect", "least"),
    [
        (True, True, ProfileSlope(gear="pinion", amount=1.0 * UM), 64.0),
        (True, False, ProfileSlope(gear="pinion", amount=1.0 * UM), 16.0),
        (False, True, ProfileSlope(gear="pinion", amount=1.0 * UM), 16.0),
        (True, True, BodyCompliance(scale=1.5), 16.0),
    ],
)
def test_a_form_of_the_flanks_must_gain_more_of_means_that_nuisances_alone_explain(
    monkeypatch: pytest.MonkeyPatch, common: bool, explained: bool, effect: Effect, least: float
) -> None:
    """Where nothing but the odds of nuisances speaks for it."""
    monkeypatch.setattr("gearfem.diagnosis.naming.verdict.sound", lambda search: explained)
    problem = SimpleNamespace(detected=16.0, wander=16.0, imitated=3.0, unknowns=SimpleNamespace(scatter=SimpleNamespace(common=common)))
    assert needed(cast(Search, SimpleNamespace(problem=problem)), (effect,)) == least


@pytest.mark.parametrize(
    ("effects", "rows", "least"),
    [
        ((PitchError(gear="wheel", tooth=3, amount=6.0 * UM),), 3.0, 80.0),
        ((Runout(gear="wheel", eccentricity=2.0 * UM, angle=0.0),), 3.0, 40.0),
        ((Runout(gear="wheel", eccentricity=2.0 * UM, angle=0.0),), 56.0, 56.0),
        ((Runout(gear="wheel", eccentricity=2.0 * UM, angle=0.0), PitchError(gear="wheel", tooth=3, amount=6.0 * UM)), 3.0, 80.0),
    ],
)
def test_what_turns_with_a_shaft_is_not_imitated_by_single_teeth(effects: tuple[Effect, ...], rows: float, least: float) -> None:
    problem = SimpleNamespace(detected=max(80.0, rows), wander=40.0, imitated=rows, unknowns=SimpleNamespace(scatter=Scatter()))
    assert needed(cast(Search, SimpleNamespace(problem=problem)), effects) == least


@pytest.mark.parametrize(("left", "verdict"), [(0.9, "no_discrepancy"), (1.1, "unexplained")])
def test_rows_that_name_nothing_and_leave_no_gap_change_no_verdict(
    monkeypatch: pytest.MonkeyPatch, found: Diagnosis, left: float, verdict: str
) -> None:
    # The package has the function of that name.
    alone, module = found.naming.alone, sys.modules[_by_rows.__module__]
    means = dataclasses.replace(found.naming, verdict="no_discrepancy", without="no_discrepancy", fit=alone, rivals=())
    rows = dataclasses.replace(means, verdict="unexplained", without="unexplained", left=left, reasons=("far off",))
    monkeypatch.setattr(module, "row_by_row", lambda problem, known: problem)
    monkeypatch.setattr(module, "bare", lambda problem, unknown: alone)
    monkeypatch.setattr(module, "select", lambda *arguments, **options: rows)
    judged = _by_rows(found.problem, means, (), {}, quiet)
    assert (judged.verdict, judged.without) == (verdict, verdict)
    assert judged.reasons[-1] == "row by row: far off"


@pytest.mark.parametrize(("left", "verdict"), [(0.9, "no_discrepancy"), (1.9, "no_discrepancy"), (2.1, "unexplained")])
def test_a_gap_that_some_healthy_pairs_leave_says_nothing_is_missing(found: Diagnosis, left: float, verdict: str) -> None:
    assert _verdict_on(found.problem, found.naming.alone, 0.0, (left, left), sound=True, close=[]) == verdict


@pytest.mark.parametrize(
    ("level", "left", "verdict"),
    [(145.0, 3.1, "partly_explained"), (17.0, 3.4, "unexplained"), (5000.0, 500.0, "unexplained"), (20.0, 2.0, "explained")],
)
def test_a_name_stands_beside_a_rest_that_is_little_of_the_gap(found: Diagnosis, level: float, left: float, verdict: str) -> None:
    assert _verdict_on(found.problem, found.naming.fit, 0.95, (level, left), sound=False, close=[]) == verdict


@pytest.mark.parametrize(("moved", "so_far"), [(1.2, False), (2.0, True)])
def test_nuisances_that_are_each_likely_may_not_be_so_together(found: Diagnosis, moved: float, so_far: bool) -> None:
    """Wherever the zero of the angle is, of which nothing is known."""
    problem, alone = found.problem, found.naming.alone
    unknown = alone.point.unknown.copy()
    unknown[: problem.outer] = moved
    unknown[[nuisance.name for nuisance in problem.nuisances].index("angle_offset")] = 9.0
    unknown[problem.unknowns.wrong] = -moved
    assert improbable(problem, dataclasses.replace(alone, point=dataclasses.replace(alone.point, unknown=unknown))) is so_far


def test_a_smooth_shape_in_smooth_noise_is_no_agreement() -> None:
    """Row by row nothing tells it from noise that wanders, which its size does."""
    record = make_record("flank_profile", np.linspace(0.01, 0.02, 80), gear="wheel", tooth=0)
    problem: Any = SimpleNamespace(records=(record,), noises=(SimpleNamespace(std=40.0 * UM),))
    for size, found in ((120.0, [("flank_profile", pytest.approx(3.0))]), (60.0, [])):
        fit: Any = SimpleNamespace(left=(np.full(80, size * UM),))
        assert wide(problem, fit) == found


@pytest.mark.parametrize(("closed", "words"), [(0.94, "closes 94 % of the gap"), (-0.01, "nuisances alone leave as little")])
def test_no_name_closes_less_than_nothing(found: Diagnosis, closed: float, words: str) -> None:
    assert words in sentence_of("explained", found.naming.fit, closed)


def test_the_mirror_of_an_explanation_is_the_same_on_the_other_gear() -> None:
    slope = ProfileSlope(gear="pinion", amount=5.0 * UM)
    pit = Pitting(gear="pinion", tooth=3, depth=4.0 * UM, centre=5.0 * MM, width=2.0 * MM)
    other, relief = ProfileSlope(gear="wheel", amount=-4.0 * UM), TipRelief(gear="wheel", amount=3.0 * UM, length=2.0 * MM)

    def mirrored(*sets: tuple[Effect, ...]) -> bool:
        return _mirrored(*(cast(Fit, SimpleNamespace(effects=effects)) for effects in sets))

    assert mirrored((other,), (slope,))
    assert mirrored((pit, other), (slope, pit))
    assert not mirrored((relief,), (slope,))
    assert not mirrored((dataclasses.replace(pit, gear="wheel"),), (pit,))
    assert not mirrored(
        (Runout(gear="wheel", eccentricity=5.0 * UM, angle=1.0),), (Runout(gear="pinion", eccentricity=5.0 * UM, angle=1.0),)
    )


def test_what_either_gear_may_have_is_fitted_once_and_left_open(found: Diagnosis) -> None:
    """The flanks leave the same gap, whoever is crowned: a rival on the other gear is as good, and costs no fit."""
    problem, alone = found.problem, found.naming.alone
    pinions, wheels = Crowning(gear="pinion", amount=8.0 * UM), Crowning(gear="wheel", amount=8.0 * UM)
    for one, other in zip(*(problem.predict((effect,), alone.point.stood) for effect in (pinions, wheels)), strict=True):
        assert np.array_equal(one, other)
    fit = dataclasses.replace(found.naming.fit, effects=(pinions,), deviations=({"amount": 0.5 * UM},), bound=())
    search = Search(problem, alone)
    search.fits[label((wheels,))] = fit
    judged = judge(search, ())
    assert judged.verdict == "ambiguous"
    (rival,) = judged.rivals
    assert (rival.effects[0].table(), rival.score_difference, rival.near) == (wheels.table(), 0.0, True)


def test_errors_of_the_model_too_large_to_be_any_are_told_and_common_forms_together() -> None:
    unknowns = SimpleNamespace(wrong=slice(2, 8), forms=slice(8, 11), ways=slice(11, 13), touch=13, errors=VARIANTS)
    moved = np.array([9.0, 9.0, 0.0, -5.5, 4.9, 0.0, 0.0, 0.0, 6.0, -7.0, 5.0, 3.0, -6.0, 1.1, 8.0])
    problem, fit = SimpleNamespace(unknowns=unknowns), SimpleNamespace(point=SimpleNamespace(unknown=moved))
    told = misshapen(cast(Problem, problem), cast(Fit, fit))
    assert [size for _, size in told] == pytest.approx([-5.5, math.sqrt(36.0 + 49.0 + 25.0), math.sqrt(9.0 + 36.0), 8.0])
    words = ("gear bodies", "forms common", "friction turns round", "largest Kw")
    assert all(word in name for word, (name, _) in zip(words, told, strict=True))


@pytest.mark.parametrize(
    ("closed", "level", "remains", "verdict"),
    [
        (0.95, 9.0, 1.5, "explained"),
        (0.5, 9.0, 0.96, "explained"),
        (0.5, 9.0, 1.2, "partly_explained"),
        (0.1, 1.3, 1.2, "explained"),
        (0.1, 1.3, 2.1, "partly_explained"),
    ],
)
def test_what_leaves_no_gap_explains_the_whole_however_little_there_was(
    closed: float, level: float, remains: float, verdict: Verdict
) -> None:
    """Nor need it close what nuisances alone leave of some healthy pairs too."""
    assert explains(closed, (level, remains)) == verdict


@pytest.mark.parametrize(
    ("level", "left", "form", "verdict"),
    [(1.3, 1.2, 0.0, "explained"), (1.3, 2.5, 0.0, "unexplained"), (2.5, 2.2, 0.0, "unexplained"), (1.3, 1.2, 9.0, "unexplained")],
)
def test_a_name_need_not_close_what_healthy_pairs_leave_too(found: Diagnosis, level: float, left: float, form: float, verdict: str) -> None:
    """Unless a form stays on all teeth, in prior deviations, that it does not stand for."""
    problem, fit = found.problem, found.naming.fit
    unknown = fit.point.unknown.copy()
    unknown[problem.unknowns.wrong.stop] = form
    fit = dataclasses.replace(fit, point=dataclasses.replace(fit.point, unknown=unknown))
    assert _verdict_on(problem, fit, 0.1, (level, left), sound=False, close=[]) == verdict


@pytest.mark.parametrize(
    ("form", "closed", "verdict"),
    [(4.9, 0.5, "explained"), (9.0, 0.95, "explained"), (9.0, 0.7, "partly_explained"), (9.0, 0.5, "unexplained")],
)
def test_forms_of_all_teeth_beside_a_name_are_left_to_be_explained(found: Diagnosis, form: float, closed: float, verdict: str) -> None:
    """However little the records show of them, since they do the work of what is missing."""
    problem, fit = found.problem, found.naming.fit
    unknown = fit.point.unknown.copy()
    unknown[problem.unknowns.forms] = 0.0
    unknown[problem.unknowns.forms.start] = form
    fit = dataclasses.replace(fit, point=dataclasses.replace(fit.point, unknown=unknown), squares=problem.floor)
    assert (remaining(fit, problem) == 1.0) == (form > 5.0)
    assert remaining(dataclasses.replace(fit, effects=()), problem) < 1.0
    assert _verdict_on(problem, fit, closed, (9.0, remaining(fit, problem)), sound=False, close=[]) == verdict


@pytest.mark.parametrize(("moved", "verdict"), [(4.9, "explained"), (-5.1, "unexplained")])
def test_no_name_stands_beside_an_error_of_the_model_that_is_too_large_to_be_any(found: Diagnosis, moved: float, verdict: str) -> None:
    """What such an error does the work of is still missing."""
    search, fit = Search(found.problem, found.naming.alone), found.naming.fit
    unknown = fit.point.unknown.copy()
    unknown[found.problem.unknowns.wrong.start] = moved
    search.fits[label(fit.effects)] = dataclasses.replace(fit, point=dataclasses.replace(fit.point, unknown=unknown))
    assert judge(search, found.naming.identifiable).verdict == verdict
