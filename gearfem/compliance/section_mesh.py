"""Second-order meshes of one tooth: with its sector of the gear body, and alone above its root."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any, TypeAlias

import numpy as np

from gearfem.compliance.patchwork import Ids, Patchwork, fractions, join, straight, transfinite
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError

# Where three patches meet on the fillet: its normal has turned through half its range there.
MEETING = 1.5
# Middle of the tip round, where the side of the tooth ends and its top begins.
TOP = 3.5
# Element size of resolution 1, in modules, and the turn of the outline one element of it may span.
SIZE, TURN = 0.5, math.radians(25.0)
# Elements of resolution 1 for each e-fold of the distance from the tip round, on both sides: a load beside it sees it at its own size.
CROWD = 0.3
# Towards the bore elements grow with the distance from the root, as the field of a tooth fades, up to half their radius.
GROWTH, SHARE = 1.0, 0.5
# Growth of elements with the distance from a place of focus.
FADE = 0.35

Focus: TypeAlias = tuple[tuple[float, float, float], ...]


@dataclasses.dataclass(frozen=True)
class SectionMesh:
    """A mesh of one tooth, symmetric about y = 0, with the node sets that loads, readings and supports need.

    Parameters
    ----------
    mesh : skfem.MeshQuad2
        Nodes [m] in the frame of the `Outline`; the nodes are the degrees of freedom of the biquadratic element.
    outline : ndarray of int, shape (2 n + 1,)
        Nodes of the described side, from the middle of the space or the clamp to the middle of the tip: end, middle, end of
        each edge.
    outline_u : ndarray, shape (2 n + 1,)
        Parameters of these nodes.
    centreline : ndarray of int, shape (2 k + 1,)
        Nodes of the axis of symmetry from the support to the tip.
    held : ndarray of int
        Nodes that do not move.
    upper, lower : ndarray of int
        Nodes of the two cuts through the middle of the tooth spaces, from the root to the bore, mirror images of
        one another; empty if the tooth stands alone.
    """

    mesh: Any
    outline: Ids
    outline_u: Array
    centreline: Ids
    held: Ids
    upper: Ids
    lower: Ids

    def flanks(self) -> Ids:
        """Return the nodes of both sides of the tooth from the form circle to the middle of the tip round."""
        first = 2 * int(np.searchsorted(self.outline_u[::2], 2.0 - 1e-9))
        side = self.outline[first : int(np.searchsorted(self.outline_u, TOP + 1e-9))]
        places = self.mesh.doflocs
        at = {(x, y): number for number, (x, y) in enumerate(places.T.tolist())}
        other = [at[x, 0.0 - y] for x, y in places[:, side].T.tolist()]
        return np.union1d(side, np.array(other, dtype=np.int64))


# ---- sides ------------------------------------------------------------------------------------------


def _count(length: float, resolution: float) -> int:
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
        count = 2 * _count(measure[-1], resolution)
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


def _depths(top: float, bottom: float, first: float, resolution: float) -> Array:
    """Return radii of nodes from `top` down to `bottom`: elements of resolution 1 start with the size `first`."""
    radius = np.linspace(top, bottom, 2001)
    size = np.minimum(first + GROWTH * (top - radius), SHARE * radius)
    measure = np.concatenate([[0.0], np.cumsum(-np.diff(radius) * 0.5 * (1.0 / size[1:] + 1.0 / size[:-1]))])
    count = 2 * _count(measure[-1], resolution)
    radii: Array = np.interp(np.arange(count + 1) / count * measure[-1], measure, radius)
    radii[0], radii[-1] = top, bottom
    return radii


def _polar(radius: float | Array, angle: Array) -> Array:
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


def _even(count: int) -> Array:
    return np.arange(2 * count + 1) / (2 * count)


def _tooth_patch(outline: Outline, foot: float, axis: float, resolution: float, focus: Focus = ()) -> tuple[Array, Array, Array]:
    """Return the patch of the tooth above a spiral from outline point `foot` to (axis, 0).

    The first direction runs from the axis to the outline, the second from the foot to the tip. Also the parameters
    of the nodes on the outline side and, from the tip round inwards, on the top.
    """
    size = SIZE * outline.gear.module
    sides = tuple(u for u in (foot, 2.0, 3.0, TOP) if u >= foot)
    side = outline_nodes(outline, tuple(dict.fromkeys(sides)), resolution, size, focus)
    # As many elements across the top as the wider foot needs.
    width = np.hypot(*np.diff(outline.point(np.linspace(TOP, 5.0, 65)), axis=0).T).sum()
    # Elements under a place of focus are as thin as they are long: the columns crowd together at the outline.
    thin = ((TOP, min(fine for _, fine, _ in focus), 0.0),) if focus else ()
    top = outline_nodes(outline, (TOP, 4.0, 5.0), resolution, size * min(1.0, width / outline.point(foot)[1]), thin)
    right, lid = outline.point(side), outline.point(top)[::-1]
    lid[0] = outline.gear.tip_radius, 0.0
    height = (right[:, 0] - right[0, 0]) / (right[-1, 0] - right[0, 0])
    share = 0.5 * (height + np.linspace(0.0, 1.0, len(side)))
    # In polar coordinates the floor follows the circles below it, and leaves a layer above them however thin the rim is.
    part = fractions(lid) if focus else np.linspace(0.0, 1.0, len(top))
    radius = axis + (np.hypot(*right[0]) - axis) * part
    floor = _polar(radius, math.atan2(right[0, 1], right[0, 0]) * part)
    floor[-1] = right[0]
    return transfinite(floor, right, lid, straight(floor[0], lid[0], share)), side, top


# ---- meshes -----------------------------------------------------------------------------------------


def sector_mesh(outline: Outline, resolution: float, focus: Focus = ()) -> SectionMesh:
    """Mesh one tooth with its sector of the body, from the bore to the tip, cut in the middle of the spaces.

    Parameters
    ----------
    outline : Outline
        Outline of the tooth.
    resolution : float
        Elements along each side, relative to a coarse mesh with elements of half a module.
    focus : tuple of (float, float, float)
        Places u of the flank with the length of elements there and the distance up to which they keep it [m].

    Returns
    -------
    SectionMesh
        Held on the bore.

    Raises
    ------
    InputError
        If the bore does not lie below the root circle.

    Notes
    -----
    Each half has four patches: the tooth, the body below it, the body below the space, and the ring below both.
    The first three meet on the fillet, where each takes a third of the straight angle; below, an arc under the root separates
    them from the ring, whose elements grow towards the bore.
    """
    gear = outline.gear
    if not 0.0 < gear.bore_radius < gear.root_radius:
        raise InputError("bore_radius_mm", f"{gear.bore_radius * 1e3:g} mm", f"between 0 and the root radius {gear.root_radius * 1e3:g} mm")
    meeting = outline.point(MEETING)
    depth = min(0.9 * gear.module, 0.5 * (gear.root_radius - gear.bore_radius))
    seam = gear.root_radius - depth
    # The first gives each of the three patches a third of the straight angle; a thin rim leaves less room.
    axis = max(meeting[0] - 0.45 * meeting[1], 0.5 * (np.hypot(*meeting) + seam))
    tooth, side, top = _tooth_patch(outline, MEETING, axis, resolution, focus)
    root = outline_nodes(outline, (0.0, 1.0, MEETING), resolution, SIZE * gear.module)
    space = outline.point(root)[::-1]

    layers = _count(depth / (SIZE * gear.module), resolution)
    polar = math.atan2(meeting[1], meeting[0])
    under = _polar(seam, polar * np.linspace(0.0, 1.0, len(top)))
    beside = _polar(seam, polar + (math.pi / gear.teeth - polar) * np.linspace(0.0, 1.0, len(root)))
    beside[0] = under[-1]
    fall = straight(under[-1], meeting, _even(layers))
    below = transfinite(under, fall, tooth[:, 0], straight(under[0], tooth[0, 0], _even(layers)))
    flank = transfinite(beside, straight(beside[-1], space[-1], _even(layers)), space, fall)
    radii = _depths(seam, gear.bore_radius, depth / max(1, round(depth / (SIZE * gear.module))), resolution)
    arc = np.concatenate([under, beside[1:]])
    ring = arc[:, None] * (radii[::-1] / seam)[None, :, None]
    ring[:, -1] = arc
    work = join((tooth, below, flank, ring))
    return _sector_sets(work, np.concatenate([root, side[1:], top[1:]]))


def _sector_sets(work: Patchwork, u: Array) -> SectionMesh:
    tooth, below, space, ring = work.above
    cuts = [np.concatenate([half[2][-1, ::-1], half[3][-1, -2::-1]]) for half in (work.above, work.below)]
    return SectionMesh(
        mesh=work.mesh,
        outline=np.concatenate([space[::-1, -1], tooth[-1, 1:], tooth[-2::-1, -1]]),
        outline_u=u,
        centreline=np.concatenate([ring[0], below[0, 1:], tooth[0, 1:]]),
        held=np.unique(np.concatenate([ring[:, 0], work.below[3][:, 0]])),
        upper=cuts[0],
        lower=cuts[1],
    )


def root_mesh(outline: Outline, resolution: float, chord: bool) -> SectionMesh:
    """Mesh the tooth alone, held between the ends of its two fillets.

    Parameters
    ----------
    outline : Outline
        Outline of the tooth.
    resolution : float
        As in `sector_mesh`.
    chord : bool
        Held on the straight chord, instead of the arc of the root circle.

    Returns
    -------
    SectionMesh

    Notes
    -----
    The fillet is tangent to the root circle where both end: the elements in the corner are slivers with an angle near zero at
    one corner, but with a positive Jacobian at every point of integration.
    """
    gear = outline.gear
    end = outline.point(1.0)
    base = end[0] if chord else gear.root_radius
    tooth, side, top = _tooth_patch(outline, 2.0, outline.form_radius, resolution)
    fillet = outline_nodes(outline, (1.0, 2.0), resolution, SIZE * gear.module)
    part = np.linspace(0.0, 1.0, len(top))
    clamp = straight(np.array([base, 0.0]), end, part) if chord else _polar(gear.root_radius, math.atan2(end[1], end[0]) * part)
    clamp[-1] = end
    share = np.linspace(0.0, 1.0, len(fillet))
    foot_patch = transfinite(clamp, outline.point(fillet), tooth[:, 0], straight(clamp[0], tooth[0, 0], share))
    work = join((tooth, foot_patch))
    upper, lower = work.above
    none = np.empty(0, dtype=np.int64)
    return SectionMesh(
        mesh=work.mesh,
        outline=np.concatenate([lower[-1], upper[-1, 1:], upper[-2::-1, -1]]),
        outline_u=np.concatenate([fillet, side[1:], top[1:]]),
        centreline=np.concatenate([lower[0], upper[0, 1:]]),
        held=np.unique(np.concatenate([lower[:, 0], work.below[1][:, 0]])),
        upper=none,
        lower=none,
    )
