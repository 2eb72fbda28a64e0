"""Second-order meshes of one tooth: with its sector of the gear body, and alone above its root."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from gearfem.compliance.patchwork import Ids, Patchwork, fractions, join, straight, transfinite
from gearfem.compliance.section_sides import SIZE, Focus, count_elements, depths, even, outline_nodes, polar
from gearfem.definition.setup import Gear
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError

# Where three patches meet on the fillet: its normal has turned through half its range there.
MEETING = 1.5
# Middle of the tip round, where the side of the tooth ends and its top begins.
TOP = 3.5


@dataclasses.dataclass(frozen=True)
class SectionMesh:
    """A mesh of one tooth about y = 0, with the node sets that loads, readings and supports need.

    Parameters
    ----------
    mesh : skfem.MeshQuad2
        Nodes [m] in the frame of the `Outline`; the nodes are the degrees of freedom of the biquadratic element.
    outline : ndarray of int, shape (2 n + 1,)
        Nodes of the described side, from the middle of the space or the clamp to the middle of the tip: end, middle, end of
        each edge.
    outline_u : ndarray, shape (2 n + 1,)
        Parameters of these nodes.
    idle : ndarray of int, shape (2 n + 1,)
        Nodes of the other side, with the same parameters; on a tooth without wear mirror images of the first.
    centreline : ndarray of int, shape (2 k + 1,)
        Nodes of the axis of symmetry of the tooth without wear, from the support to the tip.
    held : ndarray of int
        Nodes that do not move.
    upper, lower : ndarray of int
        Nodes of the two cuts through the middle of the tooth spaces, from the root to the bore, mirror images of
        one another; empty if the tooth stands alone.
    """

    mesh: Any
    outline: Ids
    outline_u: Array
    idle: Ids
    centreline: Ids
    held: Ids
    upper: Ids
    lower: Ids

    def flanks(self) -> Ids:
        """Return the nodes of both sides of the tooth from the form circle to the middle of the tip round."""
        first = 2 * int(np.searchsorted(self.outline_u[::2], 2.0 - 1e-9))
        loaded = slice(first, int(np.searchsorted(self.outline_u, TOP + 1e-9)))
        return np.union1d(self.outline[loaded], self.idle[loaded])

    @property
    def symmetric(self) -> bool:
        """Whether both sides are mirror images of one another."""
        places = self.mesh.doflocs
        return np.array_equal(places[:, self.idle], places[:, self.outline] * [[1.0], [-1.0]])


def _tooth_sides(outline: Outline, foot: float, resolution: float, focus: Focus = ()) -> tuple[Array, Array]:
    """Return parameters of the nodes above outline point `foot`: up the side, and from the tip round inwards along the top."""
    size = SIZE * outline.gear.module
    sides = tuple(u for u in (foot, 2.0, 3.0, TOP) if u >= foot)
    side = outline_nodes(outline, tuple(dict.fromkeys(sides)), resolution, size, focus)
    # As many elements across the top as the wider foot needs.
    width = np.hypot(*np.diff(outline.point(np.linspace(TOP, 5.0, 65)), axis=0).T).sum()
    # Elements under a place of focus are as thin as they are long: the columns crowd together at the outline.
    thin = ((TOP, min(fine for _, fine, _ in focus), 0.0),) if focus else ()
    return side, outline_nodes(outline, (TOP, 4.0, 5.0), resolution, size * min(1.0, width / outline.point(foot)[1]), thin)


def _tooth_patch(outline: Outline, side: Array, top: Array, axis: float, crowded: bool = False) -> Array:
    """Return the patch of the tooth above a spiral from the first point of its side to (axis, 0).

    The first direction runs from the axis to the outline, the second from the foot to the tip.
    """
    right, lid = outline.point(side), outline.point(top)[::-1]
    lid[0] = outline.gear.tip_radius, 0.0
    # Both sides of a worn tooth meet on the axis, where the side without wear has its nodes.
    height = unworn(outline).point(side)[:, 0]
    share = 0.5 * ((height - height[0]) / (height[-1] - height[0]) + np.linspace(0.0, 1.0, len(side)))
    # In polar coordinates the floor follows the circles below it, and leaves a layer above them however thin the rim is.
    part = fractions(lid) if crowded else np.linspace(0.0, 1.0, len(top))
    radius = axis + (np.hypot(*right[0]) - axis) * part
    floor = polar(radius, math.atan2(right[0, 1], right[0, 0]) * part)
    floor[-1] = right[0]
    return transfinite(floor, right, lid, straight(floor[0], lid[0], share))


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
    sound = unworn(outline)
    meeting = sound.point(MEETING)
    depth = min(0.9 * gear.module, 0.5 * (gear.root_radius - gear.bore_radius))
    seam = gear.root_radius - depth
    # The first gives each of the three patches a third of the straight angle; a thin rim leaves less room.
    axis = max(meeting[0] - 0.45 * meeting[1], 0.5 * (np.hypot(*meeting) + seam))
    side, top = _tooth_sides(sound, MEETING, resolution, focus)
    root = outline_nodes(sound, (0.0, 1.0, MEETING), resolution, SIZE * gear.module)
    layers = count_elements(depth / (SIZE * gear.module), resolution)
    radii = depths(seam, gear.bore_radius, depth / max(1, round(depth / (SIZE * gear.module))), resolution)

    def half(shape: Outline) -> tuple[Array, ...]:
        tooth, space = _tooth_patch(shape, side, top, axis, bool(focus)), shape.point(root)[::-1]
        return tooth, *body_patches(gear, tooth[:, 0], space, even(layers), radii, (even(len(top) // 2), even(len(root) // 2)))

    work = join(half(outline), None if outline is sound else half(sound))
    return _sector_sets(work, np.concatenate([root, side[1:], top[1:]]))


def body_patches(
    gear: Gear, floor: Array, space: Array, rows: Array, radii: Array, columns: tuple[Array, Array]
) -> tuple[Array, Array, Array]:
    """Return the patches below the tooth, below the space and the ring under both.

    Parameters
    ----------
    gear : Gear
        The gear.
    floor, space : ndarray, shapes (n, 2), (m, 2)
        The tooth's floor from the axis to its foot on the outline, and the outline from there to the middle of the space [m].
    rows : ndarray, shape (k,)
        Fractions of the way up from a seam between the ring and the others.
    radii : ndarray, shape (r,)
        Of the ring, from the seam down to the bore [m].
    columns : (ndarray, ndarray), shapes (n,), (m,)
        Fractions of the seam's arcs below the tooth and below the space.
    """
    seam, meeting = radii[0], floor[-1]
    angle = math.atan2(meeting[1], meeting[0])
    under = polar(seam, angle * columns[0])
    beside = polar(seam, angle + (math.pi / gear.teeth - angle) * columns[1])
    beside[0] = under[-1]
    fall = straight(under[-1], meeting, rows)
    below = transfinite(under, fall, floor, straight(under[0], floor[0], rows))
    flank = transfinite(beside, straight(beside[-1], space[-1], rows), space, fall)
    arc = np.concatenate([under, beside[1:]])
    ring = arc[:, None] * (radii[::-1] / seam)[None, :, None]
    ring[:, -1] = arc
    return below, flank, ring


def _sector_sets(work: Patchwork, u: Array) -> SectionMesh:
    tooth, below, _, ring = work.above
    cuts = [np.concatenate([half[2][-1, ::-1], half[3][-1, -2::-1]]) for half in (work.above, work.below)]
    sides = [np.concatenate([half[2][::-1, -1], half[0][-1, 1:], half[0][-2::-1, -1]]) for half in (work.above, work.below)]
    return SectionMesh(
        mesh=work.mesh,
        outline=sides[0],
        outline_u=u,
        idle=sides[1],
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
    gear, sound = outline.gear, unworn(outline)
    end = sound.point(1.0)
    base = end[0] if chord else gear.root_radius
    side, top = _tooth_sides(sound, 2.0, resolution)
    fillet = outline_nodes(sound, (1.0, 2.0), resolution, SIZE * gear.module)
    part = np.linspace(0.0, 1.0, len(top))
    clamp = straight(np.array([base, 0.0]), end, part) if chord else polar(gear.root_radius, math.atan2(end[1], end[0]) * part)
    clamp[-1] = end
    share = np.linspace(0.0, 1.0, len(fillet))

    def half(shape: Outline) -> tuple[Array, Array]:
        tooth = _tooth_patch(shape, side, top, sound.form_radius)
        right = shape.point(fillet)
        right[0] = end
        return tooth, transfinite(clamp, right, tooth[:, 0], straight(clamp[0], tooth[0, 0], share))

    work = join(half(outline), None if outline is sound else half(sound))
    sides = [np.concatenate([foot[-1], tooth[-1, 1:], tooth[-2::-1, -1]]) for tooth, foot in (work.above, work.below)]
    upper, lower = work.above
    none = np.empty(0, dtype=np.int64)
    return SectionMesh(
        mesh=work.mesh,
        outline=sides[0],
        outline_u=np.concatenate([fillet, side[1:], top[1:]]),
        idle=sides[1],
        centreline=np.concatenate([lower[0], upper[0, 1:]]),
        held=np.unique(np.concatenate([lower[:, 0], work.below[1][:, 0]])),
        upper=none,
        lower=none,
    )


def unworn(outline: Outline) -> Outline:
    """Return the outline of the idle side: that of the gear without anything missing."""
    return outline if outline.deviation is None else Outline(gear=outline.gear)
