"""Line loads on the outline and readings on the tooth's centreline, as weights of nodes."""

from __future__ import annotations

import dataclasses
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from gearfem.compliance.patchwork import Ids
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError, Record, SolveError


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class LoadLines(Record):
    """Lines along which loads act: from points of the outline, inwards along its normal, to the tooth's centreline.

    Parameters
    ----------
    u : ndarray, shape (n,)
        Parameters of the `Outline`.
    point, direction : ndarray, shape (n, 2)
        Load points [m] and unit vectors into the metal.
    depth : ndarray, shape (n,)
        Distance from the load point to the centreline along the line [m].
    """

    u: Array
    point: Array
    direction: Array
    depth: Array

    @property
    def crossing(self) -> Array:
        """Distances of the crossings with the centreline from the gear's centre, shape (n,) [m]."""
        places: Array = self.point[:, 0] + self.depth * self.direction[:, 0]
        return places

    @property
    def radius(self) -> Array:
        """Radii of the load points, shape (n,) [m]."""
        radius: Array = np.hypot(*self.point.T)
        return radius

    def kept(self, within: Array) -> LoadLines:
        """Return the lines of a mask or of indices."""
        return LoadLines(u=self.u[within], point=self.point[within], direction=self.direction[within], depth=self.depth[within])


def load_lines(outline: Outline, u: ArrayLike) -> LoadLines:
    """Return the load lines of positions on flank and tip round.

    Parameters
    ----------
    outline : Outline
        Outline of the tooth.
    u : array_like, shape (n,)
        Increasing parameters in [2, 4); towards 4 the crossing moves to the gear's centre.

    Returns
    -------
    LoadLines

    Raises
    ------
    InputError
        If a position is not on flank or tip round, or they do not increase.
    """
    u = np.atleast_1d(np.asarray(u, dtype=float))
    if u.ndim != 1 or u.size == 0 or not (u.min() >= 2.0 and u.max() < 4.0 and (np.diff(u) > 0.0).all()):
        raise InputError("load positions u", u, "increasing numbers from 2 (start of the involute) to below 4 (end of the tip round)")
    point, direction = outline.point(u), -outline.normal(u)
    return LoadLines(u=u, point=point, direction=direction, depth=-point[:, 1] / direction[:, 1])


class Loaded(Protocol):
    """A mesh with a chain of nodes that takes loads, as `SectionMesh` describes them."""

    @property
    def mesh(self) -> Any:
        """The mesh."""

    @property
    def outline(self) -> Ids:
        """Nodes of the loaded side."""

    @property
    def outline_u(self) -> Array:
        """Their parameters."""


def forces(section: Loaded, lines: LoadLines) -> Array:
    """Return the nodal forces of unit line loads, shape (2 n, k), x components first.

    Notes
    -----
    Consistent with the shape functions of the boundary edge that the load falls on; within it the load stands
    where the edge is nearest to the exact point. No moment is lost that does not vanish with the third power of the edge.
    """
    edge = _between(section.outline_u, lines.u)
    tangent = np.stack([-lines.direction[:, 1], lines.direction[:, 0]], axis=1)
    return _weights(section, section.outline, edge, lines.point, tangent, lines.direction)


def readings(section: SectionMesh, lines: LoadLines) -> Array:
    """Return the weights of nodal displacements that give the deflection along each line at its crossing, shape (2 n, k)."""
    place = np.stack([lines.crossing, np.zeros_like(lines.crossing)], axis=1)
    edge = _between(section.mesh.doflocs[0, section.centreline], lines.crossing)
    return _weights(section, section.centreline, edge, place, np.broadcast_to([1.0, 0.0], place.shape), lines.direction)


def covered(section: SectionMesh, lines: LoadLines) -> Array:
    """Return which lines cross the centreline inside the mesh, shape (k,) of bool."""
    ends = section.mesh.doflocs[0, section.centreline[[0, -1]]]
    inside: Array = (lines.crossing >= ends[0]) & (lines.crossing <= ends[1])
    return inside


def _between(values: Array, wanted: Array) -> Ids:
    """Return the edge of a chain whose end values enclose each wanted value."""
    ends = values[::2]
    edge: Ids = np.clip(np.searchsorted(ends, wanted, side="right") - 1, 0, len(ends) - 2)
    return edge


def _weights(section: Loaded, chain: Ids, edge: Ids, place: Array, tangent: Array, direction: Array) -> Array:
    nodes = section.mesh.doflocs.shape[1]
    ends = np.stack([chain[2 * edge + i] for i in range(3)], axis=1)
    shape = edge_shape(_local(section.mesh.doflocs.T[ends], place, tangent))
    result = np.zeros((2 * nodes, len(edge)))
    for axis in (0, 1):
        np.put_along_axis(result, ends.T + axis * nodes, (shape * direction[:, axis : axis + 1]).T, axis=0)
    return result


def edge_shape(part: Array) -> Array:
    """Return the quadratic shape functions of an edge at fractions of it, shape (n, 3)."""
    return np.stack([(1.0 - part) * (1.0 - 2.0 * part), 4.0 * part * (1.0 - part), part * (2.0 * part - 1.0)], axis=1)


def _local(ends: Array, place: Array, tangent: Array) -> Array:
    """Return the fraction of each edge at which it lies square to the place, by Newton's method."""
    along = np.einsum("nij,nj->ni", ends - place[:, None], tangent)
    part = np.full(len(place), 0.5)
    for _ in range(30):
        slope = np.stack([4.0 * part - 3.0, 4.0 - 8.0 * part, 4.0 * part - 1.0], axis=1)
        step = np.einsum("ni,ni->n", edge_shape(part), along) / np.einsum("ni,ni->n", slope, along)
        part = part - step
        if np.abs(step).max() < 1e-13:
            break
    # An end on a curved stretch may lie a hundredth of an edge beyond its neighbour's by the interpolation of the curve.
    if not (np.abs(part - 0.5) < 0.51).all():
        raise SolveError("a load position or reading was not found on its element edge; raise the resolution of the mesh")
    return part
