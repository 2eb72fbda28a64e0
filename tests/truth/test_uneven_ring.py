"""Rings of sectors without symmetry, and with one odd sector, against the same rings assembled whole."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import spsolve

from gearfem.compliance import PlaneStrain
from gearfem.compliance.elasticity import stiffness
from gearfem.compliance.load_lines import forces, load_lines, readings
from gearfem.compliance.ring import Ring
from gearfem.compliance.section_mesh import sector_mesh
from gearfem.compliance.uneven_ring import OddSector, Sector, UnevenRing
from gearfem.definition.setup import Material
from gearfem.flank import Outline

TEETH = 9
U = np.array([2.1, 2.5, 2.9, 3.3])


@pytest.fixture(scope="module")
def outline(gear_factory) -> Outline:
    return Outline(gear=gear_factory(TEETH, 2e-3, 11.0e-3, 0.5, bore_radius=5e-3))


@pytest.fixture(scope="module")
def sector(outline: Outline):
    """A mesh, its stiffness, and the same with springs on one side of the tooth, so that it has no symmetry."""
    mesh = sector_mesh(outline, 1.0)
    even = stiffness(mesh.mesh, PlaneStrain(), Material())
    x, y = mesh.mesh.doflocs
    springs = np.where((y > 0.0) & (x > outline.gear.root_radius), 0.02 * even.diagonal().mean(), 0.0)
    return mesh, even, sparse.csc_matrix(even + sparse.diags_array(np.tile(springs, 2)))


def assembled(mesh, matrices) -> tuple[sparse.csc_matrix, list[sparse.csr_matrix], np.ndarray]:
    """Return the stiffness of all sectors joined, the maps to their own frames and the unknowns that are free."""
    count = mesh.mesh.doflocs.shape[1]
    number = np.arange(TEETH * count).reshape(TEETH, count)
    for k in range(TEETH):
        number[(k + 1) % TEETH, mesh.lower] = number[k, mesh.upper]
    distinct, number = np.unique(number, return_inverse=True)
    number = number.reshape(TEETH, count)
    total, maps = 0, []
    for k, matrix in enumerate(matrices):
        angle = 2.0 * np.pi * k / TEETH
        pick = sparse.csr_matrix((np.ones(count), (np.arange(count), number[k])), shape=(count, len(distinct)))
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        maps.append(sparse.csr_matrix(sparse.kron(turn, pick)))
        total = total + maps[-1].T @ matrix @ maps[-1]
    held = np.concatenate([mesh.held, mesh.held + count])
    fixed = np.unique(np.concatenate([m[held].nonzero()[1] for m in maps]))
    return sparse.csc_matrix(total), maps, np.setdiff1d(np.arange(total.shape[0]), fixed)


@pytest.mark.parametrize("kind", ["equal", "odd"])
def test_ring_is_that_which_is_assembled_whole(outline: Outline, sector, kind: str) -> None:
    mesh, even, uneven = sector
    others = uneven if kind == "equal" else even
    total, maps, free = assembled(mesh, [uneven, *[others] * (TEETH - 1)])
    lines = load_lines(outline, U)
    load, reading = forces(mesh, lines), readings(mesh, lines)
    moved = np.zeros((total.shape[0], len(U)))
    moved[free] = spsolve(total[free][:, free], (maps[0].T @ load)[free])

    one = Sector(mesh, uneven, TEETH)
    offsets = (-4, -1, 1, 2)
    if kind == "equal":
        ring = UnevenRing(one, TEETH)
        coupling = ring.coupling(load, offsets)
        for place, offset in enumerate(offsets):
            there = maps[offset % TEETH] @ moved
            np.testing.assert_allclose(ring.displacements(load, offsets)[place], there, rtol=0.0, atol=1e-9 * np.abs(moved).max())
    else:
        ring = OddSector(Ring(mesh, even, TEETH), one)
        coupling = ring.coupling(load, load, offsets)
    exact = np.einsum("ij,ij->j", reading, maps[0] @ moved)
    # Rounding of two different solutions of one system, whose condition number is about 1e6.
    assert ring.deflection(load, reading) == pytest.approx(exact, rel=1e-9, abs=0.0)
    np.testing.assert_allclose(ring.displacements(load, (0,))[0], maps[0] @ moved, rtol=0.0, atol=1e-9 * np.abs(moved).max())
    for place, offset in enumerate(offsets):
        np.testing.assert_allclose(coupling[place], load.T @ (maps[offset % TEETH] @ moved), rtol=0.0, atol=1e-9 * exact.max())


def test_symmetric_sector_by_both_ways(outline: Outline, sector) -> None:
    mesh, even, _ = sector
    lines = load_lines(outline, U)
    load, reading = forces(mesh, lines), readings(mesh, lines)
    split, whole = Ring(mesh, even, TEETH), UnevenRing(Sector(mesh, even, TEETH), TEETH)
    deflection = split.deflection(load, reading)
    assert whole.deflection(load, reading) == pytest.approx(deflection, rel=1e-11, abs=0.0)
    assert OddSector(split, whole.sector).deflection(load, reading) == pytest.approx(deflection, rel=1e-11, abs=0.0)
    np.testing.assert_allclose(whole.schur, split.schur, rtol=0.0, atol=1e-12 * np.abs(split.schur).max())
    np.testing.assert_allclose(whole.coupling(load, (-1, 2)), split.coupling(load, (-1, 2)), rtol=0.0, atol=1e-11 * deflection.max())


def test_nodes_without_ports_take_no_load(sector) -> None:
    mesh, even, _ = sector
    load = np.zeros((even.shape[0], 1))
    load[mesh.centreline[4]] = 1.0
    with pytest.raises(ValueError, match="ports"):
        Sector(mesh, even, TEETH, mesh.outline).condense(load)
