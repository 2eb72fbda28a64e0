"""A whole diagnosis of a small campaign from the virtual rig: what it proves, writes and suggests."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from click.testing import CliRunner

from gearfem.assembly import assemble
from gearfem.cli import main
from gearfem.definition.setup import Member
from gearfem.diagnosis import Diagnosis, choose, compare, diagnose, fit, likely_teeth, prove, read_campaign, write_diagnosis
from gearfem.diagnosis.diagnose import _held
from gearfem.diagnosis.fit import Fit, jacobian
from gearfem.diagnosis.mimic import mimicked
from gearfem.diagnosis.parameters import at_bounds, overdone
from gearfem.diagnosis.problem import Problem
from gearfem.diagnosis.prove import Gap, _doubt
from gearfem.diagnosis.search import Search, stays, uneven, waves_of
from gearfem.diagnosis.suggest import suggest
from gearfem.diagnosis.verdict import _mirrored, closure
from gearfem.diagnosis.write import as_json
from gearfem.effects.catalogue import catalogue
from gearfem.effects.contact_compliance import ContactCompliance
from gearfem.effects.effect import Effect
from gearfem.effects.pitting import Pitting
from gearfem.effects.profile_slope import ProfileSlope
from gearfem.effects.profile_wear import ProfileWear
from gearfem.effects.runout import Runout
from gearfem.effects.tip_relief import TipRelief
from gearfem.foundation import InputError
from gearfem.foundation.toml import write_toml
from gearfem.foundation.units import MM, UM
from gearfem.model import load_model, make_setup
from gearfem.report import write_diagnosis_report
from gearfem.rig import measure, read_plan
from gearfem.sensing import observe, requests

NOMINAL: dict[str, Any] = {
    "name": "small pair",
    "pair": {"module_mm": 3.0, "face_width_mm": 20.0, "normal_backlash_mm": 0.1},
    "pinion": {"teeth": 13, "profile_shift": 0.3},
    "wheel": {"teeth": 17},
    "operation": {"pinion_torque_Nm": 100.0, "pinion_speed_rpm": 1000.0},
}
HIDDEN = {"name": "tip_relief", "gear": "wheel", "amount_um": 14.0, "length_mm": 2.5}
TORQUES = (6.0, 40.0, 80.0, 120.0)
PLAN: dict[str, Any] = {
    "name": "rig 7",
    "seed": 7,
    "scatter": {"index_error_um": 0.5},
    "instrument": {"noise_std": 0.2},
    "record": [
        {"file": f"te_{torque:g}Nm.csv", "quantity": "static_transmission_error", "pinion_torque_Nm": torque}
        | {"samples_per_turn": 234, "turns": 1.4}
        for torque in TORQUES
    ],
}


def on_the_rig(folder: Path, hidden: dict[str, Any], plan: dict[str, Any] = PLAN) -> Path:
    """Measure the nominal pair with what is hidden in it on the virtual rig; return the campaign file."""
    write_toml(folder / "true.toml", NOMINAL | hidden)
    write_toml(folder / "plan.toml", plan)
    true = load_model(folder / "true.toml")
    measure(true, read_plan(folder / "plan.toml", true.pair), NOMINAL, folder / "rig")
    return folder / "rig" / "campaign.toml"


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Measure a pair with tip relief on the virtual rig; return the campaign file."""
    return on_the_rig(tmp_path_factory.mktemp("campaign"), {"effect": [HIDDEN], "calibration": {"stiffness_scale": 1.02}})


@pytest.fixture(scope="module")
def found(campaign: Path) -> Diagnosis:
    return diagnose(read_campaign(campaign), choose(catalogue(), ["tip_relief"]))


def runout_off_the_rig(folder: Path, eccentricity: float) -> Path:
    """Write a campaign of one gear without its mate: its runout twice, with noise and scatter of its teeth [um]."""
    random = np.random.default_rng(11)
    write_toml(folder / "nominal.toml", NOMINAL)
    for name in ("fit", "holdout"):
        teeth = np.arange(34)
        values = eccentricity * np.cos(2.0 * math.pi * teeth / 17.0 - 1.0) + random.normal(scale=1.0, size=34)
        rows = "".join(f"{tooth},{value:.3f}\n" for tooth, value in zip(teeth, values, strict=True))
        (folder / f"{name}.csv").write_text("tooth,radial_deviation_um\n" + rows)
    records = [{"file": f"{role}.csv", "quantity": "radial_runout", "gear": "wheel", "role": role} for role in ("fit", "holdout")]
    write_toml(folder / "campaign.toml", {"model": "nominal.toml", "angle_zero": "unknown", "record": records})
    return folder / "campaign.toml"


@pytest.mark.parametrize(("eccentricity", "named"), [(25.0, ["runout"]), (0.0, [])])
def test_a_gear_off_the_rig_is_diagnosed_by_itself(tmp_path: Path, eccentricity: float, named: list[str]) -> None:
    """No load, no motion: no nuisance of either has a part in it."""
    found = diagnose(
        read_campaign(runout_off_the_rig(tmp_path, eccentricity)), choose(catalogue(), ["runout", "pitch_error", "tip_relief"])
    )
    assert found.problem.outer == 0
    assert [effect.name for effect in found.naming.fit.effects] == named
    if named:
        (runout,) = found.naming.fit.effects
        assert isinstance(runout, Runout)
        assert runout.gear == "wheel"
        assert runout.eccentricity == pytest.approx(eccentricity * UM, rel=0.05, abs=0.0)
    else:
        assert found.naming.verdict == "no_discrepancy"
        assert not any(rival.near for rival in found.naming.rivals)
    write_diagnosis(found, tmp_path / "out")
    assert json.loads((tmp_path / "out" / "diagnosis.json").read_text())["verdict"] == found.naming.verdict


def test_how_the_gears_are_built_is_found_and_taken_for_no_effect(tmp_path: Path) -> None:
    """Sharp tip edges and neighbours that feel half as much leave as much as micrometres of relief would."""
    built = {"coupling_scale": 0.5, "tip_edge_scale": 0.25}
    found = diagnose(read_campaign(on_the_rig(tmp_path, {"calibration": built})), choose(catalogue(), ["tip_relief", "profile_slope"]))
    assert found.naming.verdict == "no_discrepancy"
    shifts = {shift.name: shift for shift in found.comparison.shifts}
    for name, value in built.items():
        assert shifts[name].value == pytest.approx(value, rel=0.0, abs=2.0 * shifts[name].stderr)
        assert shifts[name].stderr < 0.45


def test_the_named_effect_beats_nuisances_and_a_smooth_correction_where_nobody_looked(found: Diagnosis) -> None:
    (held,) = found.proof.of("holdout")
    assert held.measurement.pinion_torque == 80.0
    assert found.proof.stands
    assert found.proof.over_nuisances is not None
    assert found.proof.over_nuisances > 1.5
    assert held.rms(held.after) < 0.3 * held.rms(held.before)
    # 0.2 um of noise, and no waviness on this rig: what the floor adds to it is the doubt of the fit.
    assert held.noise_rms == pytest.approx(0.2 * UM, rel=0.15, abs=0.0)
    assert held.noise_rms < held.floor_rms < 1.5 * held.noise_rms


def test_hold_out_records_do_not_touch_the_fit(campaign: Path, found: Diagnosis) -> None:
    assert {record.file for record in found.problem.records} == {f"te_{torque:g}Nm.csv" for torque in TORQUES if torque != 80.0}


def test_the_updated_model_meets_every_record_as_the_proof_does(found: Diagnosis, tmp_path: Path) -> None:
    write_diagnosis(found, tmp_path)
    setup = load_model(tmp_path / "updated.toml")
    system = assemble(setup)
    gaps = json.loads((tmp_path / "diagnosis.json").read_text())["gap"]
    for record, gap in zip(found.campaign.records, gaps, strict=True):
        request = requests()[record.quantity.name](axis=record.axis, pinion_torque=record.pinion_torque, file=record.file)
        left = (record.value - observe(system, request))[record.keep] / UM
        assert float(np.sqrt(np.mean(left**2))) == pytest.approx(gap["after_rms"], rel=1e-6)


def test_the_result_has_the_keys_and_units_of_its_format(found: Diagnosis) -> None:
    result = as_json(found)
    assert result["verdict"] in ("explained", "partly_explained", "ambiguous")
    effect = result["effects"][0]
    assert effect["name"] == "tip_relief"
    assert effect["parameters"]["gear"] == {"value": "wheel"}
    assert effect["parameters"]["amount_um"]["value"] == pytest.approx(14.0, rel=0.3)
    assert effect["parameters"]["length_mm"]["stderr"] > 0.0
    assert {gap["role"] for gap in result["gap"]} == {"fit", "holdout"}
    assert all(gap["unit"] == "um" for gap in result["gap"])
    assert {place["domain"] for place in result["where"]} <= {"mesh_phase", "order", "tooth", "frequency"}
    json.dumps(result, allow_nan=False)


def test_the_report_holds_its_pictures_and_asks_nothing_of_the_network(found: Diagnosis, tmp_path: Path) -> None:
    files = write_diagnosis_report(found, tmp_path)
    page = files[0].read_text()
    assert found.naming.sentence in page
    assert page.count("data:image/png;base64,") == len(files) - 1 == 6
    assert "http" not in page
    for record in found.campaign.records:
        assert record.file in page


def test_a_measurement_that_cannot_decide_is_not_suggested(found: Diagnosis) -> None:
    relief = TipRelief(gear="wheel", amount=14.0 * UM, length=2.5 * MM)
    slope = ProfileSlope(gear="pinion", amount=8.0 * UM)
    ranked = suggest(found.problem, found.naming.fit, [(slope,)] if found.naming.fit.effects else [(relief,), (slope,)])
    words = [one.words for one in ranked]
    # Neither effect moves an axis: runout is the same under both.
    runout = next(one for one in ranked if one.words == "the radial runout of the wheel")
    assert runout.separation < 1e-6
    assert words.index(runout.words) >= len(words) - 4
    assert ranked[0].separation > 5.0


def test_derivatives_are_those_of_the_effects_and_not_of_index_errors_that_were_just_solved(found: Diagnosis) -> None:
    problem, effects = found.problem, found.naming.fit.effects
    start = problem.prepare(effects, np.zeros_like(found.naming.fit.point.unknown))
    point, step = problem.at(effects, start), 0.01 * effects[0].amount
    (ahead,) = (dataclasses.replace(effect, amount=effect.amount + step) for effect in effects)
    # Both predictions hold the index errors of the start.
    change = (point.residual - problem.at((ahead,), start).residual) / step
    assert np.abs(point.unknown[problem.unknowns.late]).max() > 0.2
    assert np.linalg.norm(jacobian(problem, point)[:, 0] - change) < 0.03 * np.linalg.norm(change)


def test_a_shape_may_be_wrong_by_a_share_of_its_depth(found: Diagnosis) -> None:
    amount = 10.0 * UM
    bench = found.problem.bench((ProfileSlope(gear="pinion", amount=amount),))
    # A straight line over the path of contact, from nothing to the whole amount.
    assert bench.depth("pinion") == pytest.approx(amount / math.sqrt(3.0), rel=0.02, abs=0.0)
    assert bench.depth("wheel") == 0.0


@pytest.mark.parametrize(("scale", "least", "most"), [(1.5, 0.99, 1.5), (3.0, 0.05, 0.4)])
def test_an_effect_as_strong_as_an_error_of_the_model_is_imitated_by_it(found: Diagnosis, scale: float, least: float, most: float) -> None:
    """One of the errors of the model is a contact that yields 1.5 times as much."""
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
    held = _held(found.naming, dataclasses.replace(found.proof, over_nuisances=share, stderr=doubt), stays)
    assert held.verdict == verdict
    assert bool(held.fit.effects) == (verdict == "explained")


@pytest.mark.parametrize(("share", "floors", "verdict"), [(0.9, 3.0, "partly_explained"), (0.9, 1.0, "explained"), (1.1, 3.0, "explained")])
def test_a_record_held_out_that_straying_nuisances_foretell_better_is_not_explained(
    found: Diagnosis, share: float, floors: float, verdict: str
) -> None:
    """However much of its gap the named effects close, unless they bring it to its floor."""

    def left(gap: Gap) -> Gap:
        series = np.full(gap.after.shape, floors * gap.floor_rms)
        return dataclasses.replace(gap, before=30.0 * series, after=series) if gap.role == "holdout" else gap

    proof = dataclasses.replace(found.proof, over_nuisances=share, records=tuple(map(left, found.proof.records)))
    held = _held(found.naming, proof, sound=False)
    assert held.verdict == verdict
    assert held.fit is found.naming.fit


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


def test_waves_of_index_errors_do_the_work_of_an_effect(found: Diagnosis) -> None:
    """Teeth late by chance are none, a wave twice a turn is: brought back, it leaves the gap that it had closed."""
    problem, fit = found.problem, found.naming.alone
    late, turn = problem.unknowns.late, 2.0 * math.pi * np.arange(17) / 17

    def with_errors(wave: float) -> Fit:
        unknown = np.zeros_like(fit.point.unknown)
        unknown[late] = np.random.default_rng(5).normal(size=30)
        unknown[late][13:] += wave * np.cos(2.0 * turn + 0.3)
        return dataclasses.replace(fit, point=dataclasses.replace(fit.point, unknown=unknown))

    chance, wavy = with_errors(0.0), with_errors(6.0)
    tooth, waves = uneven(problem, wavy)
    assert waves[1] == pytest.approx(6.0 * math.sqrt(17 / 2), rel=0.25, abs=0.0)
    assert waves[1] > 5.0 > 3.0 > max(waves[0], *tooth, *uneven(problem, chance).ravel())
    assert stays(problem, chance)
    assert not stays(problem, wavy)
    assert closure(chance, chance, problem) == pytest.approx(0.0, abs=1e-9)
    assert closure(wavy, chance, problem) > 0.5
    assert waves_of(np.cos(2.0 * turn) + 3.0 + np.cos(5.0 * turn)) == pytest.approx(np.cos(2.0 * turn), abs=1e-12, rel=0.0)


def test_what_is_as_strong_as_can_be_is_not_named(found: Diagnosis) -> None:
    setup, slope = found.problem.campaign.setup, ProfileSlope(gear="pinion", amount=5.0 * UM)
    most = ContactCompliance(scale=0.05)
    assert overdone((slope, most), setup) == (most,)
    ended = dataclasses.replace(found.naming.fit, effects=(slope, most))
    assert Search(found.problem, found.naming.alone).barred(ended).startswith(most.describe())
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
    why = Search(found.problem, found.naming.alone).barred(dataclasses.replace(found.naming.fit, effects=(wear,)))
    assert ("nothing slides" in why) != named


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


def test_places_at_which_a_shape_cannot_be_computed_are_left_out(found: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    over = likely_teeth._over_a_turn

    def refuse(problem: Problem, base: Fit, effects: tuple[Effect, ...], member: Member) -> list[Any]:
        if any(isinstance(effect, Pitting) for effect in effects):
            raise InputError("depth1", "-1", "0 or more")
        return over(problem, base, effects, member)

    assert likely_teeth.starts_of(found.problem, found.naming.alone, Pitting, "pinion")
    monkeypatch.setattr(likely_teeth, "_over_a_turn", refuse)
    assert likely_teeth.starts_of(found.problem, found.naming.alone, Pitting, "pinion") == []


def test_records_that_agree_end_before_the_search(tmp_path: Path) -> None:
    steps: list[str] = []
    kinds, measured = choose(catalogue(), ["tip_relief", "pitch_error"]), read_campaign(on_the_rig(tmp_path, {}))
    naming = diagnose(measured, kinds, lambda words, done, total: steps.append(words)).naming
    assert naming.verdict == "no_discrepancy"
    assert "candidates" in steps
    assert "single effects" not in steps


def test_only_and_exclude_refuse_names_that_do_not_exist() -> None:
    with pytest.raises(InputError, match="tip_relief"):
        choose(catalogue(), ["tiprelief"])
    with pytest.raises(InputError, match="no effect left"):
        choose(catalogue(), ["runout"], ["runout"])
    assert "runout" not in choose(catalogue(), exclude=["runout"])


@pytest.mark.parametrize("words", [["--only", "tiprelief"], ["--effects", "nowhere.py"], []])
def test_a_refused_command_ends_in_one_line_and_leaves_nothing(tmp_path: Path, words: list[str]) -> None:
    (tmp_path / "campaign.toml").write_text("name = 3\n")
    result = CliRunner().invoke(main, ["diagnose", str(tmp_path / "campaign.toml"), "--out", str(tmp_path / "out"), *words])
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith("error: ")
    assert not (tmp_path / "out").exists()


def test_a_record_of_unknown_first_tooth_is_turned_until_it_fits(tmp_path: Path) -> None:
    """Indicator readings alone: no angle, no torque, and a hold-out record whose first tooth nobody noted."""
    runout = {"name": "runout", "gear": "wheel", "eccentricity_um": 12.0, "angle_rad": 1.0}
    write_toml(tmp_path / "true.toml", NOMINAL | {"effect": [runout]})
    records = [
        {"file": "runout.csv", "quantity": "radial_runout", "gear": "wheel", "turns": 3.0, "noise_std": 1.0},
        {"file": "pitch.csv", "quantity": "pitch_deviation", "gear": "wheel", "turns": 2.0, "noise_std": 0.5}
        | {"role": "holdout", "tooth_zero": "unknown"},
    ]
    write_toml(tmp_path / "plan.toml", {"name": "indicator", "seed": 5, "record": records})
    true = load_model(tmp_path / "true.toml")
    measure(true, read_plan(tmp_path / "plan.toml", true.pair), NOMINAL, tmp_path / "rig")
    drawn = json.loads((tmp_path / "rig" / "truth.json").read_text())["records"]["pitch.csv"]["first_tooth"]
    campaign = read_campaign(tmp_path / "rig" / "campaign.toml")
    comparison = compare(campaign)
    problem, alone = comparison.problem, comparison.alone
    proof = prove(problem, fit(problem, [Runout(gear="wheel", eccentricity=8.0 * UM, angle=0.5)], alone), alone)
    (held,) = proof.of("holdout")
    assert drawn > 0
    assert held.first_tooth == drawn
    assert held.smooth.size == 0
    assert held.rms(held.after) == pytest.approx(0.5 * UM, rel=0.4, abs=0.0)
    assert proof.stands


def test_a_narrow_pit_between_the_places_tried_is_found(tmp_path: Path) -> None:
    low, high = Pitting.parameters()["centre"].bounds(make_setup(NOMINAL), "wheel")
    centre = low + 0.5 * (high - low)
    hidden = {"name": "pitting", "gear": "wheel", "tooth": 4, "depth_um": 20.0, "centre_mm": centre / MM, "width_mm": 1.2}
    naming = diagnose(read_campaign(on_the_rig(tmp_path, {"effect": [hidden]})), choose(catalogue(), ["pitting"])).naming
    (found,) = naming.fit.effects
    assert naming.verdict == "explained"
    assert (found.gear, found.tooth) == ("wheel", 4)
    assert found.centre == pytest.approx(centre, rel=0.0, abs=0.3 * MM)


def test_a_tooth_out_of_place_is_named_and_not_taken_for_scatter(tmp_path: Path) -> None:
    """Index errors are nuisances, and one of nine deviations would hide among them."""
    hidden = {"name": "pitch_error", "gear": "pinion", "tooth": 8, "amount_um": -9.0}
    # Over so many turns the tooth meets several of the wheel's.
    plan = PLAN | {"record": [record | {"turns": 3.4} for record in PLAN["record"]]}
    campaign = read_campaign(on_the_rig(tmp_path, {"effect": [hidden]}, plan))
    naming = diagnose(campaign, choose(catalogue(), ["pitch_error", "profile_slope"])).naming
    (found,) = naming.fit.effects
    assert naming.verdict == "explained"
    assert (found.name, found.gear, found.tooth) == ("pitch_error", "pinion", 8)
    # Scatter of half a micrometre adds to it.
    assert found.amount == pytest.approx(-9.0 * UM, rel=0.0, abs=1.5 * UM)
