"""Select the effects that explain what nuisances leave: chosen one by one, tried against each other, and only after the last test."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.score import label
from gearfem.diagnosis.naming.few import judge_few
from gearfem.diagnosis.naming.gap import gap_left
from gearfem.diagnosis.naming.identify import Identifiability, identify
from gearfem.diagnosis.naming.naming import Naming
from gearfem.diagnosis.naming.screen import in_place, screened
from gearfem.diagnosis.naming.search import MOST, Search, Start, manner_of, without_one
from gearfem.diagnosis.naming.suspects import sound
from gearfem.diagnosis.naming.verdict import judge, outscored
from gearfem.diagnosis.ranking.candidate import Candidate, together
from gearfem.diagnosis.ranking.rank import rank, rank_again
from gearfem.diagnosis.ranking.shapes import bounded, stands
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, Array
from gearfem.foundation.progress import Progress, quiet

# Single effects, and further ones beside the best, that are fitted.
FITTED, PAIRED = 8, 4
# Cosine beyond which two responses count as one in the search.
ALIKE = 0.999
# Share of what counts as detected that an explanation must gain, or nothing is looked for beside it; and that one must promise, or
# records without a gap need no search.
HOPELESS = 0.5
# Explanations that are fitted again, with derivatives taken where they stand, before the search goes on; further ones after that.
SETTLED, FURTHER_SETTLED = 4, 2
# Those that are, beside nuisances alone without a gap, before it is known whether there is anything to look for.
PROMISED = 2
# Shares of the first gear at which an effect of both gears is tried.
SPLITS = (0.2, 0.35, 0.5, 0.65, 0.8)
# Cosine of two responses, freed from all nuisances, from which on one may pass for the other; and how many of those are fitted.
NEAR, MOST_ALIKE = 0.5, 4
# What a candidate must promise to be fitted, in parts of what a name must gain, and beside others, of what a further one must at least.
PROMISING, FURTHER_PROMISING = 0.125, 0.25


def select(
    problem: Problem,
    alone: Fit,
    kinds: Mapping[str, type[Effect]],
    progress: Progress = quiet,
    found: Sequence[tuple[tuple[Effect, ...], Array]] | None = None,
    before: Sequence[Effect] = (),
) -> Naming:
    """Choose the effects that explain what nuisances leave of one problem.

    Parameters
    ----------
    problem : Problem
        Records to fit, their noise and nuisances, prepared at `alone`.
    alone : Fit
        Nuisances alone.
    kinds : mapping of str to type
        Effects to choose among.
    progress : Progress
        Told how far the search is.
    found : sequence of (tuple of Effect, ndarray of shape (k,)), optional
        Explanations that were found before or from other records, and the unknowns to start from. Nuisances stand where these have left
        them: no further effect is sought in their place.
    before : sequence of Effect
        As of `rank`.

    Returns
    -------
    Naming

    Notes
    -----
    Forward selection with back-elimination, up to three effects; the first candidates are tried in pairs too. A score is the objective
    (what records cost by `profile`, and all nuisances, model form included, in prior deviations, squared) plus a cost for each
    parameter, for the choice of a tooth and for a parameter at its bound. Records that nuisances leave without a gap end before the
    search, where these stay within reason and no candidate promises much, or else where no single effect keeps what it promised once
    both are fitted again. Where nuisances leave less than they did, led there by an effect, all begins again from these. Leads need solid
    elements: the misalignment among the errors of the model has computed them before the work is shared out.
    """
    if problem.effects:
        # A search before has left it prepared at what that named.
        problem.prepare((), alone.point.unknown)
    search = Search(problem, alone)
    first = rank(problem, alone, kinds, progress, before)
    shown = identify(problem, alone, first)
    if alone.objective < search.problem.detected:
        return judge_few(search, judge(search, shown), first, progress)
    if _agrees(search, first):
        return judge(search, shown)
    if found is not None:
        # What is as good need not be found again, and what promises less is given up.
        search.settle_from(found, progress, "explanations found before")
    _singles(search, alone, first, progress)
    if search.instead(progress):
        problem.prepare((), search.alone.point.stood)
        return select(problem, search.alone, kinds, progress, found, before)
    if found is None and not sound(search):
        slow = screened(problem, alone, first, progress)
        search.settle_from(slow, progress, "effects that slow records call for", search.worth)
    if gap_left(alone, problem) < 1.0 and (_hopeless(search) or (not found and _settled_hopeless(search, progress))):
        return judge(search, shown)
    _pairs(search, alone, first, progress)
    search.settle([search.alone, *search.ahead(SETTLED)], progress, "first explanations again")
    if found is None:
        _in_place(search, first, progress)
    _further(search, first, progress)
    _eliminate(search)
    _twins(search, first, progress)
    naming = _concluded(search, shown, progress)
    return naming if naming.rivals else dataclasses.replace(naming, reasons=(*naming.reasons, _none_beside(naming, first)))


def _concluded(search: Search, shown: tuple[Identifiability, ...], progress: Progress) -> Naming:
    """Return the verdict once the best explanation and all that come near it are fitted again, from where that stands too.

    Those farther off have lost by the scores that they had before.
    """
    problem = search.problem
    best = search.best()
    early = {key: (fit, search.score(fit)) for key, fit in search.fits.items()}
    _prepare_at(problem, best)
    memory = problem.memory
    problem.remember(best)
    # What a fit far off leaves looks alike for long: no reason to count it less.
    problem.memory = np.minimum(memory, problem.memory)
    jobs = [search.alone, *([best] if best.effects else []), *search.rivals()]
    search.fits = {(): search.alone}
    search.settle(jobs, progress, "rivals again")
    search.abreast(progress)
    best = search.best()
    _prepare_at(problem, best)
    naming = judge(search, shown)
    if naming.best is not best:
        _prepare_at(problem, naming.best)
    _, least = early.get(label(naming.fit.effects), early[label(best.effects)])
    lost = [outscored(search, fit, naming.fit, score - least) for key, (fit, score) in early.items() if key not in search.fits]
    return dataclasses.replace(naming, rivals=(*naming.rivals, *sorted(lost, key=lambda rival: rival.score_difference)))


def _none_beside(naming: Naming, candidates: Sequence[Candidate]) -> str:
    """Return in words that nothing else was fitted, and what came first of that."""
    others = [candidate for candidate in candidates if label((candidate.effect,)) != label(naming.best.effects)]
    first = f": {others[0].effect.describe()} would gain {others[0].gain:.1f}" if others else ""
    return f"No other effect promised enough to be fitted{first}."


def _prepare_at(problem: Problem, fit: Fit) -> None:
    """Prepare a problem where a fit leads; a first fit may lead where there is no model, and columns then stay as they are."""
    with contextlib.suppress(*UNCOMPUTABLE):
        problem.prepare(fit.effects, fit.point.unknown)


def _further(search: Search, candidates: tuple[Candidate, ...], progress: Progress) -> None:
    """Fit further effects beside the best so many, as long as these gain enough to build on."""
    problem, setup = search.problem, search.problem.campaign.setup
    for count in range(1, MOST):
        # The best so many, though a pair may have been found already: each is a place to go on from.
        best = search.best(count)
        if len(best.effects) != count or search.gained(best) < HOPELESS * search.problem.detected:
            break
        _prepare_at(problem, best)
        named = label(best.effects)
        again = [
            c
            for c in rank_again(problem, best, candidates, progress)
            if c.gain > FURTHER_PROMISING * search.further_least() and label((c.effect,))[0] not in named
        ]
        starts: list[Start] = [((*best.effects, candidate.start(setup)), candidate.unknown) for candidate in _of_each_way(_apart(again))]
        search.fit(starts, best, progress, "further effects")
        ahead = [fit for fit in search.first(len(search.fits)) if len(fit.effects) == count + 1]
        search.settle(ahead[:FURTHER_SETTLED], progress, "these again")


def _agrees(search: Search, candidates: tuple[Candidate, ...]) -> bool:
    """Return whether nuisances alone are sound, and no candidate promises half of what a name needs."""
    return sound(search) and all(candidate.gain < HOPELESS * search.problem.detected for candidate in candidates)


def _hopeless(search: Search) -> bool:
    """Return whether no single effect keeps half of what a name needs."""
    return search.gained(search.best(1)) < HOPELESS * search.problem.detected


def _settled_hopeless(search: Search, progress: Progress) -> bool:
    """Return the same once the nuisances alone and the best effects are fitted again: first fits gain what these alone had missed."""
    search.settle([search.alone, *search.ahead(PROMISED)], progress, "first explanations again")
    if not _hopeless(search):
        return False
    _prepare_at(search.problem, search.alone)
    return True


def _singles(search: Search, alone: Fit, candidates: tuple[Candidate, ...], progress: Progress) -> None:
    chosen = _apart([c for c in candidates if c.gain > PROMISING * search.problem.wander])[:FITTED]
    setup = search.problem.campaign.setup
    starts: list[Start] = [((candidate.start(setup),), candidate.unknown) for candidate in chosen]
    search.fit(starts, alone, progress, "single effects")


def _in_place(search: Search, candidates: Sequence[Candidate], progress: Progress) -> None:
    """Fit effects in the place of what strays in the nuisances alone, now that these have found theirs."""
    alone = search.alone
    starts: list[Start] = list(in_place(search.problem, alone.point.unknown, candidates))
    search.fit(starts, alone, progress, "effects in the place of nuisances", anew=True)
    _again(search, starts, progress)


def _again(search: Search, starts: Sequence[Start], progress: Progress) -> None:
    """Fit again what started far from where it ends: a first look says little."""
    labels = dict.fromkeys(label(effects) for effects, _ in starts)
    search.settle([search.fits[one] for one in labels if one in search.fits], progress, "these again")


def _of_each_way(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the first candidates, and the first one of each way in which effects act."""
    ways: dict[tuple[str, str], Candidate] = {}
    for candidate in candidates:
        ways.setdefault(manner_of(candidate.effect), candidate)
    return [c for place, c in enumerate(candidates) if place < PAIRED or c is ways[manner_of(c.effect)]]


def _apart(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the first candidates whose responses differ at all; what looks like one of them is tried beside the best at the end."""
    kept: list[Candidate] = []
    for candidate in candidates:
        if not any(_alike(candidate, other) for other in kept):
            kept.append(candidate)
    return kept


def _alike(one: Candidate, other: Candidate) -> bool:
    """Return whether the responses of two candidates are the same but for their size."""
    return bool(abs(one.signature @ other.signature) >= ALIKE * np.linalg.norm(one.signature) * np.linalg.norm(other.signature))


def _twins(search: Search, candidates: tuple[Candidate, ...], progress: Progress) -> None:
    """Fit the best explanation with what looks like one of its effects in the place of this, from where the best one stands.

    The same on the other gear, and whatever the records can hardly tell from it, fitted before or not: fits end by where they begin. Of
    effects of one tooth that is what `_apart` has passed over for it, as the tooth that meets it where these meet once.
    """
    best, setup = search.best(), search.problem.campaign.setup
    starts: list[Start] = []
    for place, effect in enumerate(best.effects):
        before, after = best.effects[:place], best.effects[place + 1 :]
        others = [c for c in candidates if label((c.effect,))[0] not in label(best.effects)]
        if hasattr(effect, "tooth"):
            starts += [((*before, c.start(setup), *after), None) for c in _passed_over(effect, others, candidates)]
            continue
        others = [c for c in others if not hasattr(c.effect, "tooth")]
        try:
            own = search.problem.response(best.point, (*before, *after))
        except UNCOMPUTABLE:
            continue
        gram, _ = search.problem.freed(best.point)(np.column_stack([own, *(c.signature for c in others)]))
        strengths, cosines = gram[0, 1:] / np.diag(gram)[1:], gram[0, 1:] / np.sqrt(gram[0, 0] * np.diag(gram)[1:])
        alike = [number for number in np.argsort(-np.abs(cosines)) if abs(cosines[number]) > NEAR][:MOST_ALIKE]
        for number, candidate in enumerate(others):
            other = candidate.effect
            if type(other) is type(effect) and effect.of_one_gear():
                starts.append(((*before, candidate.start(setup), *after), None))
            elif number in alike:
                start = other if stands(other) else bounded(other.scaled(float(strengths[number]), setup), setup)
                starts.append(((*before, start, *after), None))
    search.fit(starts, best, progress, "what looks alike", anew=True)


def _passed_over(effect: Effect, others: Sequence[Candidate], candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return those of other candidates that look like that of an effect."""
    own = [candidate for candidate in candidates if label((candidate.effect,)) == label((effect,))]
    return [other for other in others if any(_alike(other, one) for one in own)]


def _pairs(search: Search, alone: Fit, candidates: tuple[Candidate, ...], progress: Progress) -> None:
    """Fit the pairs of the first candidates that promise most together."""
    few = [c for c in candidates if c.gain > PROMISING * search.problem.wander][:5]
    gains = sorted(((together(search.problem, alone, pair), pair) for pair in itertools.combinations(few, 2)), key=lambda item: -item[0])
    single = alone.objective - search.best(1).objective
    chosen = [pair for gain, pair in gains if gain > single + search.problem.wander][:1]
    setup = search.problem.campaign.setup
    starts: list[Start] = [(tuple(candidate.start(setup) for candidate in pair), pair[0].unknown) for pair in chosen]
    both = _both_gears(search)
    search.fit([*starts, *both], alone, progress, "pairs of effects")
    _again(search, both, progress)


def _both_gears(search: Search) -> list[Start]:
    """Return the best single effect of all teeth of a gear on both gears, each at a share of the strength that it would have alone."""
    best, setup = search.best(1), search.problem.campaign.setup
    alike = [fit for fit in search.first(len(search.fits)) if [type(e) for e in fit.effects] == [type(e) for e in best.effects]]
    if len(alike) < 2 or not best.effects[0].of_one_gear() or best.effects[0].repeats != "every tooth":
        return []
    starts: list[Start] = []
    for share in SPLITS:
        parts = zip(alike[:2], (share, 1.0 - share), strict=True)
        starts.append((tuple(bounded(fit.effects[0].scaled(part, setup), setup) for fit, part in parts), None))
    problem, alone = search.problem, search.alone
    return [min(starts, key=lambda start: problem.left_at(start[0], search.start(start, alone)))]


def _eliminate(search: Search) -> None:
    """Fit the best explanation without each of its effects, from where it stands, whatever fits of these there were."""
    best = search.best()
    if len(best.effects) > 1:
        search.fit(without_one(best), best, anew=True)
