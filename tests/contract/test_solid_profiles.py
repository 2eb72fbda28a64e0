"""What every profile, influence matrix, field and file of the three-dimensional tooth keeps to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import pyvista

from gearfem.compliance import Bore, Root, RootChord
from gearfem.compliance.mesh_writing import write_solid
from gearfem.compliance.paper_mesh import LayerAndSides, PaperMesh, TwoLayers
from gearfem.compliance.solid import SolidElements
from gearfem.flank import Outline
from gearfem.foundation import InputError

WIDTH = 12e-3


@pytest.fixture(scope="module")
def outline(gear_factory) -> Outline:
    return Outline(gear=gear_factory(8, 2e-3, 10e-3, profile_shift=0.5, bore_radius=4e-3))


def solid(support: Root | RootChord | Bore) -> SolidElements:
    return SolidElements(support=support, resolution=0.5, layers=4)


@pytest.mark.parametrize("support", [Root(), RootChord(), Bore()])
def test_partial_loads_add_up_and_mirror(outline: Outline, support: Root | RootChord | Bore) -> None:
    method, cut = solid(support), 2e-3
    left = method.profile(outline, 2.8, WIDTH, (-WIDTH / 2, -cut))
    right = method.profile(outline, 2.8, WIDTH, (cut, WIDTH / 2))
    inner = method.profile(outline, 2.8, WIDTH, (-cut, cut))
    whole = method.profile(outline, 2.8, WIDTH, (-WIDTH / 2, WIDTH / 2))
    assert right.deflection == pytest.approx(left.deflection[::-1], rel=1e-7, abs=1e-9 * left.deflection.max())
    # Partial loads have more layers; the meshes differ by far less than the parts.
    total = left.average + inner.average + right.average
    assert total / whole.average == pytest.approx(1.0, rel=2e-3, abs=0.0)
    assert left.ends[0] > 3.0 * left.ends[1]
    curve = method.curve(outline, [2.5, 2.8], WIDTH)
    assert (curve.method, curve.support) == ("fe_3d", support.name)
    assert curve.deflection[1] / whole.average == pytest.approx(1.0, rel=1e-8, abs=0.0)


@pytest.mark.parametrize("slices", [2, 5])
def test_influence_is_mirrored_nearly_reciprocal_and_sums_to_the_profile(outline: Outline, slices: int) -> None:
    method = solid(Root())
    (result,) = method.influence(outline, [2.8], WIDTH, slices)
    assert result.matrix.shape == (slices, slices)
    assert result.matrix == pytest.approx(result.matrix[::-1, ::-1], rel=1e-6, abs=1e-9 * result.matrix.max())
    assert (np.argmax(result.matrix, axis=0) == np.arange(slices)).all()
    profile = method.profile(outline, 2.8, WIDTH)
    middles = 0.5 * (result.edges[1:] + result.edges[:-1])
    shown = np.interp(middles, profile.place, profile.deflection)
    # Different layers and a straight line between nodes of the profile.
    assert result.matrix.sum(axis=1) / shown == pytest.approx(1.0, rel=5e-3, abs=0.0)
    assert result.asymmetry < 0.05


def test_fields_scale_with_the_load_and_are_written_whole(outline: Outline, tmp_path: Path) -> None:
    field = solid(Root()).field(outline, 2.8, WIDTH, 1e5)
    assert field.displacement.shape == field.mesh.nodes.shape
    assert np.abs(field.displacement[field.mesh.held]).max() == 0.0
    double = solid(Root()).field(outline, 2.8, WIDTH, 2e5)
    assert double.von_mises / field.von_mises == pytest.approx(2.0, rel=1e-6, abs=0.0)
    write_solid(field, tmp_path / "field.vtu")
    read = pyvista.read(tmp_path / "field.vtu")
    assert set(read.array_names) == {"root", "held", "flank", "displacement_mm", "von_mises_MPa"}
    assert read["displacement_mm"] == pytest.approx(field.displacement * 1e3, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("kind", ["solid", "paper"])
def test_files_hold_hexahedra_the_right_way_round(outline: Outline, tmp_path: Path, kind: str) -> None:
    mesh = solid(Bore()).mesh(outline, WIDTH) if kind == "solid" else PaperMesh().mesh(outline, WIDTH)
    write_solid(mesh, tmp_path / "mesh.vtu")
    read = pyvista.read(tmp_path / "mesh.vtu")
    assert read.volume > 0.0
    assert read.compute_cell_sizes()["Volume"].min() > 0.0
    if kind == "solid":
        cell = read.GetCell(0)
        for number in range(6):
            face = np.array([read.GetPoint(cell.GetFace(number).GetPointId(i)) for i in range(9)])
            # The last node of a face stands in its middle; curved sides move it by less than a tenth of the face.
            assert np.abs(face[8] - face[:4].mean(axis=0)).max() < 0.1 * np.ptp(face, axis=0).max()


@pytest.mark.parametrize("clamp", [TwoLayers(), LayerAndSides()])
def test_published_mesh_has_the_published_numbers(outline: Outline, clamp: TwoLayers | LayerAndSides) -> None:
    mesh = PaperMesh(clamp=clamp).mesh(outline, WIDTH)
    assert (len(mesh.hexes), len(mesh.nodes), int(mesh.held.sum())) == (585, 896, 128)
    held = mesh.nodes[mesh.held]
    places, counts = np.unique(held[:, 2], return_counts=True)
    assert len(places) == 16
    assert (counts == 8).all()


def test_bad_input_is_refused(outline: Outline) -> None:
    method = solid(Root())
    for call in (
        lambda: SolidElements(resolution=0.2),
        lambda: SolidElements(layers=1),
        lambda: PaperMesh(refinement=0),
        lambda: method.curve(outline, 2.8, 0.0),
        lambda: method.curve(outline, 2.8, float("nan")),
        lambda: method.profile(outline, 2.8, WIDTH, (0.0, WIDTH)),
        lambda: method.profile(outline, 2.8, WIDTH, (1e-3, 1e-3)),
        lambda: method.influence(outline, [2.8], WIDTH, 1),
        lambda: method.profile(outline, 1.5, WIDTH),
        lambda: PaperMesh().curve(outline, -1.0),
    ):
        with pytest.raises(InputError):
            call()


def test_files_of_another_ending_are_refused(outline: Outline, tmp_path: Path) -> None:
    mesh = PaperMesh().mesh(outline, WIDTH)
    for name in ("mesh.stl", "mesh.ply"):
        with pytest.raises(InputError, match="vtu"):
            write_solid(mesh, tmp_path / name)
    with pytest.raises(InputError, match="values at nodes"):
        write_solid(mesh, tmp_path / "mesh.msh", {"height": mesh.nodes[:, 0]})
    assert not list(tmp_path.iterdir())
