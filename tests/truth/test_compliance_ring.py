"""The ring solved by harmonics against the same ring assembled whole, and the identities of elasticity."""

from __future__ import annotations

import numpy as np
import pytest
import skfem
from scipy import sparse
from scipy.sparse.linalg import spsolve

from gearfem.compliance import FiniteElements, PlaneStrain, PlaneStress
from gearfem.compliance.elasticity import ELEMENT, QUADRATURE, stiffness, von_mises
from gearfem.compliance.load_lines import forces, load_lines, readings
from gearfem.compliance.section_mesh import root_mesh, sector_mesh
from gearfem.definition.setup import Material
from gearfem.flank import Outline

TEETH = 9
U = np.array([2.1, 2.5, 2.9, 3.3])


@pytest.fixture(scope="module")
def outline(gear_factory) -> Outline:
    return Outline(gear=gear_factory(TEETH, 2e-3, 11.0e-3, 0.5, bore_radius=5e-3))


@pytest.fixture(scope="module")
def sector(outline: Outline):
    mesh = sector_mesh(outline, 1.0)
    return mesh, stiffness(mesh.mesh, PlaneStrain(), Material())


def _whole_ring(sector) -> tuple[sparse.csc_matrix, list[sparse.csr_matrix]]:
    """Return the stiffness of all sectors joined, in x and y of the whole gear, and the map to each sector's own frame."""
    mesh, matrix = sector
    count = mesh.mesh.doflocs.shape[1]
    number = np.arange(TEETH * count).reshape(TEETH, count)
    for k in range(TEETH):
        number[(k + 1) % TEETH, mesh.lower] = number[k, mesh.upper]
    distinct, number = np.unique(number, return_inverse=True)
    number = number.reshape(TEETH, count)
    total, maps = 0, []
    for k in range(TEETH):
        angle = 2.0 * np.pi * k / TEETH
        pick = sparse.csr_matrix((np.ones(count), (np.arange(count), number[k])), shape=(count, len(distinct)))
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        maps.append(sparse.csr_matrix(sparse.kron(turn, pick)))
        total = total + maps[-1].T @ matrix @ maps[-1]
    return sparse.csc_matrix(total), maps


def test_harmonics_give_the_ring_that_is_assembled_whole(outline: Outline, sector) -> None:
    mesh, _ = sector
    total, maps = _whole_ring(sector)
    count = mesh.mesh.doflocs.shape[1]
    held = np.concatenate([mesh.held, mesh.held + count])
    fixed = np.unique(np.concatenate([m[held].nonzero()[1] for m in maps]))
    free = np.setdiff1d(np.arange(total.shape[0]), fixed)
    lines = load_lines(outline, U)
    load = forces(mesh, lines)
    moved = np.zeros((total.shape[0], len(U)))
    moved[free] = spsolve(total[free][:, free], (maps[0].T @ load)[free])

    offsets = (-4, -2, -1, 1, 2, 4)
    tooth = FiniteElements(resolution=1.0).tooth(outline, U, offsets)
    deflection = np.einsum("ij,ij->j", readings(mesh, lines), maps[0] @ moved)
    # Rounding of two different solutions of one system, whose condition number is about 1e6.
    assert tooth.deflection == pytest.approx(deflection, rel=1e-9, abs=0.0)
    for place, offset in enumerate(offsets):
        expected = load.T @ (maps[offset % TEETH] @ moved)
        np.testing.assert_allclose(tooth.coupling[place], expected, rtol=0.0, atol=1e-9 * deflection.max())


def test_displacements_of_sectors_agree_on_their_common_cut(outline: Outline, sector) -> None:
    field = FiniteElements(resolution=1.0).field(outline, 2.5, 1e5, neighbours=4)
    nearest = np.argsort(np.hypot(*(field.nodes - outline.point(2.5)).T))[0]
    assert field.displacement[nearest] @ field.load_direction > 0.0
    held = np.isclose(np.hypot(*field.nodes.T), outline.gear.bore_radius, rtol=1e-9)
    assert np.abs(field.displacement[held]).max() == 0.0
    # All nine sectors are there: only the cut between the last and the first is counted twice.
    angle = np.arctan2(field.nodes[:, 1], field.nodes[:, 0])
    ends = [np.flatnonzero(np.isclose(np.abs(angle), np.pi) & (np.sign(field.nodes[:, 1]) == side)) for side in (-1, 1)]
    pairs = [e[np.argsort(field.nodes[e, 0])] for e in ends]
    jump = field.displacement[pairs[0]] - field.displacement[pairs[1]]
    assert len(pairs[0]) == len(sector[0].upper)
    assert np.abs(jump).max() < 1e-9 * np.abs(field.displacement).max()


def test_coupling_is_reciprocal(outline: Outline) -> None:
    tooth = FiniteElements(resolution=1.0).tooth(outline, U, (-2, -1, 1, 2))
    scale = np.abs(tooth.coupling).max()
    # Maxwell and Betti: the neighbour ahead sees of this tooth what this tooth, being the one behind, sees of it.
    np.testing.assert_allclose(tooth.coupling[0], tooth.coupling[3].T, rtol=0.0, atol=1e-9 * scale)
    np.testing.assert_allclose(tooth.coupling[1], tooth.coupling[2].T, rtol=0.0, atol=1e-9 * scale)
    # Not symmetric in itself, or the test above could not tell +1 from -1.
    assert np.abs(tooth.coupling[1] - tooth.coupling[1].T).max() > 1e-2 * scale


@pytest.mark.parametrize("make", [lambda o: sector_mesh(o, 1.0), lambda o: root_mesh(o, 1.0, chord=False)])
@pytest.mark.parametrize("plane", [PlaneStrain(), PlaneStress()])
def test_patch_of_linear_displacements(outline: Outline, make, plane: PlaneStrain | PlaneStress) -> None:
    mesh = make(outline).mesh
    material = Material()
    x, y = mesh.doflocs
    matrix = stiffness(mesh, plane, material)
    rigid = np.stack([np.concatenate(v) for v in ([1 + 0 * x, 0 * y], [0 * x, 1 + 0 * y], [-y, x])], axis=1)
    scale = np.abs(matrix).sum(axis=1).max()
    assert np.abs(matrix @ rigid).max() < 1e-13 * scale

    strain = np.array([3e-4, -1e-4, 2e-4])
    moved = np.concatenate([strain[0] * x + strain[2] / 2 * y, strain[1] * y + strain[2] / 2 * x])
    force = matrix @ moved
    basis = skfem.CellBasis(mesh, ELEMENT, quadrature=QUADRATURE)
    boundary = np.unique(basis.get_dofs().flatten())
    inner = np.setdiff1d(np.arange(len(x)), boundary)
    # The quadrature of a curved element is not exact, but isoparametric elements carry constant strain exactly.
    assert np.abs(np.concatenate([force[inner], force[inner + len(x)]])).max() < 1e-12 * np.abs(force).max()
    nu, young = material.poissons_ratio, material.youngs_modulus
    if isinstance(plane, PlaneStrain):
        law = young / ((1 + nu) * (1 - 2 * nu)) * np.array([[1 - nu, nu, 0], [nu, 1 - nu, 0], [0, 0, (1 - 2 * nu) / 2]])
    else:
        law = young / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    stress = law @ strain
    assert moved @ force == pytest.approx(strain @ stress * basis.dx.sum(), rel=1e-12, abs=0.0)

    across = nu * (stress[0] + stress[1]) if isinstance(plane, PlaneStrain) else 0.0
    tensor = np.array([[stress[0], stress[2], 0], [stress[2], stress[1], 0], [0, 0, across]])
    deviator = tensor - np.trace(tensor) / 3 * np.eye(3)
    expected = np.sqrt(1.5 * (deviator**2).sum())
    assert von_mises(mesh, plane, material, moved.reshape(2, -1).T) == pytest.approx(expected, rel=1e-9, abs=0.0)


def test_nodal_forces_have_the_resultant_of_the_line_load(outline: Outline) -> None:
    u = np.linspace(2.0, 3.5, 40)
    lines = load_lines(outline, u)
    section = sector_mesh(outline, 3.0)
    load = forces(section, lines)
    x, y = section.mesh.doflocs
    count = len(x)
    np.testing.assert_allclose(np.stack([load[:count].sum(axis=0), load[count:].sum(axis=0)], axis=1), lines.direction, atol=1e-12)
    moment = x @ load[count:] - y @ load[:count]
    exact = lines.point[:, 0] * lines.direction[:, 1] - lines.point[:, 1] * lines.direction[:, 0]
    # The edge may pass beside the exact point, but only along the line of the load, which leaves the moment alone.
    np.testing.assert_allclose(moment, exact, rtol=0.0, atol=1e-12 * outline.gear.tip_radius)
