"""Resonances of an instrument: the frequencies and damping ratios at which they would explain most."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
from scipy.interpolate import CubicSpline

from gearfem.diagnosis.candidate import View
from gearfem.diagnosis.measurement import Measurement
from gearfem.diagnosis.shapes import FREQUENCIES, shapes_of
from gearfem.effects.effect import Effect
from gearfem.foundation import Array
from gearfem.sensing import Instrument
from gearfem.sensing.motion import RINGING_ANGLES

# Natural frequencies that are tried, closer to each other than the narrowest peak is wide; and multiples of the typical ratio.
COUNT, RATIOS = 80, (0.3, 1.0, 3.0)
# Resonances that are looked at further, and by what their frequencies differ at least; pitches before a record in which they swing in.
LIKELIEST, APART, BEFORE = 3, 1.25, 300


def rung(view: View, start: Effect) -> list[Effect]:
    """Return the resonances that would explain most, the best first.

    Parameters
    ----------
    view : View
        Records beside a fit; those of motions over the angle are used.
    start : Effect
        One that changes the instrument alone, with a natural frequency.

    Returns
    -------
    list of Effect
        At most `LIKELIEST`; a few over all frequencies where there is no such record.

    Notes
    -----
    What an instrument makes of a motion does not change the motion: one prediction of each record, from where all resonances tried have
    forgotten how they began, serves all of them. A resonance has no strength: it gains what it gains as it stands.
    """
    problem, tried = view.problem, _resonances(start)
    follows = [record.quantity.is_motion for record in problem.records]
    if not any(follows):
        return shapes_of(start, problem.campaign.setup)
    instruments = [effect.act(Instrument(), problem.campaign.setup) for _, effect in tried]
    added = tuple(
        _added(view, record, instruments) if follow else np.zeros((len(record.axis), len(tried)))
        for record, follow in zip(problem.records, follows, strict=True)
    )
    gram, pull = view.freed(problem.whiten(added))
    gains = 2.0 * pull - np.diag(gram)
    found: list[tuple[float, Effect]] = []
    for place in np.argsort(-gains)[: np.count_nonzero(gains > 0.0)]:
        frequency, effect = tried[place]
        if len(found) < LIKELIEST and all(abs(math.log(frequency / other)) > math.log(APART) for other, _ in found):
            found.append((frequency, effect))
    return [effect for _, effect in found]


def _resonances(start: Effect) -> list[tuple[float, Effect]]:
    """Return the frequencies and effects that are tried."""
    known = start.parameters()
    (frequency,) = (field for field, one in known.items() if one.reciprocal)
    others = [field for field in known if field != frequency]
    found = []
    for value, *shares in itertools.product(np.geomspace(*FREQUENCIES, COUNT).tolist(), *([RATIOS] * len(others))):
        changes = {field: share * getattr(start, field) for field, share in zip(others, shares, strict=True)}
        found.append((value, dataclasses.replace(start, **{frequency: value, **changes})))
    return found


def _added(view: View, record: Measurement, instruments: list[Instrument]) -> Array:
    """Return what each of k instruments adds to a record [SI], shape (n, k)."""
    problem, point = view.problem, view.base.point
    pitch = problem.campaign.setup.pair.pinion.pitch_angle
    longest = max(instrument.settling for instrument in instruments)
    before = min(math.ceil(record.pinion_speed * longest / pitch), BEFORE)
    first, last = math.floor(record.axis.min() / pitch) - 1, math.ceil(record.axis.max() / pitch) + 1
    grid = np.arange((first - before) * RINGING_ANGLES, last * RINGING_ANGLES) / RINGING_ANGLES * pitch
    reading = problem.bench(point.effects).predict(record.over(grid), problem.settings(point.stood))
    step, kept = pitch / RINGING_ANGLES / record.pinion_speed, before * RINGING_ANGLES
    series = [instrument.ringing(reading, step)[kept:] for instrument in instruments]
    return np.asarray(CubicSpline(grid[kept:], np.stack(series, axis=1))(record.axis))
