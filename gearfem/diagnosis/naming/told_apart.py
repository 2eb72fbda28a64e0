"""Explanations that means over the pitches cannot tell apart, by slow records row by row."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

from gearfem.diagnosis.comparing.averages import BY_ROWS, row_by_row
from gearfem.diagnosis.fitting.fit import Fit, attempt
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.score import label, simplicity
from gearfem.diagnosis.modelling.pitch_point import turns_round
from gearfem.diagnosis.naming.gap import closure, gap_left
from gearfem.diagnosis.naming.naming import BEYOND, Naming, Rival, Verdict, sentence_of
from gearfem.diagnosis.naming.verdict import explains, remaining
from gearfem.foundation import Array
from gearfem.foundation.progress import Progress
from gearfem.foundation.side_by_side import counted


def told_apart(problem: Problem, mean: Problem, naming: Naming, progress: Progress) -> Naming:
    """Return the verdict on means that cannot tell explanations apart, each now fitted to slow records row by row too.

    Not to motions: a sensor that reads a quarter makes index errors of four micrometres, and flanks that part take one branch or another.
    """
    near = [rival for rival in naming.rivals if rival.near]
    if naming.verdict != "ambiguous" or not near or not any(turns_round(record) for record in problem.records):
        return naming
    explanations = list({label(one.effects): one for one in (*near, naming.named)}.values())
    found = _scores_by_rows(row_by_row(problem, mean.known), explanations, progress)
    costs = {one: cost for one, (cost, _) in zip(explanations, found, strict=True)}
    threshold, least = max(naming.threshold, BY_ROWS), min(costs.values())
    if not math.isfinite(least):
        return naming
    enough = {one: threshold + doubt for one, (_, doubt) in zip(explanations, found, strict=True)}
    close = [one for one in costs if costs[one] < least + enough[one]]
    best = min(close, key=lambda one: (simplicity(one.effects), costs[one]))
    rivals = tuple(
        dataclasses.replace(one, score_difference=cost - costs[best], why=_beside(cost - costs[best], enough[one]), near=one in close)
        for one, cost in sorted(costs.items(), key=lambda item: item[1])
        if one is not best
    )
    closed, level, remains = closure(naming.alone, best.fit, mean), gap_left(naming.alone, mean), remaining(best.fit, mean)
    verdict: Verdict = "ambiguous" if len(close) > 1 else explains(closed, (level, remains))
    return dataclasses.replace(
        naming,
        verdict=verdict,
        fit=best.fit,
        best=best.fit,
        p_values=best.p_values,
        closed=closed,
        left=remains,
        rivals=(*rivals, *(rival for rival in naming.rivals if not rival.near)),
        # Beyond the farthest that counts as alike: by its own doubt that may stand farther off than others may.
        threshold=max([threshold, *(costs[one] - costs[best] + BEYOND for one in close)]),
        sentence=sentence_of(verdict, best.fit, closed),
    )


def _scores_by_rows(rows: Problem, explanations: Sequence[Rival], progress: Progress) -> list[tuple[float, float]]:
    """Return the scores of explanations with what they leave of slow records row by row, and the doubt about each.

    A fit of rows ends by where it begins, some forty apart: all begin where their means stand, with nuisances as the model has them, and
    where the best one ends. By as much as the two lowest ends of one explanation differ it may lead lower from elsewhere.
    """
    ends: list[list[Fit]] = [[] for _ in explanations]

    def fitted(job: tuple[int, Array]) -> Fit | None:
        number, unknown = job
        return attempt(rows, explanations[number].effects, unknown)

    def begin(jobs: list[tuple[int, Array]]) -> list[list[float]]:
        for (number, _), end in zip(jobs, counted(fitted, jobs, progress, "rivals row by row"), strict=True):
            ends[number] += [] if end is None else [end]
            ends[number].sort(key=lambda end: end.objective)
        return [[one.score_difference + end.objective for end in its] for one, its in zip(explanations, ends, strict=True)]

    starts = [rows.unknowns.of(one.fit.settings) for one in explanations]
    scores = begin([(number, unknown) for number, start in enumerate(starts) for unknown in (start, rows.unknowns.neutral(start))])
    best = min(range(len(scores)), key=lambda number: min(scores[number], default=math.inf))
    if ends[best]:
        scores = begin([(number, ends[best][0].point.stood) for number in range(len(scores)) if number != best])
    return [(its[0] if its else math.inf, its[1] - its[0] if len(its) > 1 else 0.0) for its in scores]


def _beside(worse: float, enough: float) -> str:
    """Return why an explanation lost, or did not, once slow records count row by row."""
    if worse < enough:
        return f"cannot be told apart: with slow records row by row its score differs by {worse:+.1f}, less than {enough:.1f}"
    return f"leaves more of slow records row by row: score worse by {worse:.1f}"
