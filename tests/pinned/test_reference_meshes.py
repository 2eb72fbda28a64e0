"""The reference meshes are what the program makes today, and what their recipes say."""

from __future__ import annotations

import importlib.util
import tomllib
from pathlib import Path

import numpy as np
import pytest

MESHES = Path(__file__).parents[2] / "meshes"
_spec = importlib.util.spec_from_file_location("make_meshes", MESHES / "make.py")
make = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(make)


@pytest.mark.parametrize("member", ["pinion", "wheel"])
def test_recipe_mesh_and_program_agree(member: str) -> None:
    recipe = tomllib.loads((MESHES / f"coal_combine_{member}_2d.toml").read_text(encoding="utf-8"))
    stored = make.stored(MESHES / recipe["file"])
    made, gear, _ = make.sector(member)
    assert (len(stored.points), len(stored.cells)) == (recipe["nodes"], recipe["elements"])
    assert make.checksum(stored) == recipe["sha256"]
    # Where this alone fails, the mesher has changed: run meshes/make.py and say why in the commit.
    assert make.checksum(made) == recipe["sha256"]
    # Digits of constructors beyond 1e-12 depend on the platform's mathematical functions.
    assert {key: getattr(gear, key) for key in make.GEAR_KEYS} == pytest.approx(recipe["gear_definition"], rel=1e-12, abs=0.0)
    assert (MESHES / recipe["file"]).stat().st_size < 300_000


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
