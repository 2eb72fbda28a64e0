"""Rank the effects of the catalogue by what they would explain, linear about the nuisances alone."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping

import numpy as np

from gearfem.definition.setup import Member, Setup
from gearfem.diagnosis.fit import Fit
from gearfem.diagnosis.problem import Freed, Problem
from gearfem.diagnosis.side_by_side import side_by_side
from gearfem.effects.effect import MEMBERS, Effect, Parameter
from gearfem.foundation import Array, InputError, Record, SolveError
from gearfem.foundation.progress import Progress, quiet

# Further strengths at which an effect of all teeth is tried, as multiples of the typical one.
DEEP, WIDE = (4.0, 16.0), (0.4, 2.5)
# Rounds in which the strength of a candidate is improved.
REFINED = 2
# Angles to the pitch at which the response of a tooth is taken before it is moved.
PER_PITCH = 48
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
    """

    effect: Effect
    gain: float
    amplitude: float
    signature: Array
    visible: float
    share: float

    def start(self, setup: Setup) -> Effect:
        """Return the effect at the strength that would lower the objective most, within its bounds."""
        return _bounded(self.effect.scaled(min(max(self.amplitude, -3.0), 3.0), setup), setup)

    @property
    def label(self) -> tuple[str, str, int]:
        """Name, gear and tooth; -1 where it has none."""
        return self.effect.name, getattr(self.effect, "gear", ""), getattr(self.effect, "tooth", -1)


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
    found: list[Candidate] = []
    freed = problem.freed(base.point)
    jobs = [(kind, member) for kind in kinds.values() for member in (MEMBERS if kind.of_one_gear() else MEMBERS[:1])]

    def one(job: tuple[type[Effect], Member]) -> list[Candidate]:
        starts = _starts(problem, base, *job)
        return [best for start in starts if (best := _best(problem, base, freed, start)) is not None]

    for number, several in enumerate(side_by_side(one, jobs)):
        progress("candidates", number, len(jobs))
        found += several
    progress("candidates", len(jobs), len(jobs))
    return tuple(sorted(found, key=lambda candidate: -candidate.gain))


def rank_again(problem: Problem, base: Fit, candidates: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """Return candidates in the order of what they would explain beside effects that have been fitted.

    Parameters
    ----------
    problem, base : Problem, Fit
        The fit with effects.
    candidates : tuple of Candidate
        From `rank` for the nuisances alone.

    Returns
    -------
    tuple of Candidate
        Their signatures are those of the model without effects, except that effects of one tooth are tried on all teeth again.
    """
    freed = problem.freed(base.point)
    found: list[Candidate] = []
    for kind, member in {(type(c.effect), c.effect.member): None for c in candidates if hasattr(c.effect, "tooth")}:
        starts = _starts(problem, base, kind, member)
        found += [candidate for start in starts if (candidate := _candidate(problem, base, freed, start))]
    for candidate in candidates:
        if not hasattr(candidate.effect, "tooth"):
            found.append(_scored(candidate.effect, candidate.signature, freed, problem.campaign.setup))
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


def _best(problem: Problem, base: Fit, freed: Freed, start: Effect) -> Candidate | None:
    """Return the effect at the shape, and then the strength, that explain most."""
    candidates = [_candidate(problem, base, freed, effect) for effect in _shapes(start, problem.campaign.setup)]
    good = [candidate for candidate in candidates if candidate is not None]
    if not good:
        return None
    best = max(good, key=lambda candidate: candidate.gain)
    setup = problem.campaign.setup
    for _ in range(REFINED):
        # Half way from here to where the response would end if it were linear, since it bends.
        strength = best.amplitude if best.amplitude < 1.0 else 0.5 * (1.0 + best.amplitude)
        other = _candidate(problem, base, freed, _bounded(best.effect.scaled(min(strength, 3.0), setup), setup))
        if other is None or other.gain <= best.gain:
            break
        best = other
    return best


def _bounded(effect: Effect, setup: Setup) -> Effect:
    """Return an effect whose strengths are moved into their bounds."""
    changes = {}
    for field in effect.strengths():
        low, high = effect.parameters()[field].bounds(setup, effect.member)
        changes[field] = min(max(getattr(effect, field), low), high)
    return dataclasses.replace(effect, **changes)


def _shapes(effect: Effect, setup: Setup) -> list[Effect]:
    """Return the effect with all combinations of the parameters that say where and how it acts."""
    fields = [field for field, known in effect.parameters().items() if known.neutral is None]
    options = [tries(known, setup, effect) for known in (effect.parameters()[field] for field in fields)]
    shapes = [dataclasses.replace(effect, **dict(zip(fields, values, strict=True))) for values in itertools.product(*options)]
    if effect.repeats == "one tooth" or not effect.strengths():
        return shapes
    # Far from typical sizes the response is not that of the typical one, scaled.
    sizes = DEEP if effect.stage == "flank" else WIDE
    return shapes + [_bounded(effect.scaled(size, setup), setup) for size in sizes]


def tries(known: Parameter, setup: Setup, effect: Effect) -> tuple[float, ...]:
    """Return values at which a parameter that says where or how is tried."""
    low, high = known.bounds(setup, effect.member)
    typical = known.typically(setup, effect.member)
    if known.unit == "rad":
        return tuple(math.pi * third for third in (-2.0 / 3.0, 0.0, 2.0 / 3.0))
    if low > 0.0 and high / low > 1e3:
        # Orders: whole ones first of all.
        return tuple(float(order) for order in (1, 2, 3, 4, 5)) if typical >= 1.0 else (typical,)
    return tuple(sorted({min(max(share * typical, low), high) for share in (0.5, 1.0, 1.8)}))


def _candidate(problem: Problem, base: Fit, freed: Freed, effect: Effect) -> Candidate | None:
    """Return how far an effect would explain what a fit leaves, each strength scaled on its own; None if it cannot be computed."""
    setup, point = problem.campaign.setup, base.point
    try:
        effect.check(setup)
        moved = problem.predict((*point.effects, effect), point.unknown)
    except (InputError, SolveError):
        return None
    signature = problem.whiten(tuple(a - b for a, b in zip(moved, point.predicted, strict=True)))
    if not signature @ signature > 0.0:
        return None
    candidate = _scored(effect, signature, freed, setup)
    if candidate.share <= 1e-6:
        return None
    # Where the response bends far, as where teeth separate, what it does as it stands tells more than its slope.
    real = point.objective - problem.value(moved, point)
    return dataclasses.replace(candidate, gain=real, amplitude=1.0) if real > candidate.gain else candidate


def _scored(effect: Effect, signature: Array, freed: Freed, setup: Setup) -> Candidate:
    """Return a candidate with its gain against what is left."""
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
    )


def together(problem: Problem, base: Fit, candidates: Iterable[Candidate]) -> float:
    """Return by how much several candidates together would lower the objective, if the response were linear."""
    signatures = np.column_stack([candidate.signature for candidate in candidates])
    gram, pull = problem.freed(base.point)(signatures)
    return float(pull @ np.linalg.lstsq(gram, pull, rcond=1e-10)[0])
