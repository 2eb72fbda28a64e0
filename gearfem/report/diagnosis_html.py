"""The report of a diagnosis: one HTML page that holds its pictures and asks nothing of the network."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from gearfem.definition.setup import Setup
from gearfem.diagnosis.diagnose import Diagnosis
from gearfem.diagnosis.modelling.nuisances import BUILD, MOVING, SCALES, SERIES, Nuisance
from gearfem.diagnosis.modelling.teeth import Scatter
from gearfem.diagnosis.naming.identify import Identifiability
from gearfem.diagnosis.naming.naming import Rival
from gearfem.diagnosis.proving.proof import Gap
from gearfem.diagnosis.reading.roles import ROLES
from gearfem.diagnosis.write import FINDING, notes, nuisance_rows, reasons, stderr
from gearfem.effects.effect import Effect
from gearfem.foundation.files import whole
from gearfem.foundation.units import UM, digits, factor, written
from gearfem.report.diagnosis_plots import write_diagnosis_pictures
from gearfem.report.html import inline, template
from gearfem.variants import VARIANTS

HEADINGS = {
    "explained": "Explained",
    "partly_explained": "Partly explained",
    "no_discrepancy": "No discrepancy",
    "unexplained": "A gap without a name",
    "ambiguous": "Several explanations",
}
# Cosine beyond which two effects cannot be told apart unless they are strong.
ALIKE = 0.95
# Of a normal distribution.
INTERVAL = 1.96
CAPTIONS = {
    "gap": (
        "What is left of every record",
        "Each in parts of its floor, what a right model would leave: the sensor's noise and the waviness of teeth.",
    ),
    "records": ("What is left over three pitches", "Measured less computed; the constant of each record is taken off."),
    "map_mesh_phase": (
        "Where in the mesh cycle",
        "Power of what is left, over what noise, nuisances and errors of the model leave: 1 is nothing. Records from low to high "
        "torque, those at speed below.",
    ),
    "map_order": ("At which orders", "The same over the orders of the pinion's turns that are strongest before."),
    "map_pinion": ("On which teeth of the pinion", "The same over the teeth, by the one nearest to the middle of its path of contact."),
    "map_wheel": ("On which teeth of the wheel", "The same for the wheel."),
}


def _prior(nuisance: Nuisance) -> str:
    """Return the prior of a nuisance in words."""
    about = "" if nuisance.level == 1.0 else f" about {100.0 * nuisance.level:g} %"
    return f"{nuisance.words} {100.0 * nuisance.prior:.2g} %{about}"


ASSUMPTIONS = (
    f"Nuisances carry Gaussian priors: {'; '.join(_prior(nuisance) for nuisance in (*SCALES, *BUILD, *MOVING))}; "
    f"compliance in series {100.0 * SERIES:g} % of that of a usual mesh; index error of each tooth {Scatter().index / UM:g} µm.",
    f"Errors of our own model carry priors too: {'; '.join(variant.words for variant in VARIANTS)}; form errors that all teeth share.",
    "Intervals are 95 % of a normal distribution, linear about the fit; nuisances and errors of the model are in them.",
)


class ParameterRow(NamedTuple):
    """One parameter with its interval."""

    effect: str
    words: str
    value: str
    interval: str
    unit: str
    remark: str


def write_diagnosis_report(diagnosis: Diagnosis, out: Path) -> list[Path]:
    """Write report.html and the pictures beside it.

    Parameters
    ----------
    diagnosis : Diagnosis
        Of a campaign.
    out : Path
        Folder.

    Returns
    -------
    list of Path
        The page first.
    """
    drawn = write_diagnosis_pictures(diagnosis, out)
    naming = diagnosis.naming
    page = template("diagnosis.html").render(
        name=diagnosis.campaign.name,
        version=version("gearfem"),
        heading=HEADINGS[naming.verdict],
        verdict=naming.verdict,
        sentence=naming.sentence,
        reasons=reasons(diagnosis),
        places=[place.sentence for place in diagnosis.before.where[:6]],
        gap_sentence=diagnosis.before.sentence,
        parameters=_parameters(diagnosis),
        effects=naming.fit.effects,
        p_values=naming.p_values,
        rivals=[_rival(rival) for rival in (diagnosis.alternatives or naming.rivals[:8])],
        identifiable=[_identifiable(one, diagnosis.campaign.setup) for one in naming.identifiable],
        nuisances=[row | {"unit": written(row.get("unit", ""))} for row in nuisance_rows(diagnosis)],
        finding=FINDING,
        gaps=[_gap(gap) for gap in diagnosis.proof.records],
        suggestions=diagnosis.suggestions[:3],
        notes=notes(diagnosis),
        assumptions=[*ASSUMPTIONS, *diagnosis.campaign.setup.assumptions],
        closed="closed" if naming.fit.effects else "closed by nuisances",
        pictures=[(*CAPTIONS[key], inline(drawn[key])) for key in CAPTIONS if key in drawn],
    )
    path = Path(out) / "report.html"
    with whole(path) as temporary:
        temporary.write_text(page, encoding="utf-8")
    return [path, *drawn.values()]


def _parameters(diagnosis: Diagnosis) -> list[ParameterRow]:
    fit = diagnosis.naming.fit
    rows = []
    for number, (effect, deviations) in enumerate(zip(fit.effects, diagnosis.deviations, strict=True)):
        for field, known in effect.parameters().items():
            key = effect.key(field)
            value, remark = getattr(effect, field) / factor(key), "at its bound" if (number, field) in fit.bound else ""
            edges = tuple(edge / factor(key) for edge in known.bounds(diagnosis.campaign.setup, effect.member))
            interval = "a whole number, chosen" if known.whole else _interval(value, stderr(effect, field, deviations[field]), edges)
            rows.append(ParameterRow(title(effect), known.words, f"{value:.4g}", interval, written(known.unit), remark))
    return rows


def _interval(value: float, error: float | None, edges: tuple[float, ...]) -> str:
    """Return the interval of 95 % in words, of a standard error in the same unit, within what the parameter can be."""
    if error is None:
        return "not decided by these data"
    low, high = (min(max(value + side * INTERVAL * error, edges[0]), edges[1]) for side in (-1.0, 1.0))
    return f"{low:.4g} to {high:.4g}"


def title(effect: Effect) -> str:
    """Return an effect in few words: name, gear and tooth."""
    parts = [effect.name.replace("_", " ")]
    if effect.of_one_gear():
        parts.append(f"of the {effect.member}")
    if hasattr(effect, "tooth"):
        parts.append(f"on tooth {effect.tooth}")
    return " ".join(parts)


def _identifiable(one: Identifiability, setup: Setup) -> dict[str, Any]:
    least = one.effect.scaled(min(one.limit, 1.0), setup)
    known = least.parameters()
    strengths = least.strengths()
    words = [field.replace("_", " ") + " " if len(strengths) > 1 else "" for field in strengths]
    sizes = [abs(getattr(least, field)) / factor(least.key(field)) for field in strengths]
    size = [f"{word}{digits(one)} {written(known[field].unit)}".strip() for word, one, field in zip(words, sizes, strengths, strict=True)]
    return {
        "effect": title(one.effect).partition(" on tooth")[0],
        "share": f"{one.share:.0%}",
        "limit": (", ".join(size) if size else "-") if one.limit < 1.0 else "more than is typical",
        "rival": title(one.rival).partition(" on tooth")[0] if one.rival is not None else "none",
        "overlap": f"{one.overlap:.2f}",
        "alike": one.overlap > ALIKE,
    }


def _rival(rival: Rival) -> dict[str, Any]:
    return {
        "effects": " and ".join(title(effect) for effect in rival.effects),
        "difference": f"{rival.score_difference:.1f}",
        "near": rival.near,
        "why": rival.why,
        "detail": "; ".join(effect.describe() for effect in rival.effects),
    }


def _gap(gap: Gap) -> dict[str, Any]:
    scale = gap.measurement.to_file
    row = {
        "record": gap.measurement.file,
        "role": ROLES[gap.role],
        "unit": written(gap.measurement.quantity.unit),
    }
    series = {"before": gap.before, "nuisances": gap.nuisances_only, "smooth": gap.smooth, "after": gap.after}
    numbers = {key: digits(gap.rms(values) * scale) if values.size else "-" for key, values in series.items()}
    floors = {
        "noise": digits(gap.noise_rms * scale),
        "floor": digits(gap.floor_rms * scale),
        "closure": f"{100.0 * gap.closure:.0f} %" if gap.closure >= 0.0 else "none, wider",
    }
    return row | numbers | floors
