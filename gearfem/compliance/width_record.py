"""Deflection over the face width: profiles under one load, and the influence of slices on one another."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class WidthProfile(Record):
    """Deflection over the face width under a line load at one height of the flank.

    Parameters
    ----------
    u, radius : float
        Load position as parameter of the `Outline`, and its radius [m].
    place : ndarray, shape (m,)
        Places across the face width, from mid-face [m].
    deflection : ndarray, shape (m,)
        Deflection per line load, along the load line where it crosses the tooth's centreline [m per N/m].
    average : float
        Mean of the deflection over the face width [m per N/m].
    loaded : tuple of float
        Places between which the load acts [m].
    """

    u: float
    radius: float
    place: Array
    deflection: Array
    average: float
    loaded: tuple[float, float]

    @property
    def mid(self) -> float:
        """Deflection at mid-face [m per N/m]."""
        return float(self.deflection[len(self.place) // 2])

    @property
    def ends(self) -> tuple[float, float]:
        """Deflections at both ends of the face width [m per N/m]."""
        return float(self.deflection[0]), float(self.deflection[-1])


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class WidthInfluence(Record):
    """Deflection of slices of the face width under loads on slices, at one height of the flank.

    Parameters
    ----------
    u, radius : float
        Load position as parameter of the `Outline`, and its radius [m].
    edges : ndarray, shape (n + 1,)
        Ends of the slices, from mid-face [m].
    matrix : ndarray, shape (n, n)
        matrix[i, j]: deflection at the middle of slice i per line load spread evenly over slice j [m per N/m]. A row sums to the
        deflection there under a uniform load.

    Notes
    -----
    Symmetric about mid-face: matrix[i, j] = matrix[n-1-i, n-1-j]. Reciprocity (Maxwell, Betti) ties loads to readings at
    the same points, but here the load acts on the flank and is read on the centreline, so that matrix and transpose differ
    near the ends; `asymmetry` tells by how much.
    """

    u: float
    radius: float
    edges: Array
    matrix: Array

    @property
    def asymmetry(self) -> float:
        """Largest difference of matrix and transpose over the largest entry."""
        return float(np.abs(self.matrix - self.matrix.T).max() / np.abs(self.matrix).max())
