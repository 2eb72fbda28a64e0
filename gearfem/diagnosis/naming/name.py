"""Name the effects that a campaign shows: of all teeth by means over the pitches, of single teeth and turns by what differs from these."""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from gearfem.diagnosis.comparing.averages import (
    BY_ROWS,
    averaged,
    bare,
    beside,
    has_means,
    of_teeth,
    row_by_row,
    shows_in_means,
    teeth_under,
    whole,
)
from gearfem.diagnosis.fitting.fit import Fit, again
from gearfem.diagnosis.fitting.index_errors import turns_often
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.score import Label, label, simplicity
from gearfem.diagnosis.fitting.side_by_side import counted
from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.modelling.pitch_point import turns_round
from gearfem.diagnosis.naming.gap import closure, gap_left
from gearfem.diagnosis.naming.hammering import left_open, untold
from gearfem.diagnosis.naming.naming import Naming, Rival, Verdict, sentence_of
from gearfem.diagnosis.naming.search import FURTHER_LEAST, FURTHER_OTHER, Search
from gearfem.diagnosis.naming.select import select
from gearfem.diagnosis.naming.suspects import turning
from gearfem.diagnosis.naming.verdict import REST, explains, judge
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, Array
from gearfem.foundation.progress import Progress, quiet

# Explanations without single teeth with which the search under these begins.
BEGUN = 4
# Prior deviations beyond which nuisances alone stand elsewhere than before the search.
FAR_APART = 1.0
# What is said of effects of all teeth in the place of what they gain.
NOTHING_SOUGHT = "None was sought: index errors swing more than once a turn, which stays under whatever all teeth have."
# What is said where the verdicts on all teeth and on single ones stay as they are each by itself.
NOT_BESIDE = "It could not be asked again beside single teeth"
# Verdicts that name something.
NAMED: tuple[Verdict, ...] = ("explained", "partly_explained", "ambiguous")


def name(problem: Problem, alone: Fit, kinds: Mapping[str, type[Effect]], progress: Progress = quiet) -> Naming:
    """Choose the effects that explain what nuisances leave.

    Parameters
    ----------
    problem : Problem
        Records to fit, their noise and nuisances.
    alone : Fit
        Nuisances alone.
    kinds : mapping of str to type
        Effects to choose among.
    progress : Progress
        Told how far the search is.

    Returns
    -------
    Naming
        The problem is then prepared where its fit stands.

    Raises
    ------
    InputError, SolveError
        If the records cannot be computed where the nuisances stand.

    Notes
    -----
    Effects of all teeth, and what does not come back with the turns, are selected by the means over the pitches (`averaged`), which say
    where nuisances and errors of our own model stand; then, these standing still, effects of single teeth and turns by the records row by
    row (`of_single_teeth`). Beside those the first kind is judged anew, or selected anew where any of the second was found, and those
    judged anew beside it. What means name nothing of is asked from the slow records row by row (`row_by_row`). Campaigns without a record
    over the pinion angle have no means and are searched once for all effects. Motions that hammer, and whose rows the names by their means
    leave worse than nuisances alone do, are left out of the means (`untold`), as erratic motions are. No mean is searched where index
    errors swing more than once a turn and nothing of single teeth or turns explains it.
    """
    if not has_means(problem):
        return select(problem, alone, kinds, progress)
    common, single = ({word: kind for word, kind in kinds.items() if shows_in_means(kind) == both} for both in (True, False))
    told = copy.copy(problem)
    if turns_often(problem, alone):
        second, often = _of_teeth(told, alone, single, progress, waves=turns_often)
        if often:
            return _joined(problem, alone, _nothing_sought(problem, alone), second)
    first = _of_means(told, alone.settings, common, progress)
    told.untold = untold(told, first)
    if told.untold:
        first = _of_means(told, alone.settings, common, progress, before=first)
    second, wavy = _of_teeth(told, first.fit, single, progress)
    if not wavy:
        try:
            first, second, wavy = _beside_each_other(told, first, second, common, single, progress)
        except UNCOMPUTABLE as error:
            # A verdict stands already.
            first = dataclasses.replace(first, reasons=(*first.reasons, f"{NOT_BESIDE} ({error})."))
    if wavy:
        # Something turns with a gear that no effect stands for, and what it does to the mean may look like one of all teeth.
        first = _unnamed(first)
    return left_open(problem, told.untold, _joined(problem, alone, first, second))


def _beside_each_other(
    told: Problem,
    first: Naming,
    second: Naming,
    common: Mapping[str, type[Effect]],
    single: Mapping[str, type[Effect]],
    progress: Progress,
) -> tuple[Naming, Naming, bool]:
    """Return the verdicts on all teeth and on single ones, each again beside the other, and whether waves of index errors stay."""
    missed, wavy = first.verdict == "unexplained" or first.left > 1.0, False
    taking_part = bool(second.fit.effects) if first.fit.effects else missed and second.gains
    if taking_part:
        # A pit takes the load off its teeth in the mean too: what is named of all teeth was named, or missed, without it.
        first, named = _of_all(told, first, second.best, common, progress), second.fit.effects
        if first.fit.effects or not named:
            second, wavy = _of_teeth(told, first.fit, single, progress, second)
            if named and not wavy and not second.fit.effects:
                # It made up for what was named too large, or not at all.
                first = _of_means_anew(told, first, second, progress)
    elif first.fit.effects:
        first = _of_means_anew(told, first, second, progress)
    else:
        first = _by_rows(told, first, second.fit.effects, common, progress)
        if first.fit.effects:
            second, wavy = _of_teeth(told, first.fit, single, progress)
    return first, second, wavy


def _nothing_sought(problem: Problem, alone: Fit) -> Naming:
    """Return the verdict on means that are not searched: what swings stays under whatever all teeth have, and makes index errors wrong."""
    mean = averaged(problem, alone.settings)
    found = _unnamed(judge(Search(mean, again(mean, (), mean.unknowns.of(alone.settings))), ()))
    _, *reasons = found.reasons
    return dataclasses.replace(found, reasons=(NOTHING_SOUGHT, *reasons))


def _unnamed(naming: Naming) -> Naming:
    """Return a verdict that names nothing, since something is missing that no effect stands for."""
    return dataclasses.replace(naming, verdict="unexplained", fit=naming.alone, p_values=())


def _of_all(problem: Problem, first: Naming, single: Fit, kinds: Mapping[str, type[Effect]], progress: Progress) -> Naming:
    """Return the verdict on what all teeth have again, now under the effects of single ones of a fit."""
    means = _of_means(problem, single.settings, kinds, progress, single.effects, first)
    return means if means.fit.effects else _by_rows(problem, means, single.effects, kinds, progress)


def _of_means(
    problem: Problem,
    settings: Settings,
    kinds: Mapping[str, type[Effect]],
    progress: Progress,
    known: tuple[Effect, ...] = (),
    before: Naming | None = None,
) -> Naming:
    """Return the verdict on the means over the pitches, index errors as settings have them.

    Under known effects of single teeth, if any; a verdict without these tells with which explanations to begin.
    """
    mean = averaged(problem, settings, known)
    alone = again(mean, (), mean.unknowns.of(settings))
    found = None if before is None else [(fit.effects, mean.unknowns.of(fit.settings)) for fit in _first(before)]
    return _told_apart(problem, mean, select(mean, alone, kinds, progress, found), progress)


def _first(naming: Naming) -> list[Fit]:
    """Return the fits of the best explanations."""
    fits = dict[tuple[Label, ...], Fit]()
    for fit in (naming.best, *(rival.fit for rival in naming.rivals if not rival.early)):
        fits.setdefault(label(fit.effects), fit)
    return [fit for fit in fits.values() if fit.effects][:BEGUN]


def _by_rows(problem: Problem, means: Naming, known: tuple[Effect, ...], kinds: Mapping[str, type[Effect]], progress: Progress) -> Naming:
    """Return the verdict on what all teeth have, under known effects of single ones, by slow records row by row: means have named none."""
    if not any(turns_round(record) for record in problem.records):
        return means
    rows = row_by_row(problem, known)
    found = select(rows, bare(rows, rows.unknowns.of(means.alone.settings)), kinds, progress, found=())
    if not found.fit.effects:
        said = (f"row by row: {reason}" for reason in found.reasons)
        if found.left < 1.0:
            # Means say better where nuisances and errors of the model stand, and single teeth what turns.
            return dataclasses.replace(means, reasons=(*means.reasons, *said))
        verdict, without = _verdict(means.verdict, found.verdict, found.left), _verdict(means.without, found.without, found.left)
        return dataclasses.replace(means, verdict=verdict, without=without, reasons=(*means.reasons, *said))
    # What is found stands, and what means have besides must gain as any further effect.
    named = {type(effect) for effect in found.fit.effects}
    mean = averaged(problem, means.alone.settings, (*known, *found.fit.effects))
    felt = {nuisance.name: getattr(found.fit.settings, nuisance.name) for nuisance in rows.nuisances}
    base = again(mean, (), mean.unknowns.of(dataclasses.replace(means.alone.settings, **felt, errors=found.fit.settings.errors)))
    mean.least = max(FURTHER_LEAST * mean.wander, FURTHER_OTHER * (found.alone.objective - found.fit.objective))
    others = {word: kind for word, kind in kinds.items() if kind not in named}
    return _merged(found, select(mean, base, others, progress, found=()))


def _told_apart(problem: Problem, mean: Problem, naming: Naming, progress: Progress) -> Naming:
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
    closed, level, remains = closure(naming.alone, best.fit, mean), *(gap_left(fit, mean) for fit in (naming.alone, best.fit))
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
        threshold=threshold,
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
        with contextlib.suppress(*UNCOMPUTABLE):
            return again(copy.copy(rows), explanations[number].effects, unknown)
        return None

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


def _of_teeth(
    problem: Problem,
    fit: Fit,
    kinds: Mapping[str, type[Effect]],
    progress: Progress,
    before: Naming | None = None,
    waves: Callable[[Problem, Fit], object] = turning,
) -> tuple[Naming, bool]:
    """Return what single teeth and turns show beside a fit of the means, and whether the best explanation keeps waves of index errors.

    A verdict beside another fit is judged anew.
    """
    teeth, alone = teeth_under(problem, fit.settings, fit.effects, of_teeth(problem))
    if before is None:
        naming = select(teeth, alone, kinds, progress)
    else:
        naming = _anew(teeth, alone, before.best.point.stood, before, "effects of single teeth again", progress)
    return naming, bool(waves(teeth, naming.best))


def _of_means_anew(problem: Problem, first: Naming, second: Naming, progress: Progress) -> Naming:
    """Return the verdict on the means again, single teeth as they have been found beside it."""
    mean = averaged(problem, second.fit.settings)
    alone = again(mean, (), mean.unknowns.of(first.alone.settings))
    naming = _anew(mean, alone, mean.unknowns.of(first.best.settings), first, "effects of all teeth again", progress)
    return _told_apart(problem, mean, naming, progress)


def _anew(problem: Problem, alone: Fit, start: Array, naming: Naming, words: str, progress: Progress) -> Naming:
    """Return a verdict again, its best explanation and those near it fitted from unknowns on; what lost by far is not fitted again."""
    search = Search(problem, alone)
    near = (naming.best.effects, *(rival.effects for rival in naming.rivals if rival.near))
    sets = {label(effects): effects for effects in near if effects}
    search.settle_from([(effects, start) for effects in sets.values()], progress, words)
    if search.best().effects:
        # No name wins by where it began.
        search.settle_from([((), search.best().point.stood)], progress, words)
    best = search.best()
    problem.prepare(best.effects, best.point.stood)
    judged = judge(search, naming.identifiable)
    lost = tuple(rival for rival in naming.rivals if label(rival.effects) not in search.fits)
    return dataclasses.replace(judged, rivals=(*judged.rivals, *lost))


def _merged(first: Naming, second: Naming) -> Naming:
    """Return one verdict from that on slow records row by row and that on means under what it names."""
    return _one(first, second, second.alone, beside(first.fit, second.fit), "All teeth, row by row", "All teeth, at speed")


def _joined(problem: Problem, alone: Fit, first: Naming, second: Naming) -> Naming:
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
    verdict = _verdict(first.verdict, second.verdict, second.left)
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
        without=_verdict(first.without, second.without, second.left),
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


def _verdict(means: Verdict, teeth: Verdict, left: float) -> Verdict:
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
