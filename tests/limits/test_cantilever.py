"""A tooth of constant section is Timoshenko's cantilever: the same elements, assembly and solver on a strip."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.compliance.alone import Alone
from gearfem.compliance.elasticity import PlaneStress, stiffness
from gearfem.compliance.patchwork import join
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.definition.setup import Material

MATERIAL = Material(youngs_modulus=200e9, poissons_ratio=0.3)
HEIGHT = 4e-3


def strip(length: float, along: int, across: int = 4) -> SectionMesh:
    """Return a strip from x = 0, where it is held, to x = length, symmetric about y = 0."""
    x, y = np.linspace(0.0, length, 2 * along + 1), np.linspace(0.0, HEIGHT / 2.0, 2 * across + 1)
    # First direction away from the axis, second towards the free end, as `join` wants it.
    patch = np.stack(np.broadcast_arrays(x[None, :], y[:, None]), axis=-1)
    work = join((np.ascontiguousarray(patch),))
    upper, lower = work.above[0], work.below[0]
    none = np.empty(0, dtype=np.int64)
    return SectionMesh(
        mesh=work.mesh,
        outline=upper[-1],
        outline_u=np.linspace(2.0, 3.0, upper.shape[1]),
        idle=lower[-1],
        centreline=upper[0],
        held=np.unique(np.concatenate([upper[:, 0], lower[:, 0]])),
        upper=none,
        lower=none,
    )


def deflection(length: float, direction: int = 1, material: Material = MATERIAL) -> float:
    """Return the displacement of the free end, in the mean over the force that is spread as the beam's own stress is, per force."""
    section = strip(length, max(8, round(length / HEIGHT * 8)))
    mesh = section.mesh
    nodes = mesh.doflocs.shape[1]
    end = np.flatnonzero(mesh.doflocs[0] == length)
    end = end[np.argsort(mesh.doflocs[1, end])]
    y = mesh.doflocs[1, end]
    # Parabolic shear, or even tension, as consistent nodal forces of quadratic edges by Gauss's rule of three points.
    points, weights = np.polynomial.legendre.leggauss(3)
    load = np.zeros((2 * nodes, 1))
    for k in range(0, len(end) - 2, 2):
        half = 0.5 * (y[k + 2] - y[k])
        at = y[k + 1] + half * points
        stress = 1.5 / HEIGHT * (1.0 - (2.0 * at / HEIGHT) ** 2) if direction else np.full(3, 1.0 / HEIGHT)
        shape = np.stack([0.5 * points * (points - 1.0), 1.0 - points**2, 0.5 * points * (points + 1.0)])
        load[end[k : k + 3] + direction * nodes, 0] += shape @ (weights * half * stress)
    assert load.sum() == pytest.approx(1.0, rel=1e-12, abs=0.0)
    structure = Alone(section, stiffness(mesh, PlaneStress(), material))
    return float(structure.deflection(load, load)[0])


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_bending_and_shear_are_timoshenkos(nu: float) -> None:
    material = Material(youngs_modulus=200e9, poissons_ratio=nu)
    slenderness = np.array([5.0, 10.0, 15.0, 20.0])
    rest = np.array([deflection(s * HEIGHT, material=material) for s in slenderness]) * material.youngs_modulus - 4.0 * slenderness**3
    # Beyond the clamp the beam is exact; the clamp itself turns with the moment (s^2) and shifts with the force (1).
    turn, shear, shift = np.linalg.lstsq(np.stack([slenderness**2, slenderness, 0 * slenderness + 1.0], axis=1), rest, rcond=None)[0]
    coefficient = shear * material.shear_modulus / material.youngs_modulus
    print(f"nu {nu:g}: shear coefficient {coefficient:.4f}, clamp: {turn:.4f} s^2, {shift:.3f}")
    # Timoshenko: 6/5 of the mean shear strain. Where the section would change its width, the clamp that stops it also turns
    # with the force and shifts with the moment, alike by reciprocity, which adds to the linear term: a few hundredths.
    assert coefficient == pytest.approx(1.2, rel=1e-3 if nu == 0.0 else 0.03, abs=0.0)
    assert turn == pytest.approx(0.0, abs=1e-3 if nu == 0.0 else 0.1)
    assert nu == 0.0 or turn < -0.01


def test_tension_is_hookes_law() -> None:
    # The clamp stops the lateral contraction over about one height: it stiffens by a tenth of a height or less.
    length = 20.0 * HEIGHT
    assert deflection(length, direction=0) == pytest.approx(20.0 / MATERIAL.youngs_modulus, rel=0.1 / 20.0, abs=0.0)


def test_a_rigid_body_motion_of_the_clamp_costs_no_force() -> None:
    section = strip(5.0 * HEIGHT, 10)
    x, y = section.mesh.doflocs
    matrix = stiffness(section.mesh, PlaneStress(), MATERIAL)
    motions = np.stack([np.concatenate(v) for v in ([1 + 0 * x, 0 * y], [0 * x, 1 + 0 * y], [-y, x])], axis=1)
    # Rounding of sums of entries of the size of Young's modulus.
    assert np.abs(matrix @ motions).max() < 1e-12 * np.abs(matrix).sum(axis=1).max()
    # Stretching costs force, or the bound above could not fail.
    assert np.abs(matrix @ np.concatenate([x / 5e-3, 0 * y])).max() > 1e-4 * np.abs(matrix).sum(axis=1).max()
