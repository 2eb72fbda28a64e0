"""One verdict from two: on all teeth and on single ones, or on slow records row by row and on means."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.diagnosis.comparing.averages import beside, whole
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.naming.naming import Naming, Rival, Verdict, sentence_of
from gearfem.diagnosis.naming.verdict import REST
from gearfem.effects.effect import Effect

# Prior deviations beyond which nuisances alone stand elsewhere than before the search.
FAR_APART = 1.0
# Verdicts that name something.
NAMED: tuple[Verdict, ...] = ("explained", "partly_explained", "ambiguous")


def merged(first: Naming, second: Naming) -> Naming:
    """Return one verdict from that on slow records row by row and that on means under what it names."""
    return _one(first, second, second.alone, beside(first.fit, second.fit), "row by row", "in means")


def joined(problem: Problem, alone: Fit, first: Naming, second: Naming) -> Naming:
    """Return one verdict from that on all teeth and that on single ones; where nothing is named nuisances stand as these have left them."""
    apart = problem.unknowns.of(first.alone.settings) - problem.unknowns.of(alone.settings)
    if first.fit.effects or second.fit.effects:
        fit = whole(problem, first.fit, second.fit)
    elif np.abs(apart[: problem.outer]).max(initial=0.0) > FAR_APART:
        fit = alone = whole(problem, first.alone, second.alone)
    else:
        fit = alone
        problem.prepare((), alone.point.stood)
    return _one(first, second, alone, fit, "All teeth", "Single teeth")


def _one(first: Naming, second: Naming, alone: Fit, fit: Fit, *words: str) -> Naming:
    """Return one verdict from two on different records, and the fit of what both name."""
    best = (*first.best.effects, *second.best.effects)
    named = [one for one in (first, second) if one.fit.effects]
    verdict = verdict_of_both(first.verdict, second.verdict, second.left)
    closed = max((one.closed for one in named), default=max(first.closed, second.closed))
    rivals = (
        *(_together(rival, (*rival.effects, *second.fit.effects), (*rival.p_values, *second.p_values)) for rival in first.rivals),
        *(_together(rival, (*first.fit.effects, *rival.effects), (*first.p_values, *rival.p_values)) for rival in second.rivals),
    )
    return Naming(
        verdict=verdict,
        fit=fit,
        alone=alone,
        best=fit if fit.effects or not best else dataclasses.replace(fit, effects=best),
        p_values=tuple(chance for one in named for chance in one.p_values),
        without=verdict_of_both(first.without, second.without, second.left),
        gains=first.gains or second.gains,
        level=max(one.level for one in named or (first, second)),
        closed=closed,
        left=max(first.left, second.left),
        rivals=tuple(sorted(rivals, key=lambda rival: rival.score_difference)),
        identifiable=tuple(sorted((*first.identifiable, *second.identifiable), key=lambda one: one.limit)),
        threshold=max(first.threshold, second.threshold),
        sentence=sentence_of(verdict, fit, closed),
        reasons=tuple(f"{word}: {reason}" for word, one in zip(words, (first, second), strict=True) for reason in one.reasons),
    )


def _together(rival: Rival, effects: tuple[Effect, ...], p_values: tuple[float, ...]) -> Rival:
    """Return an explanation beside what is named of the other kind."""
    return dataclasses.replace(rival, effects=effects, p_values=p_values if rival.p_values else ())


def verdict_of_both(means: Verdict, teeth: Verdict, left: float) -> Verdict:
    """Return the verdict on a campaign from those on its means and on its single teeth, of which so many gaps are left.

    What no name stands for of single teeth, but for a little of it that waviness may be, is a rest beside one that stands for means.
    """
    both = means, teeth
    if not any(one in NAMED for one in both):
        return "unexplained" if "unexplained" in both else "no_discrepancy"
    if "ambiguous" in both:
        return "ambiguous"
    rest = means == "unexplained" or (teeth == "unexplained" and not 1.0 <= left <= REST)
    return "partly_explained" if rest or "partly_explained" in both else "explained"
