"""Files of finite-element meshes for other programs."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import skfem

from gearfem.cli.steps import SUPPORTS, Done
from gearfem.compliance.elasticity import ELEMENT
from gearfem.definition.setup import Member, Setup
from gearfem.flank import make_flanks
from gearfem.foundation import InputError
from gearfem.foundation.files import whole
from gearfem.foundation.units import MM

FORMATS = {".vtu": "vtu", ".vtk": "vtk", ".msh": "gmsh22"}
MEMBERS: tuple[Member, ...] = ("pinion", "wheel")


def targets(out: str, gear: str | None, dimension: int) -> dict[Member, Path]:
    """Return the file of each gear: one file if `out` ends as a mesh does, else files in the folder `out`.

    Parameters
    ----------
    out : str
        Folder or file as the user gave it.
    gear : str or None
        ``pinion``, ``wheel`` or, for both (of a single file the pinion), None.
    dimension : int
        2.

    Raises
    ------
    InputError
        If the dimension is not 2, the file's ending is unknown, or the folder is a file.
    """
    if dimension != 2:
        raise InputError("--dim", dimension, "2: this version of gearfem meshes the section of the tooth")
    path = Path(out)
    wanted = [member for member in MEMBERS if gear in (None, member)]
    if path.is_dir() or not path.suffix:
        if path.exists() and not path.is_dir():
            raise InputError("--out", f"the file {out}", f"a folder, or a file that ends in {', '.join(FORMATS)}")
        return {member: path / f"mesh_{member}.vtu" for member in wanted}
    if path.suffix not in FORMATS:
        raise InputError("--out", out, f"a folder, or a file that ends in {', '.join(FORMATS)}")
    return {wanted[0]: path}


def write(setup: Setup, files: dict[Member, Path], support: str, resolution: float) -> Done:
    """Write the section meshes in mm, the tooth's axis along x and the gear's centre at the origin.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.
    files : dict
        File of each gear, as from `targets`.
    support, resolution : str, float
        As of the finite elements.

    Raises
    ------
    InputError
        If the resolution is below 1.
    """
    from gearfem.compliance import FiniteElements

    flanks = make_flanks(setup)
    method = FiniteElements(support=SUPPORTS[support](), resolution=resolution)
    lines = []
    for member, path in files.items():
        section = method.support.section(flanks.pinion if member == "pinion" else flanks.wheel, method.resolution)
        points = section.mesh.doflocs.T / MM
        held = np.zeros(len(points))
        held[section.held] = 1.0
        cells = np.asarray(skfem.Dofs(section.mesh, ELEMENT).element_dofs).T
        mesh = meshio.Mesh(np.hstack([points, np.zeros((len(points), 1))]), [("quad9", cells)], point_data={"held": held})
        with whole(path) as temporary:
            mesh.write(temporary, file_format=FORMATS[path.suffix])
        lines.append(f"{member}: {len(cells)} biquadratic quadrilaterals, {len(points)} nodes")
    return Done(lines, list(files.values()))
