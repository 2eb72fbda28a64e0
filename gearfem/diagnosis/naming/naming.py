"""The verdict of a diagnosis, and the explanations beside the one that is named."""

from __future__ import annotations

import dataclasses
from typing import Literal

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.naming.gap import OPEN
from gearfem.diagnosis.naming.identify import Identifiability
from gearfem.effects.effect import Effect
from gearfem.foundation import Record

# How far beyond the scores of explanations that count as alike the stated threshold lies.
BEYOND = 1.0

Verdict = Literal["explained", "partly_explained", "no_discrepancy", "unexplained", "ambiguous"]


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
    level : float
        What nuisances alone leave, in gaps.
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
    untold : tuple of str
        Files of the records whose means were left out of the search, see `gearfem.diagnosis.naming.hammering`.
    """

    verdict: Verdict
    fit: Fit
    alone: Fit
    best: Fit
    p_values: tuple[float, ...]
    without: Verdict
    gains: bool
    level: float
    closed: float
    left: float
    rivals: tuple[Rival, ...]
    identifiable: tuple[Identifiability, ...]
    threshold: float
    sentence: str
    reasons: tuple[str, ...]
    untold: tuple[str, ...] = ()

    @property
    def gapless(self) -> bool:
        """Whether nuisances alone leave no gap, but for what some healthy pairs do."""
        return self.level < OPEN

    @property
    def as_good(self) -> tuple[Rival, ...]:
        """Explanations of no more effects that the fitted records cannot tell from what is named, best first."""
        if self.verdict != "ambiguous":
            return ()
        return tuple(rival for rival in self.rivals if rival.near and len(rival.effects) <= len(self.fit.effects))

    @property
    def named(self) -> Rival:
        """What is named, as one explanation among those as good."""
        return Rival(effects=self.fit.effects, score_difference=0.0, why="", near=True, fit=self.fit, p_values=self.p_values)

    def with_rest(self, reason: str) -> Naming:
        """Return the verdict with the reason why a gap stays open beside what is named: that explains no more than a part."""
        told = dataclasses.replace(self, reasons=(*self.reasons, reason))
        if self.verdict != "explained":
            return told
        sentence = sentence_of("partly_explained", self.fit, self.closed)
        return dataclasses.replace(told, verdict="partly_explained", sentence=sentence)


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
