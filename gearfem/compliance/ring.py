"""The whole gear as a ring of equal sectors: one sector is condensed once, the ring solved by harmonics."""

from __future__ import annotations

from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from gearfem.compliance.dissection import Trailing, dissect
from gearfem.compliance.harmonic_ring import HarmonicRing
from gearfem.compliance.patchwork import Ids, mirror_images
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.foundation import Array, SolveError

Mask: TypeAlias = NDArray[np.bool_]


def factorise(matrix: Any) -> Any:
    """Return the sparse factors of a symmetric positive definite matrix.

    Parameters
    ----------
    matrix : csc_matrix, shape (n, n)
        The matrix; pivots stay on its diagonal, which is stable for positive definite ones.

    Returns
    -------
    SuperLU
        With a method `solve`.

    Raises
    ------
    SolveError
        If the matrix is singular.
    """
    try:
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:
        raise SolveError(f"the stiffness matrix cannot be factorised ({error}); check bore radius and material") from None


class Ring(HarmonicRing):
    """The ring of `teeth` equal sectors, held on the bore, loaded on one of them.

    Parameters
    ----------
    section : SectionMesh
        The sector, with its two cuts, symmetric about y = 0.
    stiffness : csc_matrix, shape (2 n, 2 n)
        Its stiffness matrix, x displacements first [Pa].
    teeth : int
        Number of sectors.
    ports : ndarray of int, optional
        Nodes with y >= 0 that take loads or are read; by default those of outline and centreline. Fewer cost less.

    Notes
    -----
    The sector is split into motions even and odd under its mirror: two problems of half the size on the upper half. With
    their Schur complements S_e, S_o, A = (S_e + S_o)/2, B = (S_e - S_o)/2 and J = diag(1, -1) for (radial, tangential),
    S_uu = A, S_ll = J A J, S_ul = B J. Counting tangential displacements in the unit i makes every system real:
    2 [A_rr + cos t B_rr, -sin t B_rt; -sin t B_tr, A_tt - cos t B_tt]. Exact up to rounding; derived here.
    """

    def __init__(self, section: SectionMesh, stiffness: Any, teeth: int, ports: Ids | None = None) -> None:
        nodes = section.mesh.doflocs.shape[1]
        self._nodes = nodes
        cut = section.upper[~np.isin(section.upper, section.held)]
        fixed = np.isin(np.arange(nodes), section.held)
        self.cut = cut
        axis = section.mesh.doflocs[1] == 0.0
        wanted = np.concatenate([section.outline, section.centreline]) if ports is None else ports
        ports = np.setdiff1d(wanted, np.concatenate([cut, section.held]))
        closed = np.setdiff1d(np.arange(nodes), ports)
        self._closed = np.concatenate([closed, closed + nodes])
        order = dissect(section.mesh)
        last = np.isin(order, np.concatenate([ports, cut]))
        order = np.concatenate([order[~last & (section.mesh.doflocs[1, order] >= 0.0) & ~fixed[order]], ports, cut])
        self._halves = tuple(_Half(stiffness, order, axis, odd, len(ports), len(cut)) for odd in (False, True))
        angle = np.pi / teeth
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        # Unknowns of a cut: x and y node by node in the factors, all radial then all tangential in the ring.
        self._polar = np.kron(turn, np.eye(len(cut))).reshape(2, len(cut), -1).swapaxes(0, 1).reshape(2 * len(cut), -1)
        self._mirror = mirror_images(section.mesh.doflocs)
        self._flip = np.repeat([1.0, -1.0], len(cut))[:, None]
        self._schur = [self._polar.T @ half.factors.schur @ self._polar for half in self._halves]
        a, b = (self._schur[0] + self._schur[1]) / 4.0, (self._schur[0] - self._schur[1]) / 4.0
        super().__init__(np.block([[self._flip * a * self._flip.T, self._flip * b], [b * self._flip.T, a]]), teeth)

    @cached_property
    def _real_inverse(self) -> Array:
        """Inverse matrices of the real systems of all harmonics."""
        even, odd = self._schur
        a, b = (even + odd) / 4.0, (even - odd) / 4.0
        c = len(a) // 2
        cosine, sine = self.phase.real[:, None, None], self.phase.imag[:, None, None]
        systems = np.empty((len(self.phase), 2 * c, 2 * c))
        systems[:, :c, :c] = a[:c, :c] + cosine * b[:c, :c]
        systems[:, c:, c:] = a[c:, c:] - cosine * b[c:, c:]
        systems[:, :c, c:] = -sine * b[:c, c:]
        systems[:, c:, :c] = systems[:, :c, c:].swapaxes(1, 2)
        return np.asarray(np.linalg.inv(2.0 * systems), dtype=float)

    def respond(self, load: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the displacements of a cut in all harmonics under loads on it, shape (h, 2 c, k)."""
        cases = load.shape[2]
        unit = np.repeat([1.0, 1.0j], load.shape[1] // 2)[:, None]
        load = load * unit.conj()
        parts = self._real_inverse @ np.concatenate([load.real, load.imag], axis=2)
        moved: NDArray[np.complex128] = (parts[:, :, :cases] + 1j * parts[:, :, cases:]) * unit
        return moved

    def own(self, load: Array, reading: Array) -> Array:
        """Return what each reading shows under the load of the same column while both cuts are held, shape (k,)."""
        shown: Array = np.sum([(half.forward(load)[0] * half.forward(reading)[0]).sum(axis=0) for half in self._halves], axis=0)
        return shown

    def condense(self, load: Array) -> Array:
        """Return what loads on a sector are worth on its two cuts, lower cut first.

        Parameters
        ----------
        load : ndarray, shape (2 n, k)
            Nodal forces of k cases, on ports alone.

        Returns
        -------
        ndarray, shape (4 c, k)
        """
        if np.count_nonzero(load[self._closed]):
            raise ValueError("loads and readings belong on the ports of the ring")
        even, odd = (self._polar.T @ half.forward(load)[1] for half in self._halves)
        return np.concatenate([self._flip * (even - odd), even + odd]) / 2.0

    def displacements(self, load: Array, offsets: tuple[int, ...]) -> Array:
        """Return nodal displacements of several sectors, each in its own frame, shape (len(offsets), 2 n, k)."""
        size = len(self._flip)
        cuts = self.cuts(self.condense(load), offsets)
        result = np.zeros((len(offsets), 2, self._nodes, load.shape[1]))
        for place, (offset, moved) in enumerate(zip(offsets, cuts, strict=True)):
            own = load if offset % self.teeth == 0 else np.zeros_like(load)
            for half, schur, sign in zip(self._halves, self._schur, (1.0, -1.0), strict=True):
                # The force that the neighbours put on the cut is what remains of its stiffness after the loads.
                cut = schur @ (moved[size:] + sign * self._flip * moved[:size]) / 2.0 - self._polar.T @ half.forward(own)[1]
                half.add(result[place], own, self._polar @ cut, self._mirror)
        return result.reshape(len(offsets), 2 * self._nodes, -1)


class _Half:
    """The upper half of a sector, for the motions that are even or odd under its mirror; energies are those of both halves."""

    def __init__(self, stiffness: Any, order: Ids, axis: Mask, odd: bool, ports: int, cut: int) -> None:
        nodes = len(axis)
        unknowns = np.stack([order, order + nodes], axis=1)
        free = np.ones(unknowns.shape, dtype=bool)
        # On the axis even motions have no y component, odd ones no x component.
        free[:, 0 if odd else 1] = ~axis[order]
        self._odd, self._nodes = odd, nodes
        self.unknowns = unknowns[free]
        first = len(order) - ports - cut
        self._ports, self._cut = int(free[first : first + ports].sum()), 2 * cut
        matrix = stiffness[self.unknowns][:, self.unknowns]
        # Both halves share the stiffness between nodes of the axis; all else belongs to one of them.
        on_axis = np.tile(axis, 2)[self.unknowns]
        shared = on_axis[matrix.indices] & np.repeat(on_axis, np.diff(matrix.indptr))
        matrix.data *= np.where(shared, 1.0, 2.0)
        self.factors = Trailing(matrix, self._ports, self._cut)

    def forward(self, load: Array) -> tuple[Array, Array]:
        start = len(self.unknowns) - self._ports - self._cut
        return self.factors.forward(load[self.unknowns[start : start + self._ports]])

    def add(self, result: Array, load: Array, cut: Array, mirror: Ids) -> None:
        """Add the displacements under loads and forces on the cut to those of the whole sector, shape (2, n, k)."""
        force = load[self.unknowns]
        force[len(force) - self._cut :] += cut
        flat = np.zeros((2 * self._nodes, load.shape[1]))
        flat[self.unknowns] = self.factors.solve(force)
        moved = flat.reshape(result.shape)
        below = np.zeros(self._nodes, dtype=bool)
        below[mirror[self.unknowns % self._nodes]] = True
        below[self.unknowns % self._nodes] = False
        signs = np.array([-1.0, 1.0] if self._odd else [1.0, -1.0])
        moved[:, below] = signs[:, None, None] * moved[:, mirror[below]]
        result += moved
