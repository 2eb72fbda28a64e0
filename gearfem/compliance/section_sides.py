"""Where the nodes of a section stand along its sides: sizes of elements on the outline and towards the bore."""

from __future__ import annotations

import itertools
import math
from typing import TypeAlias

import numpy as np

from gearfem.flank import Outline
from gearfem.foundation import Array

# Element size of resolution 1, in modules, and the turn of the outline one element of it may span.
SIZE, TURN = 0.5, math.radians(25.0)
# Elements of resolution 1 for each e-fold of the distance from the tip round, on both sides: a load beside it sees it at its own size.
CROWD = 0.3
# Towards the bore elements grow with the distance from the root, as the field of a tooth fades, up to half their radius.
GROWTH, SHARE = 1.0, 0.5
# Growth of elements with the distance from a place of focus.
FADE = 0.35

Focus: TypeAlias = tuple[tuple[float, float, float], ...]


def count_elements(length: float, resolution: float) -> int:
    """Return how many elements a side of `length` [elements of resolution 1] gets; whole multiples nest."""
    return max(1, round(max(1, round(length)) * resolution))


def outline_nodes(outline: Outline, breaks: tuple[float, ...], resolution: float, size: float, focus: Focus = ()) -> Array:
    """Return parameters of nodes along the outline, with ends of elements at the breaks.

    Parameters
    ----------
    outline : Outline
        The outline.
    breaks : tuple of float
        Increasing parameters u; stretches without length are left out.
    resolution : float
        Multiplies the number of elements of each stretch.
    size : float
        Length of an element of resolution 1 [m].
    focus : tuple of (float, float, float)
        Places u with the length of elements there and the distance up to which they keep it [m], whatever the resolution.

    Returns
    -------
    ndarray, shape (2 n + 1,)
        Ends and middles of n elements, the first and the last break included. Elements are equal in length plus, on the fillet,
        turn; towards the tip round they grow smaller.
    """
    parts = [np.array([breaks[0]])]
    for start, end in itertools.pairwise(breaks):
        u = _samples(start, end, focus)
        length = np.hypot(*np.diff(outline.point(u), axis=0).T)
        if length.sum() < 1e-9 * outline.gear.module:
            parts[-1][-1] = end if start == breaks[0] else parts[-1][-1]
            continue
        measure = length / size
        if 1.0 <= start < 2.0:
            # An undercut ends in a corner: its end must not be counted as a turn.
            normal = outline.normal(np.minimum(u, np.nextafter(2.0, 1.0)))
            measure = measure + np.abs(np.diff(np.unwrap(np.arctan2(normal[:, 1], normal[:, 0])))) / TURN
        if end == 3.0 or start == 4.0:
            away = np.concatenate([[0.0], np.cumsum(length)])
            away = away if start == 4.0 else away[-1] - away
            measure = measure + CROWD * np.abs(np.diff(np.log(away + 2.0 * outline.gear.tip_edge_radius)))
        for place, fine, reach in focus:
            away = np.hypot(*(outline.point(0.5 * (u[1:] + u[:-1])) - outline.point(place)).T)
            measure = measure + length / (fine + FADE * np.maximum(away - reach, 0.0)) / resolution
        measure = np.concatenate([[0.0], np.cumsum(measure)])
        count = 2 * count_elements(measure[-1], resolution)
        parts.append(np.interp(np.arange(1, count + 1) / count * measure[-1], measure, u))
    return np.concatenate(parts)


def _samples(start: float, end: float, focus: Focus) -> Array:
    """Return parameters along a stretch of the outline, as much closer beside the tip round and places of focus as elements are."""
    part = np.linspace(0.0, 1.0, 129)
    if end == 3.0:
        part = 1.0 - (1.0 - part) ** 3
    elif start == 4.0:
        part = part**3
    u: Array = start + (end - start) * part
    u[-1] = end
    close = [place + sign * np.geomspace(1e-5, 1.0, 300) for place, _, _ in focus for sign in (-1.0, 1.0)]
    inside = [part[(part > start) & (part < end)] for part in close]
    return np.unique(np.concatenate([u, *inside])) if focus else u


def depths(top: float, bottom: float, first: float, resolution: float) -> Array:
    """Return radii of nodes from `top` down to `bottom`: elements of resolution 1 start with the size `first`."""
    radius = np.linspace(top, bottom, 2001)
    size = np.minimum(first + GROWTH * (top - radius), SHARE * radius)
    measure = np.concatenate([[0.0], np.cumsum(-np.diff(radius) * 0.5 * (1.0 / size[1:] + 1.0 / size[:-1]))])
    count = 2 * count_elements(measure[-1], resolution)
    radii: Array = np.interp(np.arange(count + 1) / count * measure[-1], measure, radius)
    radii[0], radii[-1] = top, bottom
    return radii


def polar(radius: float | Array, angle: Array) -> Array:
    """Return points of polar coordinates, shape (n, 2)."""
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


def even(count: int) -> Array:
    """Return equal fractions of a side of `count` elements, shape (2 count + 1,)."""
    return np.arange(2 * count + 1) / (2 * count)
