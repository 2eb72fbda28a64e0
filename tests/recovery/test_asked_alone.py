"""What single teeth and turns have beside an effect of all teeth is asked by itself of records held out."""

from __future__ import annotations

import dataclasses
import sys

import pytest

from gearfem.diagnosis import Diagnosis
from gearfem.diagnosis.diagnose import _opened
from gearfem.diagnosis.naming.joined import _one
from gearfem.diagnosis.naming.naming import Naming, Rival
from gearfem.diagnosis.proving.held_out import asked_alone
from gearfem.diagnosis.proving.prove import prove
from gearfem.effects.effect import Effect
from gearfem.effects.pitting import Pitting
from gearfem.effects.profile_slope import ProfileSlope
from gearfem.effects.runout import Runout
from gearfem.foundation.progress import quiet
from gearfem.foundation.units import UM


def _with(found: Diagnosis, single: Effect, gapless: bool = False) -> Naming:
    """Return the verdict with a single tooth or a turn beside the tip relief, and rivals of what is common, and of what is single."""
    relief, setup = found.naming.fit.effects[0], found.campaign.setup
    fit = dataclasses.replace(found.naming.fit, effects=(relief, single))
    pit = Pitting.example(setup, "pinion", 2)
    sets = ((ProfileSlope.example(setup, "pinion"), single), (relief, pit), (relief, single, pit))
    near = tuple(Rival(effects=effects, score_difference=1.0, why="", near=True, fit=fit) for effects in sets)
    return dataclasses.replace(found.naming, fit=fit, p_values=(1e-9, 1e-3), rivals=near, level=1.0 if gapless else 3.0)


@pytest.mark.parametrize(
    ("share", "foretold", "stands"),
    [(0.997, 1.017, False), (1.03, 1.04, True), (1.0, 1.001, True), (0.9, 1.001, False), (1.005, 1.05, False)],
)
def test_a_tooth_that_records_held_out_would_show_and_do_not_is_withdrawn_alone(
    found: Diagnosis, share: float, foretold: float, stands: bool
) -> None:
    """The effect of all teeth stays, with what speaks for it, and so do its rivals."""
    naming, rest = _with(found, Pitting.example(found.campaign.setup, "wheel", 20)), found.naming.fit
    held = asked_alone(naming, rest, dataclasses.replace(found.proof, over_nuisances=share, foretold=foretold, stderr=0.004))
    if stands:
        assert held is naming
        return
    assert held.verdict == naming.verdict
    assert held.fit is rest
    assert held.p_values == naming.p_values[:1]
    assert "pitting" not in held.sentence.lower()
    assert held.sentence == found.naming.sentence
    assert [[effect.name for effect in rival.effects] for rival in held.rivals] == [["profile_slope"]]
    words = "more" if share < 0.97 else "not surely less"
    assert held.reasons[-1] == f"On records held out, {words} is left with pitting beside tip_relief than without."


@pytest.mark.parametrize(("common", "verdict"), [(True, "ambiguous"), (False, "explained")])
def test_teeth_that_fit_alike_leave_no_doubt_once_they_are_withdrawn(found: Diagnosis, common: bool, verdict: str) -> None:
    """Unless what all teeth have is in doubt too."""
    naming = _with(found, Pitting.example(found.campaign.setup, "wheel", 20))
    rivals = naming.rivals if common else naming.rivals[1:]
    naming = dataclasses.replace(naming, verdict="ambiguous", closed=0.99, left=0.5, rivals=rivals)
    held = asked_alone(naming, found.naming.fit, dataclasses.replace(found.proof, over_nuisances=0.997, foretold=1.017, stderr=0.004))
    assert held.verdict == verdict
    assert [effect.name for effect in held.fit.effects] == ["tip_relief"]
    assert held.sentence.endswith("fit these data as well.") == common


def test_one_verdict_has_as_many_chances_as_effects_for_each_explanation_as_good(found: Diagnosis) -> None:
    """In the order of these, so that any of them may be published in the place of what is named."""
    setup, teeth = found.campaign.setup, _with(found, Pitting.example(found.campaign.setup, "wheel", 20))
    first, pit = found.naming, dataclasses.replace(found.naming.fit, effects=(Pitting.example(setup, "wheel", 20),))
    near = Rival(effects=(Pitting.example(setup, "pinion", 2),), score_difference=1.0, why="", near=True, fit=pit, p_values=(0.3,))
    far = dataclasses.replace(near, near=False, p_values=())
    second = dataclasses.replace(teeth, fit=pit, p_values=(0.2,), rivals=(near, far))
    slope = Rival(effects=(ProfileSlope.example(setup, "pinion"),), score_difference=2.0, why="", near=True, fit=pit, p_values=(0.4,))
    joined = _one(dataclasses.replace(first, p_values=(0.1,), rivals=(slope,)), second, first.alone, teeth.fit, "All teeth", "Single teeth")
    found_so = {tuple(effect.name for effect in rival.effects): rival.p_values for rival in joined.rivals if rival.near}
    assert found_so == {("tip_relief", "pitting"): (0.1, 0.3), ("profile_slope", "pitting"): (0.4, 0.2)}
    assert [rival.p_values for rival in joined.rivals if not rival.near] == [()]


@pytest.mark.parametrize(("gapless", "stands"), [(True, False), (False, True)])
def test_a_wave_without_a_gap_must_surely_do_better_beside_other_effects_too(found: Diagnosis, gapless: bool, stands: bool) -> None:
    naming = _with(found, Runout(gear="pinion", eccentricity=5.0 * UM, angle=0.0), gapless)
    proof = dataclasses.replace(found.proof, over_nuisances=1.0, foretold=1.001, stderr=0.004)
    assert (asked_alone(naming, found.naming.fit, proof) is naming) == stands


@pytest.mark.parametrize(("seen", "names"), [(True, ["tip_relief", "pitting"]), (False, ["tip_relief"])])
def test_each_kind_is_asked_with_the_other_in_the_model(
    found: Diagnosis, monkeypatch: pytest.MonkeyPatch, seen: bool, names: list[str]
) -> None:
    asked, module = list[tuple[list[str], list[str]]](), sys.modules["gearfem.diagnosis.diagnose"]
    right = dataclasses.replace(found.proof, over_nuisances=1.2, foretold=1.2, stderr=0.01)
    missed = dataclasses.replace(right, over_nuisances=1.0)

    def proved(problem: object, fit: Naming, alone: Naming, *other: object) -> object:
        asked.append(([effect.name for effect in fit.effects], [effect.name for effect in alone.effects]))
        return right if seen or not alone.effects else missed

    monkeypatch.setattr(module, "without_single", lambda problem, fit: dataclasses.replace(fit, effects=fit.effects[:1]))
    monkeypatch.setattr(module, "prove", proved)
    held, proof = _opened(found.problem, _with(found, Pitting.example(found.campaign.setup, "wheel", 20)), quiet)
    assert asked == [(["tip_relief", "pitting"], ["tip_relief"]), (names, [])]
    assert [effect.name for effect in held.fit.effects] == names
    assert held.verdict == "explained"
    assert proof is right


def test_a_proof_against_a_part_of_the_effects_has_them_in_both(found: Diagnosis) -> None:
    fit = found.naming.fit
    proof = prove(found.problem, fit, fit)
    for gap in proof.records:
        assert gap.nuisances_only == pytest.approx(gap.after, rel=1e-12, abs=0.0)
    assert proof.over_nuisances == pytest.approx(1.0, rel=1e-12, abs=0.0)
