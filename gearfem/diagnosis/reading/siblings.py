"""What records of a campaign say of each other: copies, and one in another unit than the rest."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.periods import nearest_rows
from gearfem.foundation import Array, InputError

# Copies agree to this part up to a constant and a factor. Where rows were left out or changed most others do without a factor, at angles no
# farther apart than this part of a step: to this part of their range, or, at the same torque and speed, of the stated noise, by 1.4 times
# which real repeats differ.
COPY, APART, CHANGED, ROUNDED = 1e-9, 0.05, 1e-6, 0.25
# Rows from which on copies with changes are looked for, and the share of the shorter record that must be met.
FEWEST, MET = 20, 0.4


def refuse_duplicates(records: list[Measurement]) -> None:
    """Refuse a record whose values are those of an earlier one, under another name, torque or constant.

    Parameters
    ----------
    records : list of Measurement
        Only what was measured alike is compared.

    Raises
    ------
    InputError
        Naming both.
    """
    for later, one in enumerate(records):
        for earlier, other in enumerate(records[:later]):
            if one.file == other.file or (_alike(one, other) and _copied(one, other)):
                found = f"the same data as record[{earlier + 1}] ({other.file})"
                raise InputError(f"record[{later + 1}] ({one.file})", found, "each measurement once: leave out the copy")


def _alike(one: Measurement, other: Measurement) -> bool:
    """Whether two records say that they hold the same kind of series of the same gear and tooth."""
    return (one.quantity.columns, one.gear, one.tooth) == (other.quantity.columns, other.gear, other.tooth)


def _copied(one: Measurement, other: Measurement) -> bool:
    """Whether two series are the same up to a constant and a factor, or up to a constant on most rows of one; noise keeps repeats apart."""
    axis, value, first_axis, first = one.axis[one.keep], one.value[one.keep], other.axis[other.keep], other.value[other.keep]
    if min(len(value), len(first)) < 5:
        return False
    if len(value) == len(first) and np.allclose(axis, first_axis, rtol=1e-6, atol=0.0):
        own, its = value - value.mean(), first - first.mean()
        size = float(np.linalg.norm(own) * np.linalg.norm(its))
        if size > 0.0 and 1.0 - float(own @ its) / size < COPY:
            return True
    near = nearest_rows(first_axis, axis)
    met = np.abs(first_axis[near] - axis) < APART * np.median(np.diff(first_axis))
    if np.count_nonzero(met) < max(FEWEST, MET * min(len(value), len(first))):
        return False
    apart = value[met] - first[near[met]]
    # At another torque simulated records may share their noise.
    repeated = (one.pinion_torque, one.pinion_speed) == (other.pinion_torque, other.pinion_speed)
    noise = min(one.noise_std or 0.0, other.noise_std or 0.0) if repeated else 0.0
    return float(np.median(np.abs(apart - np.median(apart)))) < max(CHANGED * float(np.ptp(value)), ROUNDED * noise)


def refuse_odd_units(records: list[Measurement], folder: Path) -> None:
    """Refuse a slow record whose signal and whose noise are both another power of ten than those of its siblings.

    Parameters
    ----------
    records : list of Measurement
        The slow transmission errors of a campaign.
    folder : Path
        Of the campaign.

    Raises
    ------
    InputError
        Naming the record and the power.

    Notes
    -----
    One instrument has one noise, whatever the torque: third differences of practice records agree within 0.1 decades, their deviations
    within 0.3. Two siblings at least are needed to say which one is odd.
    """
    if len(records) < 3:
        return
    values = [record.value[record.keep] for record in records]
    rough = np.array([_decades(np.diff(value, 3)) for value in values])
    stated = [record.noise_std for record in records if record.noise_std is not None]
    if len(stated) == len(records):
        # An instrument that is said to be quieter may be.
        rough -= np.log10(stated)
    whole = np.array([_decades(value - np.median(value)) for value in values])
    for number, record in enumerate(records):
        others = np.arange(len(records)) != number
        off, size = rough[number] - np.median(rough[others]), whole[number] - np.median(whole[others])
        power = round(off)
        if power and abs(off - power) < 0.25 and abs(size - power) < 0.5:
            found = f"values and noise 10^{power} times those of the other records"
            raise InputError(f"column {record.quantity.columns[1]}", found, f"values in {record.quantity.unit}", str(folder / record.file))


def _decades(value: Array) -> float:
    return math.log10(max(float(np.median(np.abs(value))), 1e-30))
