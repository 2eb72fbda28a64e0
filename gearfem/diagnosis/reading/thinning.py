"""Encoders write hundreds of rows to a pitch, and rigs turn for hours: of campaigns of very many rows, which are used."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.reading.faults import Fault
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.periods import hunting_period, nearest_rows

# Rows of a campaign from which on not all are used, and those to a pitch that are left in any case: a mean has 48 places.
MANY, PLENTY = 40_000, 48
# Hunting cycles that are left, one to compare with another. Rows of two cycles are at the same angle where they are apart by such a part of
# the way to the next row, and cycles have the same rows where such a share of them are: single ones may be missing.
CYCLES, SAME, MOST = 2, 0.05, 0.99


def thinned(records: list[Measurement], pair: GearPair) -> tuple[list[Measurement], list[Fault]]:
    """Return records of fewer rows where a campaign has very many, and what is said of that.

    Parameters
    ----------
    records : list of Measurement
        All of the campaign.
    pair : GearPair
        The gears, for pitches and hunting cycles.

    Returns
    -------
    list of Measurement
        Over more than two hunting cycles their mean, where each has its rows at the same angles, else the first two; then, where these are
        still very many, every second, third, ... row of dense records.
    list of Fault
        What was done to which.

    Notes
    -----
    No row is moved, and neighbours are not averaged: that rounds off where pairs hand over, as a relief does.
    """
    remarks: list[Fault] = []
    for fewer in (_of_fewer_cycles, _of_fewer_rows):
        among = math.ceil(sum(len(record.axis) for record in records) / MANY)
        if among > 1:
            done = [fewer(one, pair, among) if one.quantity.axis == "angle" and len(one.axis) > 1 else (one, "") for one in records]
            records = [record for record, _ in done]
            since = f"since the campaign has more than {MANY}"
            remarks += [Fault(record=one.file, kind="thinned", rows=(), sentence=f"{said}, {since}") for one, said in done if said]
    return records, remarks


def _of_fewer_cycles(record: Measurement, pair: GearPair, _: int) -> tuple[Measurement, str]:
    axis, period, whole = record.axis, hunting_period(pair), len(record.axis)
    step = float(np.median(np.diff(axis)))
    near_enough = SAME * step
    # The row that would close the last cycle is the first one of another.
    cycles = int((axis[-1] - axis[0] + step + near_enough) / period)
    if cycles <= CYCLES:
        return record, ""
    rows = int(np.searchsorted(axis, axis[0] + period - near_enough))
    places = axis[:rows] + period * np.arange(cycles)[:, None]
    near = nearest_rows(axis, places.ravel()).reshape(places.shape)
    same = np.abs(axis[near] - places) < near_enough
    if same.mean() < MOST:
        record = _at(record, np.arange(np.searchsorted(axis, axis[0] + CYCLES * period)))
        return record, f"the first {CYCLES} of {cycles} hunting cycles are used, {len(record.axis)} of {whole} rows"
    used = same & record.keep[near]
    count = used.sum(axis=0)
    value = np.where(used, record.value[near], 0.0).sum(axis=0) / np.maximum(count, 1)
    noise = record.noise_std and record.noise_std / math.sqrt(cycles)
    record = dataclasses.replace(_at(record, np.arange(rows)), value=value, keep=count > 0, noise_std=noise)
    return record, f"the mean of {cycles} hunting cycles is taken, {rows} of {whole} rows"


def _of_fewer_rows(record: Measurement, pair: GearPair, among: int) -> tuple[Measurement, str]:
    whole = len(record.axis)
    step = min(among, int((whole - 1) * pair.pinion.pitch_angle / np.ptp(record.axis)) // PLENTY)
    if step < 2:
        return record, ""
    # The first of every few that no fault masks.
    keep = np.zeros(math.ceil(whole / step) * step, bool)
    keep[:whole] = record.keep
    record = _at(record, np.arange(0, len(keep), step) + np.argmax(keep.reshape(-1, step), axis=1))
    return record, f"one of {step} rows is used, {len(record.axis)} of {whole}"


def _at(record: Measurement, rows: NDArray[Any]) -> Measurement:
    """Return some rows of a record."""
    return dataclasses.replace(record, **{name: getattr(record, name)[rows] for name in ("axis", "value", "line", "keep")})
