"""Meshes as files hold them: sections and solids with their boundary sets, and how files are read."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any, NamedTuple

import meshio
import numpy as np
import skfem

from gearfem.compliance.crack_mesh import CrackedSection
from gearfem.compliance.elasticity import ELEMENT
from gearfem.compliance.patchwork import Ids
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.compliance.solid_mesh import SolidMesh
from gearfem.foundation import Array, InputError
from gearfem.foundation.units import MM

HELD, FLANK, CRACK = ("bore", "root"), "flank", "crack"
CELLS = {2: ("triangle", "triangle6", "quad", "quad8", "quad9"), 3: ("hexahedron", "hexahedron20", "hexahedron27")}
SIDES = {2: ("line", "line3"), 3: ("quad", "quad8", "quad9")}
# Corners, then middle nodes, of the faces of VTK's hexahedra, from outside; of eight-node ones the first four.
FACES = (
    (0, 4, 7, 3, 16, 15, 19, 11, 20),
    (1, 2, 6, 5, 9, 18, 13, 17, 21),
    (0, 1, 5, 4, 8, 17, 12, 16, 22),
    (3, 7, 6, 2, 19, 14, 18, 10, 23),
    (0, 3, 2, 1, 11, 10, 9, 8, 24),
    (4, 5, 6, 7, 12, 13, 14, 15, 25),
)


class MeshFile(NamedTuple):
    """A plane or solid mesh with its boundary sets.

    Parameters
    ----------
    points : ndarray, shape (n, 2) or (n, 3)
        Nodes in the unit of the file.
    cells : list of (str, ndarray of int)
        Cell types as meshio names them, and their nodes.
    sets : dict of str to ndarray of int
        Nodes of the sets ``bore``, ``root`` and ``flank`` that the file has.
    """

    points: Array
    cells: list[tuple[str, Ids]]
    sets: dict[str, Ids]


class Sides(NamedTuple):
    """Edges of a plane mesh, or faces of a solid one, that lie in its boundary sets.

    Parameters
    ----------
    kind : str
        Their type as meshio names it.
    nodes : ndarray of int, shape (k, m)
        Their nodes.
    tags : ndarray of int, shape (k,)
        0 on held nodes, 1 on the flank.
    """

    kind: str
    nodes: Ids
    tags: Ids


def section_file(section: SectionMesh, held: str) -> tuple[MeshFile, Sides]:
    """Return a section mesh as a file holds it, in mm, and its boundary edges on held nodes and flank.

    Parameters
    ----------
    section : SectionMesh
        Mesh of a sector or of a tooth.
    held : {"bore", "root"}
        Name of the set of held nodes.

    Returns
    -------
    mesh : MeshFile
        The flank set holds both sides of the tooth from the form circle to the middle of the tip round.
    sides : Sides
        Edges.
    """
    cells = np.asarray(skfem.Dofs(section.mesh, ELEMENT).element_dofs, dtype=np.int64).T
    edges = np.concatenate([cells[:, [0, 1, 4]], cells[:, [1, 2, 5]], cells[:, [2, 3, 6]], cells[:, [3, 0, 7]]])
    sets = {held: section.held, FLANK: section.flanks()}
    return MeshFile(section.mesh.doflocs.T / MM, [("quad9", cells)], sets), _outer("line3", edges, sets)


def crack_file(section: CrackedSection) -> tuple[MeshFile, Sides]:
    """Return the mesh of a sector with its crack open as a file holds it, in mm.

    Parameters
    ----------
    section : CrackedSection
        Held on its bore.

    Returns
    -------
    mesh : MeshFile
        Both faces of the crack, which share places but no nodes, are the set ``crack``; the flank set holds the loaded side.
    sides : Sides
        Edges.
    """
    cells = section.open_cells
    edges = np.concatenate([cells[:, [0, 1, 4]], cells[:, [1, 2, 5]], cells[:, [2, 3, 6]], cells[:, [3, 0, 7]]])
    tip = np.setdiff1d(_beside(edges, section.faces), section.faces)
    sets = {"bore": section.held, FLANK: section.flank(), CRACK: np.concatenate([section.faces, tip])}
    return MeshFile(section.points / MM, [("quad9", cells)], sets), _outer("line3", edges, sets)


def _beside(edges: Ids, nodes: Ids) -> Ids:
    """Return all nodes of free edges that hold some of these."""
    _, index, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    free = edges[index[count == 1]]
    return np.unique(free[np.isin(free[:, 2], nodes)])


def solid_file(mesh: SolidMesh) -> tuple[MeshFile, Sides]:
    """Return a mesh of hexahedra as a file holds it, in mm, and its boundary faces on held nodes and flank.

    Parameters
    ----------
    mesh : SolidMesh
        Of eight- or 27-node hexahedra.

    Returns
    -------
    mesh : MeshFile
        The held set is ``bore``, or ``root`` for all other supports; the flank set as of `section_file`.
    sides : Sides
        Faces.
    """
    second = mesh.hexes.shape[1] == 27
    kind, side, count = ("hexahedron27", "quad9", 9) if second else ("hexahedron", "quad", 4)
    held = "bore" if mesh.support == "bore" else "root"
    sets = {held: np.flatnonzero(mesh.held), FLANK: np.flatnonzero(mesh.flank)}
    faces = np.concatenate([mesh.hexes[:, own[:count]] for own in FACES])
    return MeshFile(mesh.nodes / MM, [(kind, np.asarray(mesh.hexes))], sets), _outer(side, faces, sets)


def _outer(kind: str, sides: Ids, sets: dict[str, Ids]) -> Sides:
    """Return the sides of one element alone all of whose nodes are in a set, set by set."""
    _, index, count = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True)
    free = sides[index[count == 1]]
    parts = [free[np.isin(free, ids).all(axis=1)] for ids in sets.values()]
    return Sides(kind, np.concatenate(parts), np.repeat(np.arange(len(parts)), [len(part) for part in parts]))


def read_mesh(path: Path, dimension: int = 2) -> MeshFile:
    """Read a plane or solid mesh with its boundary sets.

    Parameters
    ----------
    path : Path
        In a format that meshio reads.
    dimension : {2, 3}
        What is expected: triangles and quadrilaterals, or hexahedra.

    Returns
    -------
    MeshFile
        Sets by name, whatever its case, from node sets, from sets or physical groups of edges (of faces), or from point data that is not 0.

    Raises
    ------
    InputError
        If the file cannot be read, is not plane where it should be, or holds cells of other types than expected, their sides
        and points.
    """
    if not path.is_file():
        raise InputError("--mesh", path, "a file that exists")
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint), contextlib.redirect_stdout(complaint):
            mesh = meshio.read(path)
    # meshio ends the process on endings it does not know, and its readers raise whatever a broken file makes them.
    except (Exception, SystemExit) as error:
        said = " ".join((str(error) if not isinstance(error, SystemExit) else complaint.getvalue()).split())[:200]
        raise InputError(
            "--mesh", f"a file that cannot be read ({type(error).__name__}: {said})", "a mesh file of meshio", str(path)
        ) from None
    points = np.asarray(mesh.points, dtype=float)
    if points.size == 0 or not np.isfinite(points).all():
        raise InputError("--mesh", "no nodes, or some that are not finite", "a mesh with finite coordinates", str(path))
    if dimension == 2 and points.shape[1] == 3 and np.ptp(points[:, 2]) > 1e-9 * np.ptp(points[:, :2]):
        raise InputError("--mesh", f"z from {points[:, 2].min():g} to {points[:, 2].max():g}", "a plane mesh, in x and y", str(path))
    wanted, sides = CELLS[dimension], SIDES[dimension]
    found = sorted({block.type for block in mesh.cells})
    strange = [kind for kind in found if kind not in (*wanted, *sides, "line", "line3", "vertex")]
    cells = [(block.type, np.asarray(block.data, dtype=np.int64)) for block in mesh.cells if block.type in wanted and len(block.data)]
    if strange or not cells:
        raise InputError(
            "--mesh", f"cells {', '.join(strange or found) or 'none'}", f"elements of the types {', '.join(wanted)}", str(path)
        )
    sets = {name: ids for name in (*HELD, FLANK) if (ids := _named(mesh, name, dimension)).size}
    return MeshFile(points[:, :dimension], cells, sets)


def _named(mesh: Any, name: str, dimension: int) -> Ids:
    """Return the nodes of a boundary set, none if the mesh has no such set."""
    sides = [np.asarray(block.data) if block.type in SIDES[dimension] else None for block in mesh.cells]
    found = [np.asarray(ids) for key, ids in mesh.point_sets.items() if key.lower() == name]
    for key, parts in mesh.cell_sets.items():
        if key.lower() == name:
            chosen = zip(sides, parts, strict=True)
            found += [
                nodes[np.asarray(part, dtype=np.int64)] for nodes, part in chosen if nodes is not None and part is not None and len(part)
            ]
    for key, (tag, order) in ((k, v) for k, v in mesh.field_data.items() if len(v) == 2):
        if key.lower() == name and order == dimension - 1 and "gmsh:physical" in mesh.cell_data:
            tagged = zip(sides, mesh.cell_data["gmsh:physical"], strict=True)
            found += [nodes[np.asarray(tags) == tag] for nodes, tags in tagged if nodes is not None]
    for key, values in mesh.point_data.items():
        if key.lower() == name and np.ndim(values) == 1:
            found.append(np.flatnonzero(np.asarray(values) != 0))
    return np.unique(np.concatenate([np.asarray(part, dtype=np.int64).ravel() for part in found])) if found else np.empty(0, dtype=np.int64)
