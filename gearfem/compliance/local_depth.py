"""The depth of the half space that yields under a line load as the tooth does between contact and centreline."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gearfem.compliance.elasticity import Plane
from gearfem.compliance.load_lines import LoadLines, edge_shape
from gearfem.compliance.patchwork import Ids
from gearfem.compliance.section_mesh import SectionMesh, unworn
from gearfem.definition.setup import Material
from gearfem.flank import Outline
from gearfem.foundation import Array

_GAUSS, _WEIGHT = np.polynomial.legendre.leggauss(8)
# Places along an edge: its start, Gauss points, its end.
STATIONS: Array = np.concatenate([[0.0], 0.5 + 0.5 * _GAUSS, [1.0]])


class Boundary(NamedTuple):
    """Edges of the boundary, each with the metal on its right.

    Parameters
    ----------
    nodes : ndarray of int, shape (e, 3)
        Start, middle and end of each edge.
    places : ndarray, shape (e, 10, 2)
        The true boundary at `STATIONS` [m].
    u : ndarray, shape (e, 10)
        Parameters on the described side of the outline; infinite elsewhere.
    """

    nodes: Ids
    places: Array
    u: Array


def local_depth(section: SectionMesh, outline: Outline, lines: LoadLines, moved: Array, matrix: Any, plane: Plane) -> Array:
    """Return the depths at which half spaces yield as the tooth does from the contact to its centreline.

    Parameters
    ----------
    section, outline, lines : SectionMesh, Outline, LoadLines
        The mesh, the tooth and k loads on it.
    moved : ndarray, shape (2 n, k)
        Displacements under unit loads and their opposites at the crossings with the centreline.
    matrix : csc_matrix, shape (2 n, 2 n)
        Stiffness of the section [Pa].
    plane : Plane
        Plane state of the matrix.

    Returns
    -------
    ndarray, shape (k,)
        Depths d_l [m].

    Notes
    -----
    Under a line load F the approach of the points at the distance z below the load and at the centreline tends to
    2 F (1 - nu^2)/(pi E) ln(d_l/z) as z goes to 0; that defines d_l. A half space with this depth leaves out of a band of half
    width a only what is of the order (a/l)^2, l being the distance to where the surface stops being plane.

    The displacement is that of the half plane tangent at the load (Flamant; K. L. Johnson, Contact Mechanics, eq. 2.19) and a regular
    one, w, so ln(d_l/d) = [w(load) - w(crossing)] pi E/(2 F (1 - nu^2)) with the geometric depth d. By Betti's theorem the
    bracket is the work of the tractions that w needs on the boundary, and of its displacements where the section is
    held or cut, in the field `moved` of two opposite forces on one line: it dies out away from the load, and with it what
    the support does. Derived here. Exact up to the finite elements: largest change of ln d_l from resolution 3 to 12 on both gears of
    Wojnarowski & Onishchenko (2003) 2e-3 at the foot of the flank, 1e-3 elsewhere, with ln(2 d_l/a) of about 4.

    On the tip round the half plane is tangent to the round, as Hertz contact on it is. Where the fillet undercuts the flank, a
    load on that corner has no half plane, and its depth depends on the mesh.
    """
    kappa, mu = _kolosov(plane, outline.gear.material)
    work = (boundary_forces(outline_boundary(section, outline), lines, len(moved)) * moved).sum(axis=0)
    far = np.unique(np.concatenate([section.upper, section.lower, section.held]))
    rows = np.concatenate([far, far + len(moved) // 2])
    work += (half_plane(section.mesh.doflocs.T[far], lines, plane, outline.gear.material) * (matrix[rows] @ moved)).sum(axis=0)
    depth: Array = lines.depth * np.exp(work * 4.0 * np.pi * mu / (kappa + 1.0))
    return depth


def outline_boundary(section: SectionMesh, outline: Outline) -> Boundary:
    """Return the free boundary of a section and its cuts: the loaded side, the idle one, then the cuts."""
    shape = edge_shape(STATIONS)
    side, cuts = _edges(section.outline), [_edges(section.lower), _edges(section.upper)[:, ::-1]]
    u = _edges(section.outline_u) @ shape.T
    places, idle = outline.point(u), unworn(outline).point(u)
    straight = [np.einsum("si,eij->esj", shape, section.mesh.doflocs.T[cut]) for cut in cuts]
    places = np.concatenate([places, idle[:, ::-1] * [1.0, -1.0], *straight])
    rest = np.full((len(places) - len(side), len(STATIONS)), np.inf)
    return Boundary(np.concatenate([side, _edges(section.idle)[:, ::-1], *cuts]), places, np.concatenate([u, rest]))


def boundary_forces(boundary: Boundary, lines: LoadLines, size: int) -> Array:
    """Return the nodal forces that take from the boundary the tractions of half planes under unit loads, shape (size, k).

    Notes
    -----
    Flamant's stress is -2/pi cos(t)/r along the radius from the load, t being its angle from the load's direction: over an element
    of the boundary that is seen under dt it carries -2/pi cos(t) e_r dt, whatever its shape. By parts the forces are
    those of the integral G(t) = (t/2 + sin(2 t)/4, sin(t)^2/2), which is smooth as long as a chord to
    the load turns smoothly; on the way to the load its other end is taken, so that it does not turn over there.
    """
    across = np.stack([-lines.direction[:, 1], lines.direction[:, 0]], axis=1)
    chord = boundary.places - lines.point[:, None, None]
    past = boundary.u - lines.u[:, None, None]
    chord = np.where((past < 0.0)[..., None], -chord, chord)
    along, aside = (np.einsum("kesj,kj->kes", chord, axis) for axis in (lines.direction, across))
    # At the load itself (parameters have 1e-16) the chord is the tangent.
    angle = np.unwrap(np.where(np.abs(past) < 1e-9, np.pi / 2.0, np.arctan2(aside, along)), axis=-1)
    shares = _by_parts()
    forward = np.einsum("kes,si->kei", angle / 2.0 + np.sin(2.0 * angle) / 4.0, shares)
    sideways = np.einsum("kes,si->kei", np.sin(angle) ** 2 / 2.0, shares)
    result = np.zeros((size, len(lines.u)))
    for axis in (0, 1):
        force = forward * lines.direction[:, None, None, axis] + sideways * across[:, None, None, axis]
        nodal = np.moveaxis(force, 0, -1).reshape(-1, len(lines.u))
        np.add.at(result, boundary.nodes.ravel() + axis * (size // 2), -2.0 / np.pi * nodal)
    return result


def half_plane(places: Array, lines: LoadLines, plane: Plane, material: Material) -> Array:
    """Return the displacements of half planes under unit loads at places [m], shape (2 n, k), x components first.

    Notes
    -----
    K. L. Johnson, Contact Mechanics, eq. 2.19, without its rigid motion; in Kolosov's constant so that it serves both plane states.
    Its angle jumps on the outward normal of the load, which lies outside the metal.
    """
    kappa, mu = _kolosov(plane, material)
    across = np.stack([-lines.direction[:, 1], lines.direction[:, 0]], axis=1)
    chord = places[:, None] - lines.point
    along, aside = (np.einsum("nkj,kj->nk", chord, axis) for axis in (lines.direction, across))
    angle, depth = np.arctan2(aside, along), 0.5 * (kappa + 1.0) * np.log(np.hypot(along, aside))
    cosine, sine, turned = np.cos(angle), np.sin(angle), 0.5 * (kappa - 1.0) * angle
    radial = -depth * cosine - turned * sine
    hoop = depth * sine + sine - turned * cosine
    inward, sideways = radial * cosine - hoop * sine, radial * sine + hoop * cosine
    parts = [inward * lines.direction[:, axis] + sideways * across[:, axis] for axis in (0, 1)]
    moved: Array = np.concatenate(parts) / (2.0 * np.pi * mu)
    return moved


def _kolosov(plane: Plane, material: Material) -> tuple[float, float]:
    """Return Kolosov's constant (3 - 4 nu in plane strain) and mu; 2 (1 - nu^2)/(pi E) is (kappa + 1)/(4 pi mu)."""
    lam, mu = plane.lame(material)
    return (lam + 3.0 * mu) / (lam + mu), mu


def _edges(chain: Any) -> Any:
    """Return start, middle and end of the edges of a chain, shape (e, 3)."""
    return np.stack([chain[:-2:2], chain[1:-1:2], chain[2::2]], axis=1)


def _by_parts() -> Array:
    """Return the weights of G at the stations in the integral of shape functions over dG, shape (10, 3)."""
    slope = np.stack([4.0 * STATIONS - 3.0, 4.0 - 8.0 * STATIONS, 4.0 * STATIONS - 1.0], axis=1)
    weights = -np.concatenate([[0.0], 0.5 * _WEIGHT, [0.0]])[:, None] * slope
    weights[0, 0] -= 1.0
    weights[-1, 2] += 1.0
    return weights
