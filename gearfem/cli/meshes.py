"""Finite-element meshes for other programs, and from them."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gearfem.assembly import effects_in, flanks_of
from gearfem.cli.notices import SHAPES, unseen
from gearfem.cli.steps import SUPPORTS, Done
from gearfem.compliance import Bore, FiniteElements, Root, RootChord, SolidElements, load_positions
from gearfem.compliance.crack import FINE
from gearfem.compliance.crack_mesh import CrackedSection, crack_mesh, section_chord
from gearfem.compliance.foreign import check_mesh, foreign_curve
from gearfem.compliance.mesh_file import read_mesh
from gearfem.compliance.mesh_writing import FORMATS, format_of, write_section, write_solid
from gearfem.compliance.solid_mesh import cracked_solid
from gearfem.definition.setup import Member, Setup
from gearfem.effects.root_crack import RootCrack
from gearfem.flank import Flanks, Outline
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


def write(setup: Setup, files: dict[Member, Path], support: str, dimension: int, resolution: float | None, tooth: int | None) -> Done:
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
    tooth : int or None
        Which tooth, with its own flank and its crack open; by default one like most.

    Raises
    ------
    InputError
        If the resolution is below the least of the method, the gear has no such tooth, or a cracked one is not held at the bore.
    """
    flanks = flanks_of(setup)
    lines = []
    for member, path in files.items():
        teeth = flanks.of(member).gear.teeth
        if tooth is not None and not 0 <= tooth < teeth:
            raise InputError("--tooth", tooth, f"0 to {teeth - 1}, the teeth of the {member}")
        outline = flanks.of(member) if tooth is None else flanks.odd(member).get(tooth, flanks.of(member))
        depth = cracks(setup, member).get(tooth, 0.0) if tooth is not None else 0.0
        if depth and support != "bore":
            raise InputError("--support", support, f"bore: tooth {tooth} of the {member} is cracked, which is meshed with its sector alone")
        job = _Job(outline, SUPPORTS[support](), resolution, path)
        if dimension == 2:
            lines.append(f"{member}: {_section(job, depth)}")
        else:
            lines.append(f"{member}: {_solid(job, depth, setup.pair.face_width)}")
        lines += _elsewhere(setup, flanks, member, tooth)
    return Done([*lines, *unseen(_without_cracks(setup), SHAPES, lead=False)], list(files.values()))


class _Job(NamedTuple):
    """A tooth to be meshed."""

    outline: Outline
    held: Bore | Root | RootChord
    resolution: float | None
    path: Path


def cracks(setup: Setup, member: Member) -> dict[int, float]:
    """Return the depths [m] of the cracks of a gear by tooth."""
    return {effect.tooth: effect.depth for effect in effects_in(setup) if isinstance(effect, RootCrack) and effect.gear == member}


def _without_cracks(setup: Setup) -> Setup:
    return dataclasses.replace(setup, effects=tuple(effect for effect in setup.effects if not isinstance(effect, RootCrack)))


def _elsewhere(setup: Setup, flanks: Flanks, member: Member, tooth: int | None) -> list[str]:
    """Say which teeth differ from the one that was meshed."""
    odd = sorted({*flanks.odd(member), *(number for number, depth in cracks(setup, member).items() if depth)} - {tooth})
    return [f"{member}: teeth {', '.join(map(str, odd))} differ from this one: --tooth meshes one of them"] if odd else []


def _section(job: _Job, depth: float) -> str:
    plane = FiniteElements(support=job.held) if job.resolution is None else FiniteElements(support=job.held, resolution=job.resolution)
    if depth:
        cracked = _cracked(job, depth, plane.resolution / FiniteElements().resolution)
        said = write_section(cracked, "bore", job.path)
        return f"{len(cracked.open_cells)} biquadratic quadrilaterals, {len(cracked.points)} nodes, the crack open; {said}"
    section = job.held.section(job.outline, plane.resolution)
    said = write_section(section, "bore" if job.held.name == "bore" else "root", job.path)
    return f"{section.mesh.t.shape[1]} biquadratic quadrilaterals, {section.mesh.doflocs.shape[1]} nodes; {said}"


def _solid(job: _Job, depth: float, face_width: float) -> str:
    method = SolidElements(support=job.held) if job.resolution is None else SolidElements(support=job.held, resolution=job.resolution)
    solid = method.mesh(job.outline, face_width)
    if depth:
        solid = cracked_solid(_cracked(job, depth, method.resolution / FiniteElements().resolution), np.unique(solid.nodes[:, 2]))
    said = write_solid(solid, job.path)
    open_crack = ", the crack open over the whole face width" if depth else ""
    return f"{len(solid.hexes)} triquadratic hexahedra in {method.layers} layers, {len(solid.nodes)} nodes{open_crack}; {said}"


def _cracked(job: _Job, depth: float, resolution: float) -> CrackedSection:
    return crack_mesh(job.outline, depth, FINE * section_chord(job.outline), resolution)


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
