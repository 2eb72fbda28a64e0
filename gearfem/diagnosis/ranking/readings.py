"""Effects of an instrument: resonances and delays at which they would explain most."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from gearfem.diagnosis.ranking.candidate import View
from gearfem.diagnosis.ranking.shapes import FREQUENCIES, spread_of
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.effects.effect import Effect
from gearfem.foundation import Array
from gearfem.sensing import Instrument
from gearfem.sensing.motion import RINGING_ANGLES

# Natural frequencies that are tried, closer to each other than the narrowest peak is wide; and multiples of the typical ratio.
COUNT, RATIOS = 80, (0.3, 1.0, 3.0)
# Delays that are tried up to the shortest time between two pairs of teeth: what all teeth share comes back with that.
PARTS = 64
# Effects that are looked at further, by what their frequencies differ at least, and of the shortest time between pairs their delays;
# pitches before a record in which resonances swing in.
LIKELIEST, APART, LATER, BEFORE = 3, 1.25, 0.25, 300


class Tried(NamedTuple):
    """An effect that is tried, and where it stands among the others: those less than 1 apart do about the same."""

    place: float
    effect: Effect


def likeliest_readings(view: View, start: Effect) -> list[Effect]:
    """Return the effects on the instrument that would explain most, the best first.

    Parameters
    ----------
    view : View
        Records beside a fit; those of motions over the angle are used.
    start : Effect
        One that changes the instrument alone, by a natural frequency or a delay.

    Returns
    -------
    list of Effect
        At most `LIKELIEST`; shapes over all sizes (`spread_of`) where there is no such record, or neither a frequency nor a delay.

    Notes
    -----
    What an instrument makes of a motion does not change the motion: one prediction of each record, from where all resonances tried have
    forgotten how they began, serves all of them. Nothing is scaled: a resonance has no strength, and a delay of most of a pitch does what
    an earlier reading would. It gains what it gains as it stands.
    """
    problem, setup = view.problem, view.problem.campaign.setup
    follows = [record.quantity.is_motion for record in problem.records]
    tried = _tried(view, start) if any(follows) else []
    if not tried:
        return spread_of(start, setup)
    instruments = [effect.acted(Instrument(), setup) for _, effect in tried]
    added = tuple(
        _added(view, record, instruments) if follow else np.zeros((len(record.axis), len(tried)))
        for record, follow in zip(problem.records, follows, strict=True)
    )
    gram, pull = view.freed(problem.whiten(added))
    gains = 2.0 * pull - np.diag(gram)
    found: list[Tried] = []
    # Where none gains, the first one tells what the records would show of it.
    for number in np.argsort(-gains)[: max(np.count_nonzero(gains > 0.0), 1)]:
        one = tried[number]
        if len(found) < LIKELIEST and all(abs(one.place - other.place) > 1.0 for other in found):
            found.append(one)
    return [effect for _, effect in found]


def _tried(view: View, start: Effect) -> list[Tried]:
    """Return the effects that are tried; none where the effect changes neither a frequency nor a delay of the instrument."""
    known = start.parameters()
    for field in known:
        if known[field].reciprocal:
            return _resonances(start, field)
    late = [field for field in start.strengths() if known[field].unit == "s"]
    return _delays(view, start, late[0]) if late else []


def _resonances(start: Effect, frequency: str) -> list[Tried]:
    others = [field for field in start.parameters() if field != frequency]
    found = []
    for value, *shares in itertools.product(np.geomspace(*FREQUENCIES, COUNT).tolist(), *([RATIOS] * len(others))):
        changes = {field: share * getattr(start, field) for field, share in zip(others, shares, strict=True)}
        found.append(Tried(math.log(value) / math.log(APART), dataclasses.replace(start, **{frequency: value, **changes})))
    return found


def _delays(view: View, start: Effect, delay: str) -> list[Tried]:
    problem = view.problem
    fastest = max(record.pinion_speed for record in problem.records if record.quantity.is_motion)
    shortest = problem.campaign.setup.pair.pinion.pitch_angle / fastest
    within = [dataclasses.replace(start, **{delay: part * shortest}) for part in (np.arange(1, PARTS + 1) / PARTS).tolist()]
    return [Tried(getattr(effect, delay) / (LATER * shortest), effect) for effect in (*within, *spread_of(start, problem.campaign.setup))]


def _added(view: View, record: Measurement, instruments: list[Instrument]) -> Array:
    """Return what each of k instruments, all with resonances or all with delays, adds to a record [SI], shape (n, k)."""
    problem, point, speed = view.problem, view.base.point, record.pinion_speed
    pitch = problem.campaign.setup.pair.pinion.pitch_angle
    longest = max(max(instrument.settling, instrument.delay) for instrument in instruments)
    before = min(math.ceil(speed * longest / pitch), BEFORE)
    first, last = math.floor(record.axis.min() / pitch) - 1, math.ceil(record.axis.max() / pitch) + 1
    grid = np.arange((first - before) * RINGING_ANGLES, last * RINGING_ANGLES) / RINGING_ANGLES * pitch
    reading = problem.bench(point.effects).predict(record.over(grid), problem.settings(point.stood))
    if instruments[0].resonances:
        step, kept = pitch / RINGING_ANGLES / speed, before * RINGING_ANGLES
        series = [instrument.ringing(reading, step)[kept:] for instrument in instruments]
        return np.asarray(CubicSpline(grid[kept:], np.stack(series, axis=1))(record.axis))
    read, delays = CubicSpline(grid, reading), np.array([instrument.delay for instrument in instruments])
    return np.asarray(read(record.axis[:, None] - speed * delays) - read(record.axis)[:, None])
