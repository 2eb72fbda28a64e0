"""How the mean over the pitches of a motion changes, from its first few: each pitch meets other teeth, but all change nearly alike."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.campaign import Measurement
from gearfem.foundation import Array, Record

# Places of the pitch between which a mean over pitches runs in straight lines.
PLACES = 48
# Pitches that are looked at, rows among them to each place at least, and the share of a record from which on all of it is.
PITCHES, ROWS, WORTH = 20, 4, 0.67
# What is added to the rows at each place, so that one which none of them meets stands still.
RIDGE = 1e-3


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Seen(Record):
    """A record, and the rows of it that changes are read from: all of them, or for its mean those of the first pitches.

    Parameters
    ----------
    whole, rows : Measurement
        All n rows, and m of them.
    lines : sparse array, shape (n, places), optional
        What each row of the whole record takes of the places of the pitch; None where all rows are looked at.
    inverse : ndarray, shape (places, m), optional
        What each place takes of the rows that are looked at.
    """

    whole: Measurement
    rows: Measurement
    lines: Any = None
    inverse: Array | None = None

    @property
    def in_part(self) -> bool:
        """Whether not all rows are looked at."""
        return self.inverse is not None

    def spread(self, change: Array) -> Array:
        """Return a change of the rows that are looked at, shapes (m,) or (m, k), in all rows: (n,) or (n, k)."""
        return change if self.inverse is None else np.asarray(self.lines @ (self.inverse @ change))


def by_all(record: Measurement) -> Seen:
    """Return a record of which all rows are looked at."""
    return Seen(whole=record, rows=record)


def by_first(record: Measurement, pair: GearPair) -> Seen:
    """Return a record whose mean over the pitches is read from the first ones: of motions, which cost most, and are met less closely.

    From all where these are few, or the rows far apart.
    """
    if record.quantity.axis != "angle" or not record.quantity.moving:
        return by_all(record)
    along = record.axis - record.axis.min()
    rows_to_pitch = len(along) / max(float(along.max()) / pair.pinion.pitch_angle, 1.0)
    pitches = max(PITCHES, math.ceil(ROWS * PLACES / rows_to_pitch))
    first = np.flatnonzero(along < pitches * pair.pinion.pitch_angle)
    if len(first) > WORTH * len(along):
        return by_all(record)
    lines = lines_of(record, pair)
    own = lines[first]
    inverse = np.asarray(np.linalg.solve(own.T @ own + RIDGE * np.eye(PLACES), own.T), np.float64)
    return Seen(whole=record, rows=record.at(first), lines=csr_array(lines), inverse=inverse)


def lines_of(record: Measurement, pair: GearPair) -> Array:
    """Return what each row of a record takes of the places of the pitch between which a mean runs in straight lines, shape (n, places)."""
    place = record.axis / pair.pinion.pitch_angle * PLACES
    first = np.floor(place).astype(int)
    share, rows = place - first, np.arange(len(place))
    lines = np.zeros((len(place), PLACES))
    lines[rows, first % PLACES] += 1.0 - share
    lines[rows, (first + 1) % PLACES] += share
    return lines
