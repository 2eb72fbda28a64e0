"""Which of several steady motions a record shows: flanks that part may go on doing so, and nobody noted how a rig came to its speed."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable

from gearfem.diagnosis.measurement import Measurement
from gearfem.foundation import Array, InputError, SolveError

# Beginnings that are tried: lag and rate of `march_turns`.
KICKS = ((0.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (-3.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.0, 3.0), (0.0, -3.0))
# How far off a motion is, in parts of what can be expected, before others are tried; and the part of what it leaves that one may:
# half of its square. Where flanks part for some pitches only, the right beginning leaves more than half of it until the fit has followed.
FAR, NEARER = 3.0, 0.7


def nearest(record: Measurement, far: float, here: Array, left: Callable[[Measurement], Array]) -> Measurement:
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

    Notes
    -----
    Near resonances a pair with backlash has several steady motions under one load, with flanks in contact and apart, and of those that come
    back after two or three pitches as many again. Another one than that from rest is taken only if it leaves half of the square.
    """
    if not record.quantity.is_motion or record.rms(here) < far:
        return record
    found, best = record, NEARER * record.rms(here)
    for kick in (kick for kick in KICKS if kick != record.kick):
        # What cannot be computed from one beginning may be from another.
        with contextlib.suppress(InputError, SolveError):
            one = dataclasses.replace(record, kick=kick)
            if (rest := record.rms(left(one))) < best:
                found, best = one, rest
    return found
