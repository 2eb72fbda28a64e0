"""Name the effects that a campaign shows: of all teeth by means over the pitches, of single teeth and turns by what differs from these."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable, Mapping

from gearfem.diagnosis.comparing.averages import (
    averaged,
    bare,
    has_means,
    of_teeth,
    row_by_row,
    shows_in_means,
    teeth_under,
)
from gearfem.diagnosis.fitting.fit import Fit, again
from gearfem.diagnosis.fitting.index_errors import turns_often
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.score import Label, label
from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.modelling.pitch_point import turns_round
from gearfem.diagnosis.naming.hammering import left_open, untold
from gearfem.diagnosis.naming.joined import joined, merged, verdict_of_both
from gearfem.diagnosis.naming.naming import Naming
from gearfem.diagnosis.naming.search import FURTHER_LEAST, FURTHER_OTHER, Search
from gearfem.diagnosis.naming.select import select
from gearfem.diagnosis.naming.suspects import turning
from gearfem.diagnosis.naming.told_apart import told_apart
from gearfem.diagnosis.naming.verdict import judge
from gearfem.diagnosis.ranking.rank import Start
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, Array
from gearfem.foundation.progress import Progress, quiet

# Explanations without single teeth with which the search under these begins.
BEGUN = 4
# What is said of effects of all teeth in the place of what they gain.
NOTHING_SOUGHT = "None was sought: index errors swing more than once a turn, which stays under whatever all teeth have."
# What is said where the verdicts on all teeth and on single ones stay as they are each by itself.
NOT_BESIDE = "It could not be asked again beside single teeth"


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
    row (`of_single_teeth`). Beside those the first kind is judged anew, or selected anew where the second moves the means, and those
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
            return joined(problem, alone, _nothing_sought(problem, alone), second)
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
    return left_open(problem, told.untold, joined(problem, alone, first, second))


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

    Under known effects of single teeth, if any; a verdict without these tells with which explanations to begin, and where each effect
    ended.
    """
    mean = averaged(problem, settings, known)
    alone = again(mean, (), mean.unknowns.of(settings))
    if before is None:
        return told_apart(problem, mean, select(mean, alone, kinds, progress), progress)
    found = [(fit.effects, mean.unknowns.of(fit.settings)) for fit in _first(before)]
    naming = _unmoved(mean, alone, found, before, progress) if known else None
    if naming is None:
        naming = select(mean, alone, kinds, progress, found, [one.effect for one in before.identifiable])
    return told_apart(problem, mean, naming, progress)


def _unmoved(mean: Problem, alone: Fit, found: list[Start], before: Naming, progress: Progress) -> Naming | None:
    """Return the verdict of a search judged anew by what it found, or None if what is known beside it now may lead a search elsewhere.

    It does not if both nuisances alone and the best explanations leave as much as before but for less than a further name must gain.
    """
    enough = FURTHER_LEAST * mean.wander
    if abs(alone.objective - before.alone.objective) > enough:
        return None
    naming = _anew(mean, alone, found, before, "effects of all teeth again", progress)
    moved = abs(_least(naming) - _least(before)) > enough or bool(naming.fit.effects) != bool(before.fit.effects)
    return None if moved else naming


def _least(naming: Naming) -> float:
    """Return what the best explanation leaves, or one that cannot be told from it."""
    return min([naming.best.objective, *(rival.fit.objective for rival in naming.rivals if rival.near)])


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
        verdict, without = (
            verdict_of_both(means.verdict, found.verdict, found.left),
            verdict_of_both(means.without, found.without, found.left),
        )
        return dataclasses.replace(means, verdict=verdict, without=without, reasons=(*means.reasons, *said))
    # What is found stands, and what means have besides must gain as any further effect.
    named = {type(effect) for effect in found.fit.effects}
    mean = averaged(problem, means.alone.settings, (*known, *found.fit.effects))
    felt = {nuisance.name: getattr(found.fit.settings, nuisance.name) for nuisance in rows.nuisances}
    base = again(mean, (), mean.unknowns.of(dataclasses.replace(means.alone.settings, **felt, errors=found.fit.settings.errors)))
    mean.least = max(FURTHER_LEAST * mean.wander, FURTHER_OTHER * (found.alone.objective - found.fit.objective))
    others = {word: kind for word, kind in kinds.items() if kind not in named}
    return merged(found, select(mean, base, others, progress, found=()))


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
        naming = _anew(teeth, alone, _near(before, before.best.point.stood), before, "effects of single teeth again", progress)
    return naming, bool(waves(teeth, naming.best))


def _of_means_anew(problem: Problem, first: Naming, second: Naming, progress: Progress) -> Naming:
    """Return the verdict on the means again, single teeth as they have been found beside it."""
    mean = averaged(problem, second.fit.settings)
    alone = again(mean, (), mean.unknowns.of(first.alone.settings))
    naming = _anew(mean, alone, _near(first, mean.unknowns.of(first.best.settings)), first, "effects of all teeth again", progress)
    return told_apart(problem, mean, naming, progress)


def _near(naming: Naming, start: Array) -> list[Start]:
    """Return the best explanation of a verdict and those near it, all to begin from the same unknowns; what lost by far is left."""
    near = (naming.best.effects, *(rival.effects for rival in naming.rivals if rival.near))
    return [(effects, start) for effects in {label(effects): effects for effects in near if effects}.values()]


def _anew(problem: Problem, alone: Fit, starts: list[Start], naming: Naming, words: str, progress: Progress) -> Naming:
    """Return a verdict again, some of its explanations fitted anew; the others have lost."""
    search = Search(problem, alone)
    search.settle_from(starts, progress, words)
    if search.best().effects:
        # No name wins by where it began.
        search.settle_from([((), search.best().point.stood)], progress, words)
    best = search.best()
    problem.prepare(best.effects, best.point.stood)
    judged = judge(search, naming.identifiable)
    lost = tuple(rival for rival in naming.rivals if label(rival.effects) not in search.fits)
    return dataclasses.replace(judged, rivals=(*judged.rivals, *lost))
