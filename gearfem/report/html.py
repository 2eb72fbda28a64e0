"""The report: one HTML file that holds its pictures and asks nothing of the network."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup

from gearfem.foundation.files import whole
from gearfem.foundation.units import MM, RPM
from gearfem.pipeline import Results
from gearfem.report.captions import CAPTIONS
from gearfem.report.kinematics_plots import away_from_line, has_worn_flanks
from gearfem.report.plots import write_pictures
from gearfem.report.render import Rendering
from gearfem.report.summary import summarise
from gearfem.report.tables import share_of

FILES = {
    "summary.json": "the numbers of this page and more",
    "measured_flanks.csv": "points of measured flanks, their use, fit and residual",
    "compliance.csv": "deflection per line load over the load radius",
    "body.csv": "that deflection taken apart: tooth, body, wind-up; what the next teeth feel",
    "mesh_stiffness.csv": "stiffness, transmission error and load shares over the pinion angle",
    "kinematics.csv": "gear ratios, contact points and velocities of every pair in contact",
    "rigid.csv": "motion of the rigid model",
    "elastic.csv": "steady motion of the elastic model",
    "classical.csv": "steady motion of the classical model",
    "tooth_pinion.vtu": "displacement and stress of the loaded pinion tooth, for ParaView",
    "tooth_wheel.vtu": "displacement and stress of the loaded wheel tooth, for ParaView",
}

WIDE = ("measured_flanks", "compliance", "flank_outlines", "line_of_action", "dynamic_factor")
SPECIFIC, PAPER = "N/(mm·µm)", "Wojnarowski & Onishchenko 2003 report 0.9 to 1.1 for their gears"
WHY_NOT_PAPER = (
    "The paper reports that Castigliano's beam stays within 0.9 to 1.1 of its finite elements; that is a finding about its gears, no bound "
    "for these. The ratio here is lower or higher because the trapezoid has straight sides without the bulge of the involute, and gives "
    "the deflection of the load point's section where the finite elements are read where the load line crosses the centreline; because "
    "its base lies at the middle of the fillet, while the finite elements are held on the root arc; and because low on the flank that "
    "crossing comes so near to the clamp that the finite elements' deflection tends to 0."
)
KW_FORM = (
    "The dynamic factor is Kw = 1 - J₁ψ₁''/T₁ (Wojnarowski & Onishchenko 2003, eq. 29, derived again from eq. 22): above 1 where the teeth "
    "carry more than T₁. With a plus it would measure their unloading."
)
ISO_SINGLE = Markup("ISO 6336-1, method B: <i>c</i>&prime;")
ISO_MESH = Markup("ISO 6336-1, method B: <i>c</i><sub>&gamma;&alpha;</sub>")

# Label, key of summary.json, format, unit, value beside it (a key or text) and where that comes from.
NUMBERS: tuple[tuple[str, str, str, str, str, str], ...] = (
    ("transverse contact ratio", "contact_ratio", ".4f", "", "", ""),
    ("working pressure angle", "working_pressure_angle_deg", ".3f", "°", "", ""),
    ("centre distance", "centre_distance_mm", ".3f", "mm", "", ""),
    ("tip radii, pinion / wheel", "tip_radius_mm", ".3f", "mm", "", ""),
    ("root radii, pinion / wheel", "root_radius_mm", ".3f", "mm", "", ""),
    ("normal force", "normal_force_N", ".0f", "N", "", ""),
    (
        "largest stiffness of a single pair (secant F/δ)",
        "single_stiffness_max_N_per_mm_um",
        ".2f",
        SPECIFIC,
        "iso6336_c_prime_N_per_mm_um",
        ISO_SINGLE,
    ),
    (
        "mean mesh stiffness (slope dF/dδ)",
        "mesh_stiffness_mean_N_per_mm_um",
        ".2f",
        SPECIFIC,
        "iso6336_c_gamma_alpha_N_per_mm_um",
        ISO_MESH,
    ),
    ("Castigliano over finite elements, least", "castigliano_over_fe_min", ".3f", "", "0.9", PAPER),
    ("Castigliano over finite elements, largest", "castigliano_over_fe_max", ".3f", "", "1.1", PAPER),
    ("transmission error, peak to peak", "transmission_error_peak_to_peak_um", ".2f", "µm", "", ""),
    ("gear ratio under load, least", "gear_ratio_min", ".4f", "", "", ""),
    ("gear ratio under load, largest", "gear_ratio_max", ".4f", "", "", ""),
    ("gear ratio under load, mean", "gear_ratio_mean", ".5f", "", "gear_ratio_nominal", "z₂/z₁"),
    ("largest dynamic factor, rigid model", "dynamic_factor_rigid", ".3f", "", "", ""),
    ("largest dynamic factor, elastic model", "dynamic_factor_elastic", ".3f", "", "", ""),
    ("largest dynamic factor, classical model", "dynamic_factor_classical", ".3f", "", "", ""),
)

Published = tuple[str, float, float, str, str]


class Row(NamedTuple):
    """One line of the table of numbers."""

    label: str
    value: str
    unit: str
    reference: str
    source: str


class Picture(NamedTuple):
    """One picture with its heading and caption; wide ones take the page's whole width."""

    title: str
    caption: str
    data: str
    wide: bool


def write_report(
    results: Results,
    out: Path,
    published: Iterable[Published] = (),
    rendering: Rendering | None = None,
    pictures: Mapping[str, Path] | None = None,
) -> Path:
    """Write report.html: answer, numbers beside those of others, pictures, assumptions, method and files.

    Parameters
    ----------
    results : Results
        Of any stages; sections of stages that were not run are left out.
    out : Path
        Folder.
    published : iterable of (label, ours, theirs, unit, reason)
        Published figures to stand beside ours, with a sentence on why they differ.
    rendering : Rendering, optional
        Picture of the deformed tooth.
    pictures : mapping of str to Path, optional
        What `write_pictures` returned; by default it is called.

    Returns
    -------
    Path
        The file.
    """
    values = summarise(results)
    drawn = write_pictures(results, out) if pictures is None else pictures
    page = template("template.html").render(
        values=values,
        answer=_answer(results, values),
        rows=_rows(values),
        remarks=_remarks(results, values),
        pictures=_pictures(values | _for_captions(results), drawn, rendering),
        published=[(*row, (row[1] / row[2] - 1.0) * 100.0) for row in published],
        files=[(name, meaning) for name, meaning in FILES.items() if (Path(out) / name).exists()],
        stages={"compliance": results.compliance, "engagement": results.engagement, "dynamics": results.elastic},
        notice=rendering.notice if rendering is not None else "",
    )
    path = Path(out) / "report.html"
    with whole(path) as temporary:
        temporary.write_text(page, encoding="utf-8")
    return path


def _answer(results: Results, values: Mapping[str, Any]) -> str:
    operation = results.setup.operation
    sentences = []
    if results.engagement is not None:
        sentences.append(
            f"At {values['pinion_torque_Nm']:.4g} N m on the pinion the mesh stiffness is {values['mesh_stiffness_mean_N_per_mm_um']:.2f} "
            f"N/(mm·µm) in the mean (slope dF/dδ), that of a single pair at most {values['single_stiffness_max_N_per_mm_um']:.2f} "
            "N/(mm·µm) (secant F/δ)."
        )
    if results.elastic is not None:
        sentences.append(
            f"At {operation.pinion_speed / RPM:.4g} rpm the largest dynamic factor of the elastic model is "
            f"{values['dynamic_factor_elastic']:.3f}."
        )
    return " ".join(sentences)


def _remarks(results: Results, values: Mapping[str, Any]) -> list[str]:
    """Return the sentences under the table of numbers."""
    beam = [WHY_NOT_PAPER] if "castigliano_over_fe_min" in values else []
    return beam + ([KW_FORM] if results.elastic is not None else [])


def _for_captions(results: Results) -> dict[str, Any]:
    """Return numbers of the captions that are no results of their own."""
    engagement = results.engagement
    pairs = () if engagement is None else set(engagement.contacts.pairs)
    share = {"largest_load_share": max(float(share_of(engagement, pair).max()) for pair in pairs)} if engagement is not None else {}
    away = {"away_from_line_mm": away_from_line(results) / MM} if has_worn_flanks(results) else {}
    return {"friction_coefficient": results.setup.operation.friction_coefficient, **share, **away}


def _load(values: Mapping[str, Any]) -> str:
    share = values.get("largest_load_share", 1.0)
    if values["contact_ratio"] < 2.0 and share > 1.0 - 1e-9:
        return "the whole normal force, at the outer end of one-pair contact"
    return (
        "the whole normal force on one tooth, one base pitch above its lowest contact, although a pair of these gears never carries "
        f"more than {100.0 * share:.0f} % of it"
    )


def _rows(values: Mapping[str, Any]) -> list[Row]:
    """Return the table of numbers; rows whose key is absent are left out."""
    rows = []
    for label, key, form, unit, beside, source in NUMBERS:
        if key in values:
            reference = _number(values[beside], form) if beside in values else beside
            rows.append(Row(label, _number(values[key], form), unit, reference, source))
    return rows


def _number(value: Any, form: str) -> str:
    parts = value if isinstance(value, list) else [value]
    return " / ".join(format(part, form) for part in parts)


def _pictures(values: Mapping[str, Any], drawn: Mapping[str, Path], rendering: Rendering | None) -> list[Picture]:
    found = [
        Picture(title, caption(values), inline(drawn[name]), name in WIDE) for name, (title, caption) in CAPTIONS.items() if name in drawn
    ]
    if rendering is not None:
        text = f"{rendering.title}. The line is the undeformed outline; the arrow is the load: {_load(values)}."
        found.insert(1, Picture("Deformed tooth", text, inline(rendering.path), False))
    return found


def template(name: str) -> jinja2.Template:
    """Return a template of this package; a value that it asks for and does not get is an error."""
    known = jinja2.Environment(
        loader=jinja2.PackageLoader("gearfem", "report"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        finalize=_micro,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return known.get_template(name)


def _micro(value: object) -> object:
    """Return a text with the sign of the micrometre, which sentences for the terminal spell in ASCII; pictures and the rest as they are."""
    return re.sub(r"(?<=[ (])um\b", "µm", value) if isinstance(value, str) and not isinstance(value, Markup) else value


def inline(path: Path) -> str:
    """Return a picture as the address of an image that holds it."""
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
