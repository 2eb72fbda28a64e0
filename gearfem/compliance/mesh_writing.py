"""Meshes into files for other programs: one way to write sections, solids and their fields, by meshio, in mm and MPa."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from gearfem.compliance.crack_mesh import CrackedSection
from gearfem.compliance.mesh_file import MeshFile, Sides, crack_file, section_file, solid_file
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.compliance.solid_field import SolidField
from gearfem.compliance.solid_mesh import SolidMesh, trilinear
from gearfem.foundation import Array, InputError
from gearfem.foundation.files import whole
from gearfem.foundation.units import MM

# Ways in which meshio writes boundary sets that come back by name, found by writing and reading each format.
BY_DATA, BY_TAG, BY_SET = {"vtu", "vtk", "xdmf"}, {"gmsh", "gmsh22"}, {"abaqus"}
BIQUADRATIC = BY_DATA | BY_TAG | BY_SET | {"mdpa"}
# Formats whose 27-node hexahedra come back with every node in its place, those without hexahedra, and those without quadrilaterals.
TRIQUADRATIC, PLANE, SOLID = {"vtu", "vtk", "gmsh22", "mdpa"}, {"ply", "obj"}, {"su2", "flac3d"}
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
    ".obj": ("obj", {}),
    ".vol": ("netgen", {}),
    ".post": ("permas", {}),
    ".dat": ("tecplot", {}),
    ".su2": ("su2", {}),
    ".f3grid": ("flac3d", {}),
    ".med": ("med", {}),
    ".hmf": ("hmf", {}),
    ".e": ("exodus", {}),
}
MPA = 1e6


def format_of(path: Path, dimension: int = 2) -> tuple[str, dict[str, Any]]:
    """Return meshio's name of the format of a file and its options, by the ending of the file's name.

    Parameters
    ----------
    path : Path
        The file.
    dimension : {2, 3}
        Whether it is to hold quadrilaterals or hexahedra.

    Raises
    ------
    InputError
        If the format is none of `FORMATS`, or one without these elements. The others of meshio hold triangles and
        tetrahedra alone, drop other elements without a word, or write what they cannot read again.
    """
    without = SOLID if dimension == 2 else PLANE
    allowed = [ending for ending, (kind, _) in FORMATS.items() if kind not in without]
    if path.suffix not in allowed:
        raise InputError("--out", path, f"a folder, or a file that ends in {', '.join(allowed)}")
    return FORMATS[path.suffix]


def write_section(section: SectionMesh | CrackedSection, held: str, path: Path) -> str:
    """Write a section mesh with its boundary sets, in a format by the ending of the file's name.

    Parameters
    ----------
    section, held
        As for `section_file`; a cracked sector is held on its bore and has the further set ``crack``.
    path : Path
        Ends in one of `FORMATS`.

    Returns
    -------
    str
        How the sets are stored, and what the format cannot hold.

    Raises
    ------
    InputError
        If meshio needs another package for the format (h5py for \\*.xdmf, \\*.med and \\*.hmf, netCDF4 for \\*.e) and does not find it.

    Notes
    -----
    Boundary sets, as `read_mesh` finds them again:

    - \\*.vtu, \\*.vtk, \\*.xdmf have no sets: integer point data named ``bore`` (or ``root``) and ``flank``, 1 on nodes of the
      set, and ``held``, which is the first under a name common to both;
    - \\*.msh: physical groups of boundary edges (of solids, faces) with these names;
    - \\*.inp: node sets (NSET) with these names.

    Other formats hold the elements alone; those without second-order elements hold their corners as first-order ones.
    """
    kind, _ = format_of(path)
    mesh, sides = crack_file(section) if isinstance(section, CrackedSection) else section_file(section, held)
    if kind in BIQUADRATIC:
        return _write(mesh, sides, path, {})
    used, corners = np.unique(mesh.cells[0][1][:, :4], return_inverse=True)
    said = _write(MeshFile(mesh.points[used], [("quad", corners.reshape(-1, 4))], dict.fromkeys(mesh.sets, used[:0])), sides, path, {})
    return f"{said}; no biquadratic elements either: their corners as bilinear ones"


def write_solid(content: SolidMesh | SolidField, path: Path, more: Mapping[str, Array] | None = None) -> str:
    """Write a mesh of hexahedra with its boundary sets, and displacement and stress if it has any.

    Parameters
    ----------
    content : SolidMesh or SolidField
        What is written.
    path : Path
        Ends in one of `FORMATS` that has hexahedra; with values at the nodes one of \\*.vtu, \\*.vtk and \\*.xdmf.
    more : dict of str to ndarray, optional
        Further values at the nodes of the mesh, by name.

    Returns
    -------
    str
        As `write_section` does.

    Raises
    ------
    InputError
        As `write_section` does, and if the format has no place for values at nodes.

    Notes
    -----
    Sets as of `write_section`; a field is the point data ``displacement_mm`` and ``von_mises_MPa``.
    """
    kind, _ = format_of(path, 3)
    mesh, values = content, dict(more or {})
    if isinstance(content, SolidField):
        mesh = content.mesh
        values |= {"displacement_mm": content.displacement / MM, "von_mises_MPa": content.von_mises / MPA}
    assert isinstance(mesh, SolidMesh)
    cut = mesh.hexes.shape[1] == 27 and kind not in TRIQUADRATIC
    if values and (cut or kind not in BY_DATA):
        raise InputError("file of values at nodes", path.name, "a name that ends in .vtu or .vtk")
    said = _write(*solid_file(trilinear(mesh) if cut else mesh), path, values)
    return said + ("; no 27-node hexahedra: their corners as eight-node ones" if cut else "")


def _write(mesh: MeshFile, sides: Sides, path: Path, values: dict[str, Array]) -> str:
    """Write a mesh of one type of elements with its sets the way its format has them, and return which way."""
    held, dimension = next(iter(mesh.sets)), mesh.points.shape[1]
    kind, options = format_of(path, dimension)
    cells: list[tuple[str, Any]] = list(mesh.cells)
    arguments: dict[str, Any] = {}
    said, names = "no boundary sets: this format has none", ", ".join(mesh.sets)
    if kind in BY_DATA:
        flags = {name: np.isin(np.arange(len(mesh.points)), ids).astype(np.int32) for name, ids in mesh.sets.items()}
        arguments["point_data"] = {**flags, "held": flags[held], **values}
        said = f"sets {names}: point data, 1 on their nodes"
    elif kind in BY_TAG:
        tags = [np.ones(len(cells[0][1]), dtype=np.int32), sides.tags.astype(np.int32) + 2]
        cells.append((sides.kind, sides.nodes))
        arguments["cell_data"] = {"gmsh:physical": tags, "gmsh:geometrical": tags}
        groups = {"gear": (1, dimension), **{name: (number + 2, dimension - 1) for number, name in enumerate(mesh.sets)}}
        arguments["field_data"] = {name: np.array(group) for name, group in groups.items()}
        said = f"sets {names}: physical groups"
    elif kind in BY_SET:
        arguments["point_sets"] = dict(mesh.sets)
        said = f"sets {names}: node sets"
    points = np.hstack([mesh.points, np.zeros((len(mesh.points), 3 - dimension))])
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
