"""What comes back with the turns of the gears: values one period later."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import GearPair
from gearfem.foundation import Array


def hunting_period(pair: GearPair) -> float:
    """Return the turn of the pinion [rad] after which the same teeth meet again."""
    return 2.0 * math.pi * pair.wheel.teeth / math.gcd(pair.pinion.teeth, pair.wheel.teeth)


def nearest_rows(axis: Array, places: Array) -> NDArray[Any]:
    """Return the rows of a rising axis, shape (n,), that are nearest to places, shape (k,)."""
    nearest = np.clip(np.searchsorted(axis, places), 1, len(axis) - 1)
    return np.asarray(nearest - (places - axis[nearest - 1] < axis[nearest] - places))


def shifted(axis: Array, value: Array, period: float) -> tuple[Array, NDArray[Any]]:
    """Return the samples nearest to one period later, moved there along their slope, and the rows that have one.

    Parameters
    ----------
    axis, value : ndarray, shape (n,)
        A series; the axis rises.
    period : float
        In the unit of the axis.

    Returns
    -------
    ndarray, shape (k,)
        One period later.
    ndarray of int, shape (k,)
        Rows.
    """
    valid = np.flatnonzero(axis + period <= axis[-1]) if len(axis) else np.empty(0, int)
    if not len(valid):
        return np.empty(0), valid
    place = axis[valid] + period
    nearest = nearest_rows(axis, place)
    # The slope over five samples adds a hundredth to the variance; a line between neighbours would take up to half of it away.
    slope = np.zeros(len(value))
    if len(value) > 5:
        slope[2:-2] = (2.0 * (value[4:] - value[:-4]) + value[3:-1] - value[1:-3]) / (2.5 * (axis[4:] - axis[:-4]))
    return value[nearest] + slope[nearest] * (place - axis[nearest]), valid
