"""Name the effects that a campaign shows: chosen one by one, tried against each other, and only after the last test."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Literal, TypeAlias

import numpy as np
from scipy.stats import chi2

from gearfem.diagnosis.fit import Fit
from gearfem.diagnosis.identify import Identifiability, identify
from gearfem.diagnosis.problem import Problem
from gearfem.diagnosis.rank import Candidate, rank, rank_again, together
from gearfem.diagnosis.side_by_side import side_by_side
from gearfem.effects.effect import Effect
from gearfem.foundation import Array, InputError, Record, SolveError
from gearfem.foundation.progress import Progress, quiet

Verdict = Literal["explained", "partly_explained", "no_discrepancy", "unexplained", "ambiguous"]

# Costs in the score, in units of the objective where noise alone is left: of each parameter, and of each tooth or gear tried.
PARAMETER = 8.0
# What a name must gain over the nuisances alone before it counts: chance, and errors of our model that no variant holds.
DETECTED = 40.0
# Healthy pairs have gained up to a fiftieth of the rows by effects that imitate errors of our model: more is asked of a name.
IMITATED = 0.01
# A further name must gain this share of what the first ones did: less is the difference between their shapes and the real ones.
FURTHER = 0.05
# Explanations closer than this cannot be told apart; shapes of real effects differ from ours, by this share of what they explain.
THRESHOLD, SHAPE = 15.0, 0.03
FITTED, PAIRED, MOST = 8, 3, 3
# Explanations that are fitted again, with derivatives taken where they stand, before the search goes on; further ones after that.
SETTLED, FURTHER_SETTLED = 4, 2
# Rivals that are fitted again beside the best explanation: those within this share of what it gains.
NEAR, RIVALS = 0.3, 3
# What a parameter costs that ends at a bound: the shape wants to be another one.
AT_BOUND = 30.0
# Share of the gap that names must close: less is no explanation, and more brings it to the noise.
STANDS, CLOSED = 0.60, 0.90
# What fits may leave, over what can be expected of them, before it counts as a gap.
GAP_SLOW, GAP_MOVING = 1.25, 2.0
# What may remain beside a name that stands, in gaps.
REST = 2.4


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Rival(Record):
    """An explanation beside the chosen one.

    Parameters
    ----------
    effects : tuple of Effect
        As fitted.
    score_difference : float
        By how much its score is worse.
    why : str
        Why it lost, or that it did not.
    """

    effects: tuple[Effect, ...]
    score_difference: float
    why: str


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
    closed : float
        Share of the gap that the best explanation closes.
    rivals : tuple of Rival
        Other explanations that were fitted, best first.
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
    closed: float
    rivals: tuple[Rival, ...]
    identifiable: tuple[Identifiability, ...]
    threshold: float
    sentence: str
    reasons: tuple[str, ...]


# Where a fit starts: effects, and nuisances other than those of the fit it builds on.
Start: TypeAlias = tuple[tuple[Effect, ...], Array | None]


class _Search:
    """Explanations that have been fitted, by their labels."""

    def __init__(self, problem: Problem, alone: Fit) -> None:
        self.problem, self.alone = problem, alone
        self.fits: dict[tuple[object, ...], Fit] = {(): alone}
        self.rows = len(alone.white)

    def fit(self, starts: Sequence[Start], base: Fit, progress: Progress = quiet, words: str = "effects") -> None:
        """Fit sets of effects, each set of names, gears and teeth once."""
        new = [start for start in starts if label(start[0]) not in self.fits]
        best = min(fit.objective for fit in self.fits.values())
        worth = self.alone.objective - 0.5 * (self.alone.objective - best)

        def one(start: Start) -> Fit | None:
            try:
                return self.problem.fit(start[0], self.start(start, base), hopeless=worth)
            except (InputError, SolveError):
                return None

        for number, (start, found) in enumerate(zip(new, side_by_side(one, new), strict=True)):
            progress(words, number, len(new))
            if found is not None:
                self.fits[label(start[0])] = found
        progress(words, max(len(new), 1), max(len(new), 1))

    def start(self, start: Start, base: Fit) -> Array:
        """Return the nuisances from which effects leave least: those of a fit without them, scales as the model has them, or the start's.

        Scales that did the work of a missing effect stand far off, where derivatives mean little.
        """
        effects, own = start
        neutral = base.point.unknown.copy()
        names = [nuisance.name for nuisance in self.problem.nuisances]
        neutral[[place for place, word in enumerate(names) if word != "angle_offset"]] = 0.0
        starts = (base.point.unknown, neutral, *([] if own is None else [own]))
        return min(starts, key=lambda unknown: self.problem.at(effects, unknown).objective)

    def settle(self, fits: Sequence[Fit], progress: Progress, words: str) -> None:
        """Fit explanations again, each with derivatives taken where it stands."""

        def one(fit: Fit) -> Fit:
            own = copy.copy(self.problem)
            return own.fit(fit.effects, own.prepare(fit.effects, fit.point.unknown), fresh=True)

        for number, fit in enumerate(side_by_side(one, fits)):
            progress(words, number, len(fits))
            self.fits[label(fit.effects)] = fit
        progress(words, max(len(fits), 1), max(len(fits), 1))
        self.alone = self.fits[()]

    def first(self, most: int) -> list[Fit]:
        """Return the best explanations with effects, at most so many."""
        return sorted((fit for fit in self.fits.values() if fit.effects), key=self.score)[:most]

    def rivals(self) -> list[Fit]:
        """Return the explanations that come near the best one, and what is left of that without each of its effects."""
        best = self.best()
        gained = self.alone.objective - best.objective
        parts = {label(effects) for effects, _ in _without_one(best)} if len(best.effects) > 1 else set()
        # What holds the best explanation and more has lost by its cost already: it is no other explanation.
        own = set(label(best.effects))
        others = [fit for fit in self.first(len(self.fits)) if not own <= set(label(fit.effects))]
        near = [fit for fit in others if fit.objective - best.objective < NEAR * gained][:RIVALS]
        return near + [fit for key, fit in self.fits.items() if key in parts and all(fit is not other for other in near)]

    def cost(self, effects: tuple[Effect, ...]) -> float:
        """Return what an explanation pays for its parameters and for the teeth and gears among which it was chosen."""
        pair = self.problem.campaign.setup.pair
        total = 0.0
        for effect in effects:
            total += PARAMETER * len(effect.parameters())
            if hasattr(effect, "tooth"):
                total += 2.0 * math.log(pair.pinion.teeth + pair.wheel.teeth)
        return total

    def score(self, fit: Fit) -> float:
        """Return the score of a fit; lower is better."""
        return fit.objective + self.cost(fit.effects) + AT_BOUND * len(fit.bound)

    @property
    def detected(self) -> float:
        """Least gain that counts."""
        return max(DETECTED, IMITATED * self.rows)

    def best(self, most: int = MOST) -> Fit:
        """Return the fit of the best score; each effect more must pay for itself by its share of the gain too."""
        least = min(fit.objective for fit in self.fits.values())
        further = max(self.detected, FURTHER * (self.alone.objective - least))
        few = (fit for fit in self.fits.values() if len(fit.effects) <= most)
        return min(few, key=lambda fit: self.score(fit) + further * max(len(fit.effects) - 1, 0))


def label(effects: tuple[Effect, ...]) -> tuple[object, ...]:
    """Return names, gears and teeth, by which explanations are told apart."""
    return tuple(sorted((e.name, getattr(e, "gear", ""), getattr(e, "tooth", -1)) for e in effects))


def name(problem: Problem, alone: Fit, kinds: Mapping[str, type[Effect]], progress: Progress = quiet) -> Naming:
    """Choose the effects that explain what nuisances leave.

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

    Returns
    -------
    Naming

    Notes
    -----
    Forward selection with back-elimination, up to three effects; the first candidates are tried in pairs too. A score is the objective
    (whitened residual and all nuisances, model form included, in prior deviations) over the mean square that the best fit leaves,
    plus a cost for each parameter and for the choice of a tooth.
    """
    search = _Search(problem, alone)
    _prepare_width(problem, kinds, progress)
    first = rank(problem, alone, kinds, progress)
    shown = identify(problem, alone, first)
    _singles(search, alone, first, progress)
    _pairs(search, alone, first, progress)
    search.settle([alone, *search.first(SETTLED)], progress, "first explanations again")
    for count in range(1, MOST):
        best = search.best()
        if len(best.effects) != count:
            break
        problem.prepare(best.effects, best.point.unknown)
        again = [c for c in rank_again(problem, best, first, progress) if c.gain > DETECTED and c.effect.name not in _taken(best)]
        setup = problem.campaign.setup
        starts: list[Start] = [((*best.effects, candidate.start(setup)), candidate.unknown) for candidate in again[:PAIRED]]
        search.fit(starts, best, progress, "further effects")
        search.settle([fit for fit in search.first(SETTLED) if len(fit.effects) == count + 1][:FURTHER_SETTLED], progress, "these again")
    _eliminate(search)
    best = search.best()
    problem.prepare(best.effects, best.point.unknown)
    problem.remember(best)
    jobs = [search.alone, *([best] if best.effects else []), *search.rivals()]
    search.fits = {}
    search.settle(jobs, progress, "rivals again")
    best = search.best()
    problem.prepare(best.effects, best.point.unknown)
    return _verdict(search, shown)


def _prepare_width(problem: Problem, kinds: Mapping[str, type[Effect]], progress: Progress) -> None:
    """Compute the solid elements behind leads once, before the work is shared out: a child's memory ends with it."""
    for kind in kinds.values():
        if kind.stage == "flank":
            system = problem.bench((kind.example(problem.campaign.setup),)).system
            if not system.flanks.lead.uniform:
                progress("solid elements of a lead", 0, 1)
                assert system.mesh.lead is not None
                progress("solid elements of a lead", 1, 1)
                return


def _taken(best: Fit) -> set[str]:
    """Return the effects that may not be added once more: those that replace a value of the model."""
    return {effect.name for effect in best.effects if type(effect).replaces}


def _singles(search: _Search, alone: Fit, candidates: tuple[Candidate, ...], progress: Progress) -> None:
    chosen = [c for c in candidates if c.gain > DETECTED / 8.0][:FITTED]
    setup = search.problem.campaign.setup
    starts: list[Start] = [((candidate.start(setup),), candidate.unknown) for candidate in chosen]
    search.fit(starts, alone, progress, "single effects")


def _pairs(search: _Search, alone: Fit, candidates: tuple[Candidate, ...], progress: Progress) -> None:
    """Fit the pairs of the first candidates that promise most together."""
    few = [c for c in candidates if c.gain > DETECTED / 8.0][:5]
    pairs = [(a, b) for i, a in enumerate(few) for b in few[i + 1 :] if a.effect.name != b.effect.name or a.label != b.label]
    gains = sorted(((together(search.problem, alone, pair), pair) for pair in pairs), key=lambda item: -item[0])
    single = alone.objective - search.best(1).objective
    chosen = [pair for gain, pair in gains if gain > single + DETECTED][:1]
    setup = search.problem.campaign.setup
    starts: list[Start] = [(tuple(candidate.start(setup) for candidate in pair), pair[0].unknown) for pair in chosen]
    search.fit(starts, alone, progress, "pairs of effects")


def _eliminate(search: _Search) -> None:
    """Fit the best explanation without each of its effects."""
    best = search.best()
    if len(best.effects) > 1:
        search.fit(_without_one(best), best)


def _without_one(fit: Fit) -> list[Start]:
    """Return the effects of a fit, each left out in turn."""
    return [(fit.effects[:out] + fit.effects[out + 1 :], None) for out in range(len(fit.effects))]


def _verdict(search: _Search, shown: tuple[Identifiability, ...]) -> Naming:
    alone = search.alone
    best = search.best()
    scores = {key: search.score(fit) for key, fit in search.fits.items()}
    own = scores[label(best.effects)]
    gained = scores[()] - own
    closed = closure(alone, best, search.problem)
    threshold = max(THRESHOLD, SHAPE * gained)
    rivals = tuple(
        Rival(effects=fit.effects, score_difference=scores[key] - own, why=_why(fit, best, scores[key] - own, threshold))
        for key, fit in sorted(search.fits.items(), key=lambda item: scores[item[0]])
        if fit is not best and fit.effects
    )
    level, remains = (_level(fit, search.problem) for fit in (alone, best))
    close = [r for r in rivals if r.score_difference < threshold and len(r.effects) <= len(best.effects)]
    if not best.effects or gained < search.detected:
        verdict: Verdict = "no_discrepancy" if level < 1.0 else "unexplained"
    elif remains > 1.0 and (closed < STANDS or remains > REST):
        verdict = "unexplained"
    elif close:
        verdict = "ambiguous"
    elif closed >= CLOSED or remains < 1.0:
        verdict = "explained"
    else:
        verdict = "partly_explained"
    named = best if verdict in ("explained", "partly_explained", "ambiguous") else alone
    return Naming(
        verdict=verdict,
        fit=named,
        alone=alone,
        best=best,
        p_values=tuple(_p_value(search, best, number) for number in range(len(named.effects))),
        closed=closed,
        rivals=rivals,
        identifiable=shown,
        threshold=threshold,
        sentence=sentence_of(verdict, named, closed),
        reasons=(
            f"The best explanation gains {gained:.0f} in the score; a name needs {search.detected:.0f}.",
            f"Nuisances alone leave {level:.2f}, the best explanation leaves {remains:.2f} times what counts as a gap.",
        ),
    )


def closure(alone: Fit, best: Fit, problem: Problem) -> float:
    """Return the share of the gap that is closed: of the mean square above noise of each record, which counts by that one's logarithm.

    Parameters
    ----------
    alone, best : Fit
        Nuisances alone, and with effects.
    problem : Problem
        What was fitted.
    """
    before, after = (np.maximum(fit.squares / problem.floor - 1.0, 0.0) for fit in (alone, best))
    weight = problem.counts * np.log1p(before)
    return float(weight @ (1.0 - after / np.maximum(before, 1e-9)) / weight.sum()) if weight.sum() > 0.0 else 1.0


def _level(fit: Fit, problem: Problem) -> float:
    """Return what a fit leaves: the geometric mean over the rows of the mean squares over what can be expected, 1 at least.

    Slow records and motions by themselves, in parts of what counts as a gap of each; the larger one, so that many records without a gap
    do not hide the others.
    """
    above = np.log(np.maximum(fit.squares / problem.floor, 1.0))
    moving = np.array([record.quantity.moving for record in problem.records])
    kinds = ((~moving, GAP_SLOW), (moving, GAP_MOVING))
    return max(math.exp(float(problem.counts[kind] @ above[kind] / problem.counts[kind].sum())) / gap for kind, gap in kinds if kind.any())


def _p_value(search: _Search, best: Fit, number: int) -> float:
    """Return the chance of the gain of one effect, times the explanations that were tried."""
    without = search.fits.get(label(best.effects[:number] + best.effects[number + 1 :]))
    if without is None:
        return 0.0
    gain = without.objective - best.objective
    pair = search.problem.campaign.setup.pair
    trials = 40 + 3 * (pair.pinion.teeth + pair.wheel.teeth)
    return min(1.0, trials * float(chi2.sf(max(gain, 0.0), len(best.effects[number].parameters()))))


def _why(fit: Fit, best: Fit, difference: float, threshold: float) -> str:
    if difference < threshold:
        return f"cannot be told apart: its score is worse by {difference:.1f}, less than {threshold:.1f}"
    if set(label(best.effects)) < set(label(fit.effects)):
        return f"explains no more than its further parameters cost (score worse by {difference:.1f})"
    return f"leaves more of the gap: score worse by {difference:.1f}"


def sentence_of(verdict: Verdict, fit: Fit, closed: float) -> str:
    """Return a verdict in words: the effects of a fit, and the share of the gap that it closes."""
    words = "; ".join(effect.describe() for effect in fit.effects)
    return {
        "no_discrepancy": "Model and measurement agree within noise, the scatter of single teeth and the errors of our own model.",
        "unexplained": "There is a gap that no effect of the catalogue, alone or with others, closes: none is named.",
        "ambiguous": f"{words}; but other explanations fit these data as well.",
        "explained": f"{words}: this closes {100.0 * closed:.0f} % of the gap.",
        "partly_explained": f"{words}: this closes {100.0 * closed:.0f} % of the gap, and a significant rest remains.",
    }[verdict]
