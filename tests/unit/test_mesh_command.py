"""Meshes that `gearfem mesh` writes: where they reach, what they hold, and who refuses them."""

from __future__ import annotations

import os
from pathlib import Path

import meshio
import numpy as np
import pytest

from gearfem.cli.steps import SUPPORTS
from gearfem.compliance import SolidElements
from gearfem.compliance.mesh_file import read_mesh
from gearfem.flank import make_flanks
from gearfem.foundation import InputError
from gearfem.model import load_model
from tests.unit.shell import MODEL, assert_refused, call

MESHES = Path(__file__).parents[2] / "meshes"


def test_meshes_reach_from_bore_to_tip_in_millimetres(tmp_path):
    assert call("mesh", MODEL, "--out", tmp_path).exit_code == 0
    for name, bore, tip in (("pinion", 30.0, 76.17), ("wheel", 60.0, 219.17)):
        read = meshio.read(tmp_path / f"mesh_{name}.vtu")
        radius = np.hypot(*read.points[:, :2].T)
        assert [radius.min(), radius.max()] == pytest.approx([bore, tip], rel=1e-9, abs=0.0)
        assert read.cells[0].type == "quad9"
        # Nodes lie on the bore exactly; the next row is an element away.
        assert np.array_equal(read.point_data["held"] == 1.0, radius < bore * (1 + 1e-6))


def test_a_mesh_of_one_gear_goes_to_the_file_that_is_named(tmp_path):
    result = call("mesh", MODEL, "--dim", 2, "--gear", "wheel", "--support", "root", "--out", tmp_path / "tooth.msh")
    assert result.exit_code == 0, result.output
    points = meshio.read(tmp_path / "tooth.msh").points
    assert np.hypot(*points[:, :2].T).min() == pytest.approx(203.4, rel=1e-6, abs=0.0)
    assert os.listdir(tmp_path) == ["tooth.msh"]


@pytest.mark.parametrize(("ending", "kind"), [("vtu", 27), ("vtk", 27), ("msh", 27), ("mdpa", 27), ("inp", 8), ("mesh", 8), ("avs", 8)])
@pytest.mark.parametrize("support", ["root", "bore"])
def test_solids_come_back_with_their_elements_and_sets(tmp_path, ending, kind, support):
    path = tmp_path / f"tooth.{ending}"
    result = call("mesh", MODEL, "--dim", 3, "--gear", "pinion", "--support", support, "--resolution", 0.5, "--out", path)
    assert result.exit_code == 0, result.output
    assert ("eight-node" in result.stdout) == (kind == 8)
    pair = load_model(MODEL).pair
    held = SUPPORTS[support]()
    made = SolidElements(support=held, resolution=0.5).mesh(make_flanks(load_model(MODEL)).pinion, pair.face_width)
    read = read_mesh(path, 3)
    ((name, cells),) = read.cells
    assert (name, cells.shape) == ("hexahedron27" if kind == 27 else "hexahedron", (len(made.hexes), kind))
    # Every node of every element in its place: formats number second-order nodes differently. Seven digits may be written.
    assert np.abs(read.points[cells] - made.nodes[made.hexes[:, :kind]] * 1e3).max() < 1e-4
    if ending not in ("vtu", "vtk", "msh", "inp"):
        assert "no boundary sets" in result.stdout
        return
    kept = np.isin(np.arange(len(made.nodes)), made.hexes[:, :kind])
    assert set(read.sets) == {support, "flank"}
    assert len(read.sets[support]) == (made.held & kept).sum()
    assert len(read.sets["flank"]) == (made.flank & kept).sum()
    # Both sides of the tooth, over the whole face width.
    sides = read.points[read.sets["flank"]]
    assert [sides[:, 1].min(), sides[:, 2].min()] == pytest.approx([-sides[:, 1].max(), -37.5], rel=1e-6, abs=0.0)


def test_a_plane_reader_refuses_a_solid_in_one_line(tmp_path):
    path = tmp_path / "tooth.vtu"
    assert call("mesh", MODEL, "--dim", 3, "--gear", "pinion", "--support", "root", "--resolution", 0.5, "--out", path).exit_code == 0
    assert_refused(call("compliance", MODEL, "--mesh", path, "--gear", "pinion", "--out", tmp_path), "tooth.vtu", "a plane mesh")
    with pytest.raises(InputError, match="hexahedron"):
        read_mesh(MESHES / "coal_combine_pinion_2d.vtu", 3)
