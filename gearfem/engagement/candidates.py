"""Where the first touch of two teeth may lie: local minima over dense points of flanks and tip rounds, and edges."""

from __future__ import annotations

import functools
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearfem.flank import Outline
from gearfem.flank.outline import FLANK, ROUND, TIP
from gearfem.foundation import Array

# Pinion points on flank and round; points over the wheel's round; within a candidate; of the table that ranks them.
ON_FLANK, ON_ROUND, OVER_ROUND, ZOOMED, RANKED = 193, 49, 65, 17, (1025, 257)
TANGENT, EDGE1, EDGE2, SHELF = 0, 1, 2, 3
# Stands for the angle between the normals where the wheel has no point; at the edge of an undercut tooth it exceeds a radian.
NOWHERE = np.pi


class Candidates(NamedTuple):
    """Parts of the pinion's outline that hold one touch each; flat arrays.

    Parameters
    ----------
    row : ndarray
        Number of the angle.
    low, high, start : ndarray
        Ends of the part, and where to begin.
    kind : ndarray
        `TANGENT`, or the number of the gear whose edge touches (`EDGE1`, `EDGE2`), or `SHELF`: where the gap rises slowest, without
        a minimum.
    """

    row: NDArray[np.intp]
    low: Array
    high: Array
    start: Array
    kind: NDArray[np.intp]


class Ranked(NamedTuple):
    """Dense points of flank and tip round: parameters, and x, y, radius and polar angle in the tooth's frame."""

    u: Array
    x: Array
    y: Array
    radius: Array
    polar: Array


@functools.lru_cache(maxsize=256)
def _ranked(outline: Outline, on_flank: int, on_round: int) -> Ranked:
    u = np.concatenate([np.linspace(FLANK, ROUND, on_flank), np.linspace(ROUND, TIP, on_round)[1:]])
    x, y = np.moveaxis(outline.point(u), -1, 0)
    return Ranked(u, x, y, np.hypot(x, y), np.arctan2(y, x))


@functools.cache
def kernel() -> ModuleType:
    """Return the compiled search; the first call of a process loads the compiler (or its cached code)."""
    from gearfem.engagement import search_kernel as module

    return module


def _standing(wheel: Outline, distance: float, axis1: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Return R2 and the angle axis2 that each pinion point asks for, infinite where the wheel has no point; by table."""
    table = _ranked(wheel, *RANKED)
    radius, axis2 = np.empty((2, len(axis1), x.shape[-1]))
    kernel().stand(distance, axis1, np.atleast_2d(x), np.atleast_2d(y), table.radius, table.polar, radius, axis2)
    return radius, axis2


def find_candidates(pinion: Outline, wheel: Outline, distance: float, axis1: Array, within: float = 0.0) -> Candidates:
    """Return all parts of the pinion's outline in which the first touch may lie.

    Parameters
    ----------
    pinion, wheel : Outline
        The two teeth.
    distance : float
        Centre distance [m].
    axis1 : ndarray, shape (n,)
        Polar angles of the pinion's tooth [rad].
    within : float
        Turn of the wheel from the first touch within which further ones are wanted too [rad].

    Returns
    -------
    Candidates
        None or several for each angle.

    Notes
    -----
    A local minimum of the samples is kept if it may be the least of its angle, supposing only that the function is convex
    between samples. Each is then looked at 8 times closer for several minima in one.
    """
    grid = _ranked(pinion, ON_FLANK, ON_ROUND)
    radius, axis2 = _standing(wheel, distance, axis1, grid.x, grid.y)
    # The wheel's round is met within a narrow part of the pinion's outline, which gets points of its own.
    first, last = np.empty((2, len(axis1)), np.intp)
    kernel().met_within(radius, wheel.flank_end_radius, wheel.gear.tip_radius, first, last)
    rows = np.flatnonzero(first >= 0)
    first, last = first[rows], last[rows]
    fine = np.linspace(grid.u[first], grid.u[last], OVER_ROUND, axis=1)
    dense = _ranked(pinion, *RANKED)
    _, fine2 = _standing(wheel, distance, axis1[rows], np.interp(fine, dense.u, dense.x), np.interp(fine, dense.u, dense.y))
    lowest = axis2.min(axis=1)
    np.minimum.at(lowest, rows, fine2.min(axis=1))
    lowest = lowest + within
    wide, _ = _minima(grid.u, axis2, np.arange(len(axis1)), lowest)
    narrow, _ = _minima(fine, fine2, rows, lowest)
    tangent = _joined(wide, narrow)
    closer = np.linspace(tangent.low, tangent.high, ZOOMED, axis=1)
    x, y = np.interp(closer, dense.u, dense.x), np.interp(closer, dense.u, dense.y)
    inner, part = _minima(closer, _standing(wheel, distance, axis1[tangent.row], x, y)[1], tangent.row, lowest)
    # A part with one minimum keeps its own ends: those of the table's dense points err beside so small differences.
    several = np.bincount(part, minlength=tangent.row.size)[part] > 1
    shelves = [_shelves(grid, axis2, lowest)] if within > 0.0 else []
    return _joined(tangent, taken(inner, several), *shelves, *_edges(pinion, wheel, grid.u, radius))


def _joined(*parts: Candidates) -> Candidates:
    row, low, high, start, kind = (np.concatenate(values) for values in zip(*parts, strict=True))
    return Candidates(row, low, high, start, kind)


def taken(found: Candidates, which: NDArray[Any]) -> Candidates:
    """Return some of the candidates."""
    return Candidates(found.row[which], found.low[which], found.high[which], found.start[which], found.kind[which])


def _minima(u: Array, axis2: Array, rows: NDArray[np.intp], lowest: Array) -> tuple[Candidates, NDArray[np.intp]]:
    """Return the local minima that may be the least of their angle, if convex between samples, and their rows here."""
    row, column = kernel().minima(axis2, lowest[rows])
    here = np.broadcast_to(u, axis2.shape)
    low, high = here[row, np.maximum(column - 1, 0)], here[row, np.minimum(column + 1, here.shape[1] - 1)]
    return Candidates(rows[row], low, high, here[row, column], np.full(row.size, TANGENT)), row


def _shelves(grid: Ranked, axis2: Array, lowest: Array) -> Candidates:
    """Return where the samples on the flank rise or fall slowest, without a minimum beside."""
    flank = grid.u <= ROUND
    u, values = grid.u[flank], axis2[:, flank]
    with np.errstate(invalid="ignore"):
        slope = np.diff(values, axis=1) / np.hypot(np.diff(grid.x[flank]), np.diff(grid.y[flank]))
        steep = np.abs(slope)
        same = (slope[:, 1:-1] * slope[:, :-2] > 0.0) & (slope[:, 1:-1] * slope[:, 2:] > 0.0)
        least = same & (steep[:, 1:-1] < steep[:, :-2]) & (steep[:, 1:-1] <= steep[:, 2:]) & (values[:, 1:-2] <= lowest[:, None])
    row, column = np.nonzero(least)
    low, high = u[column], u[column + 3]
    return Candidates(row, low, high, 0.5 * (low + high), np.full(row.size, SHELF))


def _edges(pinion: Outline, wheel: Outline, u: Array, radius: Array) -> list[Candidates]:
    """Return where edges at the form circle meet the mate: the pinion's at the start of its flank, the wheel's at R2 of its own."""
    found = []
    if pinion.edged:
        row, start = np.arange(len(radius)), np.full(len(radius), FLANK)
        found.append(Candidates(row, start, start, start, np.full(row.size, EDGE1)))
    if wheel.edged:
        row, column = np.nonzero((radius[:, :-1] >= wheel.form_radius) & (radius[:, 1:] < wheel.form_radius))
        found.append(Candidates(row, u[column], u[column + 1], u[column], np.full(row.size, EDGE2)))
    return found
