"""Rings of sectors whose sides differ, and rings in which one sector differs from the others."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from gearfem.compliance.dissection import Trailing, dissect
from gearfem.compliance.harmonic_ring import HarmonicRing
from gearfem.compliance.patchwork import Ids
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.foundation import Array


class Sector:
    """One sector held on its bore, condensed to its two cuts, without any symmetry.

    Parameters
    ----------
    section : SectionMesh
        The sector.
    stiffness : csc_matrix, shape (2 n, 2 n)
        Its stiffness matrix, x displacements first [Pa].
    teeth : int
        Number of sectors of the whole gear.
    ports : ndarray of int, optional
        Nodes that take loads or are read; by default those of outline and centreline.
    """

    def __init__(self, section: SectionMesh, stiffness: Any, teeth: int, ports: Ids | None = None) -> None:
        nodes = section.mesh.doflocs.shape[1]
        self.nodes = nodes
        lower, upper = (cut[~np.isin(cut, section.held)] for cut in (section.lower, section.upper))
        self.cut = upper
        both = np.concatenate([lower, upper])
        wanted = np.concatenate([section.outline, section.centreline]) if ports is None else ports
        ports = np.setdiff1d(wanted, np.concatenate([both, section.held]))
        closed = np.setdiff1d(np.arange(nodes), ports)
        self._closed = np.concatenate([closed, closed + nodes])
        order = dissect(section.mesh)
        inner = order[~np.isin(order, np.concatenate([ports, both, section.held]))]
        order = np.concatenate([inner, ports, both])
        self._unknowns = np.stack([order, order + nodes], axis=1).ravel()
        self._ports = self._unknowns[2 * len(inner) : len(self._unknowns) - 2 * len(both)]
        self.factors = Trailing(stiffness[self._unknowns][:, self._unknowns], 2 * len(ports), 2 * len(both))
        self._polar = polar_of_cuts(len(upper), np.pi / teeth)

    @cached_property
    def schur(self) -> Array:
        """Stiffness seen at the two cuts, lower cut first, shape (4 c, 4 c)."""
        seen: Array = self._polar.T @ self.factors.schur @ self._polar
        return seen

    def condense(self, load: Array) -> Array:
        """Return what loads are worth on the two cuts, lower cut first, shape (2 n, k) -> (4 c, k)."""
        if np.count_nonzero(load[self._closed]):
            raise ValueError("loads and readings belong on the ports of the ring")
        worth: Array = self._polar.T @ self.factors.forward(load[self._ports])[1]
        return worth

    def own(self, load: Array, reading: Array) -> Array:
        """Return what each reading shows under the load of the same column while both cuts are held, shape (k,)."""
        shown: Array = (self.factors.forward(load[self._ports])[0] * self.factors.forward(reading[self._ports])[0]).sum(axis=0)
        return shown

    def displacements(self, load: Array, cuts: Array) -> Array:
        """Return nodal displacements under loads while the cuts move as given, shape (2 n, k)."""
        force = load[self._unknowns]
        # What the neighbours put on the cuts is what remains of their stiffness after the loads.
        force[len(force) - len(cuts) :] += self._polar @ (self.schur @ cuts - self.condense(load))
        result = np.zeros_like(load)
        result[self._unknowns] = self.factors.solve(force)
        return result


def polar_of_cuts(nodes: int, angle: float) -> Array:
    """Return x and y, node by node, of radial and tangential displacements of the lower and the upper cut."""
    result = np.zeros((2, 2 * nodes, 2, 2 * nodes))
    for side, at in ((0, -angle), (1, angle)):
        turn = np.array([[np.cos(at), -np.sin(at)], [np.sin(at), np.cos(at)]])
        result[side, :, side] = np.kron(turn, np.eye(nodes)).reshape(2, nodes, 2 * nodes).swapaxes(0, 1).reshape(2 * nodes, 2 * nodes)
    return result.reshape(4 * nodes, 4 * nodes)


class UnevenRing(HarmonicRing):
    """The ring of `teeth` equal sectors whose two sides need not be mirror images, held on the bore, loaded on one of them.

    Parameters
    ----------
    sector : Sector
        The sector, condensed.
    teeth : int
        Number of sectors.
    """

    def __init__(self, sector: Sector, teeth: int) -> None:
        super().__init__(sector.schur, teeth)
        self.sector, self.cut = sector, sector.cut

    def condense(self, load: Array) -> Array:
        """Return what loads on a sector are worth on its two cuts, lower cut first, shape (2 n, k) -> (4 c, k)."""
        return self.sector.condense(load)

    def own(self, load: Array, reading: Array) -> Array:
        """Return what each reading shows under the load of the same column while both cuts are held, shape (k,)."""
        return self.sector.own(load, reading)

    def displacements(self, load: Array, offsets: tuple[int, ...]) -> Array:
        """Return nodal displacements of several sectors, each in its own frame, shape (len(offsets), 2 n, k)."""
        moved = zip(offsets, self.cuts(self.condense(load), offsets), strict=True)
        return np.stack([self.sector.displacements(load if o % self.teeth == 0 else np.zeros_like(load), cuts) for o, cuts in moved])


class OddSector:
    """One sector that differs, in a ring of sectors that are all equal but for it.

    Parameters
    ----------
    ring : HarmonicRing
        The ring, in which the sector takes the place of number 0.
    sector : Sector
        The sector, its cuts divided as those of the ring.

    Notes
    -----
    With the stiffness W of the whole ring on the two cuts, the ring without its own sector has the stiffness
    O = W - S on them: O + S' with the odd sector's S' carries its loads. The other sectors move as in the whole ring
    under W v, v being the displacements of the two cuts. Exact up to rounding; derived here.
    """

    def __init__(self, ring: HarmonicRing, sector: Sector) -> None:
        self._ring, self._sector = ring, sector
        self._stiffness = ring.whole - ring.schur + sector.schur

    def _cuts(self, load: Array) -> Array:
        return np.asarray(np.linalg.solve(self._stiffness, self._sector.condense(load)))

    def deflection(self, load: Array, reading: Array) -> Array:
        """Return what each reading shows under the load of the same column, both on the odd sector, shape (k,)."""
        total: Array = self._sector.own(load, reading) + (self._sector.condense(reading) * self._cuts(load)).sum(axis=0)
        return total

    def displacements(self, load: Array, offsets: tuple[int, ...] = (0,)) -> Array:
        """Return the nodal displacements of the odd sector, shape (1, 2 n, k)."""
        if offsets != (0,):
            raise ValueError(f"displacements of the odd sector alone, not of {offsets}")
        return self._sector.displacements(load, self._cuts(load))[None]

    def coupling(self, load: Array, reading: Array, offsets: tuple[int, ...]) -> Array:
        """Return what readings of other sectors show under the loads on the odd one.

        Parameters
        ----------
        load : ndarray, shape (2 n, k)
            Nodal forces on the odd sector.
        reading : ndarray, shape (2 m, i)
            Weights of nodal displacements in the frame of an equal sector.
        offsets : tuple of int
            Numbers of the other sectors, 0 excluded.

        Returns
        -------
        ndarray, shape (len(offsets), i, k)
        """
        table: Array = self._ring.condense(reading).T @ self._ring.cuts(self._ring.whole @ self._cuts(load), offsets)
        return table
