"""What a search comes to: the verdict, and everything that it rests on."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence

from scipy.stats import chi2

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.score import Label, label, simplicity
from gearfem.diagnosis.naming.gap import OPEN, closure, gap_left, gaps, wide
from gearfem.diagnosis.naming.identify import Identifiability
from gearfem.diagnosis.naming.naming import Naming, Rival, Verdict, sentence_of
from gearfem.diagnosis.naming.search import Search, exchanged, least_beside
from gearfem.diagnosis.naming.suspects import astray, misshapen, sound, turning, wrong_by
from gearfem.effects.effect import Effect

# Explanations whose scores are closer than those of the same one may be cannot be told apart. Shapes of real effects differ from ours, by
# this share of what they explain.
SHAPE = 0.005
# Wear, slope or relief of one gear and its mirror on the other differ in the transmission error by less than errors of our model; their
# scores differ by so many times what those of the same explanation do.
MIRRORED = 4.0
# What forms of the flanks must gain of means that nuisances alone explain: a slope has gained 41 for a relief that is there.
FORMS = 64.0
# Share of the gap that names must close: less is no explanation, and more brings it to the noise.
STANDS, CLOSED = 0.60, 0.90
# What may remain beside a name that stands, in gaps.
REST = 2.4
# Part of what nuisances alone leave that may remain all the same, and gaps at most: shapes of real effects differ from ours. Right names
# have left up to 0.10 of it and 3.1 gaps, wrong ones in the place of bodies and leads 0.26 and more, or, for an encoder, 560 gaps.
RESEMBLES, WIDEST = 0.15, 4.0
# What is said of a record off the rig that nuisances leave too wide, and of a name beside nuisances that leave no gap.
TOO_WIDE = "Nuisances alone: {file} keeps {size:.1f} times its noise: a gap of its rows together, even where none is one by itself."
ALL_THE_SAME = "It is named all the same: nuisances leave as little only with values that are by so much less likely."


def needed(search: Search, effects: tuple[Effect, ...]) -> float:
    """Return what effects must gain to be named.

    Of means that nuisances alone explain, nothing but the odds of these speaks for a name: for one of forms of the flanks they must say
    more, since nothing but errors of our model tells forms apart.
    """
    problem = search.problem
    if effects and not problem.unknowns.scatter.common:
        return least_beside(problem, effects)
    forms = bool(effects) and all(effect.stage == "flank" and effect.repeats == "every tooth" for effect in effects)
    doubtful = forms and problem.unknowns.scatter.common and sound(search)
    return max(problem.detected, FORMS) if doubtful else problem.detected


def judge(search: Search, shown: tuple[Identifiability, ...]) -> Naming:
    """Return the verdict of a search that is over, and what the records can show of each effect beside it."""
    alone = search.alone
    best = search.best()
    scores = {fit: search.score(fit) for fit in search.fits.values()}
    gained = scores[alone] - scores[best]
    closed = closure(alone, best, search.problem)
    threshold = max(search.problem.wander, SHAPE * gained)
    ranked = sorted((fit for fit in scores if fit.effects), key=scores.__getitem__)

    def limit(fit: Fit) -> float:
        return max(threshold, MIRRORED * search.problem.wander) if _mirrored(fit, best) else threshold

    # Only those that come near are worth the question.
    barred = {fit: search.barred(fit) for fit in ranked if fit is not best and scores[fit] - scores[best] < limit(fit)}
    for fit in [best, *barred]:
        twins = list(exchanged(fit))
        scores |= dict.fromkeys(twins, scores[fit])
        barred |= dict.fromkeys(twins, barred.get(fit, ""))
    level, remains = gap_left(alone, search.problem), remaining(best, search.problem)
    suspects = (*astray(search), *turning(search.problem, alone), *misshapen(search.problem, alone))
    kept = wide(search.problem, alone)
    close = [fit for fit, why in barred.items() if len(fit.effects) <= len(best.effects) and not why]
    gains = bool(best.effects) and gained >= needed(search, best.effects)
    held = not suspects and not kept
    without = _verdict_on(search.problem, alone, closed, (level, remains), held, [])
    verdict = _verdict_on(search.problem, best, closed, (level, remains), held, close) if gains else without
    if verdict == "ambiguous":
        # Of explanations that fit alike the simplest is named: fewest effects, then fewest parameters.
        best = min([best, *close], key=lambda fit: (simplicity(fit.effects), scores[fit]))
        closed, remains = closure(alone, best, search.problem), remaining(best, search.problem)
    named = best if verdict in ("explained", "partly_explained", "ambiguous") else alone
    others = {fit: scores[fit] - scores[named] for fit in sorted(scores, key=scores.__getitem__) if fit.effects and fit is not named}
    return Naming(
        verdict=verdict,
        fit=named,
        alone=alone,
        best=best,
        p_values=tuple(_p_value(search, best, number) for number in range(len(named.effects))),
        without=without,
        gains=gains,
        level=level,
        closed=closed,
        left=remains,
        rivals=tuple(_rival(search, fit, named, worse, limit(fit), barred.get(fit, "")) for fit, worse in others.items()),
        identifiable=shown,
        threshold=max([threshold, *(limit(fit) for fit in close)]),
        sentence=sentence_of(verdict, named, closed),
        reasons=(
            f"The best explanation gains {gained:.0f} in the score; a name needs {needed(search, best.effects):.0f}.",
            f"Nuisances alone leave {gaps(level)}; the best explanation leaves {gaps(gap_left(best, search.problem))}.",
            *([ALL_THE_SAME] if named.effects and level < OPEN else ()),
            *_far_off("Nuisances alone", suspects),
            *(TOO_WIDE.format(file=file, size=size) for file, size in kept),
            *(_far_off("Beside the best explanation", misshapen(search.problem, best)) if best.effects else ()),
        ),
    )


def _far_off(where: str, suspects: Iterable[tuple[str, float]]) -> Iterator[str]:
    """Yield in words which nuisances and errors of the model may do the work of effects."""
    for words, moved in suspects:
        yield f"{where}: {words} {moved:+.1f} prior deviations from what the model has, where it may do the work of an effect."


def _verdict_on(problem: Problem, best: Fit, closed: float, left: tuple[float, float], sound: bool, close: Sequence[Fit]) -> Verdict:
    """Return the verdict on the best explanation that gains enough, and on others as close.

    Parameters
    ----------
    problem, best : Problem, Fit
        What was fitted, and the explanation; one without effects if none gains enough.
    closed : float
        Share of the gap that it closes.
    left : (float, float)
        What nuisances alone leave and what remains of it; of less than `OPEN`, as some healthy pairs leave, no share need be closed,
        unless an error of the model stays too large beside the name.
    sound : bool
        Whether nuisances alone do the work of no effect, and leave no record too wide.
    close : sequence of Fit
        Explanations that the data cannot tell from it.
    """
    level, remains = left
    most = max(REST, min(RESEMBLES * level, WIDEST))
    if not best.effects:
        return "no_discrepancy" if level < OPEN and sound else "unexplained"
    usual = OPEN if level < OPEN and not misshapen(problem, best) else 1.0
    if (remains >= usual and (closed < STANDS or remains > most)) or turning(problem, best) or wrong_by(problem, best):
        return "unexplained"
    return "ambiguous" if close else explains(closed, left)


def remaining(fit: Fit, problem: Problem) -> float:
    """Return what effects leave, in gaps: at least one where forms or other errors too large to be any do the work of what is missing.

    Beside single teeth these are left to what is said of all teeth.
    """
    left = gap_left(fit, problem)
    return max(left, 1.0) if fit.effects and problem.outer and misshapen(problem, fit) else left


def explains(closed: float, left: tuple[float, float]) -> Verdict:
    """Return the verdict on an explanation that stands, by the share of the gap that it closes, and what is left without it and with it.

    Where nuisances alone leave no more gaps than of some healthy pairs, what remains is no reason to call it a part.
    """
    _, remains = left
    return "explained" if (closed >= CLOSED and remains <= REST) or remains < 1.0 or max(left) < OPEN else "partly_explained"


def _rival(search: Search, fit: Fit, named: Fit, worse: float, limit: float, barred: str) -> Rival:
    """Return an explanation beside what is named, whose score is so much worse; closer than a limit it cannot be told apart."""
    return Rival(
        effects=fit.effects,
        score_difference=worse,
        why=barred or (_why(fit, named, worse, limit) if named.effects else _why_none(-worse, needed(search, fit.effects))),
        near=bool(named.effects) and worse < limit and not barred,
        fit=fit,
        p_values=tuple(_p_value(search, fit, number) for number in range(len(fit.effects))) if worse < limit else (),
    )


def outscored(search: Search, fit: Fit, named: Fit, worse: float) -> Rival:
    """Return an explanation that lost by so much before what is named, or nuisances alone, were fitted again."""
    if named.effects:
        why = (search.barred(fit) if worse < 0.0 else "") or _why(fit, named, worse, 0.0)
    else:
        why = _why_none(-worse, needed(search, fit.effects))
    return Rival(effects=fit.effects, score_difference=worse, why=why, near=False, fit=fit, early=True)


def _mirrored(fit: Fit, best: Fit) -> bool:
    """Return whether an explanation has the same effects as the best one, those of all teeth on the other gear."""
    return label(fit.effects) != label(best.effects) and _gearless(fit.effects) == _gearless(best.effects)


def _gearless(effects: tuple[Effect, ...]) -> list[Label]:
    """Return the labels of effects, those of all teeth without their gear; waves of one shaft are none of the other's."""
    return sorted((e.name, "" if e.repeats == "every tooth" else getattr(e, "gear", ""), getattr(e, "tooth", -1)) for e in effects)


def _p_value(search: Search, best: Fit, number: int) -> float:
    """Return the chance of the gain of one effect over the others, or over nuisances alone if they have no fit, times what was tried."""
    without = search.fits.get(label(best.effects[:number] + best.effects[number + 1 :]), search.alone)
    gain = without.objective - best.objective
    pair = search.problem.campaign.setup.pair
    trials = 40 + 3 * (pair.pinion.teeth + pair.wheel.teeth)
    chance = float(chi2.sf(max(gain, 0.0), len(best.effects[number].parameters())))
    # Chances below what a number can hold are not 0.
    return min(1.0, trials * max(chance, sys.float_info.min))


def _why(fit: Fit, best: Fit, difference: float, threshold: float) -> str:
    if best.effects and set(label(best.effects)) < set(label(fit.effects)):
        return f"gains less by what it has beside the named effects than a further name must (score {difference:+.1f})"
    if difference < -threshold:
        return f"scores better by {-difference:.1f}, but further names must gain more"
    if difference < 0.0:
        return f"cannot be told apart: its score is better by {-difference:.1f}, less than {threshold:.1f}, with more parameters"
    if difference < threshold:
        return f"cannot be told apart: its score is worse by {difference:.1f}, less than {threshold:.1f}"
    return f"leaves more of the gap: score worse by {difference:.1f}"


def _why_none(gained: float, least: float) -> str:
    """Return why an explanation is none where nothing is named."""
    if gained < 0.0:
        return f"costs {-gained:.0f} more than it gains over nuisances alone"
    if gained < least:
        return f"gains {gained:.0f} over nuisances alone; a name needs {least:.0f}"
    return f"gains {gained:.0f} over nuisances alone, but leaves a gap too wide for a name"
