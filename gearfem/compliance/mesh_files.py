"""Meshes and their fields as VTU files for other programs, in mm and MPa."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np

from gearfem.compliance.solid_field import SolidField
from gearfem.compliance.solid_mesh import SolidMesh
from gearfem.foundation import InputError
from gearfem.foundation.files import whole
from gearfem.foundation.units import MM

TYPES = {8: "hexahedron", 27: "hexahedron27"}
MPA = 1e6


def write_vtu(path: Path, content: SolidMesh | SolidField) -> Path:
    """Write a mesh of hexahedra, with its displacement and stress if it has any.

    Parameters
    ----------
    path : Path
        Target file, ending in ``.vtu``; whole or absent.
    content : SolidMesh or SolidField
        What is written.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the file ends otherwise.

    Notes
    -----
    Point data: ``bore`` or ``root`` (1 where held) and ``flank`` (1 on the loaded flank); of a field also ``displacement_mm`` and
    ``von_mises_MPa``.
    """
    path = Path(path)
    if path.suffix != ".vtu":
        raise InputError("file of a mesh", path.name, "a name that ends in .vtu")
    mesh = content.mesh if isinstance(content, SolidField) else content
    data = {"bore" if mesh.support == "bore" else "root": mesh.held.astype(float), "flank": mesh.flank.astype(float)}
    if isinstance(content, SolidField):
        data |= {"displacement_mm": content.displacement / MM, "von_mises_MPa": content.von_mises / MPA}
    cells = [(TYPES[mesh.hexes.shape[1]], np.asarray(mesh.hexes))]
    with whole(path) as temporary:
        meshio.Mesh(mesh.nodes / MM, cells, point_data=data).write(temporary, file_format="vtu")
    return path
