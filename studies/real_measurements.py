"""What the diagnosis finds in measurements that others made, and in a campaign of one published number.

    python studies/real_measurements.py FOLDER --out results/real

FOLDER holds `runout-95/` (dial indicator on the tips of a 95-tooth gear mounted with set eccentricities: `eNN.toml`, NN in 1/100 mm)
and `worn-z35/` (one flank over the steps of a wear test, digitised from photographs: `case_NN.toml`, case 0 unworn), campaigns each.
Nothing is downloaded: the sets carry no licence to be passed on. What is absent is skipped with a sentence. The campaign of
Myga's rig holds its one published number and is made here. `--campaigns` says how many of each set are diagnosed in full.
"""

from __future__ import annotations

import argparse
import itertools
import os
import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from common import HERE, print_table, write_rows

from gearfem import load_model
from gearfem.definition.measured_points import read_flank
from gearfem.diagnosis import Campaign, Diagnosis, Measurement, diagnose, read_campaign, write_diagnosis
from gearfem.effects.catalogue import catalogue
from gearfem.effects.effect import Effect
from gearfem.flank.measured import FittedFlank, fit_flank
from gearfem.foundation import Array, InputError
from gearfem.foundation.files import whole
from gearfem.foundation.units import MM, RPM, UM
from gearfem.report import style, write_diagnosis_report

RUNOUT, WORN = "runout-95", "worn-z35"
SOURCES = {
    RUNOUT: "dial indicator on the tip circle of a 95-tooth gear at set eccentricities, SMART group, University of Macau; "
    "Li, Chen, Wang & Yang, MSSP 224 (2025) 112068",
    WORN: "one flank of a 35-tooth gear over the steps of a wear test, PHM laboratory, Ben-Gurion University (2023), digitised "
    "from photographs",
}
# Stages whose effects show on a gear off the rig; all others need a load or a motion.
OFF_THE_RIG = ("flank", "placement")
# Myga's rig: largest dynamic factor, torque and speed as published with it (studies/myga_rig/model.toml).
MEASURED, MYGA = 1.20, HERE / "myga_rig/model.toml"
# Teeth of the beginning of a record, which may have been taken before the gear turned evenly.
BEGINNING, BEGUN = 5, 1.5
# A set amplitude and the one found agree within this share of it; metal grows back beyond the stated error and so many deviations.
AGREES, GROWN = 0.1, 2.0


# ---- runout ------------------------------------------------------------------------------------------------


def first_order(record: Measurement, teeth: int) -> tuple[float, float, Array]:
    """Return amplitude [m], phase from tooth 0 of the record's numbers [rad], and what is left of each row [m]."""
    turn = 2.0 * np.pi * record.axis[record.keep] / teeth
    columns = np.column_stack([np.ones_like(turn), np.cos(turn), np.sin(turn)])
    value = record.value[record.keep]
    found = np.linalg.lstsq(columns, value, rcond=None)[0]
    left = value - columns @ found
    return float(np.hypot(found[1], found[2])), float(np.arctan2(found[2], found[1])), left


def read_runouts(campaigns: Mapping[str, Campaign]) -> list[dict[str, Any]]:
    """Return one row for each record: what was set and what its first order says."""
    rows = []
    for name, campaign in campaigns.items():
        for record in campaign.records:
            gear = campaign.setup.pair.gear(record.gear)
            amplitude, phase, left = first_order(record, gear.teeth)
            set_um = 10.0 * float(re.sub(r"\D", "", name))
            rows.append(
                {
                    "campaign": name,
                    "role": record.role,
                    "teeth_passed": record.axis.size,
                    "set_um": set_um,
                    "amplitude_um": amplitude / UM,
                    "phase_deg": float(np.degrees(phase)),
                    "left_um": float(np.sqrt(left @ left / (left.size - 3))) / UM,
                    "begins_um": float(left[:BEGINNING].mean()) / UM,
                }
            )
    return rows


def conclude_runouts(rows: list[dict[str, Any]]) -> list[str]:
    """Return what the series says of its own set values, in sentences."""
    own = np.array([(row["set_um"], row["amplitude_um"], row["left_um"]) for row in rows if row["role"] == "fit"])
    scatter = f"Beside its first order each record leaves {own[:, 2].min():.2g} to {own[:, 2].max():.2g} um from tooth to tooth."
    begins = np.array([row["begins_um"] / row["left_um"] for row in rows if row["role"] == "fit"])
    if np.sum(begins < -BEGUN) + np.sum(begins > BEGUN) > 0.5 * begins.size:
        off = [abs(row["begins_um"]) for row in rows if row["role"] == "fit"]
        scatter += f" Flaw of the data: its first {BEGINNING} teeth are off by {min(off):.1f} to {max(off):.1f} um, as if not yet settled."
    if len(np.unique(own[:, 0])) < 3:
        return [scatter]
    slope, zero = np.polyfit(own[:, 0], own[:, 1], 1)
    lines = [f"Amplitude over set eccentricity: {slope:.3f}, with {zero:.1f} um at none set."]
    if abs(slope - 1.0) > AGREES:
        ratio = own[own[:, 0] > 0.0, 1] / own[own[:, 0] > 0.0, 0]
        lines.append(
            f"Flaw of the data: the gear runs out by {ratio.min():.2f} to {ratio.max():.2f} times what was set; either the settings or the "
            "indicator has another scale, and these records cannot say which. Runout is named as measured."
        )
    return [
        *lines,
        scatter,
        "The tooth at which a record begins is unknown: phases tell the fit and the held-out part apart, not the sets.",
    ]


@style.styled
def draw_runouts(campaigns: Mapping[str, Campaign], rows: list[dict[str, Any]], path: Path) -> Path:
    """Draw the records of three sets with their first orders, and amplitudes over settings."""
    figure, (left, right) = style.make_figure(style.WIDE, columns=2)
    names = list(campaigns)
    chosen = dict.fromkeys([names[0], names[len(names) // 2], names[-1]])
    for name, colour in zip(chosen, (style.GREEN, style.BLUE, style.VERMILION), strict=False):
        record = campaigns[name].records[0]
        gear = campaigns[name].setup.pair.gear(record.gear)
        amplitude, phase, _ = first_order(record, gear.teeth)
        wave = amplitude * np.cos(2.0 * np.pi * record.axis / gear.teeth - phase)
        middle = float(np.mean(record.value - wave))
        left.plot(record.axis, (record.value - middle) / UM, ".", markersize=2.5, color=colour, label=f"{name}, {record.role}")
        left.plot(record.axis, wave / UM, linewidth=1.0, color=colour)
    left.set_xlabel("tooth passed")
    left.set_ylabel("radial deviation, µm")
    for role, mark in (("fit", "o"), ("holdout", "x")):
        part = [row for row in rows if row["role"] == role]
        right.plot([row["set_um"] for row in part], [row["amplitude_um"] for row in part], mark, color=style.BLUE, label=f"found, {role}")
    ends = [0.0, max(row["set_um"] for row in rows)]
    right.plot(ends, ends, color=style.GREY, linestyle=":", label="as set")
    right.set_xlabel("set eccentricity, µm")
    right.set_ylabel("amplitude found, µm")
    left.legend()
    right.legend()
    return style.save(figure, path)


# ---- wear --------------------------------------------------------------------------------------------------


def read_wear(campaigns: Mapping[str, Campaign]) -> tuple[list[dict[str, Any]], list[FittedFlank]]:
    """Return one row for each flank, and the fits."""
    rows, fits = [], []
    for name, campaign in campaigns.items():
        pair, record = campaign.setup.pair, campaign.records[0]
        gear = pair.gear(record.gear)
        points = read_flank(Path(campaign.path).parent / record.file, record.file, record.gear or "wheel", record.tooth, gear)
        fit = fit_flank(points, gear)
        depth = fit.curve.at(fit.roll)
        deepest, pitch = int(np.argmax(depth)), gear.base_radius * np.tan(pair.working_pressure_angle)
        rows.append(
            {
                "campaign": name,
                "points": fit.roll.size,
                "deepest_um": float(depth[deepest]) / UM,
                "at_roll_mm": float(fit.roll[deepest]) / MM,
                "pitch_roll_mm": pitch / MM,
                "rms_um": float(np.sqrt(np.mean(depth**2))) / UM,
                "residual_um": fit.residual_std / UM,
                "outliers": len(fit.outliers),
                "stated_um": (record.noise_std or 0.0) / UM,
            }
        )
        fits.append(fit)
    return rows, fits


def conclude_wear(rows: list[dict[str, Any]]) -> list[str]:
    """Return what the series says of wear and of its own method, in sentences."""
    first, last = rows[0], rows[-1]
    worst = max(rows, key=lambda row: row["deepest_um"])
    lines = [
        f"Deepest wear: {worst['deepest_um']:.0f} um in {worst['campaign']}, at a roll length of {worst['at_roll_mm']:.1f} mm (pitch point "
        f"{worst['pitch_roll_mm']:.1f} mm); {last['campaign']}, the last: {last['deepest_um']:.0f} um."
    ]
    if re.sub(r"\D", "", first["campaign"]).strip("0") == "":
        lines.append(f"The unworn tooth reads {first['rms_um']:.1f} um rms where it should read none: the least error of the method.")
    back = [
        f"{a['campaign']} to {b['campaign']} by {a['deepest_um'] - b['deepest_um']:.0f} um"
        for a, b in itertools.pairwise(rows)
        if a["deepest_um"] - b["deepest_um"] > max(a["stated_um"], GROWN * a["residual_um"], GROWN * b["residual_um"])
    ]
    if back:
        lines.append(
            f"Flaw of the data: metal grows back ({'; '.join(back)}), which only an error of registration or another tooth can do."
        )
    deepest = {row["campaign"]: row["deepest_um"] for row in rows}
    if {"case_25", "case_26"} <= set(deepest):
        ratio = deepest["case_26"] / deepest["case_25"]
        jumps = f"the deepest loss, which was scaled by the tooth, by {ratio:.2f}."
        lines.append(f"Between steps 25 and 26 the scale bars of the photographs jump by 1.63; {jumps}")
    smooth = max(row["residual_um"] for row in rows)
    if 0.0 < smooth < 0.5 * first["stated_um"]:
        lines.append(
            f"Points scatter about their fits by {smooth:.1f} um at most, against {first['stated_um']:.0f} um stated: the error of a "
            "photograph is one of place and scale, alike for neighbours, and no fit shows it."
        )
    near = [row for row in rows if row["deepest_um"] > 0.5 * worst["deepest_um"]]
    inner = sum(abs(row["at_roll_mm"] - row["pitch_roll_mm"]) < 0.1 * row["pitch_roll_mm"] for row in near)
    lines.append(
        f"In {inner} of the {len(near)} deeper flanks the loss is greatest within a tenth of the roll length about the pitch point, where "
        "Archard's law has none: another mechanism, or wear that was seeded."
    )
    return lines


@style.styled
def draw_wear(fits: list[FittedFlank], rows: list[dict[str, Any]], path: Path) -> Path:
    """Draw the points and fits of four steps, and the deepest loss over the steps."""
    figure, (left, right) = style.make_figure(style.WIDE, columns=2)
    chosen = sorted({0, len(fits) // 3, 2 * len(fits) // 3, len(fits) - 1})
    for number, colour in zip(chosen, (style.GREEN, style.ORANGE, style.BLUE, style.VERMILION), strict=False):
        fit = fits[number]
        left.plot(fit.roll / MM, fit.depth / UM, ".", markersize=2.5, color=colour)
        left.plot(fit.roll / MM, fit.curve.at(fit.roll) / UM, linewidth=1.0, color=colour, label=rows[number]["campaign"])
    left.axvline(rows[0]["pitch_roll_mm"], color=style.GREY, linestyle=":", label="pitch point")
    left.set_xlabel("roll length, mm")
    left.set_ylabel("metal missing, µm")
    steps = [int(re.sub(r"\D", "", row["campaign"]) or place) for place, row in enumerate(rows)]
    spread = [row["stated_um"] for row in rows]
    right.errorbar(steps, [row["deepest_um"] for row in rows], yerr=spread, fmt="o", color=style.BLUE, ecolor=style.GREY)
    right.set_xlabel("step of the test")
    right.set_ylabel("deepest loss, µm (bars: stated error)")
    left.legend()
    return style.save(figure, path)


# ---- diagnoses ---------------------------------------------------------------------------------------------


def myga_campaign(folder: Path) -> Path:
    """Write the campaign of Myga's one number, with the model of his rig beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(MYGA, folder / "model.toml")
    operation = load_model(MYGA).operation
    texts = {
        "kw.csv": f"pinion_speed_rpm,dynamic_factor\n{operation.pinion_speed / RPM:.6g},{MEASURED}\n",
        "campaign.toml": 'name = "Myga\'s rig, one number"\nmodel = "model.toml"\nangle_zero = "unknown"\n\n[[record]]\nfile = "kw.csv"\n'
        f'quantity = "dynamic_factor"\npinion_torque_Nm = {operation.pinion_torque:.6g}\nrole = "fit"\n',
    }
    for name, text in texts.items():
        with whole(folder / name) as temporary:
            temporary.write_text(text, encoding="utf-8")
    return folder / "campaign.toml"


def found_in(name: str, campaign: Campaign, kinds: Mapping[str, type[Effect]], out: Path) -> tuple[Diagnosis, list[dict[str, Any]]]:
    """Diagnose a campaign, write all about it, and return what was found with one row for each record."""
    found = diagnose(campaign, kinds)
    write_diagnosis_report(found, out)
    write_diagnosis(found, out)
    named = "; ".join(effect.describe() for effect in found.naming.fit.effects)
    rows = []
    for gap in found.proof.records:
        scale = gap.measurement.to_file
        parts = {"before": gap.before, "nuisances": gap.nuisances_only, "after": gap.after}
        row = {"campaign": name, "role": gap.role, "verdict": found.naming.verdict, "unit": gap.measurement.quantity.unit or "1"}
        rows.append(row | {key: gap.rms(part) * scale for key, part in parts.items()} | {"noise": gap.noise_rms * scale, "named": named})
    return found, rows


def in_words(name: str, found: Diagnosis) -> list[str]:
    """Return verdict, faults of the data, alternatives and suggestion."""
    lines = [f"{name}: {found.naming.verdict}. {found.naming.sentence}"]
    lines += [f"  Reading the data: {remark.sentence}" for remark in found.campaign.remarks]
    lines += [f"  {reason}" for reason in (*found.naming.reasons, *found.proof.reasons)]
    lines += [
        f"  Or: {'; '.join(e.describe() for e in rival.effects)} (score worse by {rival.score_difference:.1f})"
        for rival in found.alternatives
    ]
    return lines + [f"  {one.sentence}" for one in found.suggestions[:1]]


def read_all(folder: Path) -> dict[str, Campaign]:
    """Return the campaigns of a folder by the names of their files; models are left out."""
    files = (path for path in sorted(folder.glob("*.toml")) if "[[record]]" in path.read_text(encoding="utf-8"))
    return {path.stem: read_campaign(path) for path in files}


def spread_over(names: list[str], count: int) -> list[str]:
    """Return so many names, the last, the first, and then between them."""
    places = np.unique(np.linspace(len(names) - 1, 0, min(count, len(names))).round().astype(int))
    return [names[place] for place in places]


def one_set(name: str, campaigns: Mapping[str, Campaign], count: int, out: Path) -> tuple[list[str], list[dict[str, Any]]]:
    """Read a set, draw it, diagnose some of its campaigns; return sentences and rows of the gaps."""
    if name == RUNOUT:
        rows = read_runouts(campaigns)
        lines = conclude_runouts(rows)
        draw_runouts(campaigns, rows, out / f"{name}.png")
    else:
        rows, fits = read_wear(campaigns)
        lines = conclude_wear(rows)
        draw_wear(fits, rows, out / f"{name}.png")
    write_rows(out / f"{name}.csv", rows, (SOURCES[name],))
    print_table(f"{name}: {SOURCES[name]}", rows)
    kinds = {key: kind for key, kind in catalogue().items() if kind.stage in OFF_THE_RIG}
    gaps: list[dict[str, Any]] = []
    for one in spread_over(list(campaigns), count):
        found, own = found_in(f"{name}/{one}", campaigns[one], kinds, out / name / one)
        lines += in_words(one, found)
        gaps += own
    return lines, gaps


def main(arguments: list[str] | None = None) -> dict[str, Any]:
    """Run the study on what is there; write tables, pictures, reports and conclusion.txt."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="folder with the data of others")
    parser.add_argument("--out", type=Path, required=True, help="folder for the results")
    parser.add_argument("--campaigns", type=int, default=3, help="campaigns of each set that are diagnosed (default 3)")
    parser.add_argument("--without-rig", action="store_true", help="leave Myga's rig out")
    given = parser.parse_args(arguments)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    lines: list[str] = []
    gaps: list[dict[str, Any]] = []
    try:
        for name in (RUNOUT, WORN):
            campaigns = read_all(given.folder / name)
            if not campaigns:
                lines.append(
                    f"No campaigns in {name}: skipped. The data are not ours to ship; get them from their authors ({SOURCES[name]})."
                )
                continue
            words, own = one_set(name, campaigns, given.campaigns, given.out)
            lines += [f"{name}:", *words]
            gaps += own
        if not given.without_rig:
            path = myga_campaign(given.out / "myga")
            found, own = found_in("myga", read_campaign(path), catalogue(), given.out / "myga")
            lines += in_words("Myga's rig", found)
            gaps += own
    except InputError as error:
        raise SystemExit(f"error: {error}") from None
    if gaps:
        write_rows(given.out / "gaps.csv", gaps, ("before, nuisances, after, noise: root mean squares in the unit of the row",))
        print_table("What is left: before, with nuisances alone, with what is named, and noise", gaps)
    print("\n" + "\n".join(lines))
    with whole(given.out / "conclusion.txt") as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return {"gaps": gaps, "lines": lines}


if __name__ == "__main__":
    main()
