"""Compliance on a mesh made elsewhere: checked against the gear, loaded on its flank, read at its centreline."""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import numpy as np
import skfem
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from gearfem.compliance.elasticity import Plane, PlaneStrain, assemble
from gearfem.compliance.load_lines import LoadLines, load_lines
from gearfem.compliance.mesh_file import FLANK, HELD, MeshFile
from gearfem.compliance.patchwork import Ids
from gearfem.compliance.record import ComplianceCurve
from gearfem.compliance.ring import factorise
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.threads import one_thread
from gearfem.foundation.units import MM

# Flank nodes may stand off the outline by this part of the module: below the manufacturing tolerance of coarse gears.
TOLERANCE = 0.005
UNITS = {"metres": 1e-3, "centimetres": 0.1, "inches": 1.0 / 25.4, "micrometres": 1e3}


class _Kind(NamedTuple):
    """An element: scikit-fem's shape functions, order of quadrature, and its sides as local nodes."""

    element: skfem.Element
    order: int
    sides: tuple[tuple[int, ...], ...]


KINDS = {
    "triangle": _Kind(skfem.ElementTriP1(), 2, ((0, 1), (1, 2), (2, 0))),
    "triangle6": _Kind(skfem.ElementTriP2(), 4, ((0, 1, 3), (1, 2, 4), (2, 0, 5))),
    "quad": _Kind(skfem.ElementQuad1(), 3, ((0, 1), (1, 2), (2, 3), (3, 0))),
    "quad8": _Kind(skfem.ElementQuadS2(), 5, ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7))),
    "quad9": _Kind(skfem.ElementQuad2(), 5, ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7))),
}


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class ForeignMesh(Record):
    """A plane mesh of a tooth or of a whole gear, one tooth of it along +x, the gear's centre at the origin.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Nodes [m].
    cells : tuple of (str, ndarray of int)
        Elements of one type each: triangle, triangle6, quad, quad8, quad9, counter-clockwise.
    held, flank : ndarray of int
        Nodes that do not move, and nodes of the flanks.
    support : str
        ``bore`` or ``root``: the name of the held set.
    """

    points: Array
    cells: tuple[tuple[str, Ids], ...]
    held: Ids
    flank: Ids
    support: str

    @property
    def span(self) -> float:
        """Angle at the gear's centre that the held nodes cover [rad], 2 pi for a whole ring."""
        angle = np.sort(np.arctan2(self.points[self.held, 1], self.points[self.held, 0]))
        gaps = np.diff(np.append(angle, angle[0] + 2.0 * np.pi))
        # A closed ring has no gap much wider than the rest.
        return 2.0 * np.pi if gaps.max() < 4.0 * np.median(gaps) else float(2.0 * np.pi - gaps.max())


def check_mesh(file: MeshFile, outline: Outline) -> ForeignMesh:
    """Check a mesh from a file against the gear it is meant for.

    Parameters
    ----------
    file : MeshFile
        As read, in mm.
    outline : Outline
        Outline of the tooth.

    Returns
    -------
    ForeignMesh

    Raises
    ------
    InputError
        If a boundary set is missing or doubtful, the unit is not mm, elements are inverted or degenerate, a part is not
        connected to the held nodes, or flank nodes stand off the outline by more than 0.005 module.
    """
    names = [name for name in HELD if name in file.sets]
    if len(names) != 1 or FLANK not in file.sets:
        found = ", ".join(file.sets) or "none"
        raise InputError("boundary sets", found, f"{FLANK}, and one of bore and root for what is held")
    cells = tuple(file.cells)
    used = np.unique(np.concatenate([nodes.ravel() for _, nodes in cells]))
    if used[0] < 0 or used[-1] >= len(file.points):
        raise InputError("cells", f"node number {used[-1]}", f"at most {len(file.points) - 1}, the last node")
    held, flank = (np.intersect1d(file.sets[name], used) for name in (names[0], FLANK))
    if held.size < 2 or flank.size < 2:
        raise InputError("boundary sets", f"{held.size} nodes of {names[0]} and {flank.size} of {FLANK} on elements", "at least 2 of each")
    _refuse_unit(np.hypot(*file.points[flank].T), outline)
    mesh = ForeignMesh(points=file.points * MM, cells=cells, held=held, flank=flank, support=names[0])
    _refuse_folds(mesh)
    _refuse_loose(mesh)
    _refuse_other_gear(mesh, outline)
    return mesh


def foreign_curve(mesh: ForeignMesh, outline: Outline, u: ArrayLike, plane: Plane | None = None) -> ComplianceCurve:
    """Compute the compliance over load positions on a mesh made elsewhere.

    Parameters
    ----------
    mesh : ForeignMesh
        As from `check_mesh`.
    outline : Outline
        Outline of the tooth.
    u : array_like, shape (n,)
        Increasing load positions in [2, 4).
    plane : Plane, optional
        By default plane strain.

    Returns
    -------
    ComplianceCurve
        Of the positions that lie on an edge of the flank set and whose load line crosses y = 0 inside the mesh.

    Raises
    ------
    InputError, SolveError
        If there is no such position, or the mesh is not held.

    Notes
    -----
    Nothing is assumed of the rest of the gear: what the mesh leaves out is missing. No error is estimated, since one mesh
    alone does not tell. A load within an edge is spread by the shape functions of that edge, the reading is that of the element
    around the crossing; on second-order meshes the error falls as in `FiniteElements`, on linear ones slower and with locking.
    """
    plane, lines = plane or PlaneStrain(), load_lines(outline, u)
    kept, weights = [], []
    sides = _flank_sides(mesh)
    for number in range(len(lines.u)):
        load = _edge_weights(mesh, sides, lines.point[number], lines.direction[number])
        reading = _inner_weights(mesh, np.array([lines.crossing[number], 0.0]))
        if load is not None and reading is not None:
            kept.append(number)
            weights.append((load, reading))
    if not kept:
        raise InputError("flank", "no load position on its edges with a crossing of load line and axis in the mesh", "a tooth along +x")
    lines = lines.kept(np.array(kept))
    return ComplianceCurve(
        method=f"fe_{plane.name}",
        support=mesh.support,
        u=lines.u,
        radius=lines.radius,
        deflection=_solve(mesh, outline, lines, weights, plane),
        depth=lines.depth,
    )


def _solve(mesh: ForeignMesh, outline: Outline, lines: LoadLines, weights: list[tuple[Weights, Weights]], plane: Plane) -> Array:
    nodes = len(mesh.points)
    matrix: Any = 0.0
    for kind, cells in mesh.cells:
        grad, dx = _gradients(mesh, kind, cells)
        matrix = matrix + assemble(grad, dx, cells, nodes, plane.lame(outline.gear.material))
    used = np.unique(np.concatenate([cells.ravel() for _, cells in mesh.cells]))
    free = np.setdiff1d(used, mesh.held)
    free = np.concatenate([free, free + nodes])
    columns = [np.zeros((2 * nodes, len(lines.u))) for _ in range(2)]
    for case, pair in enumerate(weights):
        for column, (ids, share) in zip(columns, pair, strict=True):
            for axis in (0, 1):
                column[ids + axis * nodes, case] = share * lines.direction[case, axis]
    load, reading = columns
    with one_thread():
        moved = factorise(matrix[free][:, free]).solve(np.ascontiguousarray(load[free]))
    shown: Array = (reading[free] * moved).sum(axis=0)
    return shown


# ---- elements ---------------------------------------------------------------------------------------

Weights = tuple[Ids, Array]


def _gradients(mesh: ForeignMesh, kind: str, cells: Ids) -> tuple[Array, Array]:
    """Return the gradients of the shape functions, shape (2, m, k, q), and the weights of the points, shape (m, q)."""
    element = KINDS[kind].element
    places, weight = skfem.quadrature.get_quadrature(element, KINDS[kind].order)
    local = np.stack([element.lbasis(places, i)[1] for i in range(cells.shape[1])])
    jacobian = np.einsum("mkx,klq->mqxl", mesh.points[cells], local)
    determinant = np.linalg.det(jacobian)
    if not determinant.min() > 0.0:
        return np.empty(0), determinant * weight
    grad = np.einsum("klq,mqlx->xmkq", local, np.linalg.inv(jacobian))
    return grad, determinant * weight


def _flank_sides(mesh: ForeignMesh) -> list[Ids]:
    """Return the sides of elements on the boundary whose corners belong to the flank."""
    sides = [cells[:, list(side)] for kind, cells in mesh.cells for side in KINDS[kind].sides]
    corners = np.sort(np.concatenate([side[:, :2] for side in sides]), axis=1)
    _, number, count = np.unique(corners, axis=0, return_inverse=True, return_counts=True)
    outer = np.split(count[number.ravel()] == 1, np.cumsum([len(side) for side in sides])[:-1])
    return [row for side, free in zip(sides, outer, strict=True) for row in side[free & np.isin(side[:, :2], mesh.flank).all(axis=1)]]


def _edge_weights(mesh: ForeignMesh, sides: list[Ids], place: Array, direction: Array) -> Weights | None:
    """Return the shares of nodes in a load at `place`, where the flank's edge lies square to it; None off the flank."""
    tangent = np.array([-direction[1], direction[0]])
    best: tuple[float, Weights] | None = None
    for ids in sides:
        away = mesh.points[ids] - place
        along, across = away @ tangent, away @ direction
        if along[0] * along[1] > 0.0 or (best is not None and np.abs(across[:2]).min() > best[0] + np.ptp(along[:2])):
            continue
        part = _root_on_edge(along)
        share = _edge_shape(part, len(ids))
        distance = abs(float(share @ across))
        # A straight edge of length l stands off a curve by l^2/(8 R): a tenth of l is beyond any edge that follows the outline.
        if distance < 0.1 * np.ptp(along[:2]) and (best is None or distance < best[0]):
            best = distance, (ids, share)
    return None if best is None else best[1]


def _root_on_edge(along: Array) -> float:
    """Return the fraction of an edge at which its coordinate along the tangent is 0; by Newton's method on curved ones."""
    if len(along) == 2:
        return float(along[0] / (along[0] - along[1]))
    part = 0.5
    for _ in range(30):
        slope = along @ np.array([4.0 * part - 3.0, 4.0 * part - 1.0, 4.0 - 8.0 * part])
        step = float(along @ _edge_shape(part, 3) / slope)
        part -= step
        if abs(step) < 1e-14:
            break
    return part


def _edge_shape(part: float, nodes: int) -> Array:
    if nodes == 2:
        return np.array([1.0 - part, part])
    return np.array([(1.0 - part) * (1.0 - 2.0 * part), part * (2.0 * part - 1.0), 4.0 * part * (1.0 - part)])


def _inner_weights(mesh: ForeignMesh, place: Array) -> Weights | None:
    """Return the shape functions at a place inside the mesh; None outside."""
    for kind, cells in mesh.cells:
        corners = mesh.points[cells]
        margin = 0.1 * np.ptp(corners, axis=1).max(axis=1)
        near = np.all((corners.min(axis=1) - margin[:, None] <= place) & (place <= corners.max(axis=1) + margin[:, None]), axis=1)
        for ids in cells[near]:
            share = _invert(KINDS[kind].element, mesh.points[ids], place)
            if share is not None:
                return ids, share
    return None


def _invert(element: skfem.Element, corners: Array, place: Array) -> Array | None:
    """Return the shape functions of an element at a place, None if it lies outside; by Newton's method."""
    triangle = element.refdom.nnodes == 3
    local = np.full((2, 1), 1.0 / 3.0 if triangle else 0.5)
    for _ in range(30):
        pairs = [element.lbasis(local, i) for i in range(len(corners))]
        share = np.array([float(np.ravel(value)[0]) for value, _ in pairs])
        slope = np.stack([np.asarray(gradient)[:, 0] for _, gradient in pairs])
        step = np.linalg.lstsq(corners.T @ slope, place - share @ corners, rcond=None)[0]
        local = local + step[:, None]
        if np.abs(step).max() < 1e-13:
            break
    inside = local.min() > -1e-9 and (local.sum() if triangle else local.max()) < 1.0 + 1e-9
    found = inside and np.abs(share @ corners - place).max() < 1e-9 * np.abs(corners).max()
    return share if found else None


# ---- refusals ---------------------------------------------------------------------------------------


def _refuse_unit(radius: Array, outline: Outline) -> None:
    """Compare the radii of the flank nodes [mm, if the file is right] with those of the gear."""
    low, high = outline.form_radius / MM, outline.gear.tip_radius / MM
    if not 0.9 * low < radius.max() < 1.05 * high:
        likely = [name for name, size in UNITS.items() if 0.9 * low < radius.max() / size < 1.05 * high]
        looks = f", which looks like {likely[0]}" if likely else ""
        found = f"radii from {radius.min():.6g} to {radius.max():.6g}{looks}"
        raise InputError("flank", found, f"millimetres from the gear's centre, between {low:.2f} and {high:.2f} for this gear")


def _refuse_folds(mesh: ForeignMesh) -> None:
    for kind, cells in mesh.cells:
        area = _gradients(mesh, kind, cells)[1]
        bad = np.flatnonzero(area.min(axis=1) <= 1e-12 * np.ptp(mesh.points[cells], axis=1).max(axis=1) ** 2)
        if bad.size:
            x, y = mesh.points[cells[bad[0]]].mean(axis=0) / MM
            sort = "inverted" if area[bad].max(axis=1).min() < 0.0 else "degenerate or folded"
            found = f"{bad.size} of {len(cells)} {kind} elements {sort}, the first near x = {x:.4g} mm, y = {y:.4g} mm"
            raise InputError("cells", found, "elements numbered counter-clockwise, of positive area at every point of integration")


def _refuse_loose(mesh: ForeignMesh) -> None:
    nodes = len(mesh.points)
    pairs = np.concatenate([np.stack([np.repeat(cells[:, 0], cells.shape[1]), cells.ravel()]) for _, cells in mesh.cells], axis=1)
    graph = sparse.coo_array((np.ones(pairs.shape[1]), pairs), shape=(nodes, nodes))
    part: NDArray[np.int32] = connected_components(graph, directed=False)[1]
    loose = np.setdiff1d(part[pairs[0]], part[mesh.held])
    if loose.size:
        x, y = mesh.points[np.flatnonzero(part == loose[0])[0]] / MM
        raise InputError("cells", f"{loose.size} parts without held nodes, one at x = {x:.4g} mm, y = {y:.4g} mm", "one connected mesh")


def _refuse_other_gear(mesh: ForeignMesh, outline: Outline) -> None:
    """Refuse flank nodes off the outline, each taken to the described side of the tooth along +x by the gear's symmetry."""
    pitch = outline.gear.pitch_angle
    x, y = mesh.points[mesh.flank].T
    polar = np.abs(np.mod(np.arctan2(y, x) + 0.5 * pitch, pitch) - 0.5 * pitch)
    places = np.hypot(x, y)[:, None] * np.stack([np.cos(polar), np.sin(polar)], axis=1)
    u = np.linspace(0.0, 5.0, 10001)
    points, normals = outline.point(u), outline.normal(u)
    nearest = cKDTree(points).query(places)[1]
    off = np.abs(((places - points[nearest]) * normals[nearest]).sum(axis=1))
    # Beyond the end of a stretch the normal alone would miss a node that lies far along the tangent.
    off = np.maximum(off, np.hypot(*(places - points[nearest]).T) - np.hypot(*np.diff(points, axis=0).T).max())
    allowed = TOLERANCE * outline.gear.module
    if off.max() > allowed:
        worst = int(np.argmax(off))
        found = (
            f"{np.count_nonzero(off > allowed)} of {off.size} nodes off the tooth's outline, by up to {off.max() / MM:.4g} mm "
            f"at x = {x[worst] / MM:.4f} mm, y = {y[worst] / MM:.4f} mm"
        )
        raise InputError(FLANK, found, f"at most {allowed / MM:.4g} mm (0.005 module) off the model's tooth along +x, gear centre at 0, 0")
