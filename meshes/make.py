"""Make the reference meshes again: ``python meshes/make.py`` writes each mesh as VTU and its recipe as TOML beside it.

The 2D meshes are the sector of one tooth from the bore to the tip, which is condensed once: the gear is the ring of `teeth` such
sectors, the nodes of its upper cut (at the polar angle +pi/teeth) joined to those of the lower cut of the next one, turned by
2 pi/teeth. Point data: ``bore`` (held) and ``flank`` are 1 on the nodes of these sets.

The 3D meshes are the tooth alone, held at its root: the eight-node hexahedra on the corners of the program's 27-node ones, whose
own number of nodes and checksum the recipe states beside the command that writes them. The published mesh of Wojnarowski &
Onishchenko (2003) is the pinion's, with both readings of its 128 held nodes as point data.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gearfem import __version__, load_model
from gearfem.compliance import FiniteElements, LayerAndSides, PaperMesh, Root, SolidElements, SolidMesh, TwoLayers
from gearfem.compliance.mesh_file import read_mesh, section_file, solid_file
from gearfem.compliance.mesh_writing import write_section, write_solid
from gearfem.compliance.solid_mesh import trilinear
from gearfem.flank import Outline, make_flanks
from gearfem.foundation.units import MM

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


class Reference(NamedTuple):
    """A reference mesh as it is made today.

    Parameters
    ----------
    mesh : Mesh
        What the file holds.
    gear : Gear
        Gear that it is a mesh of.
    about : dict
        Lines of the recipe that are its own.
    write : callable
        Writes it to a path.
    """

    mesh: Mesh
    gear: object
    about: dict[str, object]
    write: Callable[[Path], object]


def outline_of(member: str) -> tuple[Outline, float]:
    """Return the outline of a gear of the coal combine and the face width."""
    setup = load_model(str(MODEL))
    flanks = make_flanks(setup)
    return (flanks.pinion if member == "pinion" else flanks.wheel), setup.pair.face_width


def plane(member: str) -> Reference:
    """Return the default 2D mesh of a gear: one sector from the bore to the tip."""
    outline, _ = outline_of(member)
    method = FiniteElements()
    section = method.support.section(outline, method.resolution)
    file, _ = section_file(section, "bore")
    teeth = outline.gear.teeth
    about = {
        "title": f"default 2D section of the {member} of the coal combine pair",
        "method": f"FiniteElements, bore held: gearfem mesh MODEL --dim 2 --gear {member} --resolution {method.resolution:g}",
        "resolution": method.resolution,
        "element": "quad9",
        "ring": f"the gear is {teeth} such sectors, each turned by 2 pi/{teeth}; upper cut of one = lower cut of the next",
        "sets": "point data: bore (held) and flank, 1 on their nodes",
    }
    return Reference(Mesh(file.points, file.cells[0][1]), outline.gear, about, lambda path: write_section(section, "bore", path))


def solid(member: str) -> Reference:
    """Return the corners of the default 3D mesh of a tooth held at its root."""
    outline, width = outline_of(member)
    method = SolidElements(support=Root())
    second = method.mesh(outline, width)
    first = trilinear(second)
    places = np.unique(np.round(first.nodes[:, 2] / MM, 9))
    about = {
        "title": f"default 3D tooth of the {member} of the coal combine pair, held at its root",
        "method": f"SolidElements, root held: gearfem mesh MODEL --dim 3 --gear {member} --support root",
        "resolution": method.resolution,
        "layers": method.layers,
        "face_width_mm": width / MM,
        "places_mm": places.tolist(),
        "element": "hexahedron",
        "second_order": "the method's elements have 27 nodes: these corners, nodes halfway between two sections, and in each section "
        "the middle nodes of its mesh, on the tooth's outline where an edge lies on it; the command writes them",
        "second_order_nodes": len(second.nodes),
        "second_order_sha256": checksum(_stored(second)),
        "sets": "point data: root (held) and flank, 1 on their nodes",
    }
    return Reference(_stored(first), outline.gear, about, lambda path: write_solid(first, path))


def published(member: str) -> Reference:
    """Return the published mesh on a tooth, with both readings of what it holds."""
    outline, width = outline_of(member)
    clamps = (TwoLayers(), LayerAndSides())
    meshes = {clamp.name: PaperMesh(clamp=clamp).mesh(outline, width) for clamp in clamps}
    mesh = meshes[TwoLayers.name]
    about = {
        "title": "mesh of Wojnarowski & Onishchenko (2003): 585 eight-node hexahedra, 896 nodes, 128 of them held",
        "method": "PaperMesh, rows at equal steps of arc length from the end of the fillet on the root circle to the end of the involute",
        "face_width_mm": width / MM,
        "element": "hexahedron",
        "held": {name: int(one.held.sum()) for name, one in meshes.items()},
        "sets": "point data, 1 on their nodes: two_layers and layer_and_sides, the two readings of what the paper holds; root is the "
        "first of them, and flank",
    }
    flags = {name: one.held.astype(np.int32) for name, one in meshes.items()}
    return Reference(_stored(mesh), outline.gear, about, lambda path: write_solid(mesh, path, flags))


def _stored(mesh: SolidMesh) -> Mesh:
    file, _ = solid_file(mesh)
    return Mesh(file.points, file.cells[0][1])


# Each file, and what makes it of which gear.
REFERENCES: dict[str, tuple[Callable[[str], Reference], str]] = {
    "coal_combine_pinion_2d": (plane, "pinion"),
    "coal_combine_wheel_2d": (plane, "wheel"),
    "coal_combine_pinion_3d": (solid, "pinion"),
    "coal_combine_wheel_3d": (solid, "wheel"),
    "wojnarowski_onishchenko_2003": (published, "pinion"),
}


def made(name: str) -> Reference:
    """Return the reference mesh of this name as the program makes it."""
    make, member = REFERENCES[name]
    return make(member)


def stored(path: Path) -> Mesh:
    """Return a mesh that was written."""
    file = read_mesh(path, 2 if path.stem.endswith("_2d") else 3)
    return Mesh(file.points, file.cells[0][1])


def recipe(name: str, reference: Reference) -> str:
    """Return the recipe of a mesh as TOML."""
    keys = "\n".join(f"{key} = {getattr(reference.gear, key)!r}" for key in GEAR_KEYS)
    about = dict(reference.about)
    mesh, title, sets = reference.mesh, about.pop("title"), about.pop("sets")
    own = "\n".join(f"{key} = {_toml(value)}" for key, value in about.items())
    return f"""# Reference mesh: {title}. Made by meshes/make.py.
file = "{name}.vtu"
gearfem = "{__version__}"
model = "studies/coal_combine/model.toml"
gear = "{REFERENCES[name][1]}"
{own}
nodes = {len(mesh.points)}
elements = {len(mesh.cells)}
unit = "mm"
frame = "tooth axis along +x, centre of the gear at the origin{"" if mesh.points.shape[1] == 2 else ", z from mid-face"}"
sets = "{sets}"
rounding_mm = {UNIT_MM:g}
sha256 = "{checksum(mesh)}"

[gear_definition]                      # SI: m, rad
{keys}
"""


def _toml(value: object) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(part)}" for key, part in value.items()) + " }"
    return f'"{value}"' if isinstance(value, str) else f"{value:.12g}" if isinstance(value, float) else str(value)


def main() -> None:
    """Write all meshes and recipes."""
    for name in REFERENCES:
        reference = made(name)
        path = HERE / f"{name}.vtu"
        reference.write(path)
        path.with_suffix(".toml").write_text(recipe(name, reference), encoding="utf-8")
        size = f"{len(reference.mesh.points)} nodes, {path.stat().st_size // 1024} KiB"
        print(f"{path.name}: {size}, {checksum(reference.mesh)}")


if __name__ == "__main__":
    main()
