"""Displacement and stress of a loaded tooth in three dimensions, for pictures and other programs."""

from __future__ import annotations

import dataclasses

import numpy as np
import skfem

from gearfem.compliance.elasticity import ELEMENT
from gearfem.compliance.face_width import FaceWidth, shape_functions
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.compliance.solid_mesh import SolidMesh
from gearfem.definition.setup import Material
from gearfem.foundation import Array, Record

# The six independent components of a symmetric tensor.
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SolidField(Record):
    """Displacement and stress of a tooth under a line load; of the whole gear, the loaded sector.

    Parameters
    ----------
    mesh : SolidMesh
        Mesh with n nodes.
    displacement : ndarray, shape (n, 3)
        Of the nodes [m].
    von_mises : ndarray, shape (n,)
        Von Mises stress, averaged at the nodes [Pa].
    load_line : ndarray, shape (2, 3)
        Ends of the line load [m].
    load_direction : ndarray, shape (3,)
        Its unit vector.
    force_per_width : float
        The line load [N/m].
    """

    mesh: SolidMesh
    displacement: Array
    von_mises: Array
    load_line: Array
    load_direction: Array
    force_per_width: float


def von_mises_3d(section: SectionMesh, width: FaceWidth, material: Material, displacement: Array) -> Array:
    """Return the von Mises stress at the nodes, averaged over the elements that meet there.

    Parameters
    ----------
    section : SectionMesh
        Of n nodes.
    width : FaceWidth
        Of m nodes, degree 2.
    material : Material
        Isotropic material.
    displacement : ndarray, shape (3, n, m)
        Nodal displacements [m].

    Returns
    -------
    ndarray, shape (n, m)
        Stress [Pa]; the components are averaged before they are combined.

    Notes
    -----
    Stresses at the 2 x 2 x 2 Gauss points, where they are most accurate (Barlow 1976), extrapolated trilinearly to the nodes.
    """
    gauss = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
    points = np.array([[x, y] for x in gauss for y in gauss]).T
    basis = skfem.CellBasis(section.mesh, ELEMENT, quadrature=(points, np.full(4, 0.25)))
    dofs = basis.element_dofs
    value = np.stack([np.broadcast_to(np.asarray(own[0]), (dofs.shape[1], 4)) for own in basis.basis])
    slopes = np.stack([np.asarray(own[0].grad) for own in basis.basis])
    # Values, and derivatives in the section, at the Gauss points of each element and each node of the width.
    local = displacement[:, dofs]
    tables = [np.einsum("ieq,ciem->ceqm", table, local) for table in (slopes[:, 0], slopes[:, 1], value)]
    along, steep = shape_functions(gauss, 2)
    total = np.zeros((6, *displacement.shape[1:]))
    share = np.zeros(displacement.shape[1:])
    line = _linear(np.array([0.0, 0.5, 1.0]), gauss)
    square = np.einsum("nx,ny->nxy", *(_linear(part, gauss) for part in ELEMENT.doflocs.T)).reshape(9, 4)
    for first in range(0, len(width.places) - 1, 2):
        own = slice(first, first + 3)
        length = width.places[first + 2] - width.places[first]
        weights = (along, along, steep / length)
        gradient = np.stack([np.einsum("ceqm,gm->ceqg", t[..., own], w) for t, w in zip(tables, weights, strict=True)])
        stress = _stress(gradient, material)
        nodal = np.einsum("nq,hg,seqg->snhe", square, line, stress)
        for layer in range(3):
            np.add.at(share[:, first + layer], dofs, 1.0)
            for component in range(6):
                np.add.at(total[component, :, first + layer], dofs, nodal[component, :, layer])
    x, y, z, xy, yz, zx = total / share
    combined: Array = np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) + 3.0 * (xy**2 + yz**2 + zx**2))
    return combined


def _stress(gradient: Array, material: Material) -> Array:
    """Return six stress components of the displacement gradient, derivative first, shape (3, 3, ...)."""
    mu, nu = material.shear_modulus, material.poissons_ratio
    dilation = 2.0 * mu * nu / (1.0 - 2.0 * nu) * (gradient[0, 0] + gradient[1, 1] + gradient[2, 2])
    return np.stack([mu * (gradient[i, j] + gradient[j, i]) + (dilation if i == j else 0.0) for i, j in PAIRS])


def _linear(place: Array, gauss: Array) -> Array:
    """Return the weights of values at two Gauss points that extrapolate linearly to places of an edge, shape (n, 2)."""
    part = (place - gauss[0]) / (gauss[1] - gauss[0])
    return np.stack([1.0 - part, part], axis=1)
