"""Encoders write hundreds of rows to a pitch: of campaigns of very many rows, which are used."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.reading.faults import Fault
from gearfem.diagnosis.reading.measurement import Measurement

# Rows of a campaign from which on some are passed over, and those to a pitch that are left in any case: a mean has 48 places.
MANY, PLENTY = 40_000, 48


def thinned(records: list[Measurement], pair: GearPair) -> tuple[list[Measurement], list[Fault]]:
    """Return records of which every second, third, ... row over the angle is left where they have very many, and what is said of that.

    Rows are left as they were read, not averaged: a mean over neighbours rounds off where pairs hand over, as a relief does.
    """
    among = math.ceil(sum(len(record.axis) for record in records) / MANY)
    found, remarks = [], []
    for record in records:
        step = min(among, _to_a_pitch(record, pair) // PLENTY)
        if step > 1:
            rows = _first_good(record, step)
            said = f"one of {step} rows is used, {len(rows)} of {len(record.axis)}: the campaign has more than {MANY}"
            remarks.append(Fault(record=record.file, kind="thinned", rows=(), sentence=said))
            record = dataclasses.replace(record, **{name: getattr(record, name)[rows] for name in ("axis", "value", "line", "keep")})
        found.append(record)
    return found, remarks


def _to_a_pitch(record: Measurement, pair: GearPair) -> int:
    if record.quantity.axis != "angle" or len(record.axis) < 2:
        return 0
    return int((len(record.axis) - 1) * pair.pinion.pitch_angle / (record.axis[-1] - record.axis[0]))


def _first_good(record: Measurement, step: int) -> NDArray[Any]:
    """Return the first row of every `step` that no fault masks; the first one where all are masked."""
    keep = np.zeros(math.ceil(len(record.axis) / step) * step, bool)
    keep[: len(record.keep)] = record.keep
    return np.asarray(np.arange(0, len(keep), step) + np.argmax(keep.reshape(-1, step), axis=1))
