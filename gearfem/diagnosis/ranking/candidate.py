"""An effect as it might explain what a fit leaves: its response, freed from all nuisances, and its gain."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import numpy as np

from gearfem.definition.setup import Setup
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.marginal import WEIGHED
from gearfem.diagnosis.fitting.problem import Freed, Problem
from gearfem.diagnosis.ranking.shapes import bounded
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Candidate(Record):
    """An effect as it might explain the gap.

    Parameters
    ----------
    effect : Effect
        Where a fit would start.
    gain : float
        By how much it would lower the objective, if the response were linear.
    amplitude : float
        Multiple of this effect that would lower it most.
    signature : ndarray, shape (m,)
        Its whitened response at this strength.
    share : float
        Length of the signature that nuisances and model form leave, over the length before.
    unknown : ndarray, shape (k,), or None
        Nuisances other than the fit's under which it was tried and from which a fit would start.
    """

    effect: Effect
    gain: float
    amplitude: float
    signature: Array
    share: float
    unknown: Array | None

    def start(self, setup: Setup) -> Effect:
        """Return the effect at the strength that would lower the objective most, within its bounds."""
        # What comes once a turn is linear in its strength; most others bend.
        most = 50.0 if self.effect.repeats == "once a turn" else 3.0
        return bounded(self.effect.scaled(min(max(self.amplitude, -most), most), setup), setup)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class View:
    """Records beside a fit that candidates are measured against, predicted with the very index errors with which candidates are.

    Parameters
    ----------
    problem : Problem
        The records.
    base : Fit
        What is known already.
    freed : callable
        Measures signatures freed from all nuisances, see `Problem.freed`.
    """

    problem: Problem
    base: Fit
    freed: Freed


def view_of(problem: Problem, base: Fit, weights: Array, squares: Array) -> View:
    """Return the view of a fit, with the weights (r,) and mean squares (r,) of the records of a problem, which may be a part of its own."""
    try:
        point = problem.at(base.effects, base.point.unknown, weights, WEIGHED)
    except UNCOMPUTABLE:
        # A first fit may lead where there is no model.
        point = problem.at(base.effects, base.point.stood, weights, WEIGHED)
    base = dataclasses.replace(base, point=dataclasses.replace(point, unknown=base.point.unknown), squares=squares)
    return View(problem=problem, base=base, freed=problem.freed(base.point))


def candidate_of(view: View, effect: Effect, unknown: Array | None = None) -> Candidate | None:
    """Return how far an effect would explain what a fit leaves; None if it cannot be computed.

    Under the nuisances of the fit its strength is scaled, unless the effect as it stands explains more; under others it is taken so.
    """
    problem, point = view.problem, view.base.point
    setup = problem.campaign.setup
    try:
        effect.check(setup)
        ahead = problem.at((*point.effects, effect), point.unknown if unknown is None else unknown, point.weights)
        before = point.predicted if unknown is None else problem.predict(point.effects, unknown)
    except UNCOMPUTABLE:
        return None
    signature = problem.whiten(tuple(a - b for a, b in zip(ahead.predicted, before, strict=True)))
    if not signature @ signature > 0.0:
        return None
    candidate = scored(effect, signature, view.freed, setup, unknown)
    if candidate.share <= 1e-6:
        return None
    # Where the response bends far, as where teeth separate, what it does as it stands tells more than its slope.
    real = point.objective - ahead.objective
    if unknown is None and candidate.gain >= real:
        return candidate
    return dataclasses.replace(candidate, gain=max(real, 0.0), amplitude=1.0)


def scored(effect: Effect, signature: Array, freed: Freed, setup: Setup, unknown: Array | None = None) -> Candidate:
    """Return a candidate with its gain against what is left, each strength scaled on its own."""
    gram, pulls = freed(signature[:, None])
    square, pull = max(float(gram[0, 0]), 1e-300), float(pulls[0])
    return Candidate(
        effect=effect,
        gain=pull**2 / square if pull > 0.0 or signed(effect, setup) else 0.0,
        amplitude=pull / square,
        signature=signature,
        share=math.sqrt(square / float(signature @ signature)),
        unknown=unknown,
    )


def signed(effect: Effect, setup: Setup) -> bool:
    """Return whether the strength of an effect may lie on either side of none."""
    known = next((effect.parameters()[field] for field in effect.strengths()), None)
    return known is not None and known.bounds(setup, effect.member)[0] < known.at_rest(setup, effect.member)


def together(problem: Problem, base: Fit, candidates: Iterable[Candidate]) -> float:
    """Return by how much several candidates together would lower the objective, if the response were linear."""
    signatures = np.column_stack([candidate.signature for candidate in candidates])
    gram, pull = problem.freed(base.point)(signatures)
    return float(pull @ np.linalg.lstsq(gram, pull, rcond=1e-10)[0])
