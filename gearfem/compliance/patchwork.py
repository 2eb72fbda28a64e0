"""Structured quadrilateral patches with second-order nodes, joined where their points coincide."""

from __future__ import annotations

import dataclasses
from typing import Any, TypeAlias

import numpy as np
import skfem
from numpy.typing import NDArray

from gearfem.foundation import Array, SolveError

Ids: TypeAlias = NDArray[np.int64]


def straight(start: Array, end: Array, part: Array) -> Array:
    """Return points on a straight line at the fractions `part`, the ends exactly, shape (n, 2)."""
    points: Array = start + part[:, None] * (end - start)
    points[0], points[-1] = start, end
    return points


def transfinite(bottom: Array, right: Array, top: Array, left: Array) -> Array:
    """Return the points of a patch between four sides (bilinearly blended Coons patch).

    Parameters
    ----------
    bottom, top : ndarray, shape (n, 2)
        Sides at the start and the end of the second direction, both run along the first [m].
    left, right : ndarray, shape (m, 2)
        Sides at the start and the end of the first direction, both run along the second [m].

    Returns
    -------
    ndarray, shape (n, m, 2)
        The sides come back bit for bit.

    Notes
    -----
    Gordon & Hall (1973), transfinite mapping, with the blending weights linear in the chord length of the
    sides (mean of two opposite ones), so that a thin row of elements stays thin without folding.
    """
    s = ((fractions(bottom) + fractions(top)) / 2.0)[:, None, None]
    t = ((fractions(left) + fractions(right)) / 2.0)[None, :, None]
    corners = (1 - s) * (1 - t) * bottom[0] + s * (1 - t) * bottom[-1] + (1 - s) * t * top[0] + s * t * top[-1]
    points: Array = (1 - t) * bottom[:, None] + t * top[:, None] + (1 - s) * left[None] + s * right[None] - corners
    points[:, 0], points[:, -1], points[0], points[-1] = bottom, top, left, right
    return points


def fractions(side: Array) -> Array:
    """Return the fractions of its length at which the points of a side lie, from 0 to 1."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(side, axis=0).T))])
    share: Array = length / length[-1]
    return share


@dataclasses.dataclass(frozen=True)
class Patchwork:
    """Patches above and below y = 0 as one second-order mesh.

    Parameters
    ----------
    mesh : skfem.MeshQuad2
        The mesh; its nodes are the degrees of freedom of the biquadratic element.
    above, below : tuple of ndarray, shape (n, m)
        Numbers of the nodes of each patch, and of its counterpart below.
    """

    mesh: Any
    above: tuple[Ids, ...]
    below: tuple[Ids, ...]


def join(patches: tuple[Array, ...], mirrored: tuple[Array, ...] | None = None) -> Patchwork:
    """Join patches of the upper half plane and mirror images below it into one mesh.

    Parameters
    ----------
    patches : tuple of ndarray, shape (2 n + 1, 2 m + 1, 2)
        Corner, mid-side and centre nodes of n by m elements, the second direction clockwise from the first (first
        away from the axis, second towards the tip); points shared by patches are equal bit for bit, points of the axis have y = 0.
    mirrored : tuple of ndarray, optional
        Patches of the same shapes whose mirror images lie below, with the same points on the axis; by default `patches`.

    Returns
    -------
    Patchwork
    """
    # Adding 0.0 turns the -0.0 of mirrored axis points into 0.0.
    below = patches if mirrored is None else mirrored
    points = np.concatenate([*(p.reshape(-1, 2) for p in patches), *(p.reshape(-1, 2) * [1.0, -1.0] + 0.0 for p in below)])
    distinct, number = np.unique(points[:, 0] + 1j * points[:, 1], return_inverse=True)
    shapes = [p.shape[:2] for p in patches] * 2
    ends = np.cumsum([n * m for n, m in shapes])
    grids = [part.reshape(shape) for part, shape in zip(np.split(number, ends[:-1]), shapes, strict=True)]
    half = len(patches)
    quads = np.concatenate([*(_elements(g.T) for g in grids[:half]), *(_elements(g) for g in grids[half:])])
    mesh, renumber = _second_order(np.stack([distinct.real, distinct.imag]), quads)
    return Patchwork(mesh, tuple(renumber[g] for g in grids[:half]), tuple(renumber[g] for g in grids[half:]))


def _elements(grid: Ids) -> Ids:
    """Return nine nodes of each element: corners counter-clockwise, the mid-sides between them, the centre; shape (k, 9)."""
    places = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]
    rows, columns = grid.shape
    return np.stack([grid[i : rows - 2 + i : 2, j : columns - 2 + j : 2].ravel() for i, j in places], axis=1)


def _second_order(points: Array, quads: Ids) -> tuple[Any, Ids]:
    """Return the mesh in the numbering of its degrees of freedom, and that number of each point."""
    vertices, corners = np.unique(quads[:, :4], return_inverse=True)
    flat = skfem.MeshQuad(np.ascontiguousarray(points[:, vertices]), np.ascontiguousarray(corners.reshape(-1, 4).T))
    dofs = skfem.Dofs(flat, skfem.ElementQuad2())
    renumber = np.empty(points.shape[1], dtype=np.int64)
    renumber[quads.T] = dofs.element_dofs
    places = np.empty_like(points)
    places[:, renumber] = points
    return skfem.MeshQuad2(places, flat.t), renumber


def mirror_images(places: Array) -> Ids:
    """Return the node at the mirror image in y = 0 of each node of a symmetric mesh, shape (2, n) -> (n,)."""
    mirror = np.empty(places.shape[1], dtype=np.int64)
    mirror[np.lexsort((places[1], places[0]))] = np.lexsort((-places[1], places[0]))
    return mirror


def refuse_folds(mesh: Any, quadrature: Array, remedy: str) -> None:
    """Raise SolveError where the map of an element turns over at one of the points of integration.

    Parameters
    ----------
    mesh : skfem.MeshQuad2
        The mesh.
    quadrature : ndarray, shape (2, q)
        Points of integration in the reference element.
    remedy : str
        What to change in the input.
    """
    jacobian = mesh.mapping().detDF(quadrature)
    if not jacobian.min() > 0.0:
        x, y = mesh.p[:, mesh.t[:, int(np.argmin(jacobian.min(axis=1)))]].mean(axis=1)
        raise SolveError(f"the mesh folds over near x = {x * 1e3:.4g} mm, y = {y * 1e3:.4g} mm in the tooth's frame; {remedy}")
