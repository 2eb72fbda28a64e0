"""A sector whose tooth is cut by the section through both 30 degree tangent points, its elements graded to a crack's tip."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import skfem
from scipy.optimize import brentq

from gearfem.compliance.elasticity import ELEMENT, QUADRATURE
from gearfem.compliance.patchwork import Ids, fractions, join, refuse_folds, straight, transfinite
from gearfem.compliance.section_mesh import TOP, body_patches, unworn
from gearfem.compliance.section_sides import SIZE
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError

# Elements grow by this part of their distance from the tip; towards the bore they reach half their radius.
GROWTH, SHARE = 0.6, 0.5
# Direction of the outward normal where the tangent stands 30 degrees to the tooth's axis.
NORMAL = math.pi / 3.0


@dataclasses.dataclass(frozen=True)
class CrackedSection:
    """A sector with a seam that can be opened.

    Parameters
    ----------
    mesh : skfem.MeshQuad2
        Nodes [m] in the frame of the `Outline`, the seam closed.
    open_cells : ndarray of int, shape (m, 9)
        Nodes of the elements with the seam open: below it, number n + i instead of seam[i].
    outline : ndarray of int, shape (2 n + 1,)
        Nodes of the loaded side above the seam, up to the middle of the tip.
    outline_u : ndarray, shape (2 n + 1,)
        Their parameters.
    seam : ndarray of int, shape (s,)
        Nodes of the crack from its mouth to the one before its tip.
    held, upper, lower : ndarray of int
        As in `SectionMesh`.
    """

    mesh: Any
    open_cells: Ids
    outline: Ids
    outline_u: Array
    seam: Ids
    held: Ids
    upper: Ids
    lower: Ids

    @property
    def faces(self) -> Ids:
        """Nodes of both faces of the open crack, its tip left out."""
        return np.concatenate([self.seam, self.mesh.doflocs.shape[1] + np.arange(len(self.seam))])

    @property
    def points(self) -> Array:
        """Nodes with the seam open [m], shape (n + s, 2)."""
        places: Array = self.mesh.doflocs.T
        return np.concatenate([places, places[self.seam]])

    def flank(self) -> Ids:
        """Return the nodes of the loaded side from the form circle to the middle of the tip round."""
        return self.outline[(self.outline_u >= 2.0 - 1e-9) & (self.outline_u <= TOP + 1e-9)]


def tangent_point(outline: Outline) -> float:
    """Return the parameter u of the point of the fillet where its tangent stands at 30 degrees to the tooth's axis.

    Parameters
    ----------
    outline : Outline
        Outline of the tooth.

    Returns
    -------
    float
        In (1, 2).

    Raises
    ------
    InputError
        If the fillet has no such tangent.
    """

    def beyond(u: float) -> float:
        return float(np.arctan2(*outline.normal(u)[::-1])) - NORMAL

    first, last = 1.0, float(np.nextafter(2.0, 1.0))
    if not beyond(first) < 0.0 < beyond(last):
        raise InputError("gear", f"a fillet of {outline.gear.teeth} teeth without a 30 degree tangent", "a gear whose fillet has one")
    return float(brentq(beyond, first, last, xtol=1e-14))


def section_chord(outline: Outline) -> float:
    """Return the length [m] of the section through both 30 degree tangent points of the tooth without wear."""
    sound = unworn(outline)
    return 2.0 * float(sound.point(tangent_point(sound))[1])


def crack_mesh(outline: Outline, depth: float, fine: float, resolution: float) -> CrackedSection:
    """Mesh a sector with a crack along the section through both 30 degree tangent points.

    Parameters
    ----------
    outline : Outline
        Outline of the tooth.
    depth : float
        Of the crack, from the fillet of the described side [m], above 0 and below the chord.
    fine : float
        Length of the elements at the crack's tip at resolution 1 [m].
    resolution : float
        Multiplies the number of elements along each side.

    Returns
    -------
    CrackedSection

    Raises
    ------
    InputError, SolveError
        If the fillet has no 30 degree tangent, or the mesh folds over.

    Notes
    -----
    The patches are those of `sector_mesh` with the chord as the floor of the tooth. Rows crowd at the chord, columns at the tip; with
    the same `fine` the nodes of the cuts do not depend on the depth.
    """
    gear, sound = outline.gear, unworn(outline)
    foot = tangent_point(sound)
    place = sound.point(foot)
    half, size = float(place[1]), SIZE * gear.module
    tip = half - depth
    columns = _columns(half, tip, min(fine, 0.1 * depth), size, resolution)
    side = _along(sound, (foot, 2.0, 3.0, TOP), fine, size, resolution)
    root = _along(sound, (foot, 0.0), 0.3 * depth, size, resolution)
    lid, heights = _lid(sound), fractions(sound.point(side))
    seam_radius = gear.root_radius - min(0.9 * gear.module, 0.5 * (gear.root_radius - gear.bore_radius))
    fall = float(np.hypot(*place)) - seam_radius
    rows = 1.0 - graded((fall,), fine, size, resolution)[::-1] / fall
    radii = seam_radius - graded((seam_radius - gear.bore_radius,), size, SHARE * gear.bore_radius, resolution)
    radii[-1] = gear.bore_radius

    def patches(shape: Outline, part: Array) -> tuple[Array, ...]:
        right, top, space = shape.point(side), shape.point(lid(part)), shape.point(root)
        top[0], space[0] = (gear.tip_radius, 0.0), right[0]
        floor = straight(np.array([place[0], 0.0]), right[0], part)
        tooth = transfinite(floor, right, top, straight(floor[0], top[0], heights))
        return tooth, *body_patches(gear, floor, space, rows, radii, (part, fractions(space)))

    work = join(patches(outline, columns[0]), patches(sound, columns[1]))
    refuse_folds(work.mesh, QUADRATURE[0], "a crack needs a wide tooth root: change the rack's tip radius or the bore radius")
    (tooth, _, space, ring), (idle, *body, rim) = work.above, work.below
    floor = np.concatenate([tooth[::-1, 0], idle[1:, 0]])
    seam = floor[work.mesh.doflocs[1, floor] > tip + 1e-9 * half]
    return CrackedSection(
        mesh=work.mesh,
        open_cells=open_cells(work.mesh, seam, np.concatenate([tooth.ravel(), idle.ravel()])),
        outline=np.concatenate([tooth[-1], tooth[-2::-1, -1]]),
        outline_u=np.concatenate([side, lid(columns[0])[-2::-1]]),
        seam=seam,
        held=np.unique(np.concatenate([ring[:, 0], rim[:, 0]])),
        upper=np.concatenate([space[-1, ::-1], ring[-1, -2::-1]]),
        lower=np.concatenate([body[1][-1, ::-1], rim[-1, -2::-1]]),
    )


def graded(breaks: tuple[float, ...], fine: float, largest: float, resolution: float) -> Array:
    """Return places of nodes from 0 on whose elements start with the size `fine` and grow up to `largest`.

    Parameters
    ----------
    breaks : tuple of float
        Places after 0 where elements end, increasing [m].
    fine, largest : float
        Sizes of elements at resolution 1 [m].
    resolution : float
        Multiplies the number of elements of each stretch.

    Returns
    -------
    ndarray, shape (2 n + 1,)
        Ends and middles of n elements.
    """
    length = breaks[-1]
    place = np.concatenate([[0.0], np.geomspace(1e-3 * min(fine, length), length, 1000)])
    size = np.minimum(fine + GROWTH * place, largest)
    measure = np.concatenate([[0.0], np.cumsum(np.diff(place) * 0.5 * (1.0 / size[1:] + 1.0 / size[:-1]))])
    ends = [np.zeros(1)]
    for start, end in itertools.pairwise((0.0, *breaks)):
        first, last = np.interp([start, end], place, measure)
        count = max(1, round(resolution * max(1, round(last - first))))
        ends.append(np.interp(first + np.arange(1, count + 1) / count * (last - first), measure, place))
        ends[-1][-1] = end
    return between(np.concatenate(ends))


def between(ends: Array) -> Array:
    """Return ends of elements with the middles between them, shape (n + 1,) -> (2 n + 1,)."""
    nodes = np.empty(2 * len(ends) - 1)
    nodes[::2], nodes[1::2] = ends, 0.5 * (ends[1:] + ends[:-1])
    return nodes


def _along(outline: Outline, breaks: tuple[float, ...], fine: float, largest: float, resolution: float) -> Array:
    """Return parameters of nodes along the outline with ends of elements at the breaks, graded over the arc from the first."""
    u = np.concatenate([np.linspace(*ends, 1001)[:-1] for ends in itertools.pairwise(breaks)] + [np.array(breaks[-1:])])
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(outline.point(u), axis=0).T))])
    nodes: Array = np.interp(graded(tuple(arc[1000::1000].tolist()), fine, largest, resolution), arc, u)
    return nodes


def _columns(half: float, tip: float, fine: float, largest: float, resolution: float) -> tuple[Array, Array]:
    """Return fractions of the half chords above and below the axis, as many on each, graded to the tip at y = `tip`."""
    reach = abs(tip)
    inner = reach - graded((reach,), fine, largest, resolution)[::-1] if reach > 0.0 else np.zeros(1)
    outer = reach + graded((half - reach,), fine, largest, resolution)
    near = np.concatenate([inner, outer[1:]]) / half
    near[0], near[-1] = 0.0, 1.0
    # The other half sees the tip from the distance; it takes as many columns as the half with the tip.
    place = graded((half,), fine + GROWTH * reach, largest, resolution) / half
    far = between(np.interp(np.linspace(0.0, 1.0, (len(near) + 1) // 2), np.linspace(0.0, 1.0, (len(place) + 1) // 2), place[::2]))
    return (near, far) if tip >= 0.0 else (far, near)


def _lid(outline: Outline) -> Callable[[Array], Array]:
    """Return the function from fractions of the tooth's top, from its middle outwards, to parameters."""
    u = np.linspace(5.0, TOP, 2001)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(outline.point(u), axis=0).T))])

    def at(part: Array) -> Array:
        nodes: Array = np.interp(part, arc / arc[-1], u)
        return nodes

    return at


def open_cells(mesh: Any, seam: Ids, above: Ids) -> Ids:
    """Return the nodes of elements on both sides of an open seam.

    Parameters
    ----------
    mesh : skfem.MeshQuad2
        Mesh with n nodes, the seam closed.
    seam : ndarray of int, shape (s,)
        Nodes of the seam without its tip.
    above : ndarray of int
        All nodes of the elements on the side that keeps the seam's nodes.

    Returns
    -------
    ndarray of int, shape (m, 9)
        On the other side number n + i stands instead of seam[i].
    """
    cells = np.asarray(skfem.Dofs(mesh, ELEMENT).element_dofs, dtype=np.int64).T
    # The node in the middle of an element belongs to it alone.
    below = ~np.isin(cells[:, 8], above)
    copy = np.arange(mesh.doflocs.shape[1])
    copy[seam] = mesh.doflocs.shape[1] + np.arange(len(seam))
    opened: Ids = np.where(below[:, None], copy[cells], cells)
    return opened
