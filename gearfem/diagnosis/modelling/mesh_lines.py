"""Lines of the mesh in a record over the angle, and what teeth that differ and noise leave beside them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gearfem.foundation import Array

HARMONICS = 6
# Cycles of a line to a row at most: beyond half of one it looks like a lower line, and at just half its phase is lost.
RESOLVED = 0.48
# Orders of the shaft on either side of a line that tell its surroundings: farther than what a runout modulates, nearer than the next line.
BESIDE = (2.0, 3.0, 4.0, 5.0)


def mesh_lines(angle: Array, value: Array, pitch: float) -> NDArray[np.complex128]:
    """Return the first complex lines of the mesh, the slow course of the shafts fitted beside them.

    Parameters
    ----------
    angle, value : ndarray, shape (n,)
        Angles [rad] and values of a record.
    pitch : float
        Angular pitch of the pinion [rad].

    Returns
    -------
    ndarray of complex, shape (6,)
        0 where rows are too far apart to show a line.
    """
    return _fit(angle, value, pitch)[0]


def lines_and_beside(angle: Array, value: Array, pitch: float) -> tuple[NDArray[np.complex128], Array]:
    """Return the lines of the mesh, and what stands beside each: the root mean square of the amplitudes at the shaft's next orders.

    Parameters
    ----------
    angle, value, pitch
        As for :func:`mesh_lines`. Records of less than a turn have no orders of the shaft; one cycle of the record stands for one.

    Returns
    -------
    ndarray of complex, ndarray, shape (6,)
        In the value's unit. Deviations of single teeth spread over all orders alike, so that they put as much into the line itself.
    """
    found, rest = _fit(angle, value, pitch)
    order = max(1.0, 2.0 * math.pi / float(angle[-1] - angle[0]))
    lines = 2.0 * math.pi / pitch * np.arange(1.0, HARMONICS + 1.0)
    orders = lines[:, None] + order * np.concatenate([np.negative(BESIDE), BESIDE])
    amplitudes = 2.0 / len(angle) * np.abs(np.exp(-1j * orders[:, :, None] * angle) @ rest)
    return found, np.asarray(np.sqrt((amplitudes**2).mean(axis=1)))


def resolved(angle: Array, pitch: float) -> int:
    """Return how many lines of the mesh, from the first on, the rows of a record are close enough to show."""
    return int(RESOLVED * pitch / float(np.median(np.diff(angle))))


def _fit(angle: Array, value: Array, pitch: float) -> tuple[NDArray[np.complex128], Array]:
    turns = max(1, int((angle[-1] - angle[0]) / pitch / 2.0))
    slow = np.polynomial.chebyshev.chebvander(np.linspace(-1.0, 1.0, len(angle)), min(turns, 60))
    count = min(HARMONICS, resolved(angle, pitch))
    waves = np.exp(2j * math.pi * np.outer(angle, np.arange(1, count + 1)) / pitch)
    columns = np.column_stack([waves.real, waves.imag, slow])
    found = np.linalg.lstsq(columns, value, rcond=None)[0]
    lines = np.zeros(HARMONICS, complex)
    lines[:count] = found[:count] - 1j * found[count : 2 * count]
    return lines, np.asarray(value - columns @ found)
