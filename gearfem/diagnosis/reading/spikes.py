"""Isolated spikes: single samples that overshoot both neighbours by far, and at no other turn or tooth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.foundation import Array

# Ten deviations of Gaussian noise do not occur; resolution of the instrument takes the place of noise that is not there.
OVERSHOOT = 10.0
RESOLUTION = 2e-4
WINDOW = 24
MAD = 1.4826


def find_spikes(axis: Array, value: Array, periods: Sequence[float], jumps: bool = False) -> NDArray[Any]:
    """Return the rows of isolated spikes.

    Parameters
    ----------
    axis, value : ndarray, shape (n,)
        The series, in any unit.
    periods : sequence of float
        Distances along the axis after which real events come back: a turn of each gear, a pitch.
    jumps : bool
        Whether the signal jumps between levels, as a stiffness does where pairs come and go: at light load a second pair may carry for a
        single sample. Spikes lie outside of all levels then.

    Returns
    -------
    ndarray of int

    Notes
    -----
    A sample is a spike if it overshoots both neighbours by ten usual overshoots of the record and of its surroundings, by twice
    the largest around it, and if no event half its size stands a period away. A step, however high, lies between its
    neighbours; a narrow event of a tooth is several samples wide or comes back with the tooth. The first and the last sample, which
    have one neighbour, are spikes if they lie outside of all others by more than the range of these: no step of the record is as high.
    """
    if len(value) < 2 * WINDOW:
        return np.empty(0, int)
    over = _overshoot(value)
    size = np.abs(over)
    usual = float(np.median(size[size > 0.0])) if np.any(size > 0.0) else 0.0
    whole = MAD * usual + RESOLUTION * float(np.ptp(np.sort(value)[2:-2]))
    high = size > OVERSHOOT * whole
    found = [int(row) for row in np.flatnonzero(high) if _isolated(int(row), over, value, high)]
    inner = [row for row in found if not _returns(row, over, axis, periods)]
    least, most = np.sort(value)[[2, -3]]
    ends = [row for row in (0, len(value) - 1) if max(least - value[row], value[row] - most) > most - least]
    spikes = np.array(sorted({*inner, *ends}), int)
    if jumps and len(spikes):
        others = np.delete(value, spikes)
        spikes = spikes[(value[spikes] < others.min()) | (value[spikes] > others.max())]
    return spikes


def _overshoot(value: Array) -> Array:
    """Return how far each sample lies outside the interval of its two neighbours, with its sign; 0 inside."""
    over = np.zeros(len(value))
    before, after = np.diff(value)[:-1], -np.diff(value)[1:]
    over[1:-1] = np.where(before * after > 0.0, np.sign(before) * np.minimum(np.abs(before), np.abs(after)), 0.0)
    return over


def _isolated(row: int, over: Array, value: Array, high: NDArray[Any]) -> bool:
    """Whether a sample stands out of its surroundings once it, and further ones like it that do not adjoin, are taken out."""
    around = np.arange(max(0, row - WINDOW), min(len(value), row + WINDOW + 1))
    apart = np.abs(around - row)
    others = around[(apart > 0) & ~(high[around] & (apart > 2))]
    left = np.abs(_overshoot(value[others]))
    usual = MAD * float(np.median(left[left > 0.0])) if np.any(left > 0.0) else 0.0
    return bool(abs(over[row]) > max(OVERSHOOT * usual, 2.0 * float(left.max())))


def _returns(row: int, over: Array, axis: Array, periods: Sequence[float]) -> bool:
    """Whether an event of the same sign and half the size stands one period before or after."""
    sign = np.sign(over[row])
    for period in periods:
        for place in (axis[row] - period, axis[row] + period):
            if not axis[0] <= place <= axis[-1]:
                continue
            near = int(np.searchsorted(axis, place))
            if (sign * over[max(0, near - 2) : near + 3]).max(initial=0.0) > 0.5 * abs(over[row]):
                return True
    return False
