"""What a diagnosis writes: `diagnosis.json` and the updated model."""

from __future__ import annotations

import math
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from gearfem.diagnosis.diagnose import Diagnosis
from gearfem.diagnosis.modelling.largest import expected
from gearfem.diagnosis.naming.naming import Rival
from gearfem.diagnosis.proving.proof import Gap
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.diagnosis.updated import effect_table, write_updated
from gearfem.effects.catalogue import catalogue
from gearfem.effects.effect import Effect
from gearfem.foundation import InputError
from gearfem.foundation.files import write_csv, write_json
from gearfem.foundation.units import RPM, UM, factor

RESULT, MODEL, MAPS = "diagnosis.json", "updated.toml", "maps.csv"
# Written beside them, by `gearfem.report`.
REPORT = "report.html"
# A nuisance beyond so many prior deviations is a finding itself.
FINDING = 3.0
MAPS_SAY = (
    "what nuisances alone (before) and what is named (after) leave: mean squares of whitened residuals; expected: in noise, nuisances and "
    "errors of the model; significance: deviations from draws of these"
)
# Explanations that lost and are listed all the same.
LISTED = 5


def write_diagnosis(diagnosis: Diagnosis, out: Path) -> list[Path]:
    """Write diagnosis.json, updated.toml and maps.csv, each whole or not at all.

    Parameters
    ----------
    diagnosis : Diagnosis
        Of a campaign.
    out : Path
        Folder.

    Returns
    -------
    list of Path

    Raises
    ------
    InputError
        If one of them would replace what the campaign was read from.
    """
    refuse_to_replace(diagnosis.campaign, out)
    model = write_updated(diagnosis.campaign, diagnosis.naming.fit, diagnosis.proof, Path(out) / MODEL)
    write_csv(Path(out) / MAPS, _cells(diagnosis), (MAPS_SAY,))
    write_json(Path(out) / RESULT, as_json(diagnosis))
    return [Path(out) / RESULT, model, Path(out) / MAPS]


def refuse_to_replace(campaign: Campaign, out: Path) -> None:
    """Refuse a folder in which results would take the place of what the campaign was read from, or in which their names are folders'.

    Raises
    ------
    InputError
        Naming both.
    """
    folder = Path(campaign.path).parent
    read = {Path(campaign.path): "the campaign", Path(campaign.model): "the campaign's model"}
    read |= {folder / record.file: "a record of the campaign" for record in campaign.records}
    kinds = {path.resolve(): (path, kind) for path, kind in read.items()}
    for name in (RESULT, MODEL, MAPS, REPORT):
        if found := kinds.get((out / name).resolve()):
            path, kind = found
            raise InputError("--out", f"the folder of {path}, {kind}", f"another folder: {name} would replace it")
        if (out / name).is_dir():
            raise InputError("--out", f"{out / name}, a folder", f"a folder in which {name} can be written")


def as_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the content of diagnosis.json."""
    naming, proof = diagnosis.naming, diagnosis.proof
    beside = diagnosis.alternatives or naming.rivals[:LISTED]
    return {
        "verdict": naming.verdict,
        "sentence": naming.sentence,
        "effects": [_named(diagnosis, number) for number in range(len(naming.fit.effects))],
        "alternatives": [_rival(rival) for rival in beside],
        "threshold": naming.threshold,
        "where": [
            {
                "record": place.record,
                "domain": place.domain,
                "zone": place.zone,
                "share_of_residual": place.share_of_residual,
                "significance": place.significance,
                "sentence": place.sentence,
            }
            for place in diagnosis.before.where
        ],
        "gap_significance": {"p_value": diagnosis.before.p_value, "sentence": diagnosis.before.sentence},
        "gap": [_gap(gap) for gap in proof.records],
        "holdout": {
            "over_nuisances": proof.over_nuisances,
            "over_nuisances_stderr": proof.stderr,
            "over_smooth": proof.over_smooth,
            "stands": proof.stands,
        },
        "nuisances": nuisance_rows(diagnosis),
        "suggestion": diagnosis.suggestions[0].sentence if diagnosis.suggestions else None,
        "suggestions": [
            {"measure": one.words, "separation": one.separation, "told": one.told, "cost": one.cost} for one in diagnosis.suggestions[:3]
        ],
        "reasons": reasons(diagnosis),
        "tried": list(diagnosis.tried),
        "notes": notes(diagnosis),
        "model": MODEL,
        "version": version("gearfem"),
    }


def _cells(diagnosis: Diagnosis) -> dict[str, list[Any]]:
    """Return all cells of all maps as columns of a table."""
    records = {record.file: record for record in diagnosis.campaign.records}
    after = {(one.record, one.domain, one.part, label): (one, i) for one in diagnosis.after.maps for i, label in enumerate(one.label)}
    rows = []
    for one in diagnosis.before.maps:
        known = records.get(one.record)
        torque, speed = (f"{known.pinion_torque:.10g}", f"{known.pinion_speed / RPM:.10g}") if known else ("", "")
        for i, label in enumerate(one.label):
            then, j = after.get((one.record, one.domain, one.part, label), (None, 0))
            row = [one.record, torque, speed, one.domain, label, one.power[i], one.expected[i], one.significance[i]]
            rows.append([*row, *((then.power[j], then.significance[j]) if then else ("", ""))])
    heads = ["record", "pinion_torque_Nm", "pinion_speed_rpm", "domain", "cell", "power_before", "expected", "significance_before"]
    return dict(zip([*heads, "power_after", "significance_after"], map(list, zip(*rows, strict=True)), strict=True))


def stderr(effect: Effect, field: str, deviation: float) -> float | None:
    """Return the standard error of a parameter in the unit of its key, disputed models in it; None where the data say nothing of it."""
    known, here = effect.parameters()[field], getattr(effect, field)
    fitted = deviation * here**2 if known.reciprocal else deviation
    value = math.hypot(fitted, effect.disputed * here) if field in effect.strengths() else fitted
    return value / factor(effect.key(field)) if math.isfinite(value) else None


def _named(diagnosis: Diagnosis, number: int) -> dict[str, Any]:
    naming = diagnosis.naming
    effect, deviations = naming.fit.effects[number], diagnosis.deviations[number]
    table = effect_table(effect, diagnosis.campaign.setup)
    parameters: dict[str, Any] = {}
    for key, field in effect.keys().items():
        if field not in effect.fitted():
            parameters[key] = {"value": getattr(effect, field)}
            continue
        parameters[key] = {"value": table[key], "stderr": stderr(effect, field, deviations[field])}
        if (number, field) in naming.fit.bound:
            parameters[key]["at_bound"] = True
    return {"name": effect.name, "parameters": parameters, "p_value": naming.p_values[number], "sentence": effect.describe()}


def _rival(rival: Rival) -> dict[str, Any]:
    tables = [effect.table() for effect in rival.effects]
    names = [effect.name for effect in rival.effects]
    return {"effects": names, "score_difference": rival.score_difference, "parameters": tables, "why": rival.why}


def _gap(gap: Gap) -> dict[str, Any]:
    scale = gap.measurement.to_file
    row: dict[str, Any] = {
        "record": gap.measurement.file,
        "role": gap.role,
        "unit": gap.measurement.quantity.unit,
        "before_rms": gap.rms(gap.before) * scale,
        "nuisances_only_rms": gap.rms(gap.nuisances_only) * scale,
        "smooth_rms": gap.rms(gap.smooth) * scale if gap.smooth.size else None,
        "after_rms": gap.rms(gap.after) * scale,
        "noise_rms": gap.noise_rms * scale,
        "floor_rms": gap.floor_rms * scale,
    }
    return row if gap.measurement.tooth_known else row | {"first_tooth": gap.first_tooth}


def nuisance_rows(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return where nuisances went, in prior deviations: settings, errors of our own model, index errors of each gear."""
    problem, fit = diagnosis.problem, diagnosis.naming.fit
    rows: list[dict[str, Any]] = []
    for nuisance, moved in zip(problem.nuisances, fit.point.unknown, strict=False):
        rows.append(_row(nuisance.name, nuisance.words, float(moved), float(getattr(fit.settings, nuisance.name)), nuisance.unit))
    for variant, moved in zip(problem.unknowns.errors, fit.point.unknown[problem.unknowns.wrong], strict=True):
        rows.append(_row(variant.name, f"error of the model: {variant.words}", float(moved), variant.value(float(moved)), variant.unit))
    if any(record.quantity.is_motion for record in problem.records):
        touch = float(fit.point.unknown[problem.unknowns.touch])
        words = "share of the mesh damper that acts on the flanks that touch first, not by shares of load"
        rows.append(_row("damper_first_touch", words, touch, touch))
    if any(rise.any() for rise in problem.rise):
        moved = float(fit.point.unknown[-1])
        words = "rise of the largest Kw of a turn by waviness, over the expected one"
        rows.append(_row("kw_rise_scale", words, moved, expected(moved)))
    for member, late in (("pinion", fit.settings.pinion_late), ("wheel", fit.settings.wheel_late)):
        worst = int(np.argmax(np.abs(late)))
        words = f"index error of tooth {worst} of the {member}, the largest"
        rows.append(_row(f"{member}_index_error_um", words, float(late[worst]) / problem.unknowns.scatter.index, float(late[worst]), "um"))
    return rows


def _row(name: str, words: str, moved: float, value: float, unit: str = "") -> dict[str, Any]:
    """Return a row for a value in SI, shown in a unit."""
    shown = {"value": value / UM, "unit": unit} if unit.startswith("um") else {"value": value} | ({"unit": unit} if unit else {})
    return {"name": name, "words": words, "prior_deviations": moved, "finding": abs(moved) > FINDING} | shown


def reasons(diagnosis: Diagnosis) -> list[str]:
    """Return what the verdict rests on."""
    small = diagnosis.naming.verdict == "no_discrepancy" and diagnosis.before.gap
    words = "Cells of the maps stand out, but all that is left is no more than what healthy pairs leave of such a model."
    return [*diagnosis.naming.reasons, *diagnosis.proof.reasons, *([words] if small else [])]


def notes(diagnosis: Diagnosis) -> list[str]:
    """Return what a reader must know besides: effects left out, faults of the data and their repair, roles, noise, shifts far off."""
    remarks = [f"{remark.record}: {remark.sentence}" for remark in diagnosis.campaign.remarks]
    noise = [f"{r.file}: {n.sentence}" for r, n in zip(diagnosis.problem.records, diagnosis.problem.noises, strict=True)]
    shifts = [
        f"{row['words']}: {row['prior_deviations']:+.1f} prior deviations, more than {FINDING:g}: a finding of its own"
        for row in nuisance_rows(diagnosis)
        if row["finding"]
    ]
    begun = [
        f"{gap.measurement.file}: the motion is another steady one than that from rest; which one a rig runs in goes by how it came there"
        for gap in diagnosis.proof.records
        if any(gap.measurement.kick)
    ]
    whole = {record.file: record for record in diagnosis.campaign.records}
    begun += [
        f"{one.file}: lines {one.line[0]} to {one.line[-1]} are used: beyond them the motion goes over to another steady one"
        for one in diagnosis.problem.records
        if len(one.axis) < len(whole[one.file].axis)
    ]
    left_out = sorted(set(catalogue()) - set(diagnosis.tried))
    limits = [f"Not tried, at the user's wish: {', '.join(left_out)}."] if left_out else []
    return [*limits, *remarks, *noise, *begun, *shifts]
