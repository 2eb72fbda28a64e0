"""Which of several steady motions a record shows: flanks that part may go on doing so, and nobody noted how a rig came to its speed."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.foundation import UNCOMPUTABLE, Array

# Beginnings that are tried: lag and rate of `march_turns`.
KICKS = ((0.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (-3.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.0, 3.0), (0.0, -3.0))
# How far off a motion is, in parts of what can be expected, before others are tried; and the part of what it leaves that one may:
# half of its square. Where flanks part for some pitches only, the right beginning leaves more than half of it until the fit has followed.
FAR, NEARER = 3.0, 0.7
# Where a motion goes over to another one: parts of a record before and behind which that is none, pitches to either side that it takes, and
# the least part of the record that is left to look at.
EDGE, TURNED, LONG = 0.1, 4.0, 0.3

Kick = tuple[float, float]


def nearest(record: Measurement, far: float, here: Array, left: Callable[[Measurement], Array], pitch: float | None = None) -> Measurement:
    """Return a record with the beginning of its motion from which the model comes nearest to it.

    Parameters
    ----------
    record : Measurement
        Any record; one that is no motion over the angle, or is met as it begins, is returned as it is.
    far : float
        Root mean square from which on it is not met [SI].
    here : ndarray, shape (n,)
        What the model leaves of it as it begins.
    left : callable
        Takes the record with another beginning and returns the same.
    pitch : float, optional
        Angular pitch of the pinion [rad], where a record that shows one motion first and then another may be cut: see below.

    Returns
    -------
    Measurement
        Shorter than the record where it is cut.

    Notes
    -----
    Near resonances a pair with backlash has several steady motions under one load, with flanks in contact and apart, and of those that come
    back after two or three pitches as many again. Another one than that from rest is taken only if it leaves half of the square. Single
    teeth may lead from one to another amid a record: where one before some row and another one from there on leave half of the square that
    the nearest leaves alone, the longer part is a record of one motion, less four pitches in which it rings down.
    """
    if not record.quantity.is_motion or record.rms(here) < far:
        return record
    tried: dict[Kick, Array] = {record.kick: here}
    for kick in (kick for kick in KICKS if kick != record.kick):
        # What cannot be computed from one beginning may be from another.
        with contextlib.suppress(*UNCOMPUTABLE):
            tried[kick] = left(dataclasses.replace(record, kick=kick))
    best = min(tried, key=lambda kick: record.rms(tried[kick]))
    part = None if pitch is None else _longer_part(record, tried, NEARER * record.rms(tried[best]), pitch)
    if part is not None:
        return part
    return dataclasses.replace(record, kick=best) if record.rms(tried[best]) < NEARER * record.rms(here) else record


def _longer_part(record: Measurement, tried: Mapping[Kick, Array], limit: float, pitch: float) -> Measurement | None:
    """Return the longer part of a record that two motions, one after the other, leave less than a limit of; None where none do."""
    rows, kicks = len(record.axis), list(tried)
    series = np.array([np.where(record.keep, tried[kick], 0.0) for kick in kicks])
    used = np.count_nonzero(record.keep)
    apart = np.sqrt(((series[:, None] - series[None]) ** 2).sum(axis=2) / used) > limit
    free = record.quantity.free_constant
    head, tail = _squares(series, record.keep, free), _squares(series[:, ::-1], record.keep[::-1], free)[:, ::-1]
    edge = int(EDGE * rows)
    both = np.where(apart[:, :, None], head[:, None] + tail[None], np.inf)[:, :, edge : rows - edge]
    first, second, place = (int(number) for number in np.unravel_index(np.argmin(both), both.shape))
    if not np.sqrt(both[first, second, place] / used) < limit:
        return None
    at = record.axis[place + edge]
    before, behind = record.axis < at - TURNED * pitch, record.axis > at + TURNED * pitch
    here, chosen = (before, first) if before.sum() > behind.sum() else (behind, second)
    if here.sum() < LONG * rows:
        return None
    own = {name: getattr(record, name)[here] for name in ("axis", "value", "line", "keep")}
    # Of beginnings that lead to one motion the first one tells it.
    return dataclasses.replace(record, kick=kicks[int(np.argmin(apart[chosen]))], **own)


def _squares(series: Array, keep: NDArray[Any], free: bool) -> Array:
    """Return the sums of squares of series (k, n) before each row, (k, n + 1), less those of their means where their constant is free."""
    total = np.cumsum(series**2, axis=1)
    if free:
        total = total - np.cumsum(series, axis=1) ** 2 / np.maximum(np.cumsum(keep), 1)
    return np.pad(np.maximum(total, 0.0), ((0, 0), (1, 0)))
