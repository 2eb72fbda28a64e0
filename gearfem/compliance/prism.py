"""Linear elasticity of prisms: a section extruded along the face width, solved by modes of the width."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy import sparse

from gearfem.compliance.face_width import FaceWidth
from gearfem.compliance.reductions import Reduction, alone, harmonics
from gearfem.compliance.ring import factorise
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.definition.setup import Material
from gearfem.foundation import Array, SolveError

Values: TypeAlias = NDArray[Any]
# Error left by the conjugate gradients, relative in the norm of the preconditioner: far below that of any mesh.
TOLERANCE, SPARING, MOST_STEPS = 1e-10, 1e-3, 2000
ROUNDING = 1e-15
# Numbers in one block of right-hand sides: a dozen such blocks take half a gigabyte.
BLOCK = 4_000_000


@dataclasses.dataclass(frozen=True)
class SectionMatrices:
    """Integrals over the section of products of its n shape functions and their derivatives.

    Parameters
    ----------
    mass, xx, xy, yy, x, y : csr_matrix, shape (n, n)
        Of values, of first derivatives (rows first), and of derivatives (rows) with values (columns).
    """

    mass: Any
    xx: Any
    xy: Any
    yy: Any
    x: Any
    y: Any


def section_matrices(mesh: Any, element: Any, quadrature: tuple[Array, Array]) -> SectionMatrices:
    """Integrate over a plane mesh of scikit-fem."""
    basis = skfem.CellBasis(mesh, element, quadrature=quadrature)

    def product(row: int | None, column: int | None) -> Any:
        def form(u: Any, v: Any, _: Any) -> Any:
            return (u if column is None else u.grad[column]) * (v if row is None else v.grad[row])

        return skfem.BilinearForm(form).assemble(basis).tocsr()

    return SectionMatrices(*(product(*pair) for pair in ((None, None), (0, 0), (0, 1), (1, 1), (0, None), (1, None))))


class Prism:
    """A prism with free ends, whose section is supported in the same way over the whole face width.

    Parameters
    ----------
    matrices : SectionMatrices
        Of n nodes.
    width : FaceWidth
        Of m nodes, symmetric about mid-face.
    material : Material
        Isotropic material.
    reduction : Reduction
        The support of the section.

    Notes
    -----
    On an extruded mesh each block of the stiffness matrix is a sum of Kronecker products of a matrix of the section and one of
    the width: the integrals are those of full Gaussian integration of the hexahedra, though no hexahedron is visited.
    Mass and stiffness of the width have common eigenvectors; in their basis the matrix but for the coupling between displacements
    in the section and along the width falls apart into one plane problem for each mode. These, factorised, precondition
    conjugate gradients. What they leave out is bounded by Poisson's ratio and Korn's inequality and not by the mesh, and so is
    the number of steps: 26 on a steel tooth, at any resolution. Derived here.

    The even and the odd part of a load are solved apart: in the even one the displacements in the section are symmetric about
    mid-face and those along the width antisymmetric, in the odd one the reverse.
    """

    def __init__(self, matrices: SectionMatrices, width: FaceWidth, material: Material, reduction: Reduction) -> None:
        nu, self._mu = material.poissons_ratio, material.shear_modulus
        self._lam = 2.0 * self._mu * nu / (1.0 - 2.0 * nu)
        self.width, self._reduction = width, reduction
        m, lam, mu = matrices, self._lam, self._mu
        blocks = [
            [(lam + 2.0 * mu) * m.xx + mu * m.yy, lam * m.xy + mu * m.xy.T],
            [lam * m.xy.T + mu * m.xy, (lam + 2.0 * mu) * m.yy + mu * m.xx],
        ]
        plane, across = reduction.plane, reduction.across
        left, right = plane.conj().T.tocsr(), across.conj().T.tocsr()
        self.plane = self._own(left @ sparse.block_array(blocks, format="csr") @ plane)
        self.plane_mass = self._own(mu * left @ sparse.block_diag([m.mass, m.mass], format="csr") @ plane)
        self.across = self._own(mu * right @ (m.xx + m.yy) @ across)
        self.across_mass = self._own((lam + 2.0 * mu) * right @ m.mass @ across)
        self.dilation = self._own(lam * left @ sparse.vstack([m.x, m.y], format="csr") @ across)
        self.shear = self._own(mu * left @ sparse.vstack([m.x.T, m.y.T], format="csr") @ across)

    def _own(self, matrix: Any) -> Any:
        """Return a matrix of the unknowns as it is kept, without what mirror images leave of each other by rounding."""
        kept = (matrix.real if self._reduction.real else matrix).tocsr()
        kept.data[np.abs(kept.data) < ROUNDING * np.abs(kept.data).max(initial=0.0)] = 0.0
        kept.eliminate_zeros()
        return kept

    def solve(self, load: Array, along: Array, tolerance: float = TOLERANCE) -> Iterator[tuple[slice, Array, Array]]:
        """Yield the displacements under line loads, some columns at a time.

        Parameters
        ----------
        load : ndarray, shape (2 n, k)
            Nodal forces in the section, x components first [N/m per N/m].
        along : ndarray, shape (m, k)
            Nodal forces along the width of each column [m].
        tolerance : float
            Error left by the conjugate gradients, relative in the norm of the preconditioner.

        Yields
        ------
        columns : slice
            Which of the k columns.
        plane : ndarray, shape (2 n, m, columns)
            Displacements in the section [m], times the reduction's weight, real part.
        across : ndarray, shape (n, m, columns)
            Displacements along the width, likewise.

        Raises
        ------
        SolveError
            If the conjugate gradients do not converge.
        """
        at_once = max(1, BLOCK // ((self.plane.shape[0] + self.across.shape[0]) * len(along)))
        parts = [0.5 * (along + along[::-1]), 0.5 * (along - along[::-1])]
        # A load in mid-face has an odd part by rounding alone.
        parts[1][:, np.abs(parts[1]).max(axis=0) <= 1e-12 * np.abs(along).max(axis=0)] = 0.0
        halves = [(_Half(self, odd), part) for odd, part in enumerate(parts) if part.any()]
        forces = self._reduction.plane.conj().T @ load
        for start in range(0, load.shape[1], at_once):
            columns = slice(start, min(start + at_once, load.shape[1]))
            plane = np.zeros((load.shape[0], len(along), columns.stop - start))
            across = np.zeros((load.shape[0] // 2, len(along), columns.stop - start))
            for half, part in halves:
                u, w = self._solve(half, forces[:, None, columns] * (half.plane_modes.vectors.T @ part[:, columns]), tolerance)
                plane += self._expand(self._reduction.plane, half.plane_modes.vectors, u)
                across += self._expand(self._reduction.across, half.across_modes.vectors, w)
            yield columns, plane, across

    def _solve(self, half: _Half, force: Values, tolerance: float) -> tuple[Values, Values]:
        """Return displacements in modes; where matrices are real, under the real and the imaginary parts of the forces side by side."""
        if not (self._reduction.real and np.iscomplexobj(force)):
            return half.solve(force, tolerance)
        count = force.shape[2]
        u, w = half.solve(np.concatenate([force.real, force.imag], axis=2), tolerance)
        return u[..., :count] + 1j * u[..., count:], w[..., :count] + 1j * w[..., count:]

    def _expand(self, reduction: Any, vectors: Array, unknowns: Values) -> Array:
        places = np.matmul(vectors, unknowns)
        full = (reduction @ places.reshape(len(places), -1)).reshape(-1, *places.shape[1:])
        expanded: Array = self._reduction.weight * full.real
        return expanded


class _Half:
    """The modes of one symmetry: the matrix applied, and the preconditioned conjugate gradients."""

    def __init__(self, prism: Prism, odd: int) -> None:
        modes, p = prism.width.modes, prism
        self._prism, self.plane_modes, self.across_modes = prism, modes[odd], modes[1 - odd]
        # Derivatives of modes of displacements along the width (first) and in the section (second), with values of the others.
        slope = prism.width.matrices[2]
        self._along = self.across_modes.vectors.T @ slope @ self.plane_modes.vectors
        self._beside = self.plane_modes.vectors.T @ slope @ self.across_modes.vectors
        self._plane_factors = [factorise((p.plane + square * p.plane_mass).tocsc()) for square in self.plane_modes.squares]
        self._across_factors = [factorise((p.across + square * p.across_mass).tocsc()) for square in self.across_modes.squares]

    def _apply(self, u: Values, w: Values) -> tuple[Values, Values]:
        p = self._prism
        plane = _times(p.plane, u) + self.plane_modes.squares[:, None] * _times(p.plane_mass, u)
        plane += _times(p.dilation, np.matmul(self._along.T, w)) + _times(p.shear, np.matmul(self._beside, w))
        across = _times(p.across, w) + self.across_modes.squares[:, None] * _times(p.across_mass, w)
        across += _times(p.dilation.conj().T, np.matmul(self._along, u)) + _times(p.shear.conj().T, np.matmul(self._beside.T, u))
        return plane, across

    def _precondition(self, plane: Values, across: Values) -> tuple[Values, Values]:
        return _solved(self._plane_factors, plane), _solved(self._across_factors, across)

    def solve(self, force: Values, tolerance: float) -> tuple[Values, Values]:
        """Return displacements in the section and along the width, in modes, by conjugate gradients; all columns together."""
        rest = force, np.zeros((self._prism.across.shape[0], len(self.across_modes.squares), force.shape[2]), dtype=force.dtype)
        result = np.zeros_like(rest[0]), np.zeros_like(rest[1])
        step = ahead = self._precondition(*rest)
        size = first = _dot(rest, ahead)
        for _ in range(MOST_STEPS):
            pushed = self._apply(*step)
            length = _ratio(size, _dot(step, pushed))
            result = result[0] + length * step[0], result[1] + length * step[1]
            rest = rest[0] - length * pushed[0], rest[1] - length * pushed[1]
            ahead = self._precondition(*rest)
            size, before = _dot(rest, ahead), size
            if not np.isfinite(size).all():
                break
            if (size <= tolerance**2 * first).all():
                return result
            turn = _ratio(size, before)
            step = ahead[0] + turn * step[0], ahead[1] + turn * step[1]
        found = f"the 3D solution did not converge within {MOST_STEPS} steps of conjugate gradients"
        raise SolveError(f"{found}; is Poisson's ratio close to 0.5, or the body very thin?")


def _times(matrix: Any, block: Values) -> Values:
    product: Values = (matrix @ block.reshape(len(block), -1)).reshape(-1, *block.shape[1:])
    return product


def _solved(factors: list[Any], block: Values) -> Values:
    result = np.empty_like(block)
    for mode, factor in enumerate(factors):
        result[:, mode] = factor.solve(np.ascontiguousarray(block[:, mode]))
    return result


def _ratio(one: Array, other: Array) -> Array:
    """Return the quotients, and 0 for 0/0 in columns without a load."""
    ratio: Array = one / np.where(other > 0.0, other, 1.0)
    return ratio


def _dot(one: tuple[Values, Values], other: tuple[Values, Values]) -> Array:
    total: Array = sum(np.einsum("ijk,ijk->k", a.conj(), b).real for a, b in zip(one, other, strict=True))
    return total


def solve_prism(
    section: SectionMesh,
    matrices: SectionMatrices,
    width: FaceWidth,
    material: Material,
    teeth: int,
    load: Array,
    along: Array,
    keep: Callable[[slice, Array, Array], Array],
    sparing: bool = False,
) -> Array:
    """Return what is kept of the solution, summed over the harmonics of a ring if the section is a sector of one.

    Parameters
    ----------
    section, matrices, width, material
        Of the prism.
    teeth : int
        Number of sectors.
    load, along
        As of `Prism.solve`.
    keep : callable
        Takes the columns and their displacements and returns something linear in them, columns last.
    sparing : bool
        Whether some harmonics of a ring stand for all, see `reductions.chosen`, and the conjugate gradients stop at 1e-3, which leaves
        3e-5 of what varies over the width.

    Returns
    -------
    ndarray, shape (..., k)
    """
    nodes, tolerance = section.mesh.doflocs.shape[1], SPARING if sparing else TOLERANCE
    reductions = harmonics(section, teeth, sparing) if len(section.upper) else iter([alone(nodes, section.held)])
    return sum(  # type: ignore[return-value]
        np.concatenate([keep(*part) for part in Prism(matrices, width, material, reduction).solve(load, along, tolerance)], axis=-1)
        for reduction in reductions
    )
