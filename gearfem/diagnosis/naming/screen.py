"""Effects whose work nuisances may have done, looked for with the nuisances as the model has them."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from gearfem.diagnosis.fitting.approach import EDGES, lost, part_of, tuned, unwound
from gearfem.diagnosis.fitting.fit import Fit, attempt
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.straying import beyond
from gearfem.diagnosis.ranking.candidate import Candidate
from gearfem.diagnosis.ranking.shapes import bounded, shapes_of, stands
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, Array
from gearfem.foundation.progress import Progress
from gearfem.foundation.side_by_side import counted

# Rounds in which each effect is looked at, how many are worth a fit to all records, and times that the slow records are prepared anew for
# each of these.
ROUNDS, MOST, TIMES = 3, 5, 3


def screened(problem: Problem, alone: Fit, candidates: Sequence[Candidate], progress: Progress) -> list[tuple[tuple[Effect, ...], Array]]:
    """Return the single effects of all teeth that slow records alone call for, and nuisances to start from.

    Parameters
    ----------
    problem, alone : Problem, Fit
        Means over the pitches, and their nuisances: where these do the work of what is missing, nothing of it is left to see.
    candidates : sequence of Candidate
        Effects that the records feel.
    progress : Progress
        Told after each effect.

    Returns
    -------
    list of (tuple of Effect, ndarray of shape (k,))
        The best first, each fitted to the slow records together with all nuisances, from these as the model has them, and then tuned to the
        motions.
    """
    slow = [i for i, record in enumerate(problem.records) if not record.quantity.moving]
    whole = [c.effect for c in candidates if not hasattr(c.effect, "tooth") and not stands(c.effect) and c.effect.repeats == "every tooth"]
    jobs = list({(type(effect), effect.member): effect for effect in whole}.values())
    if not slow or not jobs:
        return []
    part, setup = part_of(problem, slow), problem.campaign.setup
    level = problem.settings(problem.unknowns.neutral(alone.point.unknown))
    edge, evenness = EDGES[-1]
    neutral = part.unknowns.of(dataclasses.replace(level, coupling_scale=1.0, tip_edge_scale=edge, evenness=evenness))
    try:
        neutral = part.prepare((), neutral)
    except UNCOMPUTABLE:
        return []

    def looked_at(example: Effect) -> Fit | None:
        tried = [((effect,), neutral) for effect in (example, *shapes_of(type(example).example(setup, example.member), setup))]
        if lost(problem, alone):
            tried += [(effects, zero) for effects, _ in tried for zero in unwound(part, effects, neutral)]
        try:
            return part.fit(*min(tried, key=lambda start: part.left_at(*start)), ROUNDS)
        except UNCOMPUTABLE:
            return None

    def fitted(fit: Fit) -> Fit:
        return attempt(part, fit.effects, fit.point.stood, TIMES) or fit

    found = [fit for fit in counted(looked_at, jobs, progress, "effects in the place of nuisances") if fit is not None]
    first = sorted(found, key=lambda fit: fit.objective)[:MOST]
    ranked = sorted(counted(fitted, first, progress, "the best of them again"), key=lambda fit: fit.objective)
    return list(counted(lambda fit: (fit.effects, _to_motions(problem, alone, fit)), ranked, progress, "the same at speed"))


def _to_motions(problem: Problem, alone: Fit, fit: Fit) -> Array:
    """Return unknowns as a fit of slow records has them, tuned to the motions."""
    known = fit.settings.with_teeth_of(alone.settings)
    here = copy.copy(problem)
    try:
        return tuned(here, here.prepare(fit.effects, problem.unknowns.of(known)), fit.effects)
    except UNCOMPUTABLE:
        return np.asarray(alone.point.stood)


def in_place(problem: Problem, unknown: Array, candidates: Sequence[Candidate]) -> Iterator[tuple[tuple[Effect, ...], Array]]:
    """Yield the candidate that would do what each scale or error of the model that strays does, and the unknowns (k,) without this."""
    kinds = {type(candidate.effect) for candidate in candidates}
    for one in problem.stand_ins:
        if not beyond(unknown[one.place]):
            continue
        effect, without = one.cause(float(unknown[one.place])), unknown.copy()
        without[one.place] = 0.0
        if isinstance(effect, Effect) and type(effect) in kinds:
            yield (bounded(effect, problem.campaign.setup),), without
