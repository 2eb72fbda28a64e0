"""Meshes out to other programs and in from them: the same compliance, and one line for each mesh that cannot be used."""

from __future__ import annotations

import csv
import importlib.util
from pathlib import Path

import meshio
import numpy as np
import pytest

from gearfem.compliance import FiniteElements, Root
from gearfem.compliance.elasticity import stiffness
from gearfem.compliance.foreign import check_mesh, foreign_curve
from gearfem.compliance.mesh_file import FLANK, MeshFile, read_mesh, section_file
from gearfem.compliance.mesh_writing import write_section
from gearfem.flank import Outline
from gearfem.foundation import InputError
from tests.unit.shell import MODEL, call

U = np.array([2.3, 2.6, 2.95])


@pytest.fixture(scope="module")
def outline(gear_factory) -> Outline:
    return Outline(gear=gear_factory(10, 2e-3, 12.2e-3, 0.5, bore_radius=5e-3))


@pytest.fixture(scope="module")
def tooth(outline: Outline) -> MeshFile:
    return section_file(Root().section(outline, 1.0), "root")[0]


@pytest.mark.parametrize("ending", [".vtu", ".vtk", ".msh", ".inp"])
def test_our_own_mesh_fed_back_gives_the_same_compliance(outline: Outline, tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"tooth{ending}"
    write_section(Root().section(outline, 1.0), "root", path)
    curve = foreign_curve(check_mesh(read_mesh(path), outline), outline, U)
    own = FiniteElements(support=Root(), resolution=1.0).curve(outline, U)
    assert (curve.method, curve.support) == ("fe_plane_strain", "root")
    # The same elements, loads and readings, with nodes moved by the 16th digit on the way through the file.
    assert curve.deflection == pytest.approx(own.deflection, rel=1e-9, abs=0.0)


def test_through_the_command_line_for_both_commands(tmp_path: Path) -> None:
    assert call("mesh", MODEL, "--gear", "wheel", "--support", "root", "--resolution", 1, "--out", tmp_path / "w.msh").exit_code == 0
    result = call("compliance", MODEL, "--mesh", tmp_path / "w.msh", "--gear", "wheel", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    table = list(csv.DictReader((tmp_path / "compliance.csv").read_text().splitlines()[1:]))
    assert {(row["gear"], row["method"], row["support"]) for row in table} == {("wheel", "fe_plane_strain", "root")}
    assert "no estimate of its error" in result.output


def _whole_gear(outline: Outline) -> MeshFile:
    """Return all sectors joined at their cuts, with the sets of all of them."""
    section = FiniteElements(resolution=1.0).support.section(outline, 1.0)
    one, _ = section_file(section, "bore")
    teeth, count = outline.gear.teeth, len(one.points)
    number = np.arange(teeth * count).reshape(teeth, count)
    for k in range(teeth):
        number[(k + 1) % teeth, section.lower] = number[k, section.upper]
    used, number = np.unique(number, return_inverse=True)
    number = number.reshape(teeth, count)
    angle = 2.0 * np.pi * np.arange(teeth) / teeth
    turns = np.stack([np.stack([np.cos(angle), np.sin(angle)], 1), np.stack([-np.sin(angle), np.cos(angle)], 1)], 1)
    points = np.zeros((len(used), 2))
    points[number] = np.einsum("ni,kij->knj", one.points, turns)
    sets = {name: np.unique(number[:, ids]) for name, ids in one.sets.items()}
    return MeshFile(points, [("quad9", np.concatenate([row[one.cells[0][1]] for row in number]))], sets)


def test_a_whole_gear_is_the_ring_of_its_sectors(outline: Outline) -> None:
    mesh = check_mesh(_whole_gear(outline), outline)
    assert mesh.span == 2.0 * np.pi
    # Two solutions of one system whose condition number is about 1e6; ten teeth, so that the last harmonic stands alone.
    assert foreign_curve(mesh, outline, U).deflection == pytest.approx(
        FiniteElements(resolution=1.0).curve(outline, U).deflection, rel=1e-8, abs=0.0
    )


def test_one_sector_on_its_bore_says_what_it_is(outline: Outline) -> None:
    section = FiniteElements(resolution=1.0).support.section(outline, 1.0)
    mesh = check_mesh(section_file(section, "bore")[0], outline)
    assert mesh.span == pytest.approx(2.0 * np.pi / 10, rel=1e-9, abs=0.0)
    # With free cuts it is softer than the gear it is cut from.
    assert np.all(foreign_curve(mesh, outline, U).deflection > 1.05 * FiniteElements(resolution=1.0).curve(outline, U).deflection)


def _as(tooth: MeshFile, kind: str) -> MeshFile:
    """Return the same tooth in elements of another type."""
    nine = tooth.cells[0][1]
    if kind == "quad":
        cells = nine[:, :4]
    elif kind == "quad8":
        cells = nine[:, :8]
    elif kind == "triangle":
        cells = np.concatenate([nine[:, [0, 1, 2]], nine[:, [0, 2, 3]]])
    else:
        cells = np.concatenate([nine[:, [0, 1, 2, 4, 5, 8]], nine[:, [0, 2, 3, 8, 6, 7]]])
    return MeshFile(tooth.points, [(kind, cells)], tooth.sets)


@pytest.mark.parametrize(("kind", "band"), [("quad8", 0.01), ("triangle6", 0.02), ("quad", 0.05), ("triangle", 0.2)])
def test_other_elements_come_near_the_same_compliance(outline: Outline, tooth: MeshFile, kind: str, band: float) -> None:
    own = FiniteElements(support=Root(), resolution=1.0).curve(outline, U).deflection
    curve = foreign_curve(check_mesh(_as(tooth, kind), outline), outline, U)
    np.testing.assert_array_equal(curve.u, U)
    ratio = curve.deflection / own
    print(kind, ratio)
    # Bands of the coarse mesh: second order by the neglected terms, bilinear ones stiff in bending, linear triangles most.
    assert ratio == pytest.approx(1.0, abs=band)
    if kind in ("quad", "triangle"):
        assert ratio.max() < 1.0


def test_mixed_elements_make_one_mesh(outline: Outline, tooth: MeshFile) -> None:
    half = len(tooth.cells[0][1]) // 2
    parts = MeshFile(tooth.points, [("quad9", tooth.cells[0][1][:half]), ("quad9", tooth.cells[0][1][half:])], tooth.sets)
    own = foreign_curve(check_mesh(tooth, outline), outline, U).deflection
    assert foreign_curve(check_mesh(parts, outline), outline, U).deflection == pytest.approx(own, rel=1e-9, abs=0.0)


def test_assembly_is_that_of_our_own_meshes(outline: Outline) -> None:
    section = Root().section(outline, 1.0)
    matrix = stiffness(section.mesh, FiniteElements().plane, outline.gear.material)
    assert np.abs((matrix - matrix.T).data).max(initial=0.0) < 1e-12 * matrix.max()


# ---- refusals ---------------------------------------------------------------------------------------


def test_meshes_that_cannot_be_meant_are_refused(outline: Outline, tooth: MeshFile) -> None:
    kind, cells = tooth.cells[0]
    turned = cells[:, [0, 3, 2, 1, 7, 6, 5, 4, 8]]
    flat = np.array(tooth.points)
    flat[cells[0]] = flat[cells[0][0]]
    moved = np.array(tooth.points)
    moved[tooth.sets[FLANK][3]] += [0.0, 0.02]
    lone = np.vstack([tooth.points, [[90.0, 0.0], [91.0, 0.0], [90.0, 1.0]]])
    last = len(tooth.points)
    turned_away = tooth.points @ np.array([[np.cos(0.1), np.sin(0.1)], [-np.sin(0.1), np.cos(0.1)]])
    cases = [
        (tooth._replace(sets={"root": tooth.sets["root"]}), "boundary sets: found root; allowed: flank"),
        (tooth._replace(sets={FLANK: tooth.sets[FLANK]}), "one of bore and root"),
        (tooth._replace(sets={**tooth.sets, "bore": tooth.sets["root"]}), "root, flank|bore, root"),
        (tooth._replace(points=tooth.points * 1e-3), "looks like metres"),
        (tooth._replace(points=tooth.points / 25.4), "looks like inches"),
        (tooth._replace(points=tooth.points * 3.0), "millimetres"),
        (tooth._replace(cells=[(kind, turned)]), f"{len(cells)} of {len(cells)} quad9 elements inverted"),
        (tooth._replace(points=flat), "degenerate"),
        (tooth._replace(points=moved), "1 of .* off the tooth's outline, by up to 0.0"),
        (tooth._replace(points=turned_away), "off the tooth's outline"),
        (tooth._replace(cells=[(kind, cells), ("triangle", np.array([[last, last + 1, last + 2]]))], points=lone), "without held nodes"),
        (tooth._replace(cells=[(kind, cells + last)]), "node number"),
    ]
    for mesh, words in cases:
        with pytest.raises(InputError, match=words):
            check_mesh(mesh, outline)


def test_a_mesh_of_the_other_gear_is_refused_in_one_line(tmp_path: Path) -> None:
    assert call("mesh", MODEL, "--gear", "wheel", "--support", "root", "--resolution", 1, "--out", tmp_path / "w.vtu").exit_code == 0
    result = call("compliance", MODEL, "--mesh", tmp_path / "w.vtu", "--gear", "pinion", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "w.vtu" in result.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("name", "content"), [("m.vtu", "<VTKFile>"), ("m.msh", "nonsense"), ("m.xyz", "1 2 3"), ("m.inp", ""), ("absent.vtu", None)]
)
def test_files_that_cannot_be_read_are_refused_in_one_line(tmp_path: Path, name: str, content: str | None) -> None:
    if content is not None:
        (tmp_path / name).write_text(content)
    result = call("compliance", MODEL, "--mesh", tmp_path / name, "--gear", "pinion", "--out", tmp_path / "out")
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1), result.output
    assert name in result.stderr


@pytest.mark.parametrize("options", [("--mesh", "m.vtu"), ("--gear", "pinion")])
def test_mesh_and_gear_belong_together(tmp_path: Path, options: tuple[str, str]) -> None:
    result = call("compliance", MODEL, *options, "--out", tmp_path)
    assert result.exit_code == 2
    assert "--mesh, --gear" in result.stderr


def test_solids_and_warped_sections_are_refused(tmp_path: Path) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    meshio.Mesh(points[:3], [("triangle", [[0, 1, 2]])]).write(tmp_path / "flat.vtu")
    assert read_mesh(tmp_path / "flat.vtu").sets == {}
    meshio.Mesh(points, [("triangle", [[0, 1, 2]])]).write(tmp_path / "space.vtu")
    with pytest.raises(InputError, match="a plane mesh"):
        read_mesh(tmp_path / "space.vtu")
    meshio.Mesh(points * [1, 1, 0], [("tetra", [[0, 1, 2, 3]])]).write(tmp_path / "solid.vtu")
    with pytest.raises(InputError, match="found cells tetra"):
        read_mesh(tmp_path / "solid.vtu")


def test_formats_without_biquadratic_elements_say_so_and_unknown_ones_are_refused(outline: Outline, tmp_path: Path) -> None:
    said = write_section(Root().section(outline, 1.0), "root", tmp_path / "tooth.mesh")
    assert "bilinear" in said
    assert meshio.read(tmp_path / "tooth.mesh").cells[0].type == "quad"
    # meshio would write an empty surface.
    for name in ("tooth.stl", "tooth.docx"):
        result = call("mesh", MODEL, "--resolution", 1, "--out", tmp_path / name)
        assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["tooth.mesh"]


@pytest.mark.skipif(importlib.util.find_spec("h5py") is not None, reason="h5py is installed")
def test_a_format_that_lacks_its_package_is_refused_in_one_line(tmp_path: Path) -> None:
    result = call("mesh", MODEL, "--resolution", 1, "--out", tmp_path / "tooth.xdmf")
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert "h5py" in result.stderr
    assert not list(tmp_path.iterdir())
