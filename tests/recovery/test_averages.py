"""Means over the pitches, single teeth beside them, and one verdict on both."""

from __future__ import annotations

import copy
import dataclasses
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from scipy.linalg import orth

from gearfem.diagnosis import Diagnosis, choose, compare, name, read_campaign
from gearfem.diagnosis.comparing.averages import (
    HAMMERING,
    MISSED,
    PLACES,
    SLOW,
    _lines,
    _sooner_or_later,
    all_but_largest,
    averaged,
    floor_of,
    hammering,
    mean_of,
    of_single_teeth,
    of_teeth,
    shows_in_means,
    slow,
    stand,
    teeth_under,
)
from gearfem.diagnosis.comparing.comparison import Comparison
from gearfem.diagnosis.fitting.fit import Fit, again
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.bench import neutral
from gearfem.diagnosis.modelling.teeth import Scatter
from gearfem.diagnosis.naming.gap import gap_left
from gearfem.diagnosis.naming.joined import joined, verdict_of_both
from gearfem.diagnosis.naming.name import _by_rows, _of_means
from gearfem.diagnosis.naming.naming import Naming, Rival, Verdict
from gearfem.diagnosis.naming.told_apart import _scores_by_rows, told_apart
from gearfem.diagnosis.naming.verdict import explains
from gearfem.diagnosis.reading.noise import measure_noise
from gearfem.diagnosis.reading.quantities import QUANTITIES
from gearfem.diagnosis.reading.whitening import make_whitener
from gearfem.effects.catalogue import catalogue
from gearfem.effects.friction import Friction
from gearfem.effects.tip_relief import TipRelief
from gearfem.foundation import Array
from gearfem.foundation.progress import quiet
from gearfem.foundation.units import MM, UM

from .rig import PLAN, on_the_rig

LATE = {"pinion_index_error_um": [0.0] * 12 + [3.0], "wheel_index_error_um": [-2.0] + [0.0] * 16}


@pytest.fixture(scope="module")
def scattered(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    """A healthy pair, one tooth of either gear out of place by three and two micrometres."""
    records = [record | {"turns": 3.4} for record in PLAN["record"]]
    return compare(read_campaign(on_the_rig(tmp_path_factory.mktemp("late"), {"calibration": LATE}, PLAN | {"record": records})))


def _mean_of(comparison: Comparison, series: Array) -> float:
    """Return the share of the square of a whitened series, of the first record, that its mean over the pitches keeps."""
    problem = comparison.problem
    mean = averaged(problem, comparison.alone.settings)
    single, kept = (noises[0].whitener.apply(series) for noises in (problem.noises, mean.noises))
    return float(kept @ kept / (single @ single))


def test_the_mean_keeps_what_repeats_with_the_pitch_and_drops_what_does_not(scattered: Comparison) -> None:
    pitches = scattered.problem.records[0].axis / scattered.campaign.setup.pair.pinion.pitch_angle
    assert _mean_of(scattered, np.cos(2.0 * np.pi * pitches)) == pytest.approx(1.0, rel=1e-3, abs=0.0)
    # Lines between 48 places miss a tenth harmonic by (pi k/48)^4/120 of its square or so.
    assert _mean_of(scattered, np.cos(20.0 * np.pi * pitches)) > 0.98
    assert _mean_of(scattered, np.cos(np.pi * pitches)) < 0.01
    noise = np.random.default_rng(3).normal(size=pitches.size)
    assert _mean_of(scattered, noise) == pytest.approx(PLACES / pitches.size, rel=0.5, abs=0.0)


def test_where_friction_turns_round_within_a_sample_is_left_open(scattered: Comparison) -> None:
    problem, pitch = scattered.problem, scattered.campaign.setup.pair.pinion.pitch_angle
    record = dataclasses.replace(problem.records[-1], axis=np.arange(8, 104) / 32.0 * pitch)
    settings = dataclasses.replace(neutral(scattered.campaign.setup.pair), angle_offset=1e-7 * pitch)
    columns = _sooner_or_later(record, problem.bench, settings)
    # Both samples beside each pitch point, and nothing like it elsewhere.
    assert [np.flatnonzero(column).tolist() for column in columns.T] == [[23, 55, 87], [24, 56, 88]]
    rubbing = problem.bench((Friction(coefficient=0.05),))
    before, after = (rubbing.predict(record, dataclasses.replace(settings, angle_offset=shift)) for shift in (-1e-7 * pitch, 1e-7 * pitch))
    jump = after - before
    share = np.linalg.lstsq(columns, jump, rcond=None)[0]
    assert np.abs(jump).max() > 0.1 * UM
    assert np.abs(jump - columns @ share).max() < 0.05 * np.abs(jump).max()
    assert share == pytest.approx([0.0, -0.5], rel=0.0, abs=0.02)


def test_motions_whose_flanks_hammer_may_be_missed_by_more(scattered: Comparison) -> None:
    pair, bench = scattered.campaign.setup.pair, scattered.problem.bench(())
    record = scattered.problem.records[0]
    fast = dataclasses.replace(record, quantity=QUANTITIES["dynamic_transmission_error"], pinion_speed=500.0)
    late = dataclasses.replace(neutral(pair), pinion_late=np.tile([60.0 * UM, 0.0], 7)[:13])
    assert [hammering(one, bench, settings) for one, settings in ((fast, neutral(pair)), (fast, late), (record, late))] == [0.0, 1.0, 0.0]
    noise = scattered.problem.noises[0]
    mean = mean_of(fast, noise, pair)
    held, parted = (floor_of(fast, mean, pair, parts) for parts in (0.0, 1.0))
    assert (parted - 1.0) / (held - 1.0) == pytest.approx((HAMMERING / MISSED["dynamic_transmission_error"]) ** 2, rel=1e-9, abs=0.0)


def test_row_by_row_nothing_is_foretold_of_flanks_that_hammer(scattered: Comparison) -> None:
    record, noise = scattered.problem.records[0], scattered.problem.noises[0]
    fast = dataclasses.replace(record, quantity=QUANTITIES["dynamic_transmission_error"], pinion_speed=500.0)
    late = dataclasses.replace(scattered.alone.settings, pinion_late=np.tile([60.0 * UM, 0.0], 7)[:13])
    problem = Problem(scattered.campaign, (fast, record), (noise, noise), Scatter(terms=2), scattered.problem.bench)
    course = np.std(record.value[record.keep]) / noise.std
    for settings, shares in ((late, (1.0, 0.04)), (scattered.alone.settings, (0.15, 0.04))):
        found = of_single_teeth(problem, settings, ())
        assert found.floor == pytest.approx([1.0 + (share * course) ** 2 for share in shares], rel=1e-9, abs=0.0)


@pytest.mark.parametrize(("rows", "gap"), [(40.0, False), (4000.0, True)])
def test_chance_leaves_more_of_a_few_rows_off_the_rig(rows: float, gap: bool) -> None:
    """Of 40 rows 1.4 times what is expected is no gap, of 4000 it is."""
    problem = SimpleNamespace(floor=np.ones(1), counts=np.array([rows]), records=[SimpleNamespace(quantity=QUANTITIES["radial_runout"])])
    fit = SimpleNamespace(squares=np.array([1.4]))
    assert (gap_left(cast(Fit, fit), cast(Problem, problem)) > 1.0) is gap


@pytest.mark.parametrize("scale", [1.01, 1.2])
def test_nuisances_alone_are_those_that_the_search_has_found(scattered: Comparison, monkeypatch: pytest.MonkeyPatch, scale: float) -> None:
    """Where these stand more than a deviation, 5 % of the stiffness, from those before it."""
    problem, alone = scattered.problem, scattered.alone
    settings = dataclasses.replace(alone.settings, stiffness_scale=scale * alone.settings.stiffness_scale)
    mean = averaged(problem, settings)
    first = mean.fit((), mean.prepare((), mean.unknowns.of(settings)), rounds=0)
    _, single = teeth_under(problem, settings, ())
    monkeypatch.setattr(sys.modules[joined.__module__], "_one", lambda first, second, alone, fit, *words: (alone, fit))
    namings = (cast(Naming, SimpleNamespace(alone=one, fit=one)) for one in (first, single))
    found = cast(tuple[Fit, Fit], joined(problem, alone, *namings))
    expected = settings if scale > 1.1 else alone.settings
    assert [fit.settings.stiffness_scale for fit in found] == pytest.approx([expected.stiffness_scale] * 2, rel=1e-9, abs=0.0)


def test_what_a_model_may_miss_is_rough_where_noise_is_smooth(scattered: Comparison) -> None:
    """As much of the course as is missed, drawn at random over the places of the pitch."""
    pair, record = scattered.campaign.setup.pair, scattered.problem.records[0]
    noise = scattered.problem.noises[0]
    covariance = noise.covariance[0] * 0.8 ** np.arange(2)
    smooth = dataclasses.replace(noise, covariance=covariance, whitener=make_whitener(covariance, record.keep))
    mean, lines = mean_of(record, smooth, pair), _lines(record, pair)
    ways = orth(lines)
    course = ways @ (ways.T @ (record.value - record.value.mean()))
    missed = SLOW * np.std(course) * np.random.default_rng(3).standard_normal((PLACES, 200))
    left = np.mean(mean.whitener.apply(lines @ missed) ** 2)
    assert floor_of(record, mean, pair, hammering=0.0) - 1.0 == pytest.approx(left, rel=0.1, abs=0.0)
    assert left > 2.0 * SLOW**2 * np.mean(mean.whitener.apply(course) ** 2)
    keep = np.arange(len(record.axis)) != 50
    masked = dataclasses.replace(record, keep=keep, value=np.where(keep, record.value, 1e-3))
    smooth = dataclasses.replace(smooth, whitener=make_whitener(covariance, keep))
    assert floor_of(masked, mean_of(masked, smooth, pair), pair, hammering=0.0) - 1.0 == pytest.approx(left, rel=0.1, abs=0.0)


def test_the_largest_kw_of_turns_is_none_of_the_means_beside_other_motions(scattered: Comparison) -> None:
    problem, held = scattered.problem, scattered.problem.records[0]
    speeds, factors = np.array([50.0, 60.0]), np.array([1.1, 1.2])
    sweep = dataclasses.replace(
        held, file="kw.csv", quantity=QUANTITIES["dynamic_factor"], axis=speeds, value=factors, keep=np.ones(2, bool)
    )
    moving = dataclasses.replace(held, file="te.csv", quantity=QUANTITIES["dynamic_transmission_error"], pinion_speed=100.0)
    for records, files in (((held, moving, sweep), [held.file, "te.csv"]), ((held, sweep), [held.file, "kw.csv"])):
        noises = tuple(measure_noise(one, scattered.campaign.setup.pair) for one in records)
        both = Problem(problem.campaign, records, noises, Scatter(terms=2), problem.bench)
        assert [one.file for one in averaged(both, scattered.alone.settings).records] == files


def test_means_of_a_healthy_pair_are_met_within_noise(scattered: Comparison) -> None:
    mean = averaged(scattered.problem, scattered.alone.settings)
    fit = again(mean, (), mean.unknowns.of(scattered.alone.settings))
    assert gap_left(fit, mean) < 1.0
    assert fit.squares.max() < 1.5
    assert np.abs(fit.point.unknown[mean.unknowns.scales]).max() < 1.5


def test_index_errors_stand_still_in_means_and_are_found_beside_them(scattered: Comparison) -> None:
    problem, alone = scattered.problem, scattered.alone
    mean = averaged(problem, alone.settings)
    unknown = mean.unknowns.of(alone.settings)
    assert mean.unknowns.settings(unknown).pinion_late == pytest.approx(alone.settings.pinion_late, rel=1e-12, abs=0.0)
    teeth, single = teeth_under(problem, alone.settings, ())
    assert teeth.outer == 0
    assert np.argmax(single.settings.pinion_late) == 12
    assert np.argmin(single.settings.wheel_late) == 0
    late = single.settings.pinion_late - np.median(single.settings.pinion_late)
    # The rig's own scatter of half a micrometre stands on top.
    assert late[12] == pytest.approx(3.0e-6, rel=0.0, abs=1.5e-6)


def test_one_fit_of_all_rows_stands_where_both_do(scattered: Comparison) -> None:
    problem, settings = scattered.problem, dataclasses.replace(scattered.alone.settings, stiffness_scale=1.01, gain=1.005)
    teeth, single = teeth_under(problem, settings, ())
    mean = averaged(problem, settings)
    whole = stand(problem, mean.fit((), mean.prepare((), mean.unknowns.of(settings)), rounds=0), teeth, single)
    assert (whole.settings.stiffness_scale, whole.settings.gain) == pytest.approx((1.01, 1.005), rel=1e-9, abs=0.0)
    assert whole.settings.pinion_late == pytest.approx(single.settings.pinion_late, rel=1e-9, abs=1e-15)
    assert whole.squares == pytest.approx(single.squares, rel=0.0, abs=0.0)


def test_single_teeth_need_no_largest_kw(scattered: Comparison) -> None:
    problem = scattered.problem
    assert of_single_teeth(problem, scattered.alone.settings, (), all_but_largest).records == problem.records
    assert [all_but_largest(QUANTITIES[name]) for name in ("dynamic_factor", "dynamic_transmission_error")] == [False, True]
    for others, told in (([], True), (["static_transmission_error"], False), (["dynamic_transmission_error"], True)):
        records = [SimpleNamespace(quantity=QUANTITIES[name]) for name in ("mesh_stiffness", *others)]
        which = of_teeth(cast(Problem, SimpleNamespace(records=records)))
        assert [which(QUANTITIES[name]) for name in ("mesh_stiffness", "static_transmission_error", "dynamic_factor")] == [
            told,
            True,
            False,
        ]
    assert [slow(QUANTITIES[name]) for name in ("dynamic_transmission_error", "pitch_deviation")] == [False, True]


@pytest.mark.parametrize(
    ("means", "teeth", "left", "verdict"),
    [
        ("no_discrepancy", "no_discrepancy", 0.8, "no_discrepancy"),
        ("unexplained", "no_discrepancy", 0.8, "unexplained"),
        ("no_discrepancy", "unexplained", 1.5, "unexplained"),
        ("explained", "no_discrepancy", 0.8, "explained"),
        ("no_discrepancy", "explained", 0.8, "explained"),
        ("explained", "explained", 0.8, "explained"),
        ("explained", "unexplained", 1.5, "explained"),
        ("explained", "unexplained", 3.0, "partly_explained"),
        # Not for what is left: index errors do the work of something.
        ("explained", "unexplained", 0.8, "partly_explained"),
        ("unexplained", "explained", 0.8, "partly_explained"),
        ("partly_explained", "explained", 0.8, "partly_explained"),
        ("explained", "ambiguous", 0.8, "ambiguous"),
        ("ambiguous", "unexplained", 3.0, "ambiguous"),
    ],
)
def test_the_verdict_is_that_on_means_and_on_single_teeth_together(means: Verdict, teeth: Verdict, left: float, verdict: Verdict) -> None:
    assert verdict_of_both(means, teeth, left) == verdict


def test_nothing_is_named_beside_a_wave_that_no_effect_stands_for(found: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    """An encoder off its centre, which is no effect, makes one, and its mean looks like wear."""
    module = sys.modules["gearfem.diagnosis.naming.name"]
    problem, first = copy.copy(found.problem), found.naming
    assert first.fit.effects
    second = dataclasses.replace(first, verdict="unexplained", fit=first.alone, best=first.alone)
    monkeypatch.setattr(module, "_of_means", lambda *args: dataclasses.replace(first, verdict="ambiguous"))
    monkeypatch.setattr(module, "_of_means_anew", lambda problem, first, second, progress: first)
    for wavy, verdict in ((True, "unexplained"), (False, "ambiguous")):
        monkeypatch.setattr(module, "_of_teeth", lambda *args, wavy=wavy: (second, wavy))
        monkeypatch.setattr(sys.modules[joined.__module__], "whole", lambda *args: first.fit)
        naming = name(problem, first.alone, {})
        assert naming.verdict == verdict
        assert bool(naming.fit.effects) != wavy


def test_means_are_asked_again_under_a_tooth_that_gains_much_and_is_no_name_yet(found: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside a misalignment a pit leaves too much of the gap, and before the pit is known means show nothing of that."""
    module = sys.modules["gearfem.diagnosis.naming.name"]
    problem, named = copy.copy(found.problem), found.naming
    alone = named.alone
    nothing = dataclasses.replace(named, verdict="unexplained", fit=alone, best=alone, p_values=())
    for gains, verdict in ((True, "explained"), (False, "unexplained")):
        unnamed = dataclasses.replace(nothing, best=named.fit, gains=gains)
        monkeypatch.setattr(module, "_of_means", lambda problem, settings, kinds, progress, known=(), *args: named if known else nothing)
        monkeypatch.setattr(module, "_by_rows", lambda problem, means, *args: means)
        monkeypatch.setattr(
            module,
            "_of_teeth",
            lambda problem, fit, kinds, progress, before=None, unnamed=unnamed: (unnamed if before is None else named, False),
        )
        monkeypatch.setattr(sys.modules[joined.__module__], "whole", lambda *args: named.fit)
        assert name(problem, alone, {}).verdict == verdict


def test_an_effect_shows_in_means_unless_it_differs_from_pitch_to_pitch() -> None:
    assert {kind.repeats for kind in catalogue().values() if not shows_in_means(kind)} == {"one tooth", "once a turn"}


def test_explanations_that_means_cannot_tell_apart_are_judged_row_by_row(campaign: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A relief of the wheel, called one of the pinion: rows say which."""
    comparison = compare(read_campaign(campaign))
    problem, alone = comparison.problem, comparison.alone
    mean = averaged(problem, alone.settings)
    bare = again(mean, (), mean.unknowns.of(alone.settings))
    wrong, right = (
        dataclasses.replace(bare, effects=(TipRelief(gear=gear, amount=14.0 * UM, length=2.5 * MM),)) for gear in ("pinion", "wheel")
    )
    naming = Naming(
        verdict="ambiguous",
        fit=wrong,
        alone=bare,
        best=wrong,
        p_values=(0.1,),
        without="unexplained",
        gains=True,
        level=3.0,
        closed=1.0,
        left=0.9,
        rivals=(Rival(effects=right.effects, score_difference=5.0, why="", near=True, fit=right, p_values=(0.5,)),),
        identifiable=(),
        threshold=16.0,
        sentence="",
        reasons=(),
    )
    told = told_apart(problem, mean, naming, quiet)
    assert told.fit is right
    assert told.p_values == (0.5,)
    assert told.verdict == explains(told.closed, (gap_left(bare, mean), told.left))
    (lost,) = told.rivals
    assert not lost.near
    assert lost.score_difference > 100.0
    assert told_apart(problem, mean, dataclasses.replace(naming, verdict="explained"), quiet).fit is wrong
    # Where one may be as good by the doubt about its own fit, it stands within the stated threshold.
    monkeypatch.setattr(sys.modules[told_apart.__module__], "_scores_by_rows", lambda *_: [(147.0, 60.0), (100.0, 0.0)])
    open_still = told_apart(problem, mean, naming, quiet)
    assert open_still.verdict == "ambiguous"
    assert [(rival.near, rival.score_difference) for rival in open_still.rivals] == [(True, 47.0)]
    assert open_still.threshold > 47.0


def test_by_rows_no_explanation_is_better_by_where_its_fit_began(monkeypatch: pytest.MonkeyPatch) -> None:
    """Places are numbers here: 0 is where the model has all nuisances, and the wheel leaves least from where the pinion ends."""
    leaves = {("pinion", 1.0): 120.0, ("pinion", 0.0): 150.0, ("wheel", 2.0): 250.0, ("wheel", 0.0): 130.0, ("wheel", 3.0): 104.0}

    def fitted(rows: object, effects: tuple[TipRelief, ...], place: float) -> SimpleNamespace:
        (effect,) = effects
        return SimpleNamespace(effects=effects, objective=leaves[effect.gear, place], point=SimpleNamespace(stood=3.0 if place else 4.0))

    monkeypatch.setattr(sys.modules[told_apart.__module__], "attempt", fitted)
    rows = cast(Problem, SimpleNamespace(unknowns=SimpleNamespace(of=lambda settings: settings, neutral=lambda place: 0.0)))
    pinion, wheel = (
        Rival(
            effects=(TipRelief(gear=gear, amount=14.0 * UM, length=2.5 * MM),),
            score_difference=worse,
            why="",
            near=True,
            fit=cast(Fit, SimpleNamespace(settings=place)),
        )
        for gear, worse, place in (("pinion", 0.0, 1.0), ("wheel", 5.0, 2.0))
    )
    assert _scores_by_rows(rows, [pinion, wheel], quiet) == [(120.0, 30.0), (109.0, 26.0)]


def test_a_relief_that_means_do_not_name_is_named_row_by_row(tmp_path: Path) -> None:
    """Where late teeth take over, and how much of it shows, goes by what all flanks have: rows say several times as much of it."""
    small = {"name": "tip_relief", "gear": "pinion", "amount_um": 1.2, "length_mm": 4.0}
    plan = PLAN | {"record": [record | {"turns": 3.4} for record in PLAN["record"]], "scatter": {"index_error_um": 1.0}}
    comparison = compare(read_campaign(on_the_rig(tmp_path, {"effect": [small]}, plan)))
    problem, settings, kinds = comparison.problem, comparison.alone.settings, choose(catalogue(), ["tip_relief"])
    means = _of_means(problem, settings, kinds, quiet)
    assert not means.fit.effects
    naming = _by_rows(problem, means, (), kinds, quiet)
    assert naming.verdict == "explained"
    (found,), (deviations,) = naming.fit.effects, naming.fit.deviations
    assert isinstance(found, TipRelief)
    assert found.gear == "pinion"
    assert found.amount == pytest.approx(1.2 * UM, rel=0.0, abs=deviations["amount"])
    assert deviations["amount"] < 0.4 * UM
    # What is named stands beside nuisances of all records.
    assert naming.fit.settings.gain == pytest.approx(1.0, rel=0.0, abs=0.05)
