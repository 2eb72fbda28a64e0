"""Linear elasticity in the plane: plane states, stiffness matrices and stresses on second-order meshes."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, Protocol

import numpy as np
import skfem
from scipy import sparse

from gearfem.definition.setup import Material
from gearfem.foundation import Array, Record

ELEMENT = skfem.ElementQuad2()
# 3 x 3 Gauss points: full integration of the biquadratic element on a parallelogram, and the usual choice on curved ones.
QUADRATURE = skfem.quadrature.get_quadrature(ELEMENT, 5)


class Plane(Protocol):
    """What carries the load across the section: gives Lame's constants in the plane and the stress across it."""

    name: ClassVar[str]

    def lame(self, material: Material) -> tuple[float, float]:
        """Return lambda and mu of the plane problem [Pa]."""

    def across(self, material: Material) -> float:
        """Return sigma_z / (sigma_x + sigma_y)."""


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class PlaneStrain(Record):
    """No strain across the face width: a wide gear.

    Notes
    -----
    lambda = E nu / ((1 + nu)(1 - 2 nu)), mu = E / (2 (1 + nu)), sigma_z = nu (sigma_x + sigma_y).
    """

    name: ClassVar[str] = "plane_strain"

    def lame(self, material: Material) -> tuple[float, float]:
        """Return lambda and mu [Pa]."""
        nu = material.poissons_ratio
        return material.youngs_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), material.shear_modulus

    def across(self, material: Material) -> float:
        """Return nu."""
        return material.poissons_ratio


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class PlaneStress(Record):
    """No stress across the face width: a thin gear.

    Notes
    -----
    lambda = E nu / (1 - nu^2), mu = E / (2 (1 + nu)): lambda of plane strain times 2 mu/(lambda + 2 mu).
    """

    name: ClassVar[str] = "plane_stress"

    def lame(self, material: Material) -> tuple[float, float]:
        """Return lambda and mu [Pa]."""
        nu = material.poissons_ratio
        return material.youngs_modulus * nu / (1.0 - nu**2), material.shear_modulus

    def across(self, material: Material) -> float:
        """Return 0."""
        return 0.0


def stiffness(mesh: Any, plane: Plane, material: Material) -> Any:
    """Assemble the stiffness matrix per unit of face width.

    Parameters
    ----------
    mesh : skfem.MeshQuad2
        Mesh with n nodes [m].
    plane : Plane
        Plane strain or plane stress.
    material : Material
        Isotropic material.

    Returns
    -------
    csc_matrix, shape (2 n, 2 n)
        All x displacements first, then all y displacements [Pa].

    Notes
    -----
    a(u, v) = integral of lambda div u div v + 2 mu eps(u) : eps(v). By components this needs only the three
    matrices of products of first derivatives; formed for all elements at once from scikit-fem's gradients, they cost a
    quarter of its own assembly.
    """
    basis = skfem.CellBasis(mesh, ELEMENT, quadrature=QUADRATURE)
    grad = np.stack([shape[0].grad for shape in basis.basis]).transpose(1, 2, 0, 3)
    return assemble(grad, basis.dx, np.asarray(basis.element_dofs).T, mesh.doflocs.shape[1], plane.lame(material))


def assemble(grad: Array, dx: Array, cells: Any, nodes: int, lame: tuple[float, float]) -> Any:
    """Assemble the stiffness matrix of elements of one type from the gradients of their shape functions.

    Parameters
    ----------
    grad : ndarray, shape (2, m, k, q)
        Derivatives in x and y of the k shape functions of m elements at q points of integration [1/m].
    dx : ndarray, shape (m, q)
        Weights of the points, the area included [m2].
    cells : ndarray of int, shape (m, k)
        Nodes of the elements.
    nodes : int
        Number n of all nodes.
    lame : tuple of float
        lambda and mu of the plane problem [Pa].

    Returns
    -------
    csc_matrix, shape (2 n, 2 n)
        As from `stiffness`.
    """
    lam, mu = lame
    weighted = (grad * dx[None, :, None]).transpose(0, 1, 3, 2)
    xx, xy, yy = (grad[i] @ weighted[j] for i, j in ((0, 0), (0, 1), (1, 1)))
    yx = xy.transpose(0, 2, 1)
    blocks = [[(lam + 2.0 * mu) * xx + mu * yy, lam * xy + mu * yx], [lam * yx + mu * xy, (lam + 2.0 * mu) * yy + mu * xx]]
    unknowns = np.concatenate([cells, cells + nodes], axis=1).astype(np.int32)
    size = unknowns.shape[1]
    rows, columns = np.repeat(unknowns, size, axis=1).ravel(), np.tile(unknowns, size).ravel()
    return sparse.coo_array((np.block(blocks).ravel(), (rows, columns)), shape=(2 * nodes, 2 * nodes)).tocsc()


def von_mises(mesh: Any, plane: Plane, material: Material, displacement: Array) -> Array:
    """Return the von Mises stress at the nodes, averaged over the elements that meet there.

    Parameters
    ----------
    mesh : skfem.MeshQuad2
        Mesh with n nodes [m].
    plane, material : Plane, Material
        As in `stiffness`.
    displacement : ndarray, shape (n, 2)
        Nodal displacements [m].

    Returns
    -------
    ndarray, shape (n,)
        Stress [Pa]; the components are averaged before they are combined.

    Notes
    -----
    Stresses at the 2 x 2 Gauss points, where they are most accurate (Barlow 1976), extrapolated bilinearly to the
    nodes of each element. Under a line load the stress grows without bound as the mesh is refined.
    """
    gauss = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
    points = np.array([[x, y] for x in gauss for y in gauss]).T
    basis = skfem.CellBasis(mesh, ELEMENT, quadrature=(points, np.full(4, 0.25)))
    grad = np.stack([basis.interpolate(displacement[:, axis]).grad for axis in (0, 1)])
    lam, mu = plane.lame(material)
    dilation = lam * (grad[0, 0] + grad[1, 1])
    at_points = np.stack([dilation + 2 * mu * grad[0, 0], dilation + 2 * mu * grad[1, 1], mu * (grad[0, 1] + grad[1, 0])])
    nodal = np.zeros((3, mesh.doflocs.shape[1]))
    dofs = basis.element_dofs
    weight = _extrapolation(gauss)
    share = np.bincount(dofs.ravel(), minlength=nodal.shape[1])
    for component, values in zip(nodal, at_points, strict=True):
        component += np.bincount(dofs.ravel(), (weight @ values.T).ravel(), minlength=nodal.shape[1]) / share
    x, y, shear = nodal
    z = plane.across(material) * (x + y)
    stress: Array = np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) + 3.0 * shear**2)
    return stress


def _extrapolation(gauss: Array) -> Array:
    """Return the bilinear extrapolation from the 2 x 2 Gauss points to the nine nodes, shape (9, 4)."""
    place = (ELEMENT.doflocs - gauss[0]) / (gauss[1] - gauss[0])
    along = [np.stack([1.0 - place[:, axis], place[:, axis]], axis=1) for axis in (0, 1)]
    table: Array = np.einsum("ni,nj->nij", *along).reshape(9, 4)
    return table
