"""The score sheet of the diagnosis: counts with exact binomial intervals beside the project's goals, as text, CSV and a picture."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from common import table_text, write_rows
from scipy.stats import binom, binomtest
from scoring import FALSE, INTERVAL, OUTCOMES, Scored

from gearfem.foundation.files import whole
from gearfem.report import style

LEVEL = 0.95
# The generator's and a practice set's order; others follow.
KINDS = ("single", "double", "none", "hidden", "twins", "weak")
LEVELS = ("easy", "medium", "hard")
# What is no name stands in the last columns of the picture.
LAST = ("several names", "ambiguous", "unexplained", "no_discrepancy", "failed")
# Seconds that a campaign may take on two cores.
TIME = 300.0
CLOSURE, OVER_FLOOR = 0.90, 1.2
ERROR = 2.0


@dataclass(frozen=True)
class Goal:
    """A share that the project wants: at least `low`, at most `high`."""

    words: str
    low: float = 0.0
    high: float = 1.0

    @property
    def text(self) -> str:
        """The goal in per cent."""
        if self.low and self.high < 1.0:
            return f"{100 * self.low:g} to {100 * self.high:g} %"
        return f">= {100 * self.low:g} %" if self.low else f"<= {100 * self.high:g} %"

    def row(self, hits: Sequence[bool]) -> dict[str, Any]:
        """Return the count of hits with its interval, and whether that lies inside the goal, outside or on both sides."""
        right, cases = sum(hits), len(hits)
        low, high = interval(right, cases)
        inside, outside = self.low <= low and high <= self.high, high < self.low or low > self.high
        return {
            "goal": self.words,
            "right": right,
            "cases": cases,
            "percent": 100.0 * right / cases if cases else math.nan,
            "low_percent": 100.0 * low,
            "high_percent": 100.0 * high,
            "wanted": self.text,
            "met": "-" if not cases else "yes" if self.low <= right / cases <= self.high else "no",
            "shown": "-" if not cases else "met" if inside else "missed" if outside else "open",
            "chance_percent": 100.0 * self.chance(cases),
        }

    def chance(self, cases: int) -> float:
        """Return how likely a program that is exactly as good as the goal's bound would meet it with so many cases."""
        if not cases or (self.low and self.high < 1.0):
            return math.nan
        if self.low:
            return float(binom.sf(math.ceil(self.low * cases - 1e-9) - 1, cases, self.low))
        return float(binom.cdf(math.floor(self.high * cases + 1e-9), cases, self.high))


def interval(right: int, cases: int) -> tuple[float, float]:
    """Return the exact (Clopper-Pearson) interval of a share at 95 %; everything where there are no cases."""
    if not cases:
        return 0.0, 1.0
    found = binomtest(right, cases).proportion_ci(LEVEL, "exact")
    return float(found.low), float(found.high)


def goal_rows(scores: Sequence[Scored]) -> list[dict[str, Any]]:
    """Return the project's goals that are shares of cases, each beside what was reached."""
    return [goal.row(hits) for goal, hits in goals(scores)]


def goals(scores: Sequence[Scored]) -> list[tuple[Goal, list[bool]]]:
    """Return the project's goals that are shares of cases, and for each case that one is about whether it is a hit."""

    def of(kind: str, level: str = "") -> list[Scored]:
        return [one for one in scores if one.label.kind == kind and level in ("", one.label.level)]

    clear, medium, double = of("single", "easy"), of("single", "medium"), of("double")
    decided = [one.decision for one in of("twins") if one.outcome == "right" and one.decision is not None]
    stated = [p.error < INTERVAL for one in scores for p in one.parameters if math.isfinite(p.error)]
    rows: list[tuple[Goal, Iterable[bool]]] = [
        (Goal("one clear effect: right name", 0.96), (one.names_right for one in clear)),
        (Goal("one clear effect, name right: gear and tooth", 0.98), (o.place_right for o in clear if o.names_right and o.has_place)),
        (Goal("one medium effect: right name", 0.85), (one.names_right for one in medium)),
        (Goal("one medium effect: wrong name", high=0.03), (one.outcome in FALSE for one in medium)),
        (Goal("no effect: false name", high=0.015), (one.outcome in FALSE for one in of("none"))),
        (Goal("cause outside the catalogue: refused", 0.95), (one.found.verdict == "unexplained" for one in of("hidden"))),
        (Goal("twins: class stated", 0.90), (one.outcome == "right" for one in of("twins"))),
        (Goal("twins, class stated: the deciding record decides", 0.90), (bool(one) for one in decided)),
        (Goal("two effects: exact set", 0.80), (one.names_right for one in double)),
        (Goal("two effects: the stronger one", 0.95), (one.stronger_named for one in double)),
        (Goal("parameters inside their 95 % intervals", 0.90, 0.98), stated),
        (Goal(f"campaigns within {TIME:g} s", 1.0), (o.found.seconds <= TIME for o in scores if math.isfinite(o.found.seconds))),
    ]
    return [(goal, list(hits)) for goal, hits in rows]


def number_rows(scores: Sequence[Scored]) -> list[dict[str, Any]]:
    """Return the goals that are medians: gap on hold-out records of clear single effects, parameter errors; and the time."""
    clear = [gap for one in scores if (one.label.kind, one.label.level) == ("single", "easy") for gap in one.gaps]
    errors = [p.error for one in scores for p in one.parameters]
    return [
        _median("closure on hold-out records, clear cases", (gap.closure for gap in clear), f">= {CLOSURE:g}"),
        _median("after/floor on hold-out records, clear cases", (gap.after / gap.floor for gap in clear), f"<= {OVER_FLOOR:g}"),
        _median("parameter error over its stated error", errors, f"<= {ERROR:g}"),
        _median("seconds per campaign", (one.found.seconds for one in scores), f"<= {TIME:g}"),
        _median("seconds of all cores per campaign", (one.found.core_seconds for one in scores), f"<= {2 * TIME:g}"),
    ]


def _median(words: str, values: Iterable[float], wanted: str) -> dict[str, Any]:
    known = np.array([value for value in values if math.isfinite(value)])
    quartiles = np.percentile(known, (0, 25, 50, 75, 100)) if known.size else np.full(5, math.nan)
    names = ("least", "quarter", "median", "three_quarters", "most")
    return {"number": words, "values": known.size, "wanted": wanted, **dict(zip(names, map(float, quartiles), strict=True))}


def level_rows(scores: Sequence[Scored]) -> list[dict[str, Any]]:
    """Return how many verdicts of each kind and level came out in which way, those in which all is right with their interval."""
    groups: dict[tuple[str, str], list[Scored]] = {}
    for one in scores:
        groups.setdefault((one.label.kind, one.label.level), []).append(one)
    present = [name for name in OUTCOMES if name == "right" or any(one.outcome == name for one in scores)]
    rows = []
    for kind, level in sorted(groups, key=lambda key: (_place(KINDS, key[0]), _place(LEVELS, key[1]))):
        group = groups[kind, level]
        low, high = interval(sum(one.outcome == "right" for one in group), len(group))
        closures = [gap.closure for one in group for gap in one.gaps if math.isfinite(gap.closure)]
        rows.append(
            {"kind": kind, "level": level, "cases": len(group)}
            | {name.replace(" ", "_"): sum(one.outcome == name for one in group) for name in present}
            | {"right_low_percent": 100.0 * low, "right_high_percent": 100.0 * high}
            | {"closure_median": float(np.median(closures)) if closures else math.nan}
            | {"seconds_median": float(np.median([one.found.seconds for one in group]))}
        )
    return rows


def _place(order: tuple[str, ...], word: str) -> tuple[int, str]:
    return (order.index(word) if word in order else len(order), word)


def confusion_rows(scores: Sequence[Scored]) -> list[dict[str, Any]]:
    """Return how often what was found for what was true."""
    counts = Counter((one.label.kind, one.label.name, one.found.name) for one in scores)
    order = sorted(counts, key=lambda key: (_place(KINDS, key[0]), key[1], -counts[key], key[2]))
    return [{"kind": kind, "true": true, "found": found, "cases": counts[kind, true, found]} for kind, true, found in order]


def confusion_lines(scores: Sequence[Scored]) -> list[dict[str, Any]]:
    """Return the same with one row for each true cause."""
    lines: dict[tuple[str, str], list[str]] = {}
    for row in confusion_rows(scores):
        lines.setdefault((row["kind"], row["true"]), []).append(f"{row['found']} {row['cases']}")
    return [{"kind": kind, "true": true, "found": ", ".join(found)} for (kind, true), found in lines.items()]


def case_rows(scores: Sequence[Scored]) -> list[dict[str, Any]]:
    """Return one row for each campaign."""
    return [
        {
            "case": one.case,
            "kind": one.label.kind,
            "level": one.label.level,
            "true": one.label.name,
            "verdict": one.found.verdict,
            "found": one.found.name,
            "outcome": one.outcome,
            "stated": len(one.found.stated),
            "decided": {None: "", True: "yes", False: "no"}[one.decision],
            "strength": max(one.label.strengths, default=math.nan),
            "closure": _middle([gap.closure for gap in one.gaps]),
            "after_over_floor": _middle([gap.after / gap.floor for gap in one.gaps]),
            "parameter_error": _middle([p.error for p in one.parameters]),
            "seconds": one.found.seconds,
            "core_seconds": one.found.core_seconds,
            "suggestion": one.found.suggestion,
            "deciding": " ".join(one.label.deciding),
            "program": one.found.code,
        }
        for one in scores
    ]


def _middle(values: Iterable[float]) -> float:
    known = [value for value in values if math.isfinite(value)]
    return float(np.median(known)) if known else math.nan


def parameter_rows(scores: Sequence[Scored]) -> list[dict[str, Any]]:
    """Return one row for each parameter of an effect that was found in the right place."""
    return [
        {"case": one.case, "effect": p.effect, "key": p.key, "true": p.true, "found": p.found}
        | {"stderr": math.nan if p.stderr is None else p.stderr, "error_over_stderr": p.error}
        for one in scores
        for p in one.parameters
    ]


def sentences(scores: Sequence[Scored]) -> tuple[str, ...]:
    """Return what a reader of the tables must know."""
    codes = {one.found.code for one in scores} - {""}
    said = [
        "right and interval: exact binomial, 95 %; shown: met or missed where the whole interval lies on one side of the goal, else open; "
        "chance: how often a program exactly as good as the goal would meet it with so many cases",
        *(f"{name}: {OUTCOMES[name]}" for name in OUTCOMES if any(one.outcome == name for one in scores)),
    ]
    if len(codes) > 1:
        said.append(f"verdicts come from {len(codes)} states of the program: not one score")
    return tuple(said)


def write_sheet(scores: Sequence[Scored], out: Path) -> list[Path]:
    """Print the score sheet and write it to a folder.

    Parameters
    ----------
    scores : sequence of Scored
        At least one.
    out : Path
        Folder.

    Returns
    -------
    list of Path
    """
    shown = {"goals": goal_rows, "medians": number_rows, "verdicts by kind and level": level_rows, "true and found": confusion_lines}
    text = "\n".join([*(table_text(title, _known(rows(scores))) for title, rows in shown.items()), "", *sentences(scores), ""])
    print(text)
    with whole(out / "score_sheet.txt") as temporary:
        temporary.write_text(text, encoding="utf-8")
    written = [out / "score_sheet.txt"]
    tables: dict[str, Callable[[Sequence[Scored]], list[dict[str, Any]]]] = {
        "goals": goal_rows,
        "numbers": number_rows,
        "levels": level_rows,
        "confusion": confusion_rows,
        "cases": case_rows,
        "parameters": parameter_rows,
    }
    for name, rows in tables.items():
        if known := _known(rows(scores)):
            written.append(out / f"score_{name}.csv")
            write_rows(written[-1], known, sentences(scores))
    return [*written, draw(scores, out / "score_sheet.png")]


def _known(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Leave cells empty that hold no number."""
    return [{key: "" if isinstance(value, float) and math.isnan(value) else value for key, value in row.items()} for row in rows]


def _column(found: str) -> str:
    """Return the column of the picture for what was found."""
    return "ambiguous" if found.startswith("ambiguous") else "several names" if " + " in found else found


@style.styled
def draw(scores: Sequence[Scored], path: Path) -> Path:
    """Draw the goals with their intervals, and what was found for what was true."""
    found = [{**row, "found": _column(row["found"])} for row in confusion_rows(scores) if row["kind"] != "double"]
    true = list(dict.fromkeys(row["true"] for row in found))
    names = sorted({row["found"] for row in found}, key=lambda name: (_place(LAST, name)[0] < len(LAST), _place((*true, *LAST), name)))
    figure, axes = style.make_figure((13.0, max(4.5, 0.24 * max(len(true), len(names)) + 2.5)), columns=2)
    _draw_goals(axes[0], [(goal, hits) for goal, hits in goals(scores) if hits])
    table = np.zeros((len(true), len(names)))
    for row in found:
        table[true.index(row["true"]), names.index(row["found"])] += row["cases"]
    axes[1].imshow(table / np.maximum(table.sum(1, keepdims=True), 1.0), cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    for (i, j), count in np.ndenumerate(table):
        if count:
            axes[1].text(j, i, f"{count:g}", ha="center", va="center", color="white" if count > 0.5 * table[i].sum() else style.INK)
    axes[1].grid(False)
    axes[1].set_xticks(range(len(names)), names, rotation=90)
    axes[1].set_yticks(range(len(true)), true)
    axes[1].set_title("true (rows) and found; two effects at once are left out")
    return style.save(figure, path)


def _draw_goals(axes: Any, wanted: Sequence[tuple[Goal, list[bool]]]) -> None:
    colours = {"met": style.GREEN, "missed": style.VERMILION, "open": style.ORANGE}
    names = []
    for height, (goal, hits) in enumerate(reversed(wanted)):
        row = goal.row(hits)
        axes.plot([row["low_percent"], row["high_percent"]], [height, height], color=colours[row["shown"]], linewidth=2.5)
        axes.plot(row["percent"], height, "o", color=style.INK, markersize=4)
        for bound in {goal.low, goal.high if goal.high < 1.0 else goal.low} - {0.0}:
            axes.plot([100.0 * bound] * 2, [height - 0.25, height + 0.25], color=style.INK, linewidth=1.0)
        names.append(f"{row['goal']}\n{row['right']} of {row['cases']}, wanted {row['wanted']}")
    axes.set_yticks(range(len(names)), names)
    axes.set_xlim(-2.0, 102.0)
    axes.set_xlabel("per cent")
    axes.set_title("95 % intervals: green meets its goal (upright), orange is open, red misses it")
