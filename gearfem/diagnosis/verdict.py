"""What a search comes to: the verdict, and everything that it rests on."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import sys
from collections.abc import Sequence
from typing import Literal

import numpy as np
from scipy.stats import chi2

from gearfem.diagnosis.fit import Fit
from gearfem.diagnosis.identify import Identifiability
from gearfem.diagnosis.index_errors import odd_of, uneven, waves_of
from gearfem.diagnosis.problem import Problem
from gearfem.diagnosis.search import Label, Search, label, stays
from gearfem.diagnosis.straying import LOST, STRAYED
from gearfem.effects.effect import MEMBERS, Effect
from gearfem.foundation import Array, InputError, Record, SolveError

Verdict = Literal["explained", "partly_explained", "no_discrepancy", "unexplained", "ambiguous"]

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
# What fits may leave, over what can be expected of them, before it counts as a gap.
GAP_SLOW, GAP_MOVING = 1.25, 2.0
# Prior deviations of a nuisance at which it does the work of something that is missing.
ASTRAY = 4.0
# Chance of nuisances and errors of the model as far off together, below which they do the work of an effect; and of noise off the rig,
# below which it is a gap.
UNLIKELY = 0.01
# What may remain beside a name that stands, in gaps; and without any, before something is said to be missing that has no name: of 78
# healthy pairs of another simulator nuisances leave up to 1.4, of one 2.2, and of causes outside the catalogue 2.6 and more.
REST, OPEN = 2.4, 1.5
# Part of what nuisances alone leave that may remain all the same, and gaps at most: shapes of real effects differ from ours. Right names
# have left up to 0.10 of it and 3.1 gaps, wrong ones in the place of bodies and leads 0.26 and more, or, for an encoder, 560 gaps.
RESEMBLES, WIDEST = 0.15, 4.0


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Rival(Record):
    """An explanation beside the chosen one.

    Parameters
    ----------
    effects : tuple of Effect
        As fitted.
    score_difference : float
        By how much its score is worse than that of what is named, or of nuisances alone.
    why : str
        Why it lost, or that it did not.
    near : bool
        Whether the data cannot tell it from the chosen one.
    fit : Fit
        Of it.
    p_values : tuple of float
        Of each of its effects, see `Naming`; empty where it is not near.
    early : bool
        Whether it lost before the best explanations were fitted again beside each other.
    """

    effects: tuple[Effect, ...]
    score_difference: float
    why: str
    near: bool
    fit: Fit
    p_values: tuple[float, ...] = ()
    early: bool = False


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Naming(Record):
    """The verdict, and everything that it rests on.

    Parameters
    ----------
    verdict : str
        As `diagnosis.json` has it.
    fit : Fit
        Named effects and nuisances; nuisances alone where nothing is named.
    alone : Fit
        Nuisances alone.
    best : Fit
        The best explanation, named or not.
    p_values : tuple of float
        Of each named effect: chance that noise and our own errors do as much, times the effects, gears and teeth tried.
    without : str
        Verdict if nothing were named.
    gains : bool
        Whether the best explanation gains what a name must.
    closed, left : float
        Share of the gap that the best explanation closes, and what it leaves, in gaps.
    rivals : tuple of Rival
        Other explanations that were fitted, best first; where nothing is named, all of them, beside nuisances alone.
    identifiable : tuple of Identifiability
        What these records can show of each effect.
    threshold : float
        Score difference below which two explanations count as one.
    sentence : str
        Verdict in words.
    reasons : tuple of str
        What it rests on.
    """

    verdict: Verdict
    fit: Fit
    alone: Fit
    best: Fit
    p_values: tuple[float, ...]
    without: Verdict
    gains: bool
    closed: float
    left: float
    rivals: tuple[Rival, ...]
    identifiable: tuple[Identifiability, ...]
    threshold: float
    sentence: str
    reasons: tuple[str, ...]


def sound(search: Search) -> bool:
    """Return whether nuisances alone leave no gap and do the work of no effect, none of them by itself nor all together."""
    problem, alone = search.problem, search.alone
    return gap_left(alone, problem) < 1.0 and stays(problem, alone) and not _unlikely(problem, alone) and not _wide(problem, alone)


def _wide(problem: Problem, fit: Fit) -> list[tuple[str, float]]:
    """Return the records of gears off the rig of which a fit leaves more than noise would that is alike over all rows, in its deviations.

    Where noise is smoother than white, of which a few dozen rows tell little, a smooth shape hides in it row by row.
    """
    most, found = math.sqrt(float(chi2.ppf(1.0 - UNLIKELY, 1))), []
    for record, noise, left in zip(problem.records, problem.noises, fit.left, strict=True):
        size = float(np.sqrt(np.mean(left[record.keep] ** 2))) / noise.std
        if record.quantity.of_gear and size > most:
            found.append((record.file, size))
    return found


def _unlikely(problem: Problem, fit: Fit) -> bool:
    """Return whether nuisances and errors of the model in a fit are farther off than healthy ones are together, whatever the zero is."""
    unknowns = problem.unknowns
    own = [place for place, nuisance in enumerate(problem.nuisances) if nuisance.name != "angle_offset"]
    moved = np.concatenate([fit.point.unknown[own], fit.point.unknown[unknowns.wrong]])
    return bool(moved.size) and float(chi2.sf(moved @ moved, moved.size)) < UNLIKELY


def needed(search: Search, effects: tuple[Effect, ...]) -> float:
    """Return what effects must gain to be named.

    Of means that nuisances alone explain, nothing but the odds of these speaks for a name: for one of forms of the flanks they must say
    more, since nothing but errors of our model tells forms apart. Waviness that is not linear imitates teeth, not what turns with a
    shaft: for this as much as scores of the same explanation may differ by is enough.
    """
    problem = search.problem
    if effects and not any(hasattr(effect, "tooth") for effect in effects) and not problem.unknowns.scatter.common:
        return max(problem.wander, problem.imitated)
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
    level, remains = (gap_left(fit, search.problem) for fit in (alone, best))
    astray = (*_astray(search), *turning(search.problem, alone), *_misshapen(search.problem, alone))
    wide = _wide(search.problem, alone)
    close = [fit for fit, why in barred.items() if len(fit.effects) <= len(best.effects) and not why]
    gains = bool(best.effects) and gained >= needed(search, best.effects)
    held = not astray and not wide
    without = _verdict_on(search.problem, alone, closed, (level, remains), held, [])
    verdict = _verdict_on(search.problem, best, closed, (level, remains), held, close) if gains else without
    if verdict == "ambiguous":
        # Of explanations that fit alike the simplest is named: fewest effects, then fewest parameters.
        best = min([best, *close], key=lambda fit: (len(fit.effects), sum(len(e.parameters()) for e in fit.effects), scores[fit]))
        closed, remains = closure(alone, best, search.problem), gap_left(best, search.problem)
    named = best if verdict in ("explained", "partly_explained", "ambiguous") else alone
    hidden = bool(named.effects) and level < 1.0
    others = {fit: scores[fit] - scores[named] for fit in ranked if fit is not named}
    return Naming(
        verdict=verdict,
        fit=named,
        alone=alone,
        best=best,
        p_values=tuple(_p_value(search, best, number) for number in range(len(named.effects))),
        without=without,
        gains=gains,
        closed=closed,
        left=remains,
        rivals=tuple(_rival(search, fit, named, worse, limit(fit), barred.get(fit, "")) for fit, worse in others.items()),
        identifiable=shown,
        threshold=max([threshold, *(limit(fit) for fit in close)]),
        sentence=sentence_of(verdict, named, closed),
        reasons=(
            f"The best explanation gains {gained:.0f} in the score; a name needs {needed(search, best.effects):.0f}.",
            f"Nuisances alone leave {gaps(level)}; the best explanation leaves {gaps(remains)}.",
            *(["It is named all the same: nuisances close the gap with values that are by so much less likely."] if hidden else ()),
            *(
                f"Nuisances alone: {words} {moved:+.1f} prior deviations from what the model has, where it may do the work of an effect."
                for words, moved in astray
            ),
            *(f"Nuisances alone: {file} keeps {size:.1f} times its noise, more than noise alike over all its rows." for file, size in wide),
        ),
    )


def _verdict_on(problem: Problem, best: Fit, closed: float, left: tuple[float, float], sound: bool, close: Sequence[Fit]) -> Verdict:
    """Return the verdict on the best explanation that gains enough, and on others as close.

    Parameters
    ----------
    problem, best : Problem, Fit
        What was fitted, and the explanation; one without effects if none gains enough.
    closed : float
        Share of the gap that it closes.
    left : (float, float)
        What nuisances alone leave and what it leaves, in gaps.
    sound : bool
        Whether nuisances alone do the work of no effect, and leave no record too wide.
    close : sequence of Fit
        Explanations that the data cannot tell from it.
    """
    level, remains = left
    most = max(REST, min(RESEMBLES * level, WIDEST))
    if not best.effects:
        return "no_discrepancy" if level < OPEN and sound else "unexplained"
    if (remains > 1.0 and (closed < STANDS or remains > most)) or turning(problem, best) or _wrong(problem, best):
        return "unexplained"
    if close:
        return "ambiguous"
    return explains(closed, remains)


def explains(closed: float, remains: float) -> Verdict:
    """Return the verdict on an explanation that stands, by the share of the gap that it closes and by what it leaves, in gaps."""
    return "explained" if (closed >= CLOSED and remains <= REST) or remains < 1.0 else "partly_explained"


def gaps(left: float) -> str:
    """Return in words what a fit leaves, in parts of what counts as a gap."""
    if left < 1.0:
        return "no gap"
    return f"{left:.2f} times what counts as a gap{', as some healthy pairs do' if left < OPEN else ''}"


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


def _astray(search: Search) -> list[tuple[str, float]]:
    """Return the nuisances that stand too far off to be nuisances in the fit without effects, in prior deviations.

    Only those on which the records insist: to come back to what costs nothing would lose what counts as detected.
    """
    problem, alone = search.problem, search.alone
    moved = alone.point.unknown[: problem.outer]
    deviations = problem.whole.weighed(alone.point.weights).deviations
    deviation = deviations[len(deviations) - problem.outer :]
    insists = (np.abs(moved) - STRAYED) ** 2 > search.problem.detected * deviation**2
    return [(problem.nuisances[at].words, float(moved[at])) for at in problem.unknowns.scales if insists[at] and abs(moved[at]) >= ASTRAY]


def turning(problem: Problem, fit: Fit) -> list[tuple[str, float]]:
    """Return the gears on which index errors of a fit hold waves once to three times a turn that no teeth have by chance."""
    waves = zip(MEMBERS, uneven(problem, fit)[1], strict=True)
    return [(f"a wave of the index errors of the {gear}", float(size)) for gear, size in waves if size > LOST]


def _misshapen(problem: Problem, fit: Fit) -> list[tuple[str, float]]:
    """Return the errors of our model in a fit that are too large to be any.

    Variants, forms common to all teeth together (the root of their squares: of six healthy pairs it was 2.1 at most), and the rise of the
    largest Kw by waviness, which stands last.
    """
    forms, rise = np.split(fit.point.unknown[problem.unknowns.wrong.stop :], [-1])
    words = ("forms common to all teeth, together", "rise of the largest Kw by waviness")
    moved = zip(words, (np.linalg.norm(forms), *rise), strict=True)
    return [*_wrong(problem, fit), *((word, float(one)) for word, one in moved if abs(one) > LOST)]


def _wrong(problem: Problem, fit: Fit) -> list[tuple[str, float]]:
    """Return the variants of the model in a fit that are too far off to be any: what is missing stands behind them."""
    moved = zip(problem.unknowns.errors, fit.point.unknown[problem.unknowns.wrong], strict=True)
    return [(f"error of the model, {variant.words},", float(one)) for variant, one in moved if abs(one) > LOST]


def _within_reason(fit: Fit, problem: Problem) -> Array:
    """Return the mean squares, shape (r,), that a fit leaves with nuisances brought back to where they do the work of no effect.

    Scales, errors of our own model, and of the index errors waves and what stands out of a single tooth.
    """
    unknowns, unknown = problem.unknowns, fit.point.unknown.copy()
    unknown[unknowns.scales] = np.clip(unknown[unknowns.scales], -STRAYED, STRAYED)
    white = fit.white
    if not np.array_equal(unknown, fit.point.unknown):
        # What cannot be computed so far off stays as it is.
        with contextlib.suppress(InputError, SolveError):
            white = problem.whiten(problem.left(problem.at(fit.effects, unknown)))
    wrong = unknown[unknowns.wrong]
    back = [wrong - np.clip(wrong, -STRAYED, STRAYED)]
    if not unknowns.scatter.common:
        gears = np.split(unknown[unknowns.late], [problem.campaign.setup.pair.pinion.teeth])
        stray = uneven(problem, fit)[1] > STRAYED
        back = [*(waves_of(late) * stray[number] + odd_of(late) for number, late in enumerate(gears)), *back]
    return np.asarray(problem.squares(white + problem.held_columns @ np.concatenate(back)) / problem.counts)


def closure(alone: Fit, best: Fit, problem: Problem) -> float:
    """Return the share of the gap that is closed: of the mean square above noise of each record, which counts by that one's logarithm.

    Parameters
    ----------
    alone, best : Fit
        Nuisances alone, and with effects; nuisances far off, which do the work of effects, are brought back within reason.
    problem : Problem
        What was fitted.
    """
    before, after = (np.maximum(_within_reason(fit, problem) / problem.floor - 1.0, 0.0) for fit in (alone, best))
    weight = problem.counts * np.log1p(before)
    return float(weight @ (1.0 - after / np.maximum(before, 1e-9)) / weight.sum()) if weight.sum() > 0.0 else 1.0


def gap_left(fit: Fit, problem: Problem) -> float:
    """Return what a fit leaves; above 1 is a gap: the geometric mean over the rows of the mean squares over what can be expected, or 1.

    Slow records, motions and gears off the rig by themselves, in parts of what counts as a gap of each; the largest one, so that many
    records without a gap do not hide the others. Off the rig a tooth or a flank is a few dozen rows, of which chance leaves more too.
    """
    above = np.log(np.maximum(fit.squares / problem.floor, 1.0))
    moving, off_rig = (np.array([getattr(record.quantity, kind) for record in problem.records]) for kind in ("moving", "of_gear"))
    few = max(float(problem.counts[off_rig].sum()), 1.0)
    kinds = ((~moving & ~off_rig, GAP_SLOW), (moving, GAP_MOVING), (off_rig, GAP_SLOW * float(chi2.ppf(1.0 - UNLIKELY, few)) / few))
    return max(math.exp(float(problem.counts[kind] @ above[kind] / problem.counts[kind].sum())) / gap for kind, gap in kinds if kind.any())


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


def sentence_of(verdict: Verdict, fit: Fit, closed: float) -> str:
    """Return a verdict in words: the effects of a fit, and the share of the gap that it closes."""
    words = "; ".join(effect.describe() for effect in fit.effects)
    # Nuisances may have closed it before, with values that are less likely than the effect is.
    closes = (
        f"this closes {100.0 * closed:.0f} % of the gap"
        if closed >= 0.01
        else "nuisances alone leave as little, but only with less likely values"
    )
    return {
        "no_discrepancy": "Model and measurement agree within noise, the scatter of single teeth and the errors of our own model.",
        "unexplained": "Something is missing that no effect that was tried, alone or with others, stands for: none is named.",
        "ambiguous": f"{words}; but other explanations fit these data as well.",
        "explained": f"{words}: {closes}.",
        "partly_explained": f"{words}: {closes}, and a significant rest remains.",
    }[verdict]
