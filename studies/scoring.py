"""What a verdict is worth beside the label of its campaign: names, gears and teeth, the gap that is left, parameters and their errors."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

# Name, gear and tooth of one effect; an explanation is one or more of them.
Brief = Mapping[str, Any]
Explanation = tuple[Brief, ...]

PLACE = ("gear", "tooth")
NAMING = ("explained", "partly_explained", "ambiguous")
# Outcomes of a verdict, from the best to the worst; FALSE are those in which a name stands that should not.
OUTCOMES = {
    "right": "verdict, names, gears and teeth as the label has them",
    "partly": "names, gears and teeth right, but said to leave a gap",
    "too sure": "an accepted explanation, where the label says that the data cannot decide",
    "misplaced": "names right, a gear or tooth wrong",
    "incomplete": "some of the names right, none wrong",
    "ambiguous": "said to be ambiguous, an accepted explanation among those stated, where the data can decide",
    "refused": "unexplained, where there is something to name or nothing to explain",
    "missed": "no discrepancy, where there is something",
    "extra": "a name beside the right ones",
    "wrong class": "said to be ambiguous, the label's explanation not among those stated",
    "wrong name": "a wrong name",
    "failed": "ended in an error",
}
FALSE = ("extra", "wrong class", "wrong name")
# A standard normal value lies within so many standard deviations in 95 % of all cases.
INTERVAL = 1.959964


@dataclass(frozen=True)
class Label:
    """What is true of a campaign; `accept` holds the explanations that count as right, the truth first."""

    kind: str
    level: str
    verdicts: tuple[str, ...]
    accept: tuple[Explanation, ...]
    # Parameters of each true effect in the catalogue's terms, and how clearly the data show it, where the label says so.
    truth: tuple[Mapping[str, Any], ...] = ()
    strengths: tuple[float, ...] = ()
    hidden: str = ""
    # What the true effects and index errors would leave of each record: sensor noise and waviness, in the record's unit.
    floors: Mapping[str, float] = field(default_factory=dict)
    deciding: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """True causes in one word."""
        return " + ".join(sorted(str(one["name"]) for one in self.truth)) or self.hidden or "none"


@dataclass(frozen=True)
class Found:
    """A verdict as it was written, and how long it took by the clock and on all cores [s], where that is known."""

    verdict: str
    effects: tuple[Mapping[str, Any], ...] = ()
    alternatives: tuple[Explanation, ...] = ()
    gap: tuple[Mapping[str, Any], ...] = ()
    suggestion: str = ""
    seconds: float = math.nan
    core_seconds: float = math.nan
    code: str = ""

    @property
    def named(self) -> Explanation:
        """Name, gear and tooth of what is named."""
        places = ({key: one["parameters"][key]["value"] for key in PLACE if key in one["parameters"]} for one in self.effects)
        return tuple({"name": one["name"], **place} for one, place in zip(self.effects, places, strict=True))

    @property
    def stated(self) -> tuple[Explanation, ...]:
        """All explanations that the verdict stands for."""
        if self.verdict not in NAMING:
            return ()
        return (self.named, *self.alternatives) if self.verdict == "ambiguous" else (self.named,)

    @property
    def name(self) -> str:
        """What was found in one word."""
        names = " + ".join(sorted(str(one["name"]) for one in self.effects))
        return {"explained": names, "partly_explained": names, "ambiguous": f"ambiguous ({names})"}.get(self.verdict, self.verdict)


@dataclass(frozen=True)
class Parameter:
    """One true value, what was found for it and its stated standard error; both in the unit of the key."""

    effect: str
    key: str
    true: float
    found: float
    stderr: float | None

    @property
    def error(self) -> float:
        """Error over the stated one; NaN where none is stated. Angles count the short way round."""
        apart = self.found - self.true
        if self.key.endswith("_rad"):
            apart = math.remainder(apart, 2.0 * math.pi)
        return abs(apart) / self.stderr if self.stderr else math.nan


@dataclass(frozen=True)
class Gap:
    """A hold-out record before and after, beside the floor that the label knows."""

    record: str
    before: float
    after: float
    floor: float

    @property
    def closure(self) -> float:
        """Share of the gap above the floor that is closed; NaN where there was none."""
        before, after, floor = self.before**2, self.after**2, self.floor**2
        return 1.0 - max(after - floor, 0.0) / (before - floor) if before > floor else math.nan


@dataclass(frozen=True)
class Scored:
    """One campaign: its label, its verdict and what that is worth."""

    case: str
    label: Label
    found: Found
    outcome: str
    decided: Found | None = None

    @property
    def names_right(self) -> bool:
        """Whether the names are accepted, in a verdict that the label allows or one that says that a gap is left."""
        if self.found.verdict not in (*self.label.verdicts, "partly_explained"):
            return False
        return accepted(self.label, self.found.stated, place=False)

    @property
    def has_place(self) -> bool:
        """Whether gears or teeth belong to the truth."""
        return any(key in one for one in (self.label.accept or ((),))[0] for key in PLACE)

    @property
    def place_right(self) -> bool:
        """Whether gears and teeth are accepted as well."""
        return self.names_right and accepted(self.label, self.found.stated, place=True)

    @property
    def stronger_named(self) -> bool:
        """Whether an accepted name of the strongest effect is among those named."""
        first = int(np.argmax(self.label.strengths)) if self.label.strengths else 0
        options = {one[first]["name"] for one in self.label.accept if len(one) > first}
        return any(one["name"] in options for one in self.found.named)

    @property
    def gaps(self) -> tuple[Gap, ...]:
        """Hold-out records, whatever the verdict."""
        rows = (row for row in self.found.gap if row["role"] == "holdout" and row["record"] in self.label.floors)
        return tuple(Gap(row["record"], row["before_rms"], row["after_rms"], self.label.floors[row["record"]]) for row in rows)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of true effects that are named with the right gear and tooth."""
        return tuple(itertools.chain.from_iterable(_parameters(true, self.found.effects) for true in self.label.truth))

    @property
    def decision(self) -> bool | None:
        """Whether the deciding record led to the truth; None where it was not tried."""
        if self.decided is None:
            return None
        return self.decided.verdict == "explained" and matches(self.decided.named, self.label.accept[0], place=True)


def matches(found: Explanation, wanted: Explanation, place: bool) -> bool:
    """Return whether two explanations hold the same effects; a gear or tooth counts where the wanted one has it."""
    if len(found) != len(wanted):
        return False
    keys = ("name", *PLACE) if place else ("name",)
    return any(
        all(one.get(key) == other[key] for one, other in zip(found, order, strict=True) for key in keys if key in other)
        for order in itertools.permutations(wanted)
    )


def accepted(label: Label, stated: Iterable[Explanation], place: bool) -> bool:
    """Return whether one of the explanations counts as right."""
    return any(matches(one, other, place) for one in stated for other in label.accept)


def outcome(label: Label, found: Found) -> str:
    """Return what a verdict is worth, one of OUTCOMES."""
    if found.verdict not in NAMING:
        if found.verdict in label.verdicts:
            return "right"
        return {"unexplained": "refused", "no_discrepancy": "missed"}.get(found.verdict, "failed")
    names, places = (accepted(label, found.stated, place) for place in (False, True))
    if label.kind == "twins" and found.verdict == "ambiguous":
        # The class: the truth and at least one that imitates it.
        stated = [any(matches(one, other, True) for one in found.stated) for other in label.accept]
        return "right" if stated[0] and sum(stated) > 1 else "wrong class"
    if not names:
        return "wrong class" if found.verdict == "ambiguous" else _beside(label, found.named)
    if not places:
        return "misplaced"
    if found.verdict in label.verdicts:
        return "right"
    if label.verdicts == ("ambiguous",):
        return "too sure"
    return "ambiguous" if found.verdict == "ambiguous" else "partly"


def _beside(label: Label, named: Explanation) -> str:
    """Return how names that are not accepted differ from those that are."""
    found = sorted(one["name"] for one in named)
    for wanted in (sorted(one["name"] for one in other) for other in label.accept):
        if wanted and _within(wanted, found):
            return "extra"
        if found and _within(found, wanted):
            return "incomplete"
    return "wrong name"


def _within(few: list[str], many: list[str]) -> bool:
    return all(few.count(one) <= many.count(one) for one in few)


def _parameters(true: Mapping[str, Any], effects: Iterable[Mapping[str, Any]]) -> Iterator[Parameter]:
    for effect in effects:
        found = effect["parameters"]
        if effect["name"] != true["name"] or any(found[key]["value"] != true[key] for key in PLACE if key in found):
            continue
        for key, one in found.items():
            if "stderr" in one and key in true:
                yield Parameter(effect["name"], key, float(true[key]), float(one["value"]), one["stderr"])
        return


def read_label(path: Path) -> Label:
    """Read the label of a campaign.

    Parameters
    ----------
    path : Path
        JSON with `kind`, `level`, `effects`, `verdicts` and `accept` (the generator's), or with `verdict` and lists of names beyond
        the truth in `accept`.
    """
    text = json.loads(path.read_text(encoding="utf-8"))
    truth = tuple({"name": one["name"], **one.get("nearest_catalogue", one)} for one in text["effects"])
    own = tuple({key: one[key] for key in ("name", *PLACE) if key in one} for one in truth)
    accept = [tuple({"name": one} if isinstance(one, str) else one for one in other) for other in text["accept"]]
    if "records" in text:
        floors = {row["file"]: row["floor_index_rms"] for row in text["records"]}
    else:
        accept, floors = [own, *accept], text.get("floor_index_rms", {})
    hidden = text.get("hidden") or ""
    return Label(
        kind=text["kind"],
        level=text["level"],
        verdicts=tuple(text.get("verdicts", text.get("verdict"))),
        accept=tuple(accept),
        truth=truth,
        strengths=tuple(text.get("strengths", ())) if truth else (),
        hidden=hidden if isinstance(hidden, str) else " + ".join(one["name"] for one in hidden),
        floors=floors,
        deciding=tuple(text.get("deciding", ())),
    )


def read_found(folder: Path) -> Found:
    """Read the verdict in a folder: diagnosis.json, with run.json beside it where the study wrote it."""
    run_file = folder / ("failed.json" if (folder / "failed.json").exists() else "run.json")
    run = json.loads(run_file.read_text(encoding="utf-8")) if run_file.exists() else {}
    more = {"seconds": run.get("seconds", math.nan), "core_seconds": run.get("core_seconds", math.nan), "code": run.get("code", "")}
    if "error" in run:
        return Found("failed", **more)
    text = json.loads((folder / "diagnosis.json").read_text(encoding="utf-8"))
    near = [one for one in text["alternatives"] if one["score_difference"] < text.get("threshold", math.inf)]
    # Alternatives come with their parameters from gearfem, and at least with their names from anybody.
    tables = [one.get("parameters") or [{"name": name} for name in one["effects"]] for one in near]
    briefs = (tuple({key: effect[key] for key in ("name", *PLACE) if key in effect} for effect in table) for table in tables)
    return Found(text["verdict"], tuple(text["effects"]), tuple(briefs), tuple(text["gap"]), text["suggestion"] or "", **more)


def score_case(case: str, label: Label, found: Found, decided: Found | None = None) -> Scored:
    """Return what a verdict is worth."""
    return Scored(case, label, found, outcome(label, found), decided)
