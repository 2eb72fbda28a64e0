"""Where fits begin: slow records by themselves, then the resonances of motions."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
from collections.abc import Callable, Iterator, Sequence

from gearfem.diagnosis.fitting.fit import ROUNDS, Fit, attempt
from gearfem.diagnosis.fitting.point import Point
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.bench import Settings, neutral
from gearfem.diagnosis.modelling.unknowns import unknowns_of
from gearfem.diagnosis.modelling.zero import guess_zero
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, Array
from gearfem.foundation.side_by_side import side_by_side

# Tip edges to start from, of the model's, and how far contact over them is that of flanks; compliance in series and damping to start from,
# in prior deviations.
EDGES = ((1.0, 0.0), (0.2, 1.0))
SERIES_TRIED, DAMPING_TRIED = (-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0), (-1.5, 0.0, 1.5)
# Times that the fit of slow records, a place to start from, is prepared anew.
TIMES = 4
# Rounds in which a fit shows the noise, and which sign and zero suit the records.
ROUGH = 3
# What a fit leaves of a record, over what can be expected, beyond which it may stand in the wrong place.
FAR_OFF = 5.0


def lost(problem: Problem, fit: Fit) -> bool:
    """Return whether a fit is so far from a record that it may stand in the wrong place."""
    return bool((fit.squares / problem.floor).max() > FAR_OFF)


def moves_otherwise(problem: Problem, base: Fit, effects: tuple[Effect, ...]) -> bool:
    """Return whether effects change motions, or how these are read, beside a fit far from the records: columns are then those under them.

    All that index errors and errors of the model do to a motion goes through its resonances and the instrument. A fit that is lost goes by
    these far, and columns from where it stands lead others astray.
    """
    return lost(problem, base) and any(effect.repeats == "not periodic" for effect in effects if effect not in base.effects)


def fit_from(problem: Problem, start: Settings, rounds: int = ROUNDS, effects: tuple[Effect, ...] = ()) -> Fit:
    """Return the fit of effects, or of the nuisances alone, from settings on, where their derivatives are taken."""
    return problem.fit(effects, problem.prepare(effects, problem.unknowns.of(start)), rounds)


def from_zeros(
    problem: Problem, rounds: int, effects: tuple[Effect, ...] = (), allowed: Callable[[float], bool] = lambda zero: True
) -> Iterator[Fit]:
    """Yield fits from the model as it is, where the zero of the pinion angle is unknown from the likeliest ones that are allowed.

    Those that cannot be computed are passed over.
    """
    level = neutral(problem.campaign.setup.pair)
    zeros = [level.angle_offset]
    if "angle_offset" in problem.unknowns.places:
        zeros = guess_zero(problem.records, problem.bench(effects), level, tuple(noise.std for noise in problem.noises))
    for zero in filter(allowed, zeros):
        with contextlib.suppress(*UNCOMPUTABLE):
            yield fit_from(problem, dataclasses.replace(level, angle_offset=zero), rounds, effects)


def part_of(problem: Problem, places: Sequence[int], effects: tuple[Effect, ...] = ()) -> Problem:
    """Return the problem of the records at some places alone, with the nuisances that these can feel, under known effects; not prepared."""
    records, noises = tuple(problem.records[i] for i in places), tuple(problem.noises[i] for i in places)
    own = problem.unknowns
    # Problems of single teeth have no nuisances, whatever the records could feel.
    unknowns = unknowns_of(problem.campaign, records, own.scatter, own.errors, None if own.nuisances else (), own.level)
    part = Problem(problem.campaign, records, noises, bench=problem.make, unknowns=unknowns, known=(*problem.known, *effects))
    part.wander, part.least = problem.wander, problem.least
    part.floor, part.counts = problem.floor[list(places)], problem.counts[list(places)]
    return part


def at_rest(problem: Problem, level: Settings) -> Settings:
    """Return settings as slow records have them, from tip edges as the model has them or as models without any; else those given.

    They say what motions, which hide it near resonances, do not: where pairs hand over, and by how much teeth and bodies yield.
    """
    slow = [i for i, record in enumerate(problem.records) if not record.quantity.moving and not record.quantity.of_gear]
    if not slow:
        return level
    part = part_of(problem, slow)
    starts = [part.unknowns.of(dataclasses.replace(level, tip_edge_scale=edge, evenness=evenness)) for edge, evenness in EDGES]

    found = [fit for fit in side_by_side(lambda unknown: attempt(part, (), unknown, TIMES), starts) if fit is not None]
    return min(found, key=lambda fit: fit.objective).settings if found else level


def tuned(problem: Problem, unknown: Array, effects: tuple[Effect, ...] = ()) -> Array:
    """Return unknowns with the compliance in series and the damping, among a few of each, under which motions leave least.

    The misfit of a resonance has a minimum wherever one of its lines meets one of the record's: no descent leaves a wrong one.
    """
    own = problem.unknowns.places
    if not {"series_compliance", "damping_scale"} <= set(own):
        return unknown
    places = [own["series_compliance"], own["damping_scale"]]

    def one(moved: tuple[float, float]) -> Point | None:
        tried = unknown.copy()
        tried[places] = moved
        with contextlib.suppress(*UNCOMPUTABLE):
            return problem.at(effects, tried)
        return None

    found = side_by_side(one, list(itertools.product(SERIES_TRIED, DAMPING_TRIED)))
    best = min([problem.at(effects, unknown), *(point for point in found if point)], key=lambda point: point.objective)
    return best.unknown


def unwound(problem: Problem, effects: tuple[Effect, ...], unknown: Array) -> list[Array]:
    """Return unknowns with zeros of the pinion angle as slow records look with effects in the model; none where these move no mesh lines.

    Effects that change all flanks much do: the zero that suited the records without them is a pitch or half of one off.
    """
    place = problem.unknowns.places.get("angle_offset")
    moves = any(effect.repeats == "every tooth" and effect.stage in ("flank", "placement") for effect in effects)
    over = [i for i, record in enumerate(problem.records) if record.quantity.axis == "angle" and not record.quantity.moving]
    if not (moves and over) or place is None:
        return []
    try:
        for effect in effects:
            effect.check(problem.campaign.setup)
        records, spread = tuple(problem.records[i] for i in over), tuple(problem.noises[i].std for i in over)
        shifts = guess_zero(records, problem.bench(effects), problem.settings(unknown), spread)
    except UNCOMPUTABLE:
        return []
    found = []
    for shift in shifts:
        turned = unknown.copy()
        turned[place] = shift / problem.nuisances[place].prior
        found.append(turned)
    return found
