"""Rank the effects of the catalogue by what they would explain, linear about the nuisances alone."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Iterable, Mapping

import numpy as np

from gearfem.definition.setup import Member, Setup
from gearfem.diagnosis.fit import Fit
from gearfem.diagnosis.problem import Freed, Problem
from gearfem.diagnosis.shapes import bounded, shapes_of, stands
from gearfem.diagnosis.side_by_side import side_by_side
from gearfem.diagnosis.zero import guess_zero
from gearfem.effects.effect import MEMBERS, Effect
from gearfem.foundation import Array, InputError, Record, SolveError
from gearfem.foundation.progress import Progress, quiet

# Rounds in which the strength of a candidate is improved, unless it promises less than this anyway.
REFINED, WORTH = 2, 5.0
# Rounds in which the weights of records settle.
WEIGHED = 4
# Angles to the pitch at which the response of a tooth is taken before it is moved.
PER_PITCH = 48
# Shapes of an effect that are looked at in motion too.
LIKELIEST = 2
# Part of the expected square beyond which nuisances alone may have found a wrong zero of the angle.
LOST = 5.0
# Part of a response that nuisances leave of an effect below which only fits tell what it is worth beside others, once nuisances stray.
VEILED = 0.05
# Effects of all teeth that are looked at again beside what is found.
LOOKED_AT = 8
# Prior deviations from which on a nuisance is a finding itself.
STRAYED = 3.0
# Teeth that are looked at in full, of each effect of one tooth.
TEETH = 2


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
    visible : float
        Length of the signature that nuisances and model form leave, in standard deviations.
    share : float
        That length over the length before.
    unknown : ndarray, shape (k,), or None
        Nuisances other than the fit's under which it was tried and from which a fit would start.
    """

    effect: Effect
    gain: float
    amplitude: float
    signature: Array
    visible: float
    share: float
    unknown: Array | None

    def start(self, setup: Setup) -> Effect:
        """Return the effect at the strength that would lower the objective most, within its bounds."""
        # What comes once a turn is linear in its strength; most others bend.
        most = 50.0 if self.effect.repeats == "once a turn" else 3.0
        return bounded(self.effect.scaled(min(max(self.amplitude, -most), most), setup), setup)


def rank(problem: Problem, base: Fit, kinds: Mapping[str, type[Effect]], progress: Progress = quiet) -> tuple[Candidate, ...]:
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
        Told after each effect.

    Returns
    -------
    tuple of Candidate
        One for each effect and gear, two for effects of one tooth; those without any response are left out.
    """
    jobs = [(kind, member) for kind in kinds.values() for member in (MEMBERS if kind.of_one_gear() else MEMBERS[:1])]
    # The longest first, so that all cores end together.
    return _ranked(problem, base, sorted(jobs, key=lambda job: not stands(job[0].example(problem.campaign.setup))), progress, "candidates")


def rank_again(problem: Problem, base: Fit, candidates: tuple[Candidate, ...], progress: Progress = quiet) -> tuple[Candidate, ...]:
    """Return candidates in the order of what they would explain beside effects that have been fitted.

    Parameters
    ----------
    problem, base : Problem, Fit
        The fit with effects.
    candidates : tuple of Candidate
        From `rank` for the nuisances alone: their signatures tell which effects are worth another look.
    progress : Progress
        Told after each effect.

    Returns
    -------
    tuple of Candidate
        Effects of all teeth that are named already are left out.
    """
    freed, setup = problem.freed(base.point), problem.campaign.setup
    teeth = {(type(c.effect), c.effect.member): None for c in candidates if hasattr(c.effect, "tooth")}
    whole = [c for c in candidates if not hasattr(c.effect, "tooth")]
    likely = sorted(whole, key=lambda c: -_scored(c.effect, c.signature, freed, setup, c.unknown).gain)
    named = {(type(effect), effect.member) for effect in base.effects}
    veiled = [c for c in likely[LOOKED_AT:] if c.share < VEILED] if strayed(problem, base) else []
    others = {kind: None for c in (*likely[:LOOKED_AT], *veiled) if (kind := (type(c.effect), c.effect.member)) not in named}
    return _ranked(problem, base, [*teeth, *others], progress, "candidates beside what is found")


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class _View:
    """Records beside a fit that candidates are measured against, predicted with the very index errors with which candidates are."""

    problem: Problem
    base: Fit
    freed: Freed


def _view(problem: Problem, base: Fit, weights: Array, squares: Array) -> _View:
    point = problem.at(base.effects, base.point.unknown, weights, WEIGHED)
    base = dataclasses.replace(base, point=dataclasses.replace(point, unknown=base.point.unknown), squares=squares)
    return _View(problem=problem, base=base, freed=problem.freed(base.point))


def _ranked(problem: Problem, base: Fit, jobs: list[tuple[type[Effect], Member]], progress: Progress, words: str) -> tuple[Candidate, ...]:
    found: list[Candidate] = []
    weights, squares = base.point.weights, base.squares
    view, slow = _view(problem, base, weights, squares), None
    places = np.flatnonzero([not record.quantity.moving for record in problem.records])
    if len(places):
        slow = _view(problem.part(places), base, weights[places], squares[places])

    def one(job: tuple[type[Effect], Member]) -> list[Candidate]:
        starts = _starts(problem, view.base, *job)
        tried = (_fitted(view, start) if stands(start) else _best(view, slow, start) for start in starts)
        return [candidate for candidate in tried if candidate is not None]

    for number, several in enumerate(side_by_side(one, jobs)):
        progress(words, number, len(jobs))
        found += several
    progress(words, len(jobs), len(jobs))
    return tuple(sorted(found, key=lambda candidate: -candidate.gain))


def _starts(problem: Problem, base: Fit, kind: type[Effect], member: Member) -> list[Effect]:
    """Return the typical effect, on the likeliest teeth where it acts on one."""
    first = kind.example(problem.campaign.setup, member)
    if not hasattr(first, "tooth"):
        return [first]
    gains = tooth_gains(problem, base, first)
    return [dataclasses.replace(first, tooth=int(tooth)) for tooth in np.argsort(-gains)[:TEETH]]  # type: ignore[call-arg]


def tooth_gains(problem: Problem, base: Fit, effect: Effect) -> Array:
    """Return by how much an effect would lower the objective on each tooth of its gear, if the response were linear.

    Parameters
    ----------
    problem, base : Problem, Fit
        As for `rank`.
    effect : Effect
        On any tooth.

    Returns
    -------
    ndarray, shape (z,)

    Notes
    -----
    Teeth are alike but for their scatter: the response of tooth k is that of tooth 0 k pitches later. It is computed once, over one
    turn of the gear, and moved. Slow records are used where there are any.
    """
    pair = problem.campaign.setup.pair
    pitch = pair.pinion.pitch_angle
    teeth = pair.pinion.teeth if effect.member == "pinion" else pair.wheel.teeth
    over = [record.quantity.axis == "angle" for record in problem.records]
    slow = [angle and not record.quantity.moving for angle, record in zip(over, problem.records, strict=True)]
    used = slow if any(slow) else over
    settings = dataclasses.replace(
        base.settings, angle_offset=0.0, pinion_late=np.zeros(pair.pinion.teeth), wheel_late=np.zeros(pair.wheel.teeth)
    )
    grid = np.arange(teeth * PER_PITCH + 1) / PER_PITCH * pitch
    benches = [problem.bench(effects) for effects in ((*base.effects, dataclasses.replace(effect, tooth=0)), base.effects)]  # type: ignore[call-arg]
    responses: list[Array | None] = []
    for record, wanted in zip(problem.records, used, strict=True):
        if not wanted:
            responses.append(None)
            continue
        turn = dataclasses.replace(record, axis=grid, value=grid, line=np.arange(len(grid)), keep=np.ones(len(grid), bool))
        responses.append(benches[0].predict(turn, settings) - benches[1].predict(turn, settings))
    series = []
    for record, response in zip(problem.records, responses, strict=True):
        if response is None:
            series.append(np.zeros((len(record.axis), teeth)))
            continue
        later = (record.axis + base.settings.angle_offset)[:, None] - np.arange(teeth) * pitch
        series.append(np.interp(later % (teeth * pitch), grid, response))
    signatures = problem.whiten(tuple(series))
    gram, pull = problem.freed(base.point)(signatures)
    freed = np.diag(gram)
    return np.asarray(np.where(freed > 0.0, pull**2 / np.maximum(freed, 1e-300), 0.0))


def _best(view: _View, slow: _View | None, start: Effect) -> Candidate | None:
    """Return the effect at the shape, and then the strength, that explain most."""
    setup = view.problem.campaign.setup
    likely = _likeliest(slow, start) if slow is not None else []
    if not likely and _lost(view):
        return _fitted(view, start)
    likely = likely or [(effect, None) for effect in shapes_of(start, setup)]
    candidates = [_candidate(view, effect, unknown) for effect, unknown in likely]
    good = [candidate for candidate in candidates if candidate is not None]
    if not good:
        return None
    best = max(good, key=lambda candidate: candidate.gain)
    for _ in range(REFINED if best.gain > WORTH else 0):
        # Half way from here to where the response would end if it were linear, since it bends.
        strength = best.amplitude if best.amplitude < 1.0 else 0.5 * (1.0 + best.amplitude)
        effect = bounded(best.effect.scaled(min(strength, 3.0), setup), setup)
        other = _candidate(view, effect, best.unknown)
        if other is None or other.gain <= best.gain:
            break
        best = other
    if view.base.effects and best.share < VEILED and strayed(view.problem, view.base):
        fitted = _fitted(view, start)
        return best if fitted is None or fitted.gain <= best.gain else fitted
    return best


def _fitted(view: _View, start: Effect) -> Candidate | None:
    """Return an effect as fits from several places find it: one that cannot be scaled, or that changes motions which are far off anyway."""
    problem, base = view.problem, view.base
    if not any(record.quantity.moving for record in problem.records):
        return None
    lost = _lost(view)
    starts = [
        ((*base.effects, effect), unknown)
        for effect in shapes_of(start, problem.campaign.setup)[:: 1 if lost else 2]
        for unknown in _elsewhere(view, effect) or [base.point.unknown]
    ]
    found = _fits(problem, starts, 2, lost)
    ahead = sorted(found, key=lambda fit: fit.objective)[:2]
    best = min(_fits(problem, [(fit.effects, fit.point.unknown) for fit in ahead], 4, lost), key=lambda fit: fit.objective, default=None)
    if best is None:
        return None
    signature = problem.whiten(tuple(a - b for a, b in zip(best.point.predicted, base.point.predicted, strict=True)))
    if not signature @ signature > 0.0:
        return None
    scored = _scored(best.effects[-1], signature, view.freed, problem.campaign.setup, best.point.unknown)
    return dataclasses.replace(scored, gain=max(base.objective - best.objective, 0.0), amplitude=1.0)


def _lost(view: _View) -> bool:
    """Return whether a fit leaves so much of motions that what is linear about it says little."""
    moving = np.array([record.quantity.moving for record in view.problem.records])
    return bool(moving.any() and (view.base.squares / view.problem.floor)[moving].max() > LOST)


def strayed(problem: Problem, fit: Fit) -> bool:
    """Return whether nuisances of a fit stand where they may do the work of an effect."""
    return bool(np.abs(fit.point.unknown[problem.unknowns.scales]).max(initial=0.0) > STRAYED)


def _fits(problem: Problem, starts: list[tuple[tuple[Effect, ...], Array]], rounds: int, fresh: bool) -> list[Fit]:
    found = []
    for effects, unknown in starts:
        with contextlib.suppress(InputError, SolveError):
            found.append(problem.fit(effects, unknown, rounds, fresh=fresh))
    return found


def _likeliest(slow: _View, start: Effect) -> list[tuple[Effect, Array | None]]:
    """Return the shapes of an effect, and the nuisances, that explain most of the slow records, which cost a hundredth of motions.

    None where slow records are blind to it.
    """
    found = []
    for effect in shapes_of(start, slow.problem.campaign.setup):
        here = _candidate(slow, effect)
        if here is not None:
            others = (_candidate(slow, effect, unknown) for unknown in _elsewhere(slow, effect))
            found += [here, *(other for other in others if other is not None)]
    found.sort(key=lambda candidate: -candidate.gain)
    return [(candidate.effect, candidate.unknown) for candidate in found[:LIKELIEST]]


def _elsewhere(view: _View, effect: Effect) -> list[Array]:
    """Return nuisances other than those of a fit that is far from the records, from which an effect may lead nearer.

    Scales as the model has them, since those of the fit do the work of what is missing; and zeros of the pinion angle as they look with
    the effect in the model, since effects that change all flanks much move the mesh lines.
    """
    problem, base = view.problem, view.base
    if (base.squares / problem.floor).max() < LOST and not (base.effects and strayed(problem, base)):
        return []
    names = [nuisance.name for nuisance in problem.nuisances]
    neutral = problem.unknowns.neutral(base.point.unknown)
    if "angle_offset" not in names or effect.repeats != "every tooth" or effect.stage not in ("flank", "placement"):
        return [neutral]
    place = names.index("angle_offset")
    over = [i for i, record in enumerate(problem.records) if record.quantity.axis == "angle" and not record.quantity.moving]
    if not over:
        return [neutral]
    try:
        effect.check(problem.campaign.setup)
        records, spread = tuple(problem.records[i] for i in over), tuple(problem.noises[i].std for i in over)
        shifts = guess_zero(records, problem.bench((*base.effects, effect)), problem.settings(neutral), spread)
    except (InputError, SolveError):
        return [neutral]
    found = [neutral]
    for shift in shifts:
        unknown = neutral.copy()
        unknown[place] = shift / problem.nuisances[place].prior
        found.append(unknown)
    return found


def _candidate(view: _View, effect: Effect, unknown: Array | None = None) -> Candidate | None:
    """Return how far an effect would explain what a fit leaves; None if it cannot be computed.

    Under the nuisances of the fit its strength is scaled, unless the effect as it stands explains more; under others it is taken so.
    """
    problem, point = view.problem, view.base.point
    setup = problem.campaign.setup
    try:
        effect.check(setup)
        ahead = problem.at((*point.effects, effect), point.unknown if unknown is None else unknown, point.weights)
    except (InputError, SolveError):
        return None
    signature = problem.whiten(tuple(a - b for a, b in zip(ahead.predicted, point.predicted, strict=True)))
    if not signature @ signature > 0.0:
        return None
    candidate = _scored(effect, signature, view.freed, setup, unknown)
    if candidate.share <= 1e-6:
        return None
    # Where the response bends far, as where teeth separate, what it does as it stands tells more than its slope.
    real = point.objective - ahead.objective
    if unknown is None and candidate.gain >= real:
        return candidate
    return dataclasses.replace(candidate, gain=max(real, 0.0), amplitude=1.0)


def _scored(effect: Effect, signature: Array, freed: Freed, setup: Setup, unknown: Array | None = None) -> Candidate:
    """Return a candidate with its gain against what is left, each strength scaled on its own."""
    gram, pulls = freed(signature[:, None])
    square, pull = max(float(gram[0, 0]), 1e-300), float(pulls[0])
    known = next((effect.parameters()[field] for field in effect.strengths()), None)
    signed = known is not None and known.bounds(setup, effect.member)[0] < known.at_rest(setup, effect.member)
    return Candidate(
        effect=effect,
        gain=pull**2 / square if pull > 0.0 or signed else 0.0,
        amplitude=pull / square,
        signature=signature,
        visible=math.sqrt(square),
        share=math.sqrt(square / float(signature @ signature)),
        unknown=unknown,
    )


def together(problem: Problem, base: Fit, candidates: Iterable[Candidate]) -> float:
    """Return by how much several candidates together would lower the objective, if the response were linear."""
    signatures = np.column_stack([candidate.signature for candidate in candidates])
    gram, pull = problem.freed(base.point)(signatures)
    return float(pull @ np.linalg.lstsq(gram, pull, rcond=1e-10)[0])
