"""What records can show at all: of each effect what nuisances leave, from which strength on it is seen, and which effect looks alike."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.ranking.candidate import Candidate
from gearfem.effects.effect import Effect
from gearfem.foundation import Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Identifiability(Record):
    """What the records of a campaign can show of one effect.

    Parameters
    ----------
    effect : Effect
        At the strength that was tried.
    share : float
        Part of its response, in standard deviations, that nuisances and errors of the model leave.
    limit : float
        Strength from which it is seen, in parts of the one that was tried.
    rival : Effect or None
        Other effect whose response is most alike.
    overlap : float
        Cosine between both, freed from nuisances: 1 cannot be told apart.
    """

    effect: Effect
    share: float
    limit: float
    rival: Effect | None
    overlap: float


def identify(problem: Problem, base: Fit, candidates: Sequence[Candidate]) -> tuple[Identifiability, ...]:
    """Return what records can show of effects, the clearest first.

    Parameters
    ----------
    problem : Problem
        As for `rank`.
    base : Fit
        Beside which the effects would stand.
    candidates : sequence of Candidate
        From `rank`; of each effect and gear the likeliest tooth is taken.

    Returns
    -------
    tuple of Identifiability

    Notes
    -----
    Linear about the fit: what bends, as where teeth part, is seen earlier or later than this says.
    """
    first = {(c.effect.name, c.effect.member if c.effect.of_one_gear() else ""): c for c in reversed(candidates)}
    kept = list(first.values())
    if not kept:
        return ()
    gram, _ = problem.freed(base.point)(np.column_stack([candidate.signature for candidate in kept]))
    length = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    alike = np.abs(gram / np.outer(length, length))
    np.fill_diagonal(alike, 0.0)
    found = []
    for place, candidate in enumerate(kept):
        nearest = int(np.argmax(alike[place]))
        found.append(
            Identifiability(
                effect=candidate.effect,
                share=candidate.share,
                limit=float(np.sqrt(problem.detected) / length[place]),
                rival=kept[nearest].effect if len(kept) > 1 else None,
                overlap=float(min(alike[place, nearest], 1.0)),
            )
        )
    return tuple(sorted(found, key=lambda one: one.limit))
