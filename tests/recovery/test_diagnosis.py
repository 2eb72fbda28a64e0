"""A whole diagnosis of a small campaign from the virtual rig: what it proves, writes and suggests."""

from __future__ import annotations

import csv
import dataclasses
import json
import pickle
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from gearfem.assembly import assemble
from gearfem.cli import main
from gearfem.definition.setup import Member
from gearfem.diagnosis import (
    Diagnosis,
    choose,
    compare,
    diagnose,
    fit,
    localise,
    prove,
    read_campaign,
    score,
    write_diagnosis,
)
from gearfem.diagnosis.fitting.fit import Fit, jacobian
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.ranking import likely_teeth, standing_out
from gearfem.diagnosis.ranking.one_flank import likeliest_flanks
from gearfem.diagnosis.ranking.rank import lowest
from gearfem.diagnosis.suggest import suggest
from gearfem.diagnosis.updated import write_updated
from gearfem.diagnosis.write import as_json
from gearfem.effects.catalogue import catalogue
from gearfem.effects.effect import Effect
from gearfem.effects.pitting import Pitting
from gearfem.effects.profile_slope import ProfileSlope
from gearfem.effects.root_crack import RootCrack
from gearfem.effects.runout import Runout
from gearfem.effects.tip_relief import TipRelief
from gearfem.foundation import InputError
from gearfem.foundation.toml import write_toml
from gearfem.foundation.units import MM, UM
from gearfem.model import load_model, make_setup
from gearfem.report import write_diagnosis_report
from gearfem.rig import measure, read_plan
from gearfem.sensing import observe
from tests.recovery.rig import NOMINAL, PLAN, TORQUES, beside_nuisances, on_the_rig, runout_off_the_rig


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
        left = (record.value - observe(system, record.request()))[record.keep] / UM
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


def test_a_diagnosis_can_be_kept_and_is_brief_in_a_notebook(found: Diagnosis) -> None:
    kept = pickle.loads(pickle.dumps(found))
    assert as_json(kept) == as_json(found)
    assert len(kept.problem.predict((), kept.naming.fit.point.unknown)) == len(found.problem.records)
    shown: list[str] = []
    found.proof._repr_pretty_(SimpleNamespace(text=shown.append), cycle=False)
    assert shown == [str(found.proof)]
    assert len(shown[0]) < 2000


def test_the_report_holds_its_pictures_and_asks_nothing_of_the_network(found: Diagnosis, tmp_path: Path) -> None:
    files = write_diagnosis_report(found, tmp_path)
    page = files[0].read_text(encoding="utf-8")
    # Pages write the micrometre with its sign.
    assert " um " in found.naming.sentence
    assert found.naming.sentence.replace(" um", " µm") in page
    assert page.count("data:image/png;base64,") == len(files) - 1 == 6
    assert "http" not in page
    for record in found.campaign.records:
        assert record.file in page


def test_a_forced_fit_ends_where_the_naming_does(found: Diagnosis) -> None:
    problem, alone = found.problem, found.comparison.alone
    mine = fit(problem, TipRelief(gear="wheel", amount=5.0 * UM, length=2.0 * MM), alone)
    assert mine.objective == pytest.approx(found.naming.fit.objective, rel=0.0, abs=2.0)
    assert score(problem, fit(problem, [], alone)) - score(problem, mine) > 50.0


def test_every_cell_of_the_maps_is_in_a_table(found: Diagnosis, tmp_path: Path) -> None:
    write_diagnosis(found, tmp_path)
    with (tmp_path / "maps.csv").open(newline="") as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    assert len(rows) == sum(len(one.label) for one in found.before.maps)
    worst = max(rows, key=lambda row: float(row["significance_before"]))
    assert float(worst["significance_before"]) == pytest.approx(found.before.largest)
    # The name takes away what stood out most.
    assert float(worst["significance_after"]) < 0.5 * float(worst["significance_before"])
    assert {float(row["pinion_torque_Nm"]) for row in rows} == {torque for torque in TORQUES if torque != 80.0}


def test_what_was_tried_and_why_it_lost_is_told(found: Diagnosis) -> None:
    result = as_json(found)
    assert result["tried"] == ["tip_relief"]
    assert any("runout" in note for note in result["notes"] if note.startswith("Not tried"))
    assert all(rival["why"] for rival in result["alternatives"])
    assert result["alternatives"] or any(reason.endswith("enough to be fitted.") for reason in result["reasons"])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda found: compare("campaign.toml"), "a Campaign, from read_campaign"),
        (lambda found: localise(found.comparison, draws=0), "draws"),
        (lambda found: fit(found.problem, ["tip_relief"], found.comparison.alone), "effects with values"),
        (lambda found: fit(found.problem, TipRelief(gear="wheel", amount=1.0, length=2e-3), found.comparison.alone), "amount_um"),
    ],
)
def test_wrong_arguments_are_said_in_a_line(found: Diagnosis, call: Callable[[Diagnosis], Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        call(found)


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


def test_a_scan_is_fitted_from_its_pits_alone() -> None:
    assert lowest([3.0, 1.0, 2.0, 5.0, 4.0]) == [1, 4]
    assert lowest([1.0, 2.0, np.inf, 7.0, np.inf]) == [0, 3]


@pytest.mark.parametrize("kind", [Pitting, RootCrack])
def test_shapes_that_cannot_be_computed_explain_nothing(found: Diagnosis, monkeypatch: pytest.MonkeyPatch, kind: type[Effect]) -> None:
    over = likely_teeth._over_a_turn

    def refuse(problem: Problem, base: Fit, effects: tuple[Effect, ...], member: Member) -> list[Any]:
        if any(isinstance(effect, kind) for effect in effects):
            raise InputError("depth1", "-1", "0 or more")
        return over(problem, base, effects, member)

    def refuse_to_act(*_: Any) -> Any:
        raise InputError("depth1", "-1", "0 or more")

    monkeypatch.setattr(standing_out, "STANDS_OUT", 0.0)
    assert likely_teeth.starts_of(found.problem, found.naming.alone, kind, "pinion")
    monkeypatch.setattr(likely_teeth, "_over_a_turn", refuse)
    monkeypatch.setattr(kind, "act", refuse_to_act)
    assert likely_teeth.starts_of(found.problem, found.naming.alone, kind, "pinion") == []


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
    assert "runout" not in choose(catalogue(), exclude="runout")
    assert list(choose(catalogue(), "runout")) == ["runout"]


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
    mine = fit(problem, Runout(gear="wheel", eccentricity=8.0 * UM, angle=0.5), alone)
    proof = prove(problem, mine, alone)
    (held,) = proof.of("holdout")
    assert drawn > 0
    assert held.first_tooth == drawn
    assert held.smooth.size == 0
    assert held.rms(held.after) == pytest.approx(0.5 * UM, rel=0.4, abs=0.0)
    assert proof.stands
    # The file knows the tooth that was found.
    cold = observe(assemble(load_model(write_updated(campaign, mine, proof, tmp_path / "updated.toml"))), held.measurement.request())
    np.testing.assert_allclose(held.measurement.value - cold, held.after, rtol=0.0, atol=1e-6 * UM)


def test_a_shallow_pit_stands_out_amid_the_scatter_of_teeth_under_light_loads(tmp_path: Path) -> None:
    """Errors of single teeth decide which pair bears: no tooth feels it as it would amid even ones."""
    setup = make_setup(NOMINAL)
    low, high = Pitting.parameters()["centre"].bounds(setup, "wheel")
    centre = low + 0.55 * (high - low)
    hidden = {"name": "pitting", "gear": "wheel", "tooth": 4, "depth_um": 2.0, "centre_mm": centre / MM, "width_mm": 3.0}
    records = [
        PLAN["record"][0] | {"file": f"te_{torque:g}Nm.csv", "pinion_torque_Nm": torque, "turns": 5.2} for torque in (2.0, 6.0, 12.0)
    ]
    view = beside_nuisances(tmp_path, [hidden], records)
    gains, pits = zip(*likeliest_flanks(view.problem, view.base, Pitting.example(setup, "wheel")), strict=True)
    pit = pits[4]
    print([round(gain) for gain in gains], pit)
    assert int(np.argmax(gains)) == pit.tooth == 4
    assert max(gain for tooth, gain in enumerate(gains) if abs(tooth - 4) > 1) < 0.2 * gains[4]
    assert pit.centre == pytest.approx(centre, rel=0.0, abs=0.3 * MM)
    assert pit.depth == pytest.approx(2.0 * UM, rel=0.3, abs=0.0)


@pytest.mark.slow
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
    diagnosis = diagnose(campaign, choose(catalogue(), ["pitch_error", "profile_slope"]))
    naming = diagnosis.naming
    (found,) = naming.fit.effects
    assert naming.verdict == "explained"
    # Nuisances have taken it up, so that nothing of it is left to see; with the name it is gone from there.
    assert [place.zone for place in diagnosis.before.where if "index errors" in place.sentence] == ["pinion:8"]
    assert not any("index errors" in place.sentence for place in diagnosis.after.where)
    assert found.describe().endswith("um early")
    assert (found.name, found.gear, found.tooth) == ("pitch_error", "pinion", 8)
    # Scatter of half a micrometre adds to it.
    assert found.amount == pytest.approx(-9.0 * UM, rel=0.0, abs=1.5 * UM)
