"""Finite-element meshes for other programs, and from them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gearfem.assembly import flanks_of
from gearfem.cli.steps import SUPPORTS, Done
from gearfem.compliance import FiniteElements, SolidElements, load_positions
from gearfem.compliance.foreign import check_mesh, foreign_curve
from gearfem.compliance.mesh_file import read_mesh
from gearfem.compliance.mesh_writing import FORMATS, format_of, write_section, write_solid
from gearfem.definition.setup import Member, Setup
from gearfem.foundation import InputError
from gearfem.foundation.units import UM_PER_N_PER_MM
from gearfem.pipeline import Results
from gearfem.report import write_compliance

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
        2 or 3.

    Raises
    ------
    InputError
        If the dimension is another, the file's ending is unknown or that of a format without the elements, or the folder is a file.
    """
    if dimension not in (2, 3):
        raise InputError("--dim", dimension, "2, the section of the tooth, or 3, the tooth as a solid")
    path = Path(out)
    wanted = [member for member in MEMBERS if gear in (None, member)]
    if path.is_dir() or not path.suffix:
        if path.exists() and not path.is_dir():
            raise InputError("--out", f"the file {out}", f"a folder, or a file that ends in {', '.join(FORMATS)}")
        return {member: path / f"mesh_{member}.vtu" for member in wanted}
    format_of(path, dimension)
    return {wanted[0]: path}


def write(setup: Setup, files: dict[Member, Path], support: str, dimension: int, resolution: float | None) -> Done:
    """Write the meshes in mm, the tooth's axis along x, the gear's centre at the origin; of solids mid-face at z = 0.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.
    files : dict
        File of each gear, as from `targets`.
    support : str
        What is held.
    dimension : {2, 3}
        The section, or the solid over the whole face width.
    resolution : float or None
        As of `FiniteElements`, or of `SolidElements`; by default that of theirs.

    Raises
    ------
    InputError
        If the resolution is below the least of the method.
    """
    flanks, held = flanks_of(setup), SUPPORTS[support]()
    lines = []
    for member, path in files.items():
        outline = flanks.pinion if member == "pinion" else flanks.wheel
        if dimension == 2:
            plane = FiniteElements(support=held) if resolution is None else FiniteElements(support=held, resolution=resolution)
            section = held.section(outline, plane.resolution)
            said = write_section(section, "bore" if support == "bore" else "root", path)
            nodes, elements = section.mesh.doflocs.shape[1], section.mesh.t.shape[1]
            lines.append(f"{member}: {elements} biquadratic quadrilaterals, {nodes} nodes; {said}")
        else:
            method = SolidElements(support=held) if resolution is None else SolidElements(support=held, resolution=resolution)
            solid = method.mesh(outline, setup.pair.face_width)
            said = write_solid(solid, path)
            size = f"{len(solid.hexes)} triquadratic hexahedra in {method.layers} layers, {len(solid.nodes)} nodes"
            lines.append(f"{member}: {size}; {said}")
    return Done(lines, list(files.values()))


def compliance(setup: Setup, out: Path, file: Path, member: Member) -> Done:
    """Compute the compliance of one gear on a mesh from a file.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.
    out : Path
        Folder.
    file : Path
        The mesh.
    member : {"pinion", "wheel"}
        The gear that it is a mesh of.

    Raises
    ------
    InputError
        If the file cannot be read or its mesh is not one of this gear.
    """
    flanks = flanks_of(setup)
    outline = flanks.pinion if member == "pinion" else flanks.wheel
    positions = load_positions(outline)
    positions = positions[positions <= 3.0]
    try:
        mesh = check_mesh(read_mesh(file), outline)
        curve = foreign_curve(mesh, outline, positions)
    except InputError as error:
        raise error.in_file(str(file)) from None
    elements = ", ".join(f"{len(cells)} {kind}" for kind, cells in mesh.cells)
    low, high = curve.deflection.min() / UM_PER_N_PER_MM, curve.deflection.max() / UM_PER_N_PER_MM
    lines = [
        f"{member}, {curve.method}, {curve.support}, {elements}: {low:.5f} to {high:.5f} um per N/mm; "
        f"{positions.size - curve.u.size} of {positions.size} positions left out, off the flank set or with the crossing outside the mesh",
        "one mesh gives no estimate of its error: compare with a finer one",
    ]
    if mesh.support == "bore" and mesh.span < 2.0 * np.pi:
        span = f"{np.degrees(mesh.span):.1f} degrees"
        lines.append(f"the mesh holds {span} of the bore, not the whole gear: what is missing beyond its ends makes it too soft")
    results = Results(setup=setup, flanks=flanks, comparison=((member, curve),), assumptions=setup.assumptions)
    return Done(lines, [write_compliance(results, out)])
