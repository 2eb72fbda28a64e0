"""Explanations of a campaign: sets of effects, fitted, scored and compared."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

from gearfem.diagnosis.fitting.approach import lost, moves_otherwise, unwound
from gearfem.diagnosis.fitting.fit import Fit, attempt
from gearfem.diagnosis.fitting.parameters import faint, overdone
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.score import Label, label, near_by, score
from gearfem.diagnosis.fitting.straying import STRAYED
from gearfem.diagnosis.naming.by_themselves import borrowed
from gearfem.diagnosis.naming.mimic import mimicked
from gearfem.effects.effect import MEMBERS, Effect
from gearfem.foundation import UNCOMPUTABLE, Array
from gearfem.foundation.progress import Progress, quiet
from gearfem.foundation.side_by_side import counted

# A further name must gain this share of what the first ones did where it acts as one of them does: less is the difference between their
# shapes and the real ones, which other effects do not imitate as well.
FURTHER, FURTHER_OTHER = 0.05, 0.01
# What it must gain at least, in parts of what scores of the same explanation differ by.
FURTHER_LEAST = 2.5
# An effect is named from twice the strength on at which errors of our model imitate it.
MIMICKED = 0.5
# Most effects of an explanation.
MOST = 3
# Rivals that are fitted again beside the best explanation: those within this share of what it gains.
NEAR, RIVALS = 0.3, 3
# Share of what the best explanation gains below which another one is left behind: first fits miss much of what they will gain, not as much.
BEHIND = 0.2
# Share of what a further name must gain that a fit with one must promise beside the one it builds on, or it is given up.
LITTLE = 0.5

# Where a fit starts: effects, and nuisances other than those of the fit it builds on.
Start: TypeAlias = tuple[tuple[Effect, ...], Array | None]


class Search:
    """Explanations that have been fitted, by their labels."""

    def __init__(self, problem: Problem, alone: Fit) -> None:
        self.problem = problem
        self.fits: dict[tuple[Label, ...], Fit] = {(): alone}
        # By columns as they were prepared.
        self._mimicked: dict[Fit, tuple[tuple[Array, ...], tuple[float, ...]]] = {}
        # The same wherever the problem is prepared.
        self._borrowed: dict[Fit, str] = {}
        # Explanations that have begun from nuisances as the model has them, and how long errors of the model stayed alike then.
        self._neutral: set[tuple[tuple[Label, ...], bytes]] = set()

    @property
    def alone(self) -> Fit:
        """Nuisances alone."""
        return self.fits[()]

    @property
    def worth(self) -> float:
        """Objective that an explanation must promise to come down to, or it is given up: half way from nuisances alone to the least."""
        return 0.5 * (self.alone.objective + min(fit.objective for fit in self.fits.values()))

    def fit(self, starts: Sequence[Start], base: Fit, progress: Progress = quiet, words: str = "effects", anew: bool = False) -> None:
        """Fit sets of effects, told apart by names, gears and teeth; of several starts of one set the best is kept.

        Those not fitted before, or all of them `anew`.
        """
        new = [start for start in starts if anew or label(start[0]) not in self.fits]
        worth, further = self.worth, base.objective - LITTLE * self.further_least()

        def one(start: Start) -> Fit | None:
            effects, own = start
            hopeless = further if base.effects and len(effects) > len(base.effects) else worth
            if own is not None and moves_otherwise(self.problem, base, effects):
                return attempt(self.problem, effects, own, hopeless=hopeless)
            try:
                return self.problem.fit(effects, self.start(start, base), hopeless=hopeless)
            except UNCOMPUTABLE:
                return None

        for found in counted(one, new, progress, words):
            self._keep(found)

    def start(self, start: Start, base: Fit) -> Array:
        """Return the nuisances from which effects leave least: those of a fit without them, scales as the model has them, or the start's.

        Scales that did the work of a missing effect stand far off, where derivatives mean little; and so does the zero of the angle.
        """
        effects, own = start
        neutral = self.problem.unknowns.neutral(base.point.unknown)
        elsewhere = unwound(self.problem, effects, neutral) if lost(self.problem, base) else []
        starts = (base.point.unknown, neutral, *([] if own is None else [own]), *elsewhere)
        return min(starts, key=lambda unknown: self.problem.left_at(effects, unknown))

    def settle(self, fits: Sequence[Fit], progress: Progress, words: str) -> None:
        """Fit explanations again, see `again`; those that stay far off or stray, from nuisances as the model has them too.

        The place that a fit descends into goes by where it began. From nuisances as the model has them an explanation begins once, as
        long as errors of the model stay alike over as many rows: later it would leave its place for one where it has been. Where one leaves
        far more than it promised, with columns of another place, it begins where the nuisances alone stand as well: index errors that suit
        those columns may lead a motion elsewhere. What each record counts goes along, or a fit would leave its place. Of single teeth
        nuisances stand still: there is no other place, and where they leave far more than noise of all records, index errors take little
        of it unless all count at first. Effects that do not promise to be worth it are given up where they stand.
        """
        bare, memory, free = self.alone.point.stood, self.problem.memory.tobytes(), self.problem.outer > 0
        worth = self.worth

        def one(fit: Fit) -> Fit:
            hopeless = worth if fit.effects else math.inf
            weights = fit.point.weights if free else None
            found = attempt(self.problem, fit.effects, fit.point.stood, hopeless=hopeless, weights=weights) or fit
            if near_by(self.problem, found):
                return found
            begun = not free or (label(fit.effects), memory) in self._neutral
            starts = [] if begun else [self.problem.unknowns.neutral(fit.point.unknown)]
            if fit.effects and found.objective > fit.objective + self.problem.wander:
                starts.append(bare)
            for start in starts:
                other = attempt(self.problem, fit.effects, start, hopeless=min(found.objective, hopeless))
                found = found if other is None else min(found, other, key=self.score)
            return found

        self._renew(one, fits, progress, words)
        again = (label(fit.effects) for fit in fits)
        self._neutral |= {(key, memory) for key in again if not near_by(self.problem, self.fits[key])}

    def settle_from(
        self, starts: Sequence[tuple[tuple[Effect, ...], Array]], progress: Progress, words: str, hopeless: float = math.inf
    ) -> None:
        """Fit explanations that begin far from the nuisances alone, each prepared where it begins; the better one of a kind stays.

        Those that do not promise to come down to `hopeless` are given up where they stand.
        """
        for found in counted(lambda start: attempt(self.problem, *start, hopeless=hopeless), starts, progress, words):
            self._keep(found)

    def instead(self, progress: Progress) -> bool:
        """Fit the nuisances alone from where one of them does what a single effect has gained by; return whether they leave less then.

        Where the effect is a likely value of the nuisance it has gained by where the fit of these began.
        """
        starts = []
        for fit in self.first(len(self.fits)):
            if len(fit.effects) > 1 or self.gained(fit) < self.problem.wander:
                continue
            for one in self.problem.stand_ins:
                if one.serves(fit.effects[0]) and abs(moved := one.moved(fit.effects[0])) <= STRAYED:
                    unknown = fit.point.stood
                    unknown[one.place] = moved
                    starts.append(((), unknown))
        before = self.alone
        self.settle_from(starts, progress, "nuisances in the place of effects")
        return before.objective - self.alone.objective > self.problem.wander

    def _keep(self, found: Fit | None) -> None:
        """Keep a fit if it is the best one of its effects so far."""
        if found is not None:
            before = self.fits.get(label(found.effects), found)
            self.fits[label(found.effects)] = min(before, found, key=self.score)

    def abreast(self, progress: Progress) -> None:
        """Fit all explanations beside the best again from where that stands, so that none wins by where it began."""
        best = self.best()
        others = [fit for fit in self.fits.values() if fit is not best]

        def one(fit: Fit) -> Fit:
            found = attempt(self.problem, fit.effects, best.point.stood, hopeless=fit.objective)
            return fit if found is None else min(fit, found, key=self.score)

        self._renew(one, others, progress, "rivals from where the best stands")

    def _renew(self, one: Callable[[Fit], Fit], fits: Sequence[Fit], progress: Progress, words: str) -> None:
        """Put what becomes of fits in their place."""
        for fit in counted(one, fits, progress, words):
            self.fits[label(fit.effects)] = fit

    def first(self, most: int) -> list[Fit]:
        """Return the best explanations with effects, at most so many."""
        return sorted((fit for fit in self.fits.values() if fit.effects), key=self.score)[:most]

    def ahead(self, most: int) -> list[Fit]:
        """Return the best explanations with effects, at most so many, less those left far behind by one that may be named."""
        fits = self.first(most)
        gains = [self.gained(fit) for fit in fits]
        least = BEHIND * gains[0] if gains and gains[0] > self.problem.detected else -math.inf
        return [fit for fit, gain in zip(fits, gains, strict=True) if gain > least]

    def rivals(self) -> list[Fit]:
        """Return the explanations that come near the best one, and what is left of that without each of its effects."""
        best = self.best()
        least, gained = self.score(best), self.gained(best)
        parts = {label(effects) for effects, _ in without_one(best)} if len(best.effects) > 1 else set()
        # What holds the best explanation and more has lost by its cost already: it is no other explanation.
        own = set(label(best.effects))
        others = [fit for fit in self.first(len(self.fits)) if not own <= set(label(fit.effects))]
        near = [fit for fit in others if self.score(fit) - least < NEAR * gained][:RIVALS]
        return near + [fit for key, fit in self.fits.items() if key in parts and all(fit is not other for other in near)]

    def score(self, fit: Fit) -> float:
        """Return the score of a fit, see `score`."""
        return score(self.problem, fit)

    def gained(self, fit: Fit) -> float:
        """Return by how much a fit scores better than nuisances alone."""
        return self.score(self.alone) - self.score(fit)

    def best(self, most: int = MOST) -> Fit:
        """Return the fit of the best score that may be named; effects beside the first pay for themselves too."""
        like, other = (self.further_least(share) for share in (FURTHER, FURTHER_OTHER))

        def price(fit: Fit) -> float:
            ways = len({manner_of(effect) for effect in fit.effects})
            further = like * (len(fit.effects) - ways) + other * max(ways - 1, 0)
            return self.score(fit) + further

        ranked = sorted((fit for fit in self.fits.values() if len(fit.effects) <= most), key=price)
        return next(fit for fit in ranked if not self.barred(fit))

    def further_least(self, share: float = FURTHER_OTHER) -> float:
        """Return what a name beside others must gain, if it is at least a share of what explanations gain at most."""
        most = self.alone.objective - min(fit.objective for fit in self.fits.values())
        return max(FURTHER_LEAST * self.problem.wander, self.problem.detected, share * most)

    def barred(self, fit: Fit) -> str:
        """Return why a fit may not be named, in words; empty if it may.

        An effect of it contradicts its own cause, or is as strong as can be, or hardly there, or errors of our model imitate it, or what it
        does to the columns of waviness gains and not the effect itself.
        """
        setup = self.problem.campaign.setup
        for effect in fit.effects:
            if why := effect.contradicts():
                return f"{effect.describe()}: {why}"
        for effect in overdone(fit.effects, setup):
            return f"{effect.describe()}: as strong as can be, so that something else is missing that looks like it"
        for effect, deviations in zip(fit.effects, fit.deviations, strict=True):
            multiplies = any(one.serves(effect) and one.way.is_scale for one in self.problem.stand_ins)
            if faint(effect, deviations, setup, multiplies):
                return f"{effect.describe()}: too weak against its own doubt, so that the fit gains by something else"
        if self.problem.unknowns.scatter.common:
            # Of means the fit itself knows errors of the model and their size: what is not faint has been told from them.
            return ""
        columns, shares = self._mimicked.get(fit, (None, ()))
        if columns is not self.problem.columns:
            try:
                shares = mimicked(self.problem, fit)
            except UNCOMPUTABLE:
                return "what errors of our own model would do beside it cannot be computed"
            self._mimicked[fit] = self.problem.columns, shares
        for effect, share in zip(fit.effects, shares, strict=True):
            if share > MIMICKED:
                return f"{effect.describe()}: errors of our own model would be taken for half of it or more"
        return self._borrows(fit)

    def _borrows(self, fit: Fit) -> str:
        """Return what `borrowed` says of an explanation of single teeth and turns that gains what a name needs, asked once."""
        if self.problem.outer or not fit.effects or self.gained(fit) < least_beside(self.problem, fit.effects):
            return ""
        if fit not in self._borrowed:
            try:
                self._borrowed[fit] = borrowed(self.problem, fit)
            except UNCOMPUTABLE:
                self._borrowed[fit] = "what it scores by itself cannot be computed"
        return self._borrowed[fit]


def least_beside(problem: Problem, effects: tuple[Effect, ...]) -> float:
    """Return what effects of single teeth and turns must gain to be named.

    Waviness that is not linear imitates teeth, not what turns with a shaft: for this as much as scores of the same explanation may differ
    by is enough.
    """
    return problem.detected if any(hasattr(effect, "tooth") for effect in effects) else max(problem.wander, problem.imitated)


def manner_of(effect: Effect) -> tuple[str, str]:
    """Return how an effect acts, where in the model and how it repeats: one of the same way may do what another one's shape lacks."""
    return "teeth" if effect.stage in ("flank", "placement") else effect.stage, effect.repeats


def exchanged(fit: Fit) -> Iterator[Fit]:
    """Yield a fit with each of its effects that either gear may have on the other one, which no record tells from it."""
    for place, effect in enumerate(fit.effects):
        if effect.either_gear:
            (other,) = (member for member in MEMBERS if member != effect.member)
            moved = dataclasses.replace(effect, gear=other)  # type: ignore[call-arg]
            effects = (*fit.effects[:place], moved, *fit.effects[place + 1 :])
            yield dataclasses.replace(fit, effects=effects, point=dataclasses.replace(fit.point, effects=effects))


def without_one(fit: Fit) -> list[Start]:
    """Return the effects of a fit, each left out in turn."""
    return [(fit.effects[:out] + fit.effects[out + 1 :], None) for out in range(len(fit.effects))]
