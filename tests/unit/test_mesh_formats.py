"""Every format that is offered gives back what was written."""

from __future__ import annotations

import meshio
import pytest

from gearfem.compliance import FiniteElements, Root, SolidElements
from gearfem.compliance.mesh_writing import FORMATS, PLANE, SOLID, write_section, write_solid
from gearfem.flank import Outline
from gearfem.foundation import InputError

# h5py and netCDF4 are an extra; without them the refusal names the package.
EXTRA = {"xdmf": "h5py", "med": "h5py", "hmf": "h5py", "exodus": "netCDF4"}


@pytest.fixture(scope="module")
def outline(gear_factory) -> Outline:
    return Outline(gear=gear_factory(20, 2e-3, 22e-3))


def elements(path, kind: str, corners: tuple[str, ...]) -> int:
    """Return the number of elements of these kinds in a file."""
    return sum(len(block.data) for block in meshio.read(path, file_format=kind).cells if block.type in corners)


def skip_without_package(kind: str, write) -> None:
    if kind in EXTRA:
        try:
            __import__(EXTRA[kind])
        except ModuleNotFoundError:
            with pytest.raises(InputError, match=EXTRA[kind]):
                write()
            pytest.skip(f"{EXTRA[kind]} is not installed; the refusal names it")


@pytest.mark.parametrize("ending", [ending for ending, (kind, _) in FORMATS.items() if kind not in SOLID])
def test_section_comes_back(tmp_path, outline, ending) -> None:
    section = Root().section(outline, FiniteElements(resolution=1.0).resolution)
    path, kind = tmp_path / f"tooth{ending}", FORMATS[ending][0]
    skip_without_package(kind, lambda: write_section(section, "root", path))
    write_section(section, "root", path)
    assert elements(path, "gmsh" if kind == "gmsh22" else kind, ("quad", "quad9")) == section.mesh.t.shape[1]


@pytest.mark.parametrize("ending", [ending for ending, (kind, _) in FORMATS.items() if kind not in PLANE])
def test_solid_comes_back(tmp_path, outline, ending) -> None:
    mesh = SolidElements(support=Root(), resolution=0.5, layers=2).mesh(outline, 10e-3)
    path, kind = tmp_path / f"tooth{ending}", FORMATS[ending][0]
    skip_without_package(kind, lambda: write_solid(mesh, path))
    write_solid(mesh, path)
    assert elements(path, "gmsh" if kind == "gmsh22" else kind, ("hexahedron", "hexahedron27")) == len(mesh.hexes)
