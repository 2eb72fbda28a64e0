"""The verdict on so few numbers that no explanation can gain what a name needs."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.stats import chi2

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.marginal import marginal
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.nuisances import BUILD
from gearfem.diagnosis.naming.gap import closure, gap_left, gaps
from gearfem.diagnosis.naming.naming import BEYOND, Naming, Rival, sentence_of
from gearfem.diagnosis.naming.search import Search, exchanged
from gearfem.diagnosis.ranking.candidate import Candidate
from gearfem.foundation.progress import Progress

# Chance of a gap as wide in noise and nuisances alone, below which it is one.
CHANCE = 0.01
# Share of what the nuisances leave that a candidate must promise to be fitted.
PROMISED = 0.5
# Share of its strength at which an effect that ended as strong as can be must do, and of what it gains there that must be left.
MODERATE, KEPT = 0.5, 0.5
# Chance that a name has which a handful of numbers gives: they cannot decide.
UNDECIDED = (1.0,)


def judge_few(search: Search, naming: Naming, candidates: tuple[Candidate, ...], progress: Progress) -> Naming:
    """Return the verdict where the records hold a handful of numbers: nothing, ambiguous, or without a name.

    Parameters
    ----------
    search : Search
        Of the nuisances alone.
    naming : Naming
        The verdict on them.
    candidates : tuple of Candidate
        From `rank`.
    progress : Progress
        Told how many fits are done.

    Returns
    -------
    Naming

    Notes
    -----
    Of a handful of numbers, the variance that a model leaves cannot be told: the gap is judged by its square under noise, single teeth
    and the scales of model and instrument within their priors, r' (I + A A')^-1 r, against chi-square. If it is one, every effect that
    closes it is an explanation, one that ends as strong as can be only if half of that does too; the one with the fewest parameters is
    named, and two of them are one too many to decide. Errors of our own model are no reason to call it none: so few numbers cannot tell
    them from effects.
    """
    problem, alone = search.problem, search.alone
    chance, with_errors = (float(chi2.sf(_square(problem, search, own), len(alone.white))) for own in (False, True))
    seen = (
        f"Nuisances alone leave {gaps(gap_left(alone, problem))}.",
        f"Noise, single teeth and scales within their priors make a gap as wide with a chance of {chance:.2g}; "
        f"with errors of our own model, as how neighbour teeth are coupled, of {with_errors:.2g}.",
    )
    if chance > CHANCE:
        return dataclasses.replace(naming, verdict="no_discrepancy", sentence=sentence_of("no_discrepancy", alone, 1.0), reasons=seen)
    fits = _closing(search, candidates, progress)
    reasons = (*seen, _undecided(fits))
    if len(fits) < 2:
        return dataclasses.replace(naming, verdict="unexplained", sentence=sentence_of("unexplained", alone, 0.0), reasons=reasons)
    best = fits[0]
    apart = [search.score(fit) - search.score(best) for fit in fits]
    rivals = tuple(
        Rival(
            effects=fit.effects,
            score_difference=worse,
            why=f"closes the gap as well; its score is worse by {worse:.1f}",
            near=True,
            fit=fit,
            p_values=UNDECIDED,
        )
        for fit, worse in zip(fits[1:], apart[1:], strict=True)
    )
    closed = closure(alone, best, problem)
    return dataclasses.replace(
        naming,
        verdict="ambiguous",
        fit=best,
        best=best,
        p_values=UNDECIDED,
        closed=closed,
        rivals=rivals,
        threshold=max(naming.threshold, apart[-1] + BEYOND),
        sentence=sentence_of("ambiguous", best, closed),
        reasons=reasons,
    )


def _undecided(fits: Sequence[Fit]) -> str:
    """Return in words which effects close the gap, and that none is to be named for it."""
    if not fits:
        return "No effect closes the gap alone."
    if len(fits) == 1:
        return f"One effect closes the gap alone ({fits[0].effects[0].describe()}); so few numbers cannot earn it a name."
    return f"{len(fits)} effects close the gap alone; so few numbers cannot decide between them."


def _closing(search: Search, candidates: tuple[Candidate, ...], progress: Progress) -> list[Fit]:
    """Return the fits of single effects that close the gap, the one to name first."""
    problem, alone, setup = search.problem, search.alone, search.problem.campaign.setup
    promising = [candidate for candidate in candidates if candidate.gain > PROMISED * alone.objective]
    search.fit([((candidate.start(setup),), candidate.unknown) for candidate in promising], alone, progress, "single effects")
    fits = [_moderate(problem, alone, fit) if fit.bound else fit for fit in search.fits.values() if fit.effects]
    fits = [fit for fit in fits if not fit.bound and gap_left(fit, problem) < 1.0]
    fits += [twin for fit in fits for twin in exchanged(fit)]
    # All of them close it fully: what they cost decides, and then an instrument that is wrong comes last.
    return sorted(fits, key=lambda fit: (round(search.score(fit), 1), fit.effects[0].stage == "sensing"))


def _moderate(problem: Problem, alone: Fit, fit: Fit) -> Fit:
    """Return a fit that ended at a bound with half its strength, where it gains much of the same; else itself."""
    setup, own = problem.campaign.setup, copy.copy(problem)
    effects = tuple(effect.scaled(MODERATE, setup) for effect in fit.effects)
    half = own.fit(effects, own.prepare(effects, fit.point.unknown), rounds=0)
    return half if alone.objective - half.objective > KEPT * (alone.objective - fit.objective) else fit


def _square(problem: Problem, search: Search, own: bool) -> float:
    """Return the square of the gap in standard deviations of noise and all nuisances, errors of our own model among them or not."""
    gap, unknowns = problem.effective(search.alone.point), problem.unknowns
    count = problem.whole.columns[0].shape[1] - unknowns.outer
    built = [place for place, nuisance in enumerate(problem.nuisances) if nuisance in BUILD or nuisance.name == "series_compliance"]
    errors = [*range(unknowns.first_form - unknowns.outer, count - 1), *(count + place for place in built)]
    freed = marginal(tuple(np.delete(part, [] if own else errors, axis=1) for part in problem.whole.columns))
    return float(freed.weighed(np.ones(len(problem.records))).measure(gap[:, None], gap)[0][0, 0])
