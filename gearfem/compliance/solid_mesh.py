"""Hexahedral meshes: a section extruded along the face width."""

from __future__ import annotations

import dataclasses

import numpy as np
import skfem
from numpy.typing import NDArray

from gearfem.compliance.crack_mesh import CrackedSection
from gearfem.compliance.elasticity import ELEMENT
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.foundation import Array, Record

# Nodes of VTK's triquadratic hexahedron (cell type 29): node of the nine-node quadrilateral, and layer from 0 to 2.
TRIQUADRATIC = (
    [(corner, 0) for corner in range(4)]
    + [(corner, 2) for corner in range(4)]
    + [(middle, 0) for middle in range(4, 8)]
    + [(middle, 2) for middle in range(4, 8)]
    + [(corner, 1) for corner in range(4)]
    + [(7, 1), (5, 1), (4, 1), (6, 1), (8, 0), (8, 2), (8, 1)]
)
# Nodes of the eight-node hexahedron (cell type 12).
TRILINEAR = [(corner, layer) for layer in (0, 1) for corner in range(4)]


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SolidMesh(Record):
    """A mesh of hexahedra.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        x along the tooth's axis, y towards the loaded side, z along the face width from mid-face, from the gear's centre [m].
    hexes : ndarray of int, shape (k, 8) or (k, 27)
        Nodes of trilinear or triquadratic hexahedra in VTK's order (cell types 12 and 29).
    held, flank : ndarray of bool, shape (n,)
        Nodes that do not move, and nodes of both flanks, up to the middle of the tip round where the mesh reaches it.
    support : str
        What is held: ``bore``, ``root``, ``root_chord`` or the name of a variant of the published mesh.
    """

    nodes: Array
    hexes: NDArray[np.int64]
    held: NDArray[np.bool_]
    flank: NDArray[np.bool_]
    support: str


def extrude(points: Array, quads: NDArray[np.int64], places: Array) -> tuple[Array, NDArray[np.int64]]:
    """Return nodes and hexahedra of an extruded section.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Nodes of the section [m].
    quads : ndarray of int, shape (e, 4) or (e, 9)
        Its quadrilaterals in VTK's order, counter-clockwise.
    places : ndarray, shape (m,)
        Increasing places of the nodes across the width [m]; with nine-node quadrilaterals every second one is a middle node.

    Returns
    -------
    nodes : ndarray, shape (n m, 3)
        Node i of the section at place j has number j n + i [m].
    hexes : ndarray of int, shape (layers e, 8) or (layers e, 27)
    """
    count, degree = len(points), 2 if quads.shape[1] == 9 else 1
    nodes = np.hstack([np.tile(points, (len(places), 1)), np.repeat(places, count)[:, None]])
    one = np.stack([quads[:, own] + layer * count for own, layer in (TRIQUADRATIC if degree == 2 else TRILINEAR)], axis=1)
    shifts = count * np.arange(0, len(places) - 1, degree)
    return nodes, (one[None] + shifts[:, None, None]).reshape(-1, one.shape[1])


def solid_mesh(section: SectionMesh, places: Array, support: str) -> SolidMesh:
    """Return the mesh of triquadratic hexahedra over a section.

    Parameters
    ----------
    section : SectionMesh
        Of nine-node quadrilaterals.
    places : ndarray, shape (2 k + 1,)
        As from `graded_places` [m].
    support : str
        What the section is held at.

    Returns
    -------
    SolidMesh
    """
    quads = np.asarray(skfem.Dofs(section.mesh, ELEMENT).element_dofs, dtype=np.int64).T
    nodes, hexes = extrude(section.mesh.doflocs.T, quads, places)
    number = np.arange(section.mesh.doflocs.shape[1])
    held, flank = (np.tile(np.isin(number, own), len(places)) for own in (section.held, section.flanks()))
    return SolidMesh(nodes=nodes, hexes=hexes, held=held, flank=flank, support=support)


def cracked_solid(section: CrackedSection, places: Array) -> SolidMesh:
    """Return the hexahedra over a sector whose crack is open over the whole face width.

    Parameters
    ----------
    section : CrackedSection
        Of nine-node quadrilaterals.
    places : ndarray, shape (2 k + 1,)
        As from `graded_places` [m].

    Returns
    -------
    SolidMesh
        Its flank nodes are those of the loaded side.
    """
    nodes, hexes = extrude(section.points, section.open_cells, places)
    number = np.arange(len(section.points))
    held, flank = (np.tile(np.isin(number, own), len(places)) for own in (section.held, section.flank()))
    return SolidMesh(nodes=nodes, hexes=hexes, held=held, flank=flank, support="bore")


def trilinear(mesh: SolidMesh) -> SolidMesh:
    """Return the eight-node hexahedra on the corners of a mesh.

    Parameters
    ----------
    mesh : SolidMesh
        Of either type.

    Returns
    -------
    SolidMesh
        Corners in the order of the mesh's nodes; curved sides become straight.
    """
    used, corners = np.unique(mesh.hexes[:, :8], return_inverse=True)
    hexes = corners.reshape(-1, 8).astype(np.int64)
    return SolidMesh(nodes=mesh.nodes[used], hexes=hexes, held=mesh.held[used], flank=mesh.flank[used], support=mesh.support)
