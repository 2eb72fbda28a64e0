"""Rank the effects of the catalogue by what they would explain, linear about the nuisances alone."""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from gearfem.definition.setup import Member
from gearfem.diagnosis.fitting.approach import lost, moves_otherwise, unwound
from gearfem.diagnosis.fitting.fit import Fit, again
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.ranking.candidate import Candidate, View, candidate_of, scored, view_of
from gearfem.diagnosis.ranking.likely_teeth import late_tooth, starts_of
from gearfem.diagnosis.ranking.readings import likeliest_readings
from gearfem.diagnosis.ranking.shapes import bounded, scanned, shapes_of, spread_of, stands
from gearfem.diagnosis.ranking.turning import turned, turns
from gearfem.effects.effect import MEMBERS, Effect
from gearfem.foundation import UNCOMPUTABLE, Array
from gearfem.foundation.progress import Progress, quiet
from gearfem.foundation.side_by_side import counted

# Rounds in which the strength of a candidate is improved, unless it promises less than this anyway.
REFINED, WORTH = 2, 5.0
# Shapes of an effect that are looked at in motion too.
LIKELIEST = 2
# Places from which such an effect is fitted, under each set of nuisances: those that leave least as they stand.
MET = 3
# Rounds in which such fits begin; how many of them go on where derivatives are taken anew, and rounds of the one that does elsewhere.
BEGUN, LED, ENDED = 2, 2, 4
# Effects of all teeth that are looked at again beside what is found.
LOOKED_AT = 8

# Where a fit starts: effects and unknowns.
Start: TypeAlias = tuple[tuple[Effect, ...], Array]


def rank(
    problem: Problem, base: Fit, kinds: Mapping[str, type[Effect]], progress: Progress = quiet, before: Sequence[Effect] = ()
) -> tuple[Candidate, ...]:
    """Return the effects that these records can show, the one that explains most first.

    Parameters
    ----------
    problem : Problem
        Records, noise and nuisances.
    base : Fit
        Of the nuisances alone, or with effects already named: what it leaves is to be explained.
    kinds : mapping of str to type
        Effects to try.
    progress : Progress
        Told after each effect, and then after each fit.
    before : sequence of Effect
        As the same records have had them, less known beside: what is fitted from several sizes begins from theirs alone.

    Returns
    -------
    tuple of Candidate
        One for each effect and gear, of what either gear may have for the pinion alone; for effects of one tooth one for each of the
        likeliest teeth, and shape there. Those without any response are left out.
    """
    jobs = [(kind, member) for kind in kinds.values() for member in _members(kind)]
    return _ranked(problem, base, jobs, progress, "candidates", before)


def _members(kind: type[Effect]) -> tuple[Member, ...]:
    return MEMBERS if kind.of_one_gear() and not kind.either_gear else MEMBERS[:1]


def rank_again(problem: Problem, base: Fit, candidates: tuple[Candidate, ...], progress: Progress = quiet) -> tuple[Candidate, ...]:
    """Return candidates in the order of what they would explain beside effects that have been fitted.

    Parameters
    ----------
    problem, base : Problem, Fit
        The fit with effects.
    candidates : tuple of Candidate
        From `rank` for the nuisances alone: their signatures tell which effects are worth another look.
    progress : Progress
        Told after each effect, and then after each fit.

    Returns
    -------
    tuple of Candidate
        Effects of all teeth that are named already are left out.
    """
    freed, setup = problem.freed(base.point), problem.campaign.setup
    teeth = {(type(c.effect), c.effect.member): None for c in candidates if hasattr(c.effect, "tooth")}
    whole = [c for c in candidates if not hasattr(c.effect, "tooth")]
    likely = sorted(whole, key=lambda c: -scored(c.effect, c.signature, freed, setup, c.unknown).gain)
    named = {(type(effect), effect.member) for effect in base.effects}
    others = {kind: None for c in likely[:LOOKED_AT] if (kind := (type(c.effect), c.effect.member)) not in named}
    return _ranked(problem, base, [*teeth, *others], progress, "candidates beside what is found")


def _ranked(
    problem: Problem, base: Fit, jobs: list[tuple[type[Effect], Member]], progress: Progress, words: str, before: Sequence[Effect] = ()
) -> tuple[Candidate, ...]:
    sizes = {(type(effect), effect.member): [effect] for effect in before}
    weights, squares = base.point.weights, base.squares
    view, slow = view_of(problem, base, weights, squares), None
    places = np.flatnonzero([not record.quantity.moving for record in problem.records])
    if len(places):
        slow = view_of(problem.part(places), base, weights[places], squares[places])

    def one(job: tuple[type[Effect], Member]) -> list[Candidate | list[Start]]:
        starts = starts_of(problem, view.base, *job)
        own = sizes.get(job)
        tried = [_nearest(view, start, own) if stands(start) else _best(view, slow, start, own) for start in starts]
        tried += [candidate_of(view, *late) for late in late_tooth(problem, view.base, *job)]
        return [candidate for candidate in tried if candidate]

    # The longest first, so that all cores end together.
    several = counted(one, sorted(jobs, key=lambda job: _tries(problem, job), reverse=True), progress, words)
    ranked = list(itertools.chain.from_iterable(several))
    found = [candidate for candidate in ranked if isinstance(candidate, Candidate)]
    if nearest := [places for places in ranked if isinstance(places, list)]:
        found += _fitted(view, nearest, progress, words)
    return tuple(sorted(found, key=lambda candidate: -candidate.gain))


def _tries(problem: Problem, job: tuple[type[Effect], Member]) -> tuple[bool, bool, int]:
    """Return what tells how long an effect takes: whether it is fitted as it stands, is sought on every tooth, and its sizes and shapes."""
    kind, member = job
    first = kind.example(problem.campaign.setup, member)
    return stands(first), hasattr(first, "tooth"), len(spread_of(first, problem.campaign.setup))


def _best(view: View, slow: View | None, start: Effect, sizes: list[Effect] | None = None) -> Candidate | list[Start] | None:
    """Return the effect at the shape, and then the strength, that explain most; `_nearest` where it has to be fitted."""
    setup = view.problem.campaign.setup
    if turns(start):
        likely = _waves(view, start)
        if not likely:
            # No order of it stands out: what it would do tells what the records show of it.
            shown = candidate_of(view, start)
            return None if shown is None else dataclasses.replace(shown, gain=0.0)
    else:
        likely = _likeliest(slow, start) if slow is not None else []
    if not likely and slow is not None and any(record.quantity.moving for record in view.problem.records):
        return _nearest(view, start, sizes)
    likely = likely or [(effect, None) for effect in shapes_of(start, setup)]
    candidates = [candidate_of(view, effect, unknown) for effect, unknown in likely]
    good = [candidate for candidate in candidates if candidate is not None]
    if not good:
        return None
    # Of what explains as much, to rounding, the first: a handful of numbers is met by any shape.
    best = max(good, key=lambda candidate: round(candidate.gain, 3))
    for _ in range(REFINED if best.gain > WORTH else 0):
        # Half way from here to where the response would end if it were linear, since it bends.
        strength = best.amplitude if best.amplitude < 1.0 else 0.5 * (1.0 + best.amplitude)
        effect = bounded(best.effect.scaled(min(strength, 3.0), setup), setup)
        other = candidate_of(view, effect, best.unknown)
        if other is None or other.gain <= best.gain:
            break
        best = other
    return best


def _nearest(view: View, start: Effect, sizes: list[Effect] | None = None) -> list[Start]:
    """Return where to fit an effect that cannot be scaled, or that motions alone feel, the nearest first, at given sizes if any."""
    problem, base = view.problem, view.base
    if not any(record.quantity.moving for record in problem.records):
        return []
    tried: list[tuple[float, Start]] = []
    for unknown in (base.point.unknown, *_elsewhere(view, start)):
        with contextlib.suppress(*UNCOMPUTABLE):
            effects = sizes or _sizes(view, start, unknown)
            starts: list[Start] = [((*base.effects, effect), unknown) for effect in effects]
            left = [problem.left_at(*place) for place in starts]
            pits = lowest(left) if scanned(start, problem.campaign.setup) else range(len(left))
            # Where nuisances do the work of an effect a little of it leaves less than all of it does where they have come back.
            tried += sorted(((left[place], starts[place]) for place in pits), key=lambda item: item[0])[:MET]
    return [place for _, place in sorted(tried, key=lambda item: item[0])]


def _fitted(view: View, nearest: list[list[Start]], progress: Progress, words: str) -> list[Candidate]:
    """Return each effect as fits from the places nearest to it find it: all of them begin side by side, and then few go on."""
    starts = [(number, start) for number, places in enumerate(nearest) for start in places]
    begun: dict[int, list[Fit]] = {}
    for (number, _), fit in zip(starts, counted(lambda item: _begun(view, item[1]), starts, progress, f"{words}: fits begun"), strict=True):
        if fit is not None:
            begun.setdefault(number, []).append(fit)
    ended = counted(lambda fits: _ended(view, fits), list(begun.values()), progress, f"{words}: fits")
    return [candidate for candidate in ended if candidate is not None]


def _begun(view: View, start: Start) -> Fit | None:
    """Return a fit in its first rounds, with columns taken under its effect where this moves motions far off; None where there is none."""
    effects, unknown = start
    here = copy.copy(view.problem)
    with contextlib.suppress(*UNCOMPUTABLE):
        if moves_otherwise(view.problem, view.base, effects[-1:]):
            unknown = here.prepare(effects, unknown)
        return here.fit(effects, unknown, BEGUN, view.base.objective)
    return None


def _ended(view: View, begun: list[Fit]) -> Candidate | None:
    """Return the last effect of fits as begun, where those that lead lowest end."""
    return max(_candidates(view, _led_on(view, begun)), key=lambda candidate: candidate.gain, default=None)


def _led_on(view: View, begun: list[Fit]) -> list[Fit]:
    """Return those of one effect that lead lowest as begun, fitted to the end.

    After the first one none goes on that stands above what one before it has come to, or above the fit that they build on.
    """
    problem, least, found = view.problem, view.base.objective, list[Fit]()
    otherwise = moves_otherwise(problem, view.base, begun[0].effects[-1:])
    for fit in sorted(begun, key=lambda fit: fit.objective)[: LED if otherwise else 1]:
        if found and fit.objective >= least:
            break
        with contextlib.suppress(*UNCOMPUTABLE):
            if otherwise:
                found.append(again(copy.copy(problem), fit.effects, fit.point.stood, hopeless=least))
            else:
                found.append(problem.fit(fit.effects, fit.point.unknown, ENDED, least))
            least = min(least, found[-1].objective)
    return found


def _sizes(view: View, start: Effect, unknown: Array) -> list[Effect]:
    """Return an effect that cannot be scaled, or that motions alone feel, at sizes from which it may lead near under some nuisances."""
    if start.stage != "sensing":
        return spread_of(start, view.problem.campaign.setup)
    return likeliest_readings(view if unknown is view.base.point.unknown else _moved(view, unknown), start)


def lowest(left: Sequence[float]) -> list[int]:
    """Return the places of a scan that leave no more than their neighbours: a fit from any other one ends where one from these does."""
    edged = [math.inf, *left, math.inf]
    return [place for place, here in enumerate(left) if here <= min(edged[place], edged[place + 2])]


def _moved(view: View, unknown: Array) -> View:
    """Return the same fit under other nuisances."""
    point = view.problem.at(view.base.effects, unknown)
    return View(problem=view.problem, base=dataclasses.replace(view.base, point=point), freed=view.problem.freed(point))


def _candidates(view: View, fits: list[Fit]) -> list[Candidate]:
    """Return the last effect of each fit as it stands there; its signature is what it does under the nuisances of that fit."""
    problem, base, found = view.problem, view.base, []
    for fit in fits:
        with contextlib.suppress(*UNCOMPUTABLE):
            signature = problem.response(fit.point, base.effects)
            if signature @ signature > 0.0:
                standing = scored(fit.effects[-1], signature, view.freed, problem.campaign.setup, fit.point.unknown)
                found.append(dataclasses.replace(standing, gain=max(base.objective - fit.objective, 0.0), amplitude=1.0))
    return found


def _waves(view: View, start: Effect) -> list[tuple[Effect, Array | None]]:
    """Return an effect that comes with the turns of a shaft where it explains most, and the nuisances beside it."""
    return [(effect, unknown) for effect in turned(view, start) for unknown in (None, *_elsewhere(view, effect))]


def _likeliest(slow: View, start: Effect) -> list[tuple[Effect, Array | None]]:
    """Return the shapes of an effect, and the nuisances, that explain most of the slow records, which cost a hundredth of motions.

    None where slow records are blind to it, as to most of what is not periodic.
    """
    found: list[Candidate] = []
    if start.repeats == "not periodic":
        return []
    for effect in shapes_of(start, slow.problem.campaign.setup):
        here = candidate_of(slow, effect)
        found += [here] if here is not None else []
    found.sort(key=lambda candidate: -candidate.gain)
    return [(candidate.effect, candidate.unknown) for candidate in found[:LIKELIEST]]


def _elsewhere(view: View, effect: Effect) -> list[Array]:
    """Return nuisances other than those of a fit that is far from the records, from which an effect may lead nearer.

    Scales as the model has them, since those of the fit do the work of what is missing: all, or those of motions alone, of which slow
    records say nothing; and zeros of the pinion angle as they look with the effect in the model, since effects that change all flanks much
    move the mesh lines.
    """
    problem, base = view.problem, view.base
    if not lost(problem, base):
        return []
    unknowns, stood = problem.unknowns, base.point.unknown
    neutral = unknowns.neutral(stood)
    return [neutral, *([unknowns.resting(stood)] if unknowns.moving else []), *unwound(problem, (*base.effects, effect), neutral)]
