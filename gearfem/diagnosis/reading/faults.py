"""Faults of measured data: isolated ones are masked and listed, the rest is refused with record and row."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import Gear, GearPair
from gearfem.diagnosis.reading.quantities import FASTEST, SLOWEST, Quantity
from gearfem.diagnosis.reading.series import Series
from gearfem.diagnosis.reading.spikes import find_spikes
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.units import MM, UM

# A spacing is a gap above four usual ones, and above three of the widest that an unequal sampling has anyway.
GAP, GAP_UNEQUAL = 4.0, 3.0
MISSING = 1.75
# Turns of a gear off the rig.
MOST_TURNS = 1000
# Teeth that say anything beside an unknown constant.
FEWEST_TEETH = 3
SAMPLES_PER_PITCH = 6.0
# Share of the fast variation that repeats with the mesh from which on it tells the unit of the angle: of 461 records in radians, with and
# without effects, no other unit has more of it, and five times as much as they.
MESHES = 0.1
# Mesh cycles that a line must cover to be told from what the shafts do.
FEWEST_MESHES = 4.0
# One sample in a hundred is no longer isolated.
MOST_SPIKES = 0.01
# Outliers lie outside of all but this share of the rows at either end, two at least, by so many times the range of the others.
OUTER, FEW_OUTER, OUTLIER = 0.01, 2, 20.0
# Rows of one number that mark missing values, up to a share of all, and how far it lies from the others, in ranges of these: no instrument
# reads one number that often.
MARKS, MOST_MARKS, MARKED = 3, 0.2, 3.0
# A step lies between two levels that are so many times as far apart as either varies, each over so many pitches: a tooth out of place is
# past after two.
STEP, LEVEL = 3.0, 3.0
# Part of the module that no tooth is late or early by.
OUT_OF_PLACE = 0.05


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Fault(Record):
    """Something about a record that a reader of the results must know.

    Parameters
    ----------
    record : str
        File of the record.
    kind : str
        One of spike, missing_rows, mean, role.
    rows : tuple of int
        Rows concerned, counted from 0 without comments and header.
    sentence : str
        The same in words.
    """

    record: str
    kind: str
    rows: tuple[int, ...]
    sentence: str


def find_faults(file: str, quantity: Quantity, series: Series, pair: GearPair, gear: Gear) -> tuple[NDArray[Any], list[Fault]]:
    """Check one series as its file has it; return which rows can be used, and what was repaired.

    Parameters
    ----------
    file : str
        Name of the record.
    quantity : Quantity
        What was measured.
    series : Series
        In the units of the file.
    pair : GearPair
        The gears.
    gear : Gear
        Gear of a record of one gear; the pinion for all others.

    Returns
    -------
    keep : ndarray of bool, shape (n,)
        False where a spike was masked.
    faults : list of Fault
        What was repaired.

    Raises
    ------
    InputError
        On an axis that runs backwards, has a gap or another unit, on spikes that are not isolated, on rows far from all others or marks
        for missing values, and on a step to another level.
    """
    keep = np.ones(len(series.axis), bool)
    if quantity.axis == "speed":
        _check_speed(series, quantity)
        return keep, []
    _check_order(series, quantity)
    if quantity.axis == "tooth":
        _check_teeth(series, quantity, gear)
        _refuse_outliers(series, quantity, keep, OUT_OF_PLACE * gear.module / UM)
        return keep, []
    if quantity.axis == "roll":
        _check_roll(series, gear)
    else:
        _check_angle(series, quantity, pair)
    faults = _check_spacing(file, series, quantity, pair)
    periods = [2.0 * math.pi, 2.0 * math.pi * pair.ratio, pair.pinion.pitch_angle] if quantity.axis == "angle" else []
    spikes = find_spikes(series.axis, series.value, periods, quantity.name == "mesh_stiffness")
    if len(spikes) > max(1.0, MOST_SPIKES * len(keep)):
        column = quantity.columns[1]
        found = f"{len(spikes)} spikes ({rows_text(series, spikes)})"
        raise InputError(f"{series.row(int(spikes[0]))}, column {column}", found, "isolated ones, at most one row in a hundred")
    if len(spikes):
        keep[spikes] = False
        rows = tuple(int(row) for row in spikes)
        faults.append(Fault(record=file, kind="spike", rows=rows, sentence=f"isolated spikes masked: {rows_text(series, spikes)}"))
    if quantity.axis == "angle":
        _refuse_outliers(series, quantity, keep)
        _refuse_step(series, quantity, keep, LEVEL * pair.pinion.pitch_angle)
    return keep, faults


def _refuse_outliers(series: Series, quantity: Quantity, keep: NDArray[Any], least: float = 0.0) -> None:
    """Refuse rows that stand as far outside of all others as no flank can be, and by a least amount: marks for missing values, say."""
    outer = max(FEW_OUTER, math.ceil(OUTER * np.count_nonzero(keep)))
    others = np.sort(series.value[keep])[outer:-outer]
    if not len(others):
        return
    low, high = float(others[0]), float(others[-1])
    reach = max(OUTLIER * (high - low), least)
    rows = np.flatnonzero(keep & ((series.value < low - reach) | (series.value > high + reach)))
    if not len(rows):
        rows, low, high = _marks(series.value, keep, least)
    if reach > 0.0 and len(rows):
        row, column = int(rows[0]), quantity.columns[1]
        found = f"{series.value[row]:g} ({len(rows)} such rows: {rows_text(series, rows)})"
        raise InputError(f"{series.row(row)}, column {column}", found, f"values near those of the other rows, {low:.4g} to {high:.4g}")


def _marks(value: Array, keep: NDArray[Any], least: float) -> tuple[NDArray[Any], float, float]:
    """Return the rows that have one number, smallest or largest of all and far from any other, many times; and the range of the others."""
    for mark in (value[keep].min(), value[keep].max()):
        marked, others = keep & (value == mark), keep & (value != mark)
        if not MARKS <= np.count_nonzero(marked) <= MOST_MARKS * np.count_nonzero(keep):
            continue
        low, high = float(value[others].min()), float(value[others].max())
        if high > low and max(low - mark, mark - high) > max(MARKED * (high - low), least):
            return np.flatnonzero(marked), low, high
    return np.empty(0, int), 0.0, 0.0


def _refuse_step(series: Series, quantity: Quantity, keep: NDArray[Any], least: float) -> None:
    """Refuse a signal that goes on at another level from one row on, each over a least part of the axis: counts were lost."""
    rows = np.flatnonzero(keep)
    value, axis = series.value[rows], series.axis[rows]
    highest, lowest = np.maximum.accumulate(value)[:-1], np.minimum.accumulate(value)[:-1]
    highest_on, lowest_on = np.maximum.accumulate(value[::-1])[-2::-1], np.minimum.accumulate(value[::-1])[-2::-1]
    apart = np.maximum(lowest_on - highest, lowest - highest_on)
    wide = np.maximum(highest - lowest, highest_on - lowest_on)
    steps = np.flatnonzero((apart > STEP * wide) & (axis[:-1] - axis[0] > least) & (axis[-1] - axis[1:] > least))
    if len(steps):
        row, by = int(rows[steps[0] + 1]), float(value[steps[0] + 1] - value[steps[0]])
        found = f"a step of {by:.4g} from all rows before it to all that follow, which vary by {wide[steps[0]]:.4g}"
        raise InputError(f"{series.row(row)}, column {quantity.columns[1]}", found, "one level: split the record in two files at the step")


def rows_text(series: Series, rows: NDArray[Any]) -> str:
    """Return rows in words, the first few of many."""
    names = [series.row(int(row)) for row in rows[:5]]
    return ", ".join(names) + (f" and {len(rows) - 5} more" if len(rows) > 5 else "")


# ---- axes ---------------------------------------------------------------------------------------------


def _check_order(series: Series, quantity: Quantity) -> None:
    back = np.flatnonzero(np.diff(series.axis) <= 0.0)
    if len(back):
        row = int(back[0]) + 1
        found = f"{series.axis[row]:.10g} after {series.axis[row - 1]:.10g}"
        raise InputError(f"{series.row(row)}, column {quantity.columns[0]}", found, "a value above that of the row before it")


def _check_spacing(file: str, series: Series, quantity: Quantity, pair: GearPair) -> list[Fault]:
    """Refuse gaps; list single rows that are missing."""
    if len(series.axis) < 8:
        return []
    spacing = np.diff(series.axis)
    usual = float(np.median(spacing))
    if quantity.axis == "roll":
        return []
    # However unequal the sampling, what lies in a sixth of a pitch is seen.
    unequal = min(GAP_UNEQUAL * float(np.quantile(spacing, 0.95)), pair.pinion.pitch_angle / SAMPLES_PER_PITCH)
    limit = max(GAP * usual, unequal)
    gaps = np.flatnonzero(spacing > limit)
    if len(gaps):
        row = int(gaps[0]) + 1
        found = f"a gap of {spacing[row - 1]:.4g} behind the row before it, the usual step being {usual:.4g}"
        allowed = f"steps up to {limit:.4g}; split the record in two files at the gap"
        raise InputError(f"{series.row(row)}, column {quantity.columns[0]}", found, allowed)
    equal = float(np.quantile(spacing, 0.95)) < 1.2 * usual
    missing = np.flatnonzero(spacing > MISSING * usual) + 1 if equal else np.empty(0, int)
    if not len(missing):
        return []
    rows = tuple(int(row) for row in missing)
    return [Fault(record=file, kind="missing_rows", rows=rows, sentence=f"rows are missing before {rows_text(series, missing)}")]


def _rows(series: Series) -> str:
    return f"{len(series.axis)} row{'' if len(series.axis) == 1 else 's'}"


def _check_angle(series: Series, quantity: Quantity, pair: GearPair) -> None:
    """Refuse angles that cannot be radians of the pinion."""
    where = f"column {quantity.columns[0]}"
    pitch = pair.pinion.pitch_angle
    if len(series.axis) < 8 or np.ptp(series.axis) < 0.5 * pitch:
        found = f"{_rows(series)} over {np.ptp(series.axis):.4g}"
        raise InputError(where, found, f"at least 8 rows over half a pitch of {pitch:.4g} rad (radians, not turns?)")
    usual = float(np.median(np.diff(series.axis)))
    if usual > pitch / SAMPLES_PER_PITCH:
        raise InputError(where, f"a step of {usual:.4g}", f"up to a sixth of the pitch of {pitch:.4g} rad (radians, not degrees?)")
    readings = {
        "degrees": math.pi / 180.0,
        "turns": 2.0 * math.pi,
        "angles of the wheel": pair.ratio,
    }
    _refuse_still(series, quantity)
    if np.ptp(series.axis) < FEWEST_MESHES * pitch:
        return
    own = _mesh_share(series, 1.0, pitch)
    for word, scale in readings.items() if own < 0.2 else ():
        other = _mesh_share(series, scale, pitch)
        if abs(scale - 1.0) > 0.02 and other > MESHES and own < 0.2 * other:
            found = f"a mesh line that fits {word} ({other:.0%} of the variation; {own:.0%} for radians of the pinion)"
            raise InputError(where, found, f"radians of the pinion, {pair.pinion.teeth} mesh cycles to the turn")


def _refuse_still(series: Series, quantity: Quantity) -> None:
    """Refuse a signal that stands still, and a stiffness that pushes the wrong way."""
    column = quantity.columns[1]
    if np.ptp(series.value) == 0.0:
        raise InputError(f"column {column}", f"{series.value[0]:g} in every row", "a signal that varies: does the instrument read?")
    wrong = np.flatnonzero(series.value <= 0.0)
    if quantity.name == "mesh_stiffness" and len(wrong):
        raise InputError(f"{series.row(int(wrong[0]))}, column {column}", f"{series.value[wrong[0]]:g}", "a number above 0 N/um")


def _mesh_share(series: Series, scale: float, pitch: float) -> float:
    """Return the share of the fast variation that repeats with the mesh if the axis is stretched by `scale`."""
    phase = 2.0 * math.pi * scale * series.axis / pitch
    cycles = float(np.ptp(phase)) / (2.0 * math.pi)
    if cycles < FEWEST_MESHES or len(phase) < 6.0 * cycles:
        return 0.0
    slow = np.polynomial.chebyshev.chebvander(np.linspace(-1.0, 1.0, len(phase)), min(max(2, int(cycles / 2.0)), 40))
    wave = np.exp(1j * phase[:, None] * np.arange(1, 4))
    fast, left = (_remainder(columns, series.value) for columns in (slow, np.column_stack([slow, wave.real, wave.imag])))
    return 1.0 - left / fast if fast > 0.0 else 0.0


def _remainder(columns: NDArray[Any], value: Array) -> float:
    """Return the sum of squares that columns leave; their normal equations are well enough conditioned for a share."""
    fitted = np.linalg.lstsq(columns.T @ columns, columns.T @ value, rcond=None)[0]
    return float(np.sum((value - columns @ fitted) ** 2))


def _check_speed(series: Series, quantity: Quantity) -> None:
    limits = ((SLOWEST, FASTEST, f"{SLOWEST:g} to {FASTEST:g} rpm"), (np.nextafter(0.0, 1.0), math.inf, "a number above 0"))
    for (low, high, allowed), name, values in zip(limits, quantity.columns, (series.axis, series.value), strict=True):
        wrong = np.flatnonzero((values < low) | (values > high))
        if len(wrong):
            row = int(wrong[0])
            raise InputError(f"{series.row(row)}, column {name}", f"{values[row]:g}", allowed)
    if series.value.max() < 0.5 or series.value.min() > 5.0 or series.value.max() > 50.0:
        found = f"{series.value.min():.3g} to {series.value.max():.3g}"
        raise InputError(f"column {quantity.columns[1]}", found, "largest Kw of each speed, about 1 or above (a factor, not per cent)")


def _check_teeth(series: Series, quantity: Quantity, gear: Gear) -> None:
    last = MOST_TURNS * gear.teeth
    odd = np.flatnonzero((series.axis != np.round(series.axis)) | (series.axis < 0.0) | (series.axis > last))
    if len(odd):
        row = int(odd[0])
        raise InputError(f"{series.row(row)}, column tooth", f"{series.axis[row]:g}", f"whole numbers from 0 to {last}")
    span, most = float(np.ptp(series.value)), gear.module / UM
    if len(series.axis) < FEWEST_TEETH or span == 0.0:
        found = f"{_rows(series)} over {span:g} um"
        raise InputError(f"column {quantity.columns[1]}", found, f"{FEWEST_TEETH} rows or more that vary: their constant is unknown")
    if span > most:
        found = f"values over {span:.4g} um"
        raise InputError(f"column {quantity.columns[1]}", found, f"a range up to the module, {most:g} um (micrometres, not nanometres?)")


def _check_roll(series: Series, gear: Gear) -> None:
    end = math.sqrt(gear.tip_radius**2 - gear.base_radius**2) / MM
    low, high = float(series.axis[0]), float(series.axis[-1])
    if low < -0.02 * end or high > 1.1 * end or high < 0.2 * end:
        allowed = f"roll lengths from the base circle, 0 to {end:.4g} mm at the tip"
        raise InputError("column roll_length_mm", f"{low:.4g} to {high:.4g}", allowed)
    deepest = 0.5 * gear.module / UM
    wrong = np.flatnonzero(np.abs(series.value) > deepest)
    if len(wrong):
        row = int(wrong[0])
        found = f"{series.value[row]:g}"
        raise InputError(f"{series.row(row)}, column deviation_um", found, f"up to half a module, {deepest:g} um either way")
