"""Make the reference meshes again: ``python meshes/make.py`` writes each mesh as VTU and its recipe as TOML beside it.

The 2D meshes are the sector of one tooth from the bore to the tip, which is condensed once: the gear is the ring of `teeth` such
sectors, the nodes of its upper cut (at the polar angle +pi/teeth) joined to those of the lower cut of the next one, turned by
2 pi/teeth. Point data: ``bore`` (held) and ``flank`` are 1 on the nodes of these sets.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gearfem import __version__, load_model
from gearfem.compliance import FiniteElements
from gearfem.compliance.mesh_file import read_mesh, section_file
from gearfem.compliance.mesh_writing import write_section
from gearfem.flank import make_flanks

HERE = Path(__file__).parent
MODEL = HERE.parent / "studies" / "coal_combine" / "model.toml"
# Coordinates differ by some 1e-13 mm between platforms; ten nanometres are far above that and far below what matters.
UNIT_MM = 1e-5
GEAR_KEYS = (
    "teeth",
    "module",
    "pressure_angle",
    "profile_shift",
    "flank_thinning",
    "root_radius",
    "tip_radius",
    "tip_edge_radius",
    "bore_radius",
)


class Mesh(NamedTuple):
    """Nodes [mm] and elements of one type."""

    points: np.ndarray
    cells: np.ndarray


def checksum(mesh: Mesh) -> str:
    """Return the SHA-256 of a mesh, the same whatever the numbering of nodes and elements and the last digits of coordinates.

    Notes
    -----
    Coordinates are counted in units of 10 nm and rounded down after a third of a unit is added, so that round numbers, and
    zeros of either sign, lie far from where the rounding steps. Nodes are numbered in the order of these integers, elements
    sorted; the order of nodes within an element counts.
    """
    grid = np.floor(mesh.points / UNIT_MM + 1.0 / 3.0).astype("<i8")
    order = np.lexsort(grid.T[::-1])
    number = np.empty(len(order), dtype="<i8")
    number[order] = np.arange(len(order))
    cells = number[mesh.cells]
    cells = np.ascontiguousarray(cells[np.lexsort(cells.T[::-1])])
    return hashlib.sha256(np.ascontiguousarray(grid[order]).tobytes() + cells.tobytes()).hexdigest()


def sector(member: str) -> tuple[Mesh, object, object]:
    """Return the default 2D mesh of a gear of the coal combine, with its gear and its section."""
    flanks = make_flanks(load_model(str(MODEL)))
    outline = flanks.pinion if member == "pinion" else flanks.wheel
    method = FiniteElements()
    section = method.support.section(outline, method.resolution)
    file, _ = section_file(section, "bore")
    return Mesh(file.points, file.cells[0][1]), outline.gear, section


def stored(path: Path) -> Mesh:
    """Return a mesh that was written."""
    file = read_mesh(path)
    return Mesh(file.points, file.cells[0][1])


def recipe(member: str, mesh: Mesh, gear: object) -> str:
    """Return the recipe of a 2D mesh as TOML."""
    keys = "\n".join(f"{key} = {getattr(gear, key)!r}" for key in GEAR_KEYS)
    return f"""# Reference mesh: default 2D section of the {member} of the coal combine pair. Made by meshes/make.py.
file = "coal_combine_{member}_2d.vtu"
gearfem = "{__version__}"
model = "studies/coal_combine/model.toml"
gear = "{member}"
method = "FiniteElements, bore held: gearfem mesh MODEL --dim 2 --gear {member} --resolution {FiniteElements().resolution:g}"
resolution = {FiniteElements().resolution:g}
element = "quad9"
nodes = {len(mesh.points)}
elements = {len(mesh.cells)}
unit = "mm"
frame = "tooth axis along +x, centre of the gear at the origin"
ring = "the gear is {gear.teeth} such sectors, each turned by 2 pi/{gear.teeth}; upper cut of one = lower cut of the next"
sets = "point data: bore (held) and flank, 1 on their nodes"
rounding_mm = {UNIT_MM:g}
sha256 = "{checksum(mesh)}"

[gear_definition]                      # SI: m, rad
{keys}
"""


def main() -> None:
    """Write all meshes and recipes."""
    for member in ("pinion", "wheel"):
        mesh, gear, section = sector(member)
        path = HERE / f"coal_combine_{member}_2d.vtu"
        write_section(section, "bore", path)
        path.with_suffix(".toml").write_text(recipe(member, mesh, gear), encoding="utf-8")
        print(f"{path.name}: {len(mesh.points)} nodes, {path.stat().st_size // 1024} KiB, {checksum(mesh)}")


if __name__ == "__main__":
    main()
