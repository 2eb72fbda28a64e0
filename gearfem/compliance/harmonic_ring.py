"""What rings of equal sectors share: loads on one sector, spread over all cuts by harmonics."""

from __future__ import annotations

import abc
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gearfem.compliance.patchwork import Ids
from gearfem.foundation import Array


class CutRing:
    """The cuts of a ring of `teeth` equal sectors held on the bore, loads on the two cuts of sector 0.

    Parameters
    ----------
    schur : ndarray, shape (4 c, 4 c)
        Stiffness of one sector seen at its two cuts, lower cut first.
    teeth : int
        Number of sectors.

    Notes
    -----
    On a cut, displacements are counted in radial and tangential direction, all radial ones first, so that the upper cut of
    sector k and the lower cut of sector k + 1 share the unknowns v_k. With the sector's Schur complement S, the sum of forces at
    cut k is S_ul v_(k-1) + (S_uu + S_ll) v_k + S_lu v_(k+1) = f_k. The discrete Fourier transform turns it into
    (S_ul exp(-i t) + S_uu + S_ll + S_lu exp(i t)) v_n = f_n, t = 2 pi n / teeth, one small system for each
    harmonic n = 0 ... teeth/2 (the rest are complex conjugates). Exact up to rounding; derived here.
    """

    def __init__(self, schur: Array, teeth: int) -> None:
        self.schur, self.teeth = schur, teeth

    @cached_property
    def phase(self) -> NDArray[np.complex128]:
        """Phases exp(i t) of the harmonics 0 ... teeth/2."""
        phase: NDArray[np.complex128] = np.exp(2j * np.pi / self.teeth * np.arange(self.teeth // 2 + 1))
        return phase

    @cached_property
    def _inverse(self) -> NDArray[np.complex128]:
        size = len(self.schur) // 2
        ll, lu, ul, uu = (self.schur[i : i + size, j : j + size] for i in (0, size) for j in (0, size))
        phase = self.phase[:, None, None]
        return np.asarray(np.linalg.inv(ll + uu + ul / phase + lu * phase), dtype=np.complex128)

    def respond(self, load: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the displacements of a cut in all harmonics under loads on it, shape (h, 2 c, k)."""
        moved: NDArray[np.complex128] = self._inverse @ load
        return moved

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
        phase = self.phase
        # Cut k is the upper one of sector k: the lower cut of the loaded sector is number -1.
        spectrum = self.respond(condensed[size:] + phase[:, None, None] * condensed[:size])
        count = np.full(len(phase), 2.0)
        count[0] = 1.0
        if self.teeth % 2 == 0:
            count[-1] = 1.0
        wanted = np.unique([k for o in offsets for k in (o - 1, o)])
        weight = count * phase ** wanted[:, None] / self.teeth
        at = dict(zip(wanted.tolist(), np.tensordot(weight, spectrum, axes=1).real, strict=True))
        return np.stack([np.concatenate([at[o - 1], at[o]]) for o in offsets])

    @cached_property
    def whole(self) -> Array:
        """Stiffness of the whole ring seen at the two cuts of sector 0, shape (4 c, 4 c); less `schur` it is that of the others."""
        stiffness = np.linalg.inv(self.cuts(np.eye(len(self.schur)), (0,))[0])
        return np.asarray(0.5 * (stiffness + stiffness.T))


class HarmonicRing(CutRing, abc.ABC):
    """A ring of equal sectors that takes loads inside sector 0."""

    cut: Ids

    @abc.abstractmethod
    def condense(self, load: Array) -> Array:
        """Return what loads on a sector are worth on its two cuts, lower cut first, shape (2 n, k) -> (4 c, k)."""

    @abc.abstractmethod
    def own(self, load: Array, reading: Array) -> Array:
        """Return what each reading shows under the load of the same column while both cuts are held, shape (k,)."""

    @abc.abstractmethod
    def displacements(self, load: Array, offsets: tuple[int, ...]) -> Array:
        """Return nodal displacements of several sectors, each in its own frame, shape (len(offsets), 2 n, k)."""

    def deflection(self, load: Array, reading: Array) -> Array:
        """Return what each reading shows under the load of the same column, shape (k,).

        Parameters
        ----------
        load, reading : ndarray, shape (2 n, k)
            Nodal forces and weights of nodal displacements, both on ports of sector 0.
        """
        follows = self.cuts(self.condense(load), (0,))[0]
        total: Array = self.own(load, reading) + (self.condense(reading) * follows).sum(axis=0)
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

    def wind_up(self, load: Array) -> tuple[Ids, Array]:
        """Return nodes of a cut and their tangential displacements under loads shared evenly by all sectors.

        Parameters
        ----------
        load : ndarray, shape (2 n, k)
            Nodal forces on one sector, of which each sector takes its part of 1/teeth: harmonic 0 of the loads.

        Returns
        -------
        nodes : ndarray of int, shape (c,)
        displacement : ndarray, shape (c, k)
            Towards growing polar angles [m].
        """
        condensed = self.condense(load)
        size = len(condensed) // 2
        loads = np.repeat((condensed[:size] + condensed[size:])[None], len(self.phase), axis=0).astype(complex)
        return self.cut, self.respond(loads)[0, size // 2 :].real / self.teeth
