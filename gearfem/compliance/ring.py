"""The whole gear as a ring of equal sectors: one sector is condensed once, the ring solved by harmonics."""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

from gearfem.compliance.section_mesh import SectionMesh
from gearfem.foundation import Array, SolveError


def one_thread() -> AbstractContextManager[Any]:
    """Return a context in which dense algebra keeps to one thread.

    Notes
    -----
    SuperLU calls it on blocks so small that starting threads costs more than they save: on two cores that are
    shared, the compliance of one gear pair took 0.7 to 5 s with two threads and 0.4 s with one.
    """
    context: AbstractContextManager[Any] = threadpool_limits(1, user_api="blas")
    return context


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


class Ring:
    """The ring of `teeth` equal sectors, held on the bore, loaded on one of them.

    Parameters
    ----------
    section : SectionMesh
        The sector, with its two cuts.
    stiffness : csc_matrix, shape (2 n, 2 n)
        Its stiffness matrix, x displacements first [Pa].
    teeth : int
        Number of sectors.

    Notes
    -----
    On a cut, displacements are counted in radial and tangential direction, so that the upper cut of sector k and the lower cut
    of sector k + 1 share the unknowns v_k. With the sector's Schur complement S, the sum of forces at cut k is
    S_ul v_(k-1) + (S_uu + S_ll) v_k + S_lu v_(k+1) = f_k. The discrete Fourier transform turns it into
    (S_ul exp(-i n t) + S_uu + S_ll + S_lu exp(i n t)) v_n = f_n, t = 2 pi / teeth, one small system for each
    harmonic n = 0 ... teeth/2 (the rest are complex conjugates). Exact up to rounding; derived here.
    """

    def __init__(self, section: SectionMesh, stiffness: Any, teeth: int) -> None:
        nodes = section.mesh.doflocs.shape[1]
        self.teeth, self._nodes = teeth, nodes
        kept = ~np.isin(section.upper, section.held)
        self._cuts = section.lower[kept], section.upper[kept]
        cut = np.concatenate(self._cuts)
        inner = np.setdiff1d(np.arange(nodes), np.concatenate([cut, section.held]))
        self._inner = np.concatenate([inner, inner + nodes])
        self._cut = np.concatenate([part + shift for part in self._cuts for shift in (0, nodes)])
        self._factors = factorise(stiffness[self._inner][:, self._inner])
        # Columns of the cut in radial and tangential directions.
        coupling = stiffness[:, self._cut].toarray() @ self._local
        self._influence = self._factors.solve(coupling[self._inner])
        schur = self._local.T @ coupling[self._cut] - coupling[self._inner].T @ self._influence
        self._schur = 0.5 * (schur + schur.T)

    @cached_property
    def _local(self) -> Array:
        """Columns: the radial, then the tangential unit displacements of the lower, then of the upper cut."""
        half = np.pi / self.teeth
        identity = np.eye(len(self._cuts[0]))
        blocks = [np.kron(np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]), identity) for a in (-half, half)]
        zero = np.zeros_like(blocks[0])
        return np.block([[blocks[0], zero], [zero, blocks[1]]])

    @cached_property
    def _harmonics(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Phases exp(i n t) of the harmonics 0 ... teeth/2 and the inverse matrices of their systems."""
        size = len(self._schur) // 2
        s = self._schur
        ll, lu, ul, uu = s[:size, :size], s[:size, size:], s[size:, :size], s[size:, size:]
        phase = np.exp(2j * np.pi / self.teeth * np.arange(self.teeth // 2 + 1))
        return phase, np.linalg.inv(uu + ll + ul * phase.conj()[:, None, None] + lu * phase[:, None, None])

    def condense(self, load: Array) -> Array:
        """Return what loads on a sector are worth on its two cuts, lower cut first.

        Parameters
        ----------
        load : ndarray, shape (2 n, k)
            Nodal forces of k cases.

        Returns
        -------
        ndarray, shape (4 c, k)
        """
        worth: Array = self._local.T @ load[self._cut] - self._influence.T @ load[self._inner]
        return worth

    def cuts(self, condensed: Array, offsets: tuple[int, ...]) -> Array:
        """Return the displacements of the two cuts of several sectors under loads on sector 0.

        Parameters
        ----------
        condensed : ndarray, shape (4 c, k)
            Loads as `condense` returns them.
        offsets : tuple of int
            Numbers of the sectors, counted towards positive polar angles.

        Returns
        -------
        ndarray, shape (len(offsets), 4 c, k)
        """
        size = len(condensed) // 2
        phase, inverse = self._harmonics
        # Cut k is the upper one of sector k: the lower cut of the loaded sector is number -1.
        spectrum = inverse @ (condensed[size:] + phase[:, None, None] * condensed[:size])
        count = np.full(len(phase), 2.0)
        count[0] = 1.0
        if self.teeth % 2 == 0:
            count[-1] = 1.0
        weight = {k: count[:, None, None] * (phase**k)[:, None, None] / self.teeth for o in offsets for k in (o - 1, o)}
        at = {k: (w * spectrum).sum(axis=0).real for k, w in weight.items()}
        return np.stack([np.concatenate([at[o - 1], at[o]]) for o in offsets])

    def deflection(self, load: Array, reading: Array) -> Array:
        """Return what each reading shows under the load of the same column, shape (k,).

        Parameters
        ----------
        load, reading : ndarray, shape (2 n, k)
            Nodal forces and weights of nodal displacements, both on sector 0.
        """
        follows = self.cuts(self.condense(load), (0,))[0]
        own = np.einsum("ij,ij->j", reading, self._inside(load))
        total: Array = own + np.einsum("ij,ij->j", self.condense(reading), follows)
        return total

    def coupling(self, load: Array, offsets: tuple[int, ...]) -> Array:
        """Return the displacements of other sectors, weighted as the loads are, under the loads on sector 0.

        Parameters
        ----------
        load : ndarray, shape (2 n, k)
            Nodal forces, and weights of the displacements in the frame of the other sector.
        offsets : tuple of int
            Numbers of the other sectors, 0 excluded.

        Returns
        -------
        ndarray, shape (len(offsets), k, k)
            Reading i under load j.
        """
        condensed = self.condense(load)
        table: Array = condensed.T @ self.cuts(condensed, offsets)
        return table

    def displacements(self, load: Array, offsets: tuple[int, ...]) -> Array:
        """Return nodal displacements of several sectors, each in its own frame, shape (len(offsets), 2 n, k)."""
        cuts = self.cuts(self.condense(load), offsets)
        result = np.zeros((len(offsets), 2 * self._nodes, load.shape[1]))
        result[:, self._inner] = -self._influence @ cuts
        result[:, self._cut] = self._local @ cuts
        for place, offset in enumerate(offsets):
            if offset % self.teeth == 0:
                result[place] += self._inside(load)
        return result

    def _inside(self, load: Array) -> Array:
        """Return the displacements under loads with the cuts held."""
        result = np.zeros_like(load)
        result[self._inner] = self._factors.solve(np.ascontiguousarray(load[self._inner]))
        return result


class Alone:
    """One tooth, held at its root: the counterpart of `Ring` without neighbours.

    Parameters
    ----------
    section : SectionMesh
        The tooth.
    stiffness : csc_matrix, shape (2 n, 2 n)
        Its stiffness matrix [Pa].
    """

    def __init__(self, section: SectionMesh, stiffness: Any) -> None:
        nodes = section.mesh.doflocs.shape[1]
        free = np.setdiff1d(np.arange(nodes), section.held)
        self._free = np.concatenate([free, free + nodes])
        self._factors = factorise(stiffness[self._free][:, self._free])

    def deflection(self, load: Array, reading: Array) -> Array:
        """Return what each reading shows under the load of the same column, shape (k,)."""
        shown: Array = np.einsum("ij,ij->j", reading, self.displacements(load, (0,))[0])
        return shown

    def displacements(self, load: Array, offsets: tuple[int, ...]) -> Array:
        """Return the nodal displacements, shape (1, 2 n, k); there is no other sector than 0."""
        if offsets != (0,):
            raise ValueError(f"a tooth held at its root has no neighbours {offsets}")
        result = np.zeros_like(load)
        result[self._free] = self._factors.solve(np.ascontiguousarray(load[self._free]))
        return result[None]
