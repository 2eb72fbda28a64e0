"""Sparse factors with chosen unknowns last, whose trailing block is the factor of what those unknowns see."""

from __future__ import annotations

from typing import Any

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.sparse.linalg import splu

from gearfem.compliance.elasticity import ELEMENT
from gearfem.compliance.patchwork import Ids
from gearfem.foundation import Array, SolveError

# Elements that are not divided further; measured on both gears of a pair, 2 beats 4 and 8 by a few per cent.
LEAF = 2


def dissect(mesh: Any) -> Ids:
    """Return an order of the nodes in which elimination fills little: nested dissection of the elements by their places.

    Parameters
    ----------
    mesh : skfem.MeshQuad2
        Mesh with n nodes.

    Returns
    -------
    ndarray of int, shape (n,)
        Numbers of the nodes: those inside each half before those on the line between the halves, at every level.

    Notes
    -----
    George, SIAM J. Numer. Anal. 10 (1973) 345, with halves of equal numbers of elements across the longer side of their box.
    All levels are divided at once: with leaves numbered from the left, a node belongs to the smallest subtree that holds the
    first and the last of its leaves, and subtrees are taken in postorder.
    """
    dofs = np.asarray(skfem.Dofs(mesh, ELEMENT).element_dofs, dtype=np.int64)
    centre = mesh.doflocs[:, dofs].mean(axis=1).T
    leaf = np.zeros(len(centre), dtype=np.int64)
    for level in range(max(0, int(np.ceil(np.log2(len(centre) / LEAF))))):
        count = np.bincount(leaf, minlength=2**level)
        low = np.full((2**level, 2), np.inf)
        high = -low
        np.minimum.at(low, leaf, centre)
        np.maximum.at(high, leaf, centre)
        along = np.take_along_axis(centre, np.argmax(high - low, axis=1)[leaf][:, None], axis=1)[:, 0]
        row = np.lexsort((along, leaf))
        rank = np.empty(len(leaf), dtype=np.int64)
        rank[row] = np.arange(len(leaf)) - (np.cumsum(count) - count)[leaf[row]]
        leaf = 2 * leaf + (2 * rank >= count[leaf])
    first = np.full(mesh.doflocs.shape[1], leaf.max() + 1)
    last = np.full(mesh.doflocs.shape[1], -1)
    at = np.broadcast_to(leaf, dofs.shape)
    np.minimum.at(first, dofs, at)
    np.maximum.at(last, dofs, at)
    height = np.ceil(np.log2((first ^ last) + 1)).astype(np.int64)
    order: Ids = np.lexsort((height, ((last >> height) + 1) << height))
    return order


class Trailing:
    """Factors of a symmetric positive definite matrix whose last unknowns are ports, and after them a cut.

    Parameters
    ----------
    matrix : csc_matrix, shape (n, n)
        The matrix, its unknowns in the order in which they are eliminated.
    ports, cut : int
        Numbers of the unknowns that take loads or are read, and of the last ones, which join other structures.

    Raises
    ------
    SolveError
        If the matrix is singular.

    Notes
    -----
    A = L D L'. The trailing block of the factors is that of the Schur complement, so that loads at the ports cost dense
    substitutions of the size of the block and none over the inside.
    """

    def __init__(self, matrix: Any, ports: int, cut: int) -> None:
        try:
            factors = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise SolveError(f"the stiffness matrix cannot be factorised ({error}); check bore radius and material") from None
        size = matrix.shape[0]
        tail = np.arange(size - ports - cut, size)
        # SuperLU may reorder subtrees, but must not move the chain at the end nor pivot.
        if not ((factors.perm_c[tail] == tail).all() and (factors.perm_r == factors.perm_c).all()):
            raise SolveError("the stiffness matrix is not positive definite; check bore radius and material")
        block = factors.L[tail[0] :, tail[0] :].toarray() if tail.size else np.empty((0, 0))
        self._diagonal = factors.U.diagonal()[size - len(tail) :]
        self._factors, self._ports = factors, ports
        self._block: Array = block

    def forward(self, load: Array) -> tuple[Array, Array]:
        """Return loads at the ports scaled to orthogonal unknowns, and what they are worth on the cut.

        Parameters
        ----------
        load : ndarray, shape (ports, k)

        Returns
        -------
        scaled : ndarray, shape (ports, k)
            The work of one load in the displacement of another, the cut held, is the sum of products.
        worth : ndarray, shape (cut, k)
        """
        p = self._ports
        eliminated = solve_triangular(self._block[:p, :p], load, lower=True, unit_diagonal=True)
        return eliminated / np.sqrt(self._diagonal[:p, None]), -self._block[p:, :p] @ eliminated

    @property
    def schur(self) -> Array:
        """Stiffness seen at the cut, shape (cut, cut)."""
        p = self._ports
        lower = self._block[p:, p:]
        seen: Array = (lower * self._diagonal[p:]) @ lower.T
        return seen

    def solve(self, load: Array) -> NDArray[np.float64]:
        """Return all displacements under loads on any unknown, the cut free, shape (n, k)."""
        result: Array = self._factors.solve(np.ascontiguousarray(load))
        return result
