"""The face width as a row of one-dimensional elements: graded places of nodes, line loads, readings, integrals."""

from __future__ import annotations

import dataclasses
import itertools
import math
from functools import cached_property

import numpy as np
from scipy.linalg import eigh

from gearfem.foundation import Array

# Elements grow with the distance from the ends of the face width and of the load, from these parts of the module. A load
# that ends inside is felt on the centreline a tooth's half thickness away, where its step is smooth.
FINEST, INSIDE = 0.25, 1.0


def shape_functions(part: Array, degree: int) -> tuple[Array, Array]:
    """Return Lagrange's shape functions of degree 1 or 2 and their derivatives at fractions of an element, shape (n, degree + 1)."""
    if degree == 1:
        return np.stack([1.0 - part, part], axis=1), np.broadcast_to([-1.0, 1.0], (len(part), 2))
    value = np.stack([(1.0 - part) * (1.0 - 2.0 * part), 4.0 * part * (1.0 - part), part * (2.0 * part - 1.0)], axis=1)
    return value, np.stack([4.0 * part - 3.0, 4.0 - 8.0 * part, 4.0 * part - 1.0], axis=1)


def graded_places(face_width: float, layers: int, module: float, ends: tuple[float, ...] = ()) -> Array:
    """Return places of second-order nodes across the face width, finer where it or a load ends.

    Parameters
    ----------
    face_width : float
        Face width [m].
    layers : int
        Elements over the face width under a uniform load.
    module : float
        Module, the measure of how fast the disturbance of an end fades [m].
    ends : tuple of float
        Places where loads end, from mid-face [m]; each becomes the end of an element, and so does its mirror image.

    Returns
    -------
    ndarray, shape (2 n + 1,)
        Ends and middles of n elements from -b/2 to b/2, symmetric about mid-face, where one element ends.

    Examples
    --------
    >>> (graded_places(0.02, 4, 0.002) * 1e3).round(2).tolist()
    [-10.0, -9.1, -8.21, -4.1, 0.0, 4.1, 8.21, 9.1, 10.0]
    """
    half, finest = 0.5 * face_width, FINEST * module
    # Places that differ by rounding are one.
    inner = half * np.unique(np.round(np.abs(ends) / half, 9))
    inner = inner[(inner > 0.0) & (inner < half)]
    step = math.log1p(half / finest) / max(1, math.ceil(layers / 2))
    # The density of elements is 1/(smallest + distance to the nearest end), whose integral is a logarithm.
    corners = [0.0]
    special = np.array([*-inner[:1], *inner, half])
    smallest = np.array([INSIDE * module] * (len(special) - 1) + [finest])
    for start, stop in itertools.pairwise([0.0, *inner, half]):
        z = np.linspace(start, stop, 1001)
        density = 1.0 / np.min(np.abs(z - special[:, None]) + smallest[:, None], axis=0)
        measure = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(z))])
        count = max(1, round(measure[-1] / step))
        corners.extend(np.interp(np.arange(1, count) / count * measure[-1], measure, z))
        corners.append(stop)
    side = np.array(corners)
    both = np.concatenate([-side[:0:-1], side])
    return np.insert(both, np.arange(1, len(both)), 0.5 * (both[1:] + both[:-1]))


@dataclasses.dataclass(frozen=True, eq=False)
class FaceWidth:
    """Elements in a row across the face width.

    Parameters
    ----------
    places : ndarray, shape (m,)
        Increasing places of the nodes, symmetric about mid-face, 0 [m].
    degree : int
        Degree of the elements, 1 or 2; middle nodes stand halfway.
    """

    places: Array
    degree: int

    @property
    def width(self) -> float:
        """Face width [m]."""
        return float(self.places[-1] - self.places[0])

    @cached_property
    def _corners(self) -> Array:
        return self.places[:: self.degree]

    def _gather(self, place: Array, weight: Array) -> Array:
        """Return the sum of shape functions at places, times weights, shape (m,)."""
        element = np.clip(np.searchsorted(self._corners, place, side="right") - 1, 0, len(self._corners) - 2)
        start, stop = self._corners[element], self._corners[element + 1]
        value, _ = shape_functions((place - start) / (stop - start), self.degree)
        result = np.zeros(len(self.places))
        np.add.at(result, self.degree * element[:, None] + np.arange(self.degree + 1), value * weight[:, None])
        return result

    def load(self, start: float, stop: float) -> Array:
        """Return the nodal forces of a unit line load between two places, exactly integrated, shape (m,) [m]."""
        cuts = np.unique(np.concatenate([[start], self._corners[(self._corners > start) & (self._corners < stop)], [stop]]))
        nodes, weights = np.polynomial.legendre.leggauss(2)
        half = 0.5 * np.diff(cuts)[:, None]
        place = cuts[:-1, None] + half * (nodes + 1.0)
        return self._gather(place.ravel(), (half * weights).ravel())

    def at(self, place: float) -> Array:
        """Return the weights of nodal values that interpolate at a place, shape (m,)."""
        return self._gather(np.array([place]), np.ones(1))

    @cached_property
    def average(self) -> Array:
        """Weights of nodal values that give their mean over the face width, shape (m,)."""
        return self.load(self.places[0], self.places[-1]) / self.width

    @cached_property
    def matrices(self) -> tuple[Array, Array, Array]:
        """Integrals of products of values, of derivatives, and of derivatives (rows) with values (columns), shape (m, m)."""
        nodes, weights = np.polynomial.legendre.leggauss(3)
        value, slope = shape_functions(0.5 * (nodes + 1.0), self.degree)
        mass, stiffness, mixed = np.zeros((3, len(self.places), len(self.places)))
        for number, length in enumerate(np.diff(self._corners)):
            own = np.ix_(*2 * (self.degree * number + np.arange(self.degree + 1),))
            mass[own] += 0.5 * length * (value.T * weights) @ value
            stiffness[own] += 0.5 / length * (slope.T * weights) @ slope
            mixed[own] += 0.5 * (slope.T * weights) @ value
        return mass, stiffness, mixed

    @cached_property
    def modes(self) -> tuple[Modes, Modes]:
        """Eigenvectors of stiffness and mass that are even, and those that are odd about mid-face.

        Kept apart from the start: of loads that end inside the face the even and the odd mode may differ by rounding alone.
        """
        mass, stiffness, _ = self.matrices
        count = len(self.places)
        half = np.eye(count, (count + 1) // 2)
        bases = half + half[::-1], (half - half[::-1])[:, : count // 2]
        return _modes(bases[0], mass, stiffness), _modes(bases[1], mass, stiffness)


@dataclasses.dataclass(frozen=True, eq=False)
class Modes:
    """Modes of the face width, of unit mass.

    Parameters
    ----------
    squares : ndarray, shape (k,)
        Squared wave numbers [1/m2].
    vectors : ndarray, shape (m, k)
        Nodal values.
    """

    squares: Array
    vectors: Array


def _modes(basis: Array, mass: Array, stiffness: Array) -> Modes:
    squares, vectors = eigh(basis.T @ stiffness @ basis, basis.T @ mass @ basis)
    return Modes(np.maximum(squares, 0.0), basis @ vectors)
