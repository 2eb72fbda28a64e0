"""A seam opened in a mesh: an edge crack in a bent strip, a ring with one cracked tooth, and gaps that close."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import spsolve

from gearfem.compliance import PlaneStrain, PlaneStress, crack_tooth, cracked, make_compliance, scale_body
from gearfem.compliance.crack import crack_table
from gearfem.compliance.crack_mesh import CrackedSection, between, crack_mesh, graded, open_cells, section_chord, tangent_point
from gearfem.compliance.elasticity import stiffness
from gearfem.compliance.harmonic_ring import CutRing
from gearfem.compliance.iso6336_root import root_section
from gearfem.compliance.load_lines import LoadLines, forces, load_lines
from gearfem.compliance.patchwork import join, straight, transfinite
from gearfem.compliance.seam import Seam, _stiffness, pressed
from gearfem.definition.setup import Material
from gearfem.flank import Outline, make_flanks
from gearfem.foundation import InputError
from gearfem.foundation.record import digest

WIDTH, ARM = 1e-2, 12e-2
WRONG = [(51, 1e-3, "tooth"), (-1, 1e-3, "tooth"), (3, -1e-6, "depth_mm"), (3, 15e-3, "depth_mm")]
TEETH = 9


def strip(share: float, fine: float) -> CrackedSection:
    """Return a cantilever along x whose upper edge is cracked 3 widths from the clamp, its load to stand at `ARM` from the crack."""
    half, tip = 0.5 * WIDTH, (0.5 - share) * WIDTH
    near = tip + graded((share * WIDTH,), fine, 1e-3, 1.0)
    if tip > 0.0:
        near = np.concatenate([tip - graded((tip,), fine, 1e-3, 1.0)[:0:-1], near])
    near[0], near[-1] = 0.0, half
    far = between(np.linspace(0.0, half, (len(near) + 1) // 2))
    below, above = (graded((length,), fine, 2.5e-3, 1.0) for length in (3.0 * WIDTH, 1.2 * ARM))

    def patches(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rows = [np.stack([np.full_like(y, x), y], axis=1) for x in (-3.0 * WIDTH, 0.0, 1.2 * ARM)]
        parts = 1.0 - below[::-1] / below[-1], above / above[-1]
        return tuple(
            transfinite(rows[i], straight(rows[i][-1], rows[i + 1][-1], part), rows[i + 1], straight(rows[i][0], rows[i + 1][0], part))
            for i, part in enumerate(parts)
        )

    work = join(patches(near), patches(far))
    (foot, top), (under, over) = work.above, work.below
    seam = top[::-1, 0][work.mesh.doflocs[1, top[::-1, 0]] > tip + 1e-9]
    none = np.empty(0, dtype=np.int64)
    return CrackedSection(
        mesh=work.mesh,
        open_cells=open_cells(work.mesh, seam, np.concatenate([top.ravel(), over.ravel()])),
        outline=top[-1],
        outline_u=2.0 + above / above[-1],
        seam=seam,
        held=np.unique(np.concatenate([foot[:, 0], under[:, 0]])),
        upper=none,
        lower=none,
    )


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_edge_crack_in_bending_releases_the_energy_of_its_stress_intensity(share: float) -> None:
    material, point = Material(), np.array([[ARM, WIDTH / 2]])
    lines = LoadLines(u=np.array([2.0 + 1.0 / 1.2]), point=point, direction=np.array([[0.0, -1.0]]), depth=np.ones(1))
    section = strip(share, 1e-3 * WIDTH)
    none = CutRing(np.empty((0, 0)), TEETH)
    added = Seam(section, PlaneStress(), material, TEETH, lines).increments(none, (1,))[0][0]
    # Energy release rate K^2/E, K = sigma sqrt(pi a) F(a/b), sigma = 6 M/b^2, of an edge crack in pure bending: F of Brown & Srawley,
    # ASTM STP 410 (1966), stated to 0.2 %. Half of what the crack adds, times the square of the load, is its integral over the depth.
    factor = np.polynomial.Polynomial([1.122, -1.40, 7.33, -13.08, 14.0])
    released = (np.polynomial.Polynomial([0.0, 1.0]) * factor**2).integ()(share)
    expected = 2.0 * np.pi * (6.0 * ARM / WIDTH**2) ** 2 * WIDTH**2 * released / material.youngs_modulus
    # Twice 0.2 % of F, and the shear force that comes with the moment adds of the order (b/ARM)^2 = 0.7 %.
    assert added == pytest.approx(expected, rel=0.01, abs=0.0)


@pytest.fixture(scope="module")
def outline(gear_factory) -> Outline:
    return Outline(gear=gear_factory(TEETH, 2e-3, 11.0e-3, 0.5, bore_radius=5e-3))


def test_section_is_that_of_the_standard(outline: Outline, coal_combine) -> None:
    for one in (outline, Outline(gear=coal_combine.pair.pinion), Outline(gear=coal_combine.pair.wheel)):
        section = root_section(one)
        assert section_chord(one) == pytest.approx(section.chord, rel=1e-9, abs=0.0)
        assert one.point(tangent_point(one))[0] == pytest.approx(section.height, rel=1e-9, abs=0.0)


def test_cracked_ring_is_that_which_is_assembled_whole(outline: Outline) -> None:
    section = crack_mesh(outline, 0.3 * section_chord(outline), 2e-5, 1.0)
    lines = load_lines(outline, [2.8, 2.95])
    seam = Seam(section, PlaneStrain(), Material(), TEETH, lines)
    own, others = seam.increments(CutRing(seam.schur, TEETH), (-1, 2))

    count, copies = section.mesh.doflocs.shape[1], len(section.seam)
    sound = stiffness(section.mesh, PlaneStrain(), Material())
    number = np.arange(TEETH * count).reshape(TEETH, count)
    for k in range(TEETH):
        number[(k + 1) % TEETH, section.lower] = number[k, section.upper]
    distinct, number = np.unique(number, return_inverse=True)
    number, size = number.reshape(TEETH, count), len(distinct) + copies
    maps = []
    for k in range(TEETH):
        angle = 2.0 * np.pi * k / TEETH
        column = np.concatenate([number[k], len(distinct) + np.arange(copies)]) if k == 0 else number[k]
        pick = sparse.csr_matrix((np.ones(len(column)), (np.arange(len(column)), column)), shape=(len(column), size))
        maps.append(sparse.csr_matrix(sparse.kron(np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]), pick)))
    ring = sum(m.T @ sound @ m for m in maps[1:])
    lame = PlaneStrain().lame(Material())
    opened = ring + maps[0].T @ _stiffness(section, lame, count + copies) @ maps[0]
    load = forces(section, lines).reshape(2, count, -1)
    full = np.concatenate([load, np.zeros((2, copies, load.shape[2]))], axis=1).reshape(2 * (count + copies), -1)
    closed_map = sparse.csr_matrix(maps[0].reshape(maps[0].shape)[np.r_[0:count, count + copies : 2 * count + copies]])
    closed = ring + closed_map.T @ sound @ closed_map
    held = np.concatenate([m[np.concatenate([section.held, section.held + m.shape[0] // 2])].nonzero()[1] for m in maps])
    free = np.setdiff1d(np.arange(2 * size), held)
    state = np.zeros((2, 2 * size, load.shape[2]))
    state[0, free] = spsolve(sparse.csc_matrix(opened)[free][:, free], (maps[0].T @ full)[free])
    kept = np.setdiff1d(free, np.r_[len(distinct) : size, size + len(distinct) : 2 * size])
    state[1, kept] = spsolve(sparse.csc_matrix(closed)[kept][:, kept], (closed_map.T @ load.reshape(2 * count, -1))[kept])
    # These loads open the seam everywhere, so that no gap closes.
    moved = (maps[0] @ state[0]).reshape(2, count + copies, -1)
    assert (moved[0, section.seam] - moved[0, count:]).min() > 0.0
    flat = load.reshape(2 * count, -1)
    expected = (flat * (closed_map @ (state[0] - state[1]))).sum(axis=0)
    assert own == pytest.approx(expected, rel=1e-7, abs=0.0)
    for place, offset in enumerate((-1, 2)):
        there = flat.T @ (maps[offset % TEETH] @ (state[0] - state[1]))
        np.testing.assert_allclose(others[place], there, rtol=0.0, atol=1e-7 * expected.max())


def test_gaps_close_and_do_not_pull() -> None:
    rng = np.random.default_rng(5)
    root = rng.normal(size=(6, 9))
    compliance, gap = root @ root.T, rng.normal(size=(6, 4))
    force = pressed(compliance, gap)
    left = compliance @ force + gap
    assert force.min() >= 0.0
    assert left.min() > -1e-12
    assert np.abs(force * left).max() < 1e-10
    assert (force > 0.0).any()
    assert (left > 1e-6).any()


@pytest.fixture(scope="module")
def compliance(coal_combine):
    return make_compliance(make_flanks(coal_combine), positions=14)


def test_depth_0_is_the_sound_tooth_and_shallow_cracks_grow_with_the_square(compliance) -> None:
    tooth = compliance.pinion
    assert digest(cracked(tooth, 0.0)) == digest(tooth)
    table = crack_table(tooth.outline, tooth.u, tooth.offsets)
    one, two = (table.at(depth * table.chord)[0] for depth in (1e-4, 2e-4))
    assert two == pytest.approx(4.0 * one, rel=5e-3, abs=0.0)
    rising = np.array([table.at(part * table.deepest)[0] for part in np.linspace(0.0, 1.0, 61)])
    upper = (tooth.u > 2.3) & (tooth.u <= 3.0)
    assert np.all(np.diff(rising[:, upper], axis=0) > 0.0)


def test_interpolation_over_depth_and_mesh_keep_their_stated_errors(compliance) -> None:
    tooth = compliance.pinion
    table = crack_table(tooth.outline, tooth.u, tooth.offsets)
    ring = None
    for share, resolution in ((0.07, 1.0), (0.51, 1.0), (0.71, 1.0), (0.3, 1.5)):
        section = crack_mesh(tooth.outline, share * table.chord, 5e-4 * table.chord, resolution)
        seam = Seam(section, PlaneStrain(), tooth.outline.gear.material, tooth.outline.gear.teeth, load_lines(tooth.outline, tooth.u))
        if ring is None or resolution != 1.0:
            ring = CutRing(seam.schur, tooth.outline.gear.teeth)
        direct, read = seam.increments(ring, (1,))[0], table.at(share * table.chord)[0]
        upper = tooth.u > 2.33
        assert np.abs(read / direct - 1.0)[upper].max() < 0.01
        assert (np.abs(read - direct) / tooth.deflection).max() < 0.015


def test_one_tooth_of_the_pair_is_cracked_whatever_its_body(compliance) -> None:
    weak = crack_tooth(compliance, "pinion", 7, 3e-3)
    assert set(weak.odd("pinion")) == {7}
    assert not weak.wheel_odd
    assert np.all(weak.odd("pinion")[7].deflection > compliance.pinion.deflection)
    first, second = scale_body(weak, 1.3), crack_tooth(scale_body(compliance, 1.3), "pinion", 7, 3e-3)
    assert first.odd("pinion")[7].deflection == pytest.approx(second.odd("pinion")[7].deflection, rel=1e-12, abs=0.0)
    assert first.odd("pinion")[7].coupling == pytest.approx(second.odd("pinion")[7].coupling, rel=1e-9, abs=0.0)


@pytest.mark.parametrize(("tooth", "depth", "where"), WRONG)
def test_refuses_teeth_and_depths_that_are_not(compliance, tooth: int, depth: float, where: str) -> None:
    with pytest.raises(InputError, match=where):
        crack_tooth(compliance, "wheel", tooth, depth)
