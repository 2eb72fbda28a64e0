"""The reference meshes are what the program makes today, and what their recipes say."""

from __future__ import annotations

import importlib.util
import tomllib
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from gearfem.compliance.mesh_file import read_mesh

MESHES = Path(__file__).parents[2] / "meshes"
_spec = importlib.util.spec_from_file_location("make_meshes", MESHES / "make.py")
make = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(make)


def recipe_of(name: str) -> dict[str, Any]:
    return tomllib.loads((MESHES / f"{name}.toml").read_text(encoding="utf-8"))


def test_every_mesh_has_its_recipe_and_its_maker() -> None:
    for ending in ("toml", "vtu"):
        assert {path.stem for path in MESHES.glob(f"*.{ending}")} == set(make.REFERENCES)


@pytest.mark.parametrize("name", make.REFERENCES)
def test_recipe_mesh_and_program_agree(name: str) -> None:
    recipe = recipe_of(name)
    stored = make.stored(MESHES / recipe["file"])
    made = make.made(name)
    assert (len(stored.points), len(stored.cells)) == (recipe["nodes"], recipe["elements"])
    assert make.checksum(stored) == recipe["sha256"]
    # Where this alone fails, the mesher has changed: run meshes/make.py and say why in the commit.
    assert make.checksum(made.mesh) == recipe["sha256"]
    # Digits of constructors beyond 1e-12 depend on the platform's mathematical functions.
    assert {key: getattr(made.gear, key) for key in make.GEAR_KEYS} == pytest.approx(recipe["gear_definition"], rel=1e-12, abs=0.0)
    assert {key: made.about[key] for key in made.about if key.startswith("second_order_")} == {
        key: value for key, value in recipe.items() if key.startswith("second_order_")
    }
    assert (MESHES / recipe["file"]).stat().st_size < (300_000 if name.endswith("_2d") else 400_000)


def test_the_published_mesh_has_the_published_numbers_and_both_clamps() -> None:
    name = "wojnarowski_onishchenko_2003"
    read = meshio.read(MESHES / f"{name}.vtu")
    assert (len(read.cells[0].data), len(read.points)) == (585, 896)
    assert recipe_of(name)["held"] == {"two_layers": 128, "layer_and_sides": 128}
    assert [int(read.point_data[clamp].sum()) for clamp in ("two_layers", "layer_and_sides")] == [128, 128]
    assert np.any(read.point_data["two_layers"] != read.point_data["layer_and_sides"])


@pytest.mark.parametrize("member", ["pinion", "wheel"])
def test_solid_teeth_stand_on_their_root_over_the_face_width(member: str) -> None:
    recipe = recipe_of(f"coal_combine_{member}_3d")
    file = read_mesh(MESHES / recipe["file"], 3)
    assert set(file.sets) == {"root", "flank"}
    # Every section has the same held nodes, on the root circle between the ends of the fillets.
    assert len(file.sets["root"]) % (recipe["layers"] + 1) == 0
    radius = np.hypot(*file.points[file.sets["root"], :2].T)
    assert radius == pytest.approx(1e3 * recipe["gear_definition"]["root_radius"], rel=1e-9, abs=0.0)
    assert np.unique(file.points[:, 2].round(9)) == pytest.approx(recipe["places_mm"], abs=1e-9)


def test_checksum_sees_shape_and_topology_but_neither_numbering_nor_rounding() -> None:
    mesh = make.stored(MESHES / "coal_combine_pinion_2d.vtu")
    base = make.checksum(mesh)
    shuffle = np.random.default_rng(1).permutation(len(mesh.points))
    place = np.argsort(shuffle)
    assert make.checksum(make.Mesh(mesh.points[shuffle], place[mesh.cells][::-1])) == base
    assert make.checksum(make.Mesh(mesh.points + 1e-13, mesh.cells)) == base
    moved = np.array(mesh.points)
    moved[7, 0] += 2e-5
    assert make.checksum(make.Mesh(moved, mesh.cells)) != base
    assert make.checksum(make.Mesh(mesh.points, mesh.cells[1:])) != base
    assert make.checksum(make.Mesh(mesh.points, mesh.cells[:, [1, 2, 3, 0, 5, 6, 7, 4, 8]])) != base
