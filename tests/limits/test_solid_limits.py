"""The three-dimensional tooth between plane stress and plane strain, and the prism as a beam."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.compliance import Bore, FiniteElements, PlaneStrain, PlaneStress, Root, reductions
from gearfem.compliance.elasticity import ELEMENT, QUADRATURE
from gearfem.compliance.face_width import FaceWidth
from gearfem.compliance.patchwork import join, straight, transfinite
from gearfem.compliance.prism import section_matrices, solve_prism
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.compliance.solid import SolidElements
from gearfem.definition.setup import Material
from gearfem.flank import Outline


def beam(length: float, height: float, along: int, across: int) -> SectionMesh:
    """Return a cantilever along x, held at x = 0."""
    part, up = (np.arange(2 * n + 1) / (2 * n) for n in (along, across))
    foot = straight(np.zeros(2), np.array([0.0, height / 2]), up)
    top = straight(np.array([length, 0.0]), np.array([length, height / 2]), up)
    work = join((transfinite(foot, straight(foot[-1], top[-1], part), top, straight(foot[0], top[0], part)),))
    grid, mirror = work.above[0], work.below[0]
    none = np.empty(0, dtype=np.int64)
    return SectionMesh(
        mesh=work.mesh,
        outline=grid[-1],
        outline_u=part,
        idle=mirror[-1],
        centreline=grid[0],
        held=np.unique(np.concatenate([grid[:, 0], mirror[:, 0]])),
        upper=none,
        lower=none,
    )


def deflection(section: SectionMesh, width: float, material: Material, layers: int) -> np.ndarray:
    """Return the mean deflections at quarter, half and three quarters of a cantilever under 1 N at its end [m]."""
    nodes = section.mesh.doflocs.shape[1]
    line = FaceWidth(width * (np.arange(2 * layers + 1) / (2 * layers) - 0.5), 2)
    tip = np.zeros((2 * nodes, 1))
    tip[nodes + section.centreline[-1]] = 1.0
    quarter = (len(section.centreline) - 1) // 4
    shown = nodes + section.centreline[[quarter, 2 * quarter, 3 * quarter]]

    def keep(_: slice, plane: np.ndarray, across: np.ndarray) -> np.ndarray:
        return np.einsum("m,amk->ak", line.average, plane[shown])

    matrices = section_matrices(section.mesh, ELEMENT, QUADRATURE)
    return solve_prism(section, matrices, line, material, 1, tip, line.average[:, None], keep)[:, 0]


LENGTH, HEIGHT, WIDTH = 20e-3, 1e-3, 1e-3


def test_cantilever_is_timoshenkos() -> None:
    material = Material(youngs_modulus=206e9, poissons_ratio=0.0)
    stiffness, x = material.youngs_modulus * WIDTH * HEIGHT**3 / 12.0, LENGTH / 2.0
    # Cowper (1966): shear coefficient 5/6 of a rectangle without lateral contraction.
    exact = x**2 * (3.0 * LENGTH - x) / (6.0 * stiffness) + x / (5.0 / 6.0 * WIDTH * HEIGHT * material.shear_modulus)
    ratio = deflection(beam(LENGTH, HEIGHT, 20, 2), WIDTH, material, 2)[1] / exact
    print(f"cantilever over Timoshenko's: {ratio:.5f}")
    # Shear is 0.24 % of the deflection; the clamp keeps the section plane, which takes a few per cent of that.
    assert ratio == pytest.approx(1.0, abs=3e-4)


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.45, 0.49])
def test_bending_does_not_lock(poisson: float) -> None:
    material = Material(youngs_modulus=206e9, poissons_ratio=poisson)
    stiffness, step = material.youngs_modulus * WIDTH * HEIGHT**3 / 12.0, LENGTH / 4.0
    # One element through half the height and one through the width, five times as long as high; the second
    # difference leaves out what the clamp does, F step^2 (L - L/2)/(E I) is exact (Saint-Venant).
    for elements, tolerance in ((8, 5e-4), (20, 1e-6)):
        low, middle, high = deflection(beam(LENGTH, HEIGHT, elements, 1), WIDTH, material, 1)
        ratio = (high - 2.0 * middle + low) / (step**2 * LENGTH / 2.0 / stiffness)
        print(f"nu = {poisson}, {elements} elements: bending {ratio - 1.0:+.1e}")
        # What the clamp and the load disturb fades within a height or two, sooner than the elements of the coarse mesh.
        assert ratio == pytest.approx(1.0, abs=tolerance)


def _plane_states(outline: Outline, support: Bore | Root, u: float, resolution: float) -> tuple[float, float]:
    """Return the deflection in plane strain and in plane stress."""
    methods = (FiniteElements(plane=plane, support=support, resolution=resolution) for plane in (PlaneStrain(), PlaneStress()))
    strain, stress = (method.curve(outline, u).deflection[0] for method in methods)
    return strain, stress


@pytest.mark.slow
@pytest.mark.parametrize("support", [Bore(), Root()])
def test_face_width_leads_from_plane_stress_to_plane_strain(gear_factory, support: Bore | Root) -> None:
    outline = Outline(gear=gear_factory(8, 2e-3, 10e-3, profile_shift=0.5, bore_radius=4e-3))
    u, solid = 2.8, SolidElements(support=support, resolution=1.0, layers=8)
    strain, stress = _plane_states(outline, support, u, 1.0)
    ratios = (0.005, 0.05, 2.0, 10.0, 60.0)
    profiles = [solid.profile(outline, u, ratio * outline.gear.module) for ratio in ratios]
    place = [(p.mid - strain) / (stress - strain) for p in profiles]
    for ratio, profile, share in zip(ratios, profiles, place, strict=True):
        print(
            f"{support.name}, b/m = {ratio:5.2f}: mid-face {profile.mid / strain:.5f}, average {profile.average / strain:.5f}, "
            f"ends {profile.ends[0] / strain:.5f} of plane strain; mid-face {share:+.3f} of the way to plane stress"
        )
    # Thin: what is held is held across the width too, in truth over a length like the width, on the mesh over one element.
    fine = SolidElements(support=support, resolution=2.0, layers=2).profile(outline, u, ratios[0] * outline.gear.module).mid
    low, high = _plane_states(outline, support, u, 2.0)
    gaps = 1.0 - place[0], (high - fine) / (high - low)
    assert 0.0 < gaps[1] < 0.75 * gaps[0] < 0.02
    assert place[0] >= place[1] > place[2] > place[3]
    # Wide: the ends fade over a few tooth heights (Saint-Venant).
    assert place[-1] == pytest.approx(0.0, abs=0.005)
    assert profiles[-1].ends[0] / profiles[-1].ends[1] == pytest.approx(1.0, rel=1e-8, abs=0.0)


def test_without_lateral_contraction_every_width_is_plane(gear_factory) -> None:
    outline = Outline(gear=gear_factory(17, 1e-3, 9.5e-3, bore_radius=5e-3, material=Material(poissons_ratio=0.0)))
    solid = SolidElements(support=Root(), resolution=1.0, layers=4)
    plane = FiniteElements(support=Root(), resolution=1.0).curve(outline, 2.8).deflection[0]
    # Equal up to where the conjugate gradients stop.
    assert solid.profile(outline, 2.8, 7e-3).deflection / plane == pytest.approx(1.0, rel=1e-8, abs=0.0)


def test_some_harmonics_of_a_ring_stand_for_all(gear_factory, monkeypatch) -> None:
    """What is uneven over the face width, as the influence of slices needs it; what all slices share is not asked for."""
    outline, width, every = Outline(gear=gear_factory(20, 2e-3, 22e-3, bore_radius=8e-3)), 12e-3, reductions.chosen
    method = SolidElements(resolution=0.5, layers=2)
    found = []
    for choose in (every, lambda teeth, _: every(teeth)):
        monkeypatch.setattr(reductions, "chosen", choose)
        matrix = method.influence(outline, [2.6], width, 4)[0].matrix
        found.append(matrix - matrix.mean())
    off = np.abs(found[0] - found[1]).max() / np.abs(found[1]).max()
    print(f"{len(every(20, True)[0])} harmonics against {len(every(20)[0])}: {off:.1e} of what is uneven")
    assert 0.0 < off < 3e-4
