"""The prism solved by modes of the width, held to scikit-fem's own elasticity on the same hexahedra and to the rigid body."""

from __future__ import annotations

import numpy as np
import pytest
import skfem
from scipy.sparse.linalg import spsolve
from skfem.models.elasticity import lame_parameters, linear_elasticity

from gearfem.compliance import Bore, Root
from gearfem.compliance.elasticity import ELEMENT, QUADRATURE
from gearfem.compliance.face_width import FaceWidth, graded_places
from gearfem.compliance.load_lines import forces, load_lines
from gearfem.compliance.prism import section_matrices, solve_prism
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.compliance.solid_mesh import solid_mesh
from gearfem.definition.setup import Material
from gearfem.flank import Outline

STEEL = Material()


@pytest.fixture(scope="module")
def outline(gear_factory) -> Outline:
    return Outline(gear=gear_factory(8, 2e-3, 10e-3, profile_shift=0.5, bore_radius=4e-3))


def by_prism(section: SectionMesh, width: FaceWidth, teeth: int, load: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return displacements, shape (3, n, m)."""
    matrices = section_matrices(section.mesh, ELEMENT, QUADRATURE)
    moved = solve_prism(section, matrices, width, STEEL, teeth, load, along, lambda _, plane, across: np.concatenate([plane, across]))
    return moved[..., 0].reshape(3, -1, len(width.places))


def solid_matrix(nodes: np.ndarray, hexes: np.ndarray) -> tuple[object, np.ndarray]:
    """Return scikit-fem's stiffness of 27-node hexahedra and the number of its unknown for each node, shape (n, 3)."""
    # scikit-fem's corner order and VTK's differ; the places of the reference nodes tell which node is which.
    reference = skfem.ElementHex2().doflocs
    vtk = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float)
    order = [int(np.argmin(np.abs(vtk - corner).sum(axis=1))) for corner in reference[:8]]
    vertices, corners = np.unique(hexes[:, order], return_inverse=True)
    flat = skfem.MeshHex(np.ascontiguousarray(nodes[vertices].T), np.ascontiguousarray(corners.reshape(-1, 8).T))
    dofs = skfem.Dofs(flat, skfem.ElementHex2())
    table = {tuple(np.round(place, 3)): number for number, place in enumerate(_vtk_places())}
    own = [table[tuple(np.round(place, 3))] for place in reference]
    places = np.empty((3, dofs.N))
    number = np.empty(dofs.N, dtype=int)
    for local, node in enumerate(own):
        places[:, dofs.element_dofs[local]] = nodes[hexes[:, node]].T
        number[dofs.element_dofs[local]] = hexes[:, node]
    mesh = skfem.MeshHex2(places, flat.t)
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex2()), intorder=5)
    matrix = linear_elasticity(*lame_parameters(STEEL.youngs_modulus, STEEL.poissons_ratio)).assemble(basis)
    scalar = skfem.Basis(mesh, skfem.ElementHex2(), intorder=5)
    unknown = np.empty((dofs.N, 3), dtype=int)
    unknown[number[scalar.element_dofs]] = basis.element_dofs.reshape(27, 3, -1).transpose(0, 2, 1)
    return matrix.tocsc(), unknown


def _vtk_places() -> np.ndarray:
    """Return the 27 reference places of VTK's triquadratic hexahedron: corners, edges, faces (x, y, z), centre."""
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    middles = [(0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5)]
    rows = [(*c, z) for z in (0, 1) for c in corners] + [(*m, z) for z in (0, 1) for m in middles] + [(*c, 0.5) for c in corners]
    rows += [(0, 0.5, 0.5), (1, 0.5, 0.5), (0.5, 0, 0.5), (0.5, 1, 0.5), (0.5, 0.5, 0), (0.5, 0.5, 1), (0.5, 0.5, 0.5)]
    return np.array(rows, dtype=float)


@pytest.mark.slow
def test_tooth_agrees_with_hexahedra_assembled_by_scikit_fem(outline: Outline) -> None:
    section = Root().section(outline, 0.5)
    width = FaceWidth(graded_places(6e-3, 2, 2e-3, (1e-3,)), 2)
    # A partial load has an even and an odd part.
    along = width.load(1e-3, 3e-3)[:, None]
    load = forces(section, load_lines(outline, 2.8))
    mesh = solid_mesh(section, width.places, "root")
    matrix, unknown = solid_matrix(mesh.nodes, mesh.hexes)
    count = section.mesh.doflocs.shape[1]
    vector = np.zeros(matrix.shape[0])
    for axis in (0, 1):
        vector[unknown[:, axis].reshape(-1, count)] = along * load[axis * count : (axis + 1) * count, 0]
    free = np.setdiff1d(np.arange(len(vector)), unknown[mesh.held].ravel())
    direct = np.zeros_like(vector)
    direct[free] = spsolve(matrix[free][:, free], vector[free])
    expected = direct[unknown].reshape(-1, count, 3).transpose(2, 1, 0)
    moved = by_prism(section, width, outline.gear.teeth, load, along)
    # Conjugate gradients stop at 1e-10 of the energy norm; a hundredfold for the largest of many displacements.
    assert np.abs(moved - expected).max() < 1e-8 * np.abs(expected).max()


def test_ring_balances_the_load_at_every_free_node(outline: Outline) -> None:
    section = Bore().section(outline, 0.5)
    width = FaceWidth(graded_places(6e-3, 2, 2e-3), 2)
    along = width.load(*width.places[[0, -1]])[:, None]
    load = forces(section, load_lines(outline, 2.8))
    moved = by_prism(section, width, outline.gear.teeth, load, along)
    mesh = solid_mesh(section, width.places, "bore")
    matrix, unknown = solid_matrix(mesh.nodes, mesh.hexes)
    count = section.mesh.doflocs.shape[1]
    vector = np.zeros(matrix.shape[0])
    vector[unknown] = moved.transpose(2, 1, 0).reshape(-1, 3)
    force = (matrix @ vector)[unknown].reshape(-1, count, 3)
    inner = np.setdiff1d(np.arange(count), np.concatenate([section.held, section.upper, section.lower]))
    expected = np.stack([along * load[:count, 0], along * load[count:, 0], 0.0 * along * load[:count, 0]], axis=-1)
    assert np.abs(force - expected)[:, inner].max() < 1e-7 * np.abs(expected).max()
    # The loaded sector's part of the bore holds only a part of the moment; the neighbours' hold the rest.
    arms = section.mesh.doflocs
    moment = (arms[0] * force[..., 1] - arms[1] * force[..., 0])[:, section.held].sum()
    applied = (arms[0] * expected[..., 1] - arms[1] * expected[..., 0]).sum()
    assert 0.2 < -moment / applied < 1.0


def test_loads_and_readings_are_reciprocal(outline: Outline) -> None:
    section = Root().section(outline, 0.5)
    width = FaceWidth(graded_places(6e-3, 4, 2e-3, (1e-3,)), 2)
    lines = load_lines(outline, [2.5, 2.9])
    load = forces(section, lines)
    on = np.stack([width.load(1e-3, 3e-3), width.load(-3e-3, 2e-3)], axis=1)
    matrices = section_matrices(section.mesh, ELEMENT, QUADRATURE)

    def work(columns: slice, plane: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.einsum("ia,ma,imk->ak", load, on, plane)

    table = solve_prism(section, matrices, width, STEEL, 8, load, on, work)
    assert table[0, 1] / table[1, 0] == pytest.approx(1.0, rel=1e-8, abs=0.0)
    assert abs(table[0, 0] / table[1, 1] - 1.0) > 0.1
