"""Meshes in files of other programs: tagged boundary sets out and in, by meshio."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any, NamedTuple

import meshio
import numpy as np
import skfem

from gearfem.compliance.elasticity import ELEMENT
from gearfem.compliance.patchwork import Ids
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.foundation import Array, InputError
from gearfem.foundation.files import whole
from gearfem.foundation.units import MM

HELD, FLANK = ("bore", "root"), "flank"
# Ways in which meshio writes boundary sets that come back by name, found by writing and reading each format.
BY_DATA, BY_TAG, BY_SET = {"vtu", "vtk", "xdmf"}, {"gmsh", "gmsh22"}, {"abaqus"}
BIQUADRATIC = BY_DATA | BY_TAG | BY_SET | {"mdpa"}
FORMATS: dict[str, tuple[str, dict[str, Any]]] = {
    ".vtu": ("vtu", {}),
    ".vtk": ("vtk", {}),
    ".msh": ("gmsh22", {}),
    ".inp": ("abaqus", {}),
    ".xdmf": ("xdmf", {"data_format": "XML"}),
    ".mdpa": ("mdpa", {}),
    ".mesh": ("medit", {}),
    ".avs": ("avsucd", {}),
    ".ply": ("ply", {}),
}


class MeshFile(NamedTuple):
    """A plane mesh with its boundary sets.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Nodes in the unit of the file.
    cells : list of (str, ndarray of int)
        Cell types as meshio names them, and their nodes.
    sets : dict of str to ndarray of int
        Nodes of the sets ``bore``, ``root`` and ``flank`` that the file has.
    """

    points: Array
    cells: list[tuple[str, Ids]]
    sets: dict[str, Ids]


def section_file(section: SectionMesh, held: str) -> tuple[MeshFile, Ids]:
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
    edges : ndarray of int, shape (k, 4)
        End, end and middle node of each edge, and 0 on held nodes, 1 on the flank.
    """
    places = section.mesh.doflocs
    cells = np.asarray(skfem.Dofs(section.mesh, ELEMENT).element_dofs, dtype=np.int64).T
    first = 2 * int(np.searchsorted(section.outline_u[::2], 2.0 - 1e-9))
    last = int(np.searchsorted(section.outline_u, 3.5 + 1e-9))
    side = section.outline[first:last]
    other = _mirrored(places, side)
    sides = np.concatenate([cells[:, [0, 1, 4]], cells[:, [1, 2, 5]], cells[:, [2, 3, 6]], cells[:, [3, 0, 7]]])
    sets = {held: section.held, FLANK: np.union1d(side, other)}
    _, index, count = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True)
    free = sides[index[count == 1]]
    edges = [
        np.hstack([part, np.full((len(part), 1), tag)])
        for tag, ids in enumerate(sets.values())
        for part in [free[np.isin(free, ids).all(axis=1)]]
    ]
    return MeshFile(places.T / MM, [("quad9", cells)], sets), np.concatenate(edges)


def _mirrored(places: Array, nodes: Ids) -> Ids:
    """Return the nodes at the mirror images in y = 0 of some nodes."""
    at = {(x, y): number for number, (x, y) in enumerate(places.T.tolist())}
    return np.array([at[x, 0.0 - y] for x, y in places[:, nodes].T.tolist()], dtype=np.int64)


def format_of(path: Path) -> tuple[str, dict[str, Any]]:
    """Return meshio's name of the format of a file and its options, by the ending of the file's name.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    InputError
        If the format is none of `FORMATS`. The others of meshio drop quadrilaterals without a word (stl), hold triangles
        alone, or need packages that could not be tried.
    """
    if path.suffix not in FORMATS:
        raise InputError("--out", path, f"a folder, or a file that ends in {', '.join(FORMATS)}")
    return FORMATS[path.suffix]


def write_section(section: SectionMesh, held: str, path: Path) -> str:
    """Write a section mesh with its boundary sets, in a format by the ending of the file's name.

    Parameters
    ----------
    section, held
        As for `section_file`.
    path : Path
        Ends in one of `FORMATS`.

    Returns
    -------
    str
        How the sets are stored, and what the format cannot hold.

    Raises
    ------
    InputError
        If meshio needs another package for the format (h5py for \\*.xdmf) and does not find it.

    Notes
    -----
    Boundary sets, as `read_mesh` finds them again:

    - \\*.vtu, \\*.vtk, \\*.xdmf have no sets: integer point data named ``bore`` (or ``root``) and ``flank``, 1 on nodes of the
      set, and ``held``, which is the first under a name common to both;
    - \\*.msh: physical groups of boundary edges with these names;
    - \\*.inp: node sets (NSET) with these names.

    Other formats hold the elements alone; those without biquadratic elements hold their corners as bilinear ones.
    """
    kind, options = format_of(path)
    mesh, edges = section_file(section, held)
    cells: list[tuple[str, Ids]] = list(mesh.cells)
    arguments: dict[str, Any] = {}
    said = "no boundary sets: this format has none"
    if kind in BY_DATA:
        flags = {name: np.isin(np.arange(len(mesh.points)), ids).astype(np.int32) for name, ids in mesh.sets.items()}
        arguments["point_data"] = {**flags, "held": flags[held]}
        said = f"sets {held}, {FLANK}: point data, 1 on their nodes"
    elif kind in BY_TAG:
        tags = [np.ones(len(cells[0][1]), dtype=np.int32), edges[:, 3].astype(np.int32) + 2]
        cells.append(("line3", edges[:, :3]))
        arguments["cell_data"] = {"gmsh:physical": tags, "gmsh:geometrical": tags}
        arguments["field_data"] = {"gear": np.array([1, 2]), held: np.array([2, 1]), FLANK: np.array([3, 1])}
        said = f"sets {held}, {FLANK}: physical groups"
    elif kind in BY_SET:
        arguments["point_sets"] = dict(mesh.sets)
        said = f"sets {held}, {FLANK}: node sets"
    points = np.hstack([mesh.points, np.zeros((len(mesh.points), 1))])
    if kind not in BIQUADRATIC:
        used, corners = np.unique(cells[0][1][:, :4], return_inverse=True)
        points, cells = points[used], [("quad", corners.reshape(-1, 4))]
        said += "; no biquadratic elements either: their corners as bilinear ones"
    with whole(path) as temporary, contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        try:
            meshio.Mesh(points, cells, **arguments).write(temporary, file_format=kind, **options)
        except OSError:
            raise
        # meshio's writers fail in ways of their own, a package that is not installed among them.
        except (Exception, SystemExit) as error:
            allowed = f"one of {', '.join(FORMATS)}, or the package that meshio needs for this format"
            raise InputError("--out", f"{path.suffix}, which meshio cannot write here ({type(error).__name__}: {error})", allowed) from None
    return said


def read_mesh(path: Path) -> MeshFile:
    """Read a plane mesh with its boundary sets.

    Parameters
    ----------
    path : Path
        In a format that meshio reads.

    Returns
    -------
    MeshFile
        Sets by name, whatever its case, from node sets, from sets or physical groups of edges, or from point data that is not 0.

    Raises
    ------
    InputError
        If the file cannot be read, is not plane, or holds cells other than triangles, quadrilaterals, edges and points.
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
    if points.shape[1] == 3 and np.ptp(points[:, 2]) > 1e-9 * np.ptp(points[:, :2]):
        raise InputError("--mesh", f"z from {points[:, 2].min():g} to {points[:, 2].max():g}", "a plane mesh, in x and y", str(path))
    areas = ("triangle", "triangle6", "quad", "quad8", "quad9")
    found = sorted({block.type for block in mesh.cells})
    strange = [kind for kind in found if kind not in (*areas, "line", "line3", "vertex")]
    cells = [(block.type, np.asarray(block.data, dtype=np.int64)) for block in mesh.cells if block.type in areas and len(block.data)]
    if strange or not cells:
        raise InputError("--mesh", f"cells {', '.join(strange or found) or 'none'}", f"elements of the types {', '.join(areas)}", str(path))
    sets = {name: ids for name in (*HELD, FLANK) if (ids := _named(mesh, name)).size}
    return MeshFile(points[:, :2], cells, sets)


def _named(mesh: Any, name: str) -> Ids:
    """Return the nodes of a boundary set, none if the mesh has no such set."""
    edges = [np.asarray(block.data) if block.type in ("line", "line3") else None for block in mesh.cells]
    found = [np.asarray(ids) for key, ids in mesh.point_sets.items() if key.lower() == name]
    for key, parts in mesh.cell_sets.items():
        if key.lower() == name:
            chosen = zip(edges, parts, strict=True)
            found += [
                nodes[np.asarray(part, dtype=np.int64)] for nodes, part in chosen if nodes is not None and part is not None and len(part)
            ]
    for key, (tag, dimension) in ((k, v) for k, v in mesh.field_data.items() if len(v) == 2):
        if key.lower() == name and dimension == 1 and "gmsh:physical" in mesh.cell_data:
            tagged = zip(edges, mesh.cell_data["gmsh:physical"], strict=True)
            found += [nodes[np.asarray(tags) == tag] for nodes, tags in tagged if nodes is not None]
    for key, values in mesh.point_data.items():
        if key.lower() == name and np.ndim(values) == 1:
            found.append(np.flatnonzero(np.asarray(values) != 0))
    return np.unique(np.concatenate([np.asarray(part, dtype=np.int64).ravel() for part in found])) if found else np.empty(0, dtype=np.int64)
