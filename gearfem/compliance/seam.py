"""A sector with a seam that is closed or open, condensed to what sees the difference."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import skfem
from scipy.optimize import nnls

from gearfem.compliance.crack_mesh import CrackedSection
from gearfem.compliance.dissection import Trailing, dissect
from gearfem.compliance.elasticity import ELEMENT, QUADRATURE, Plane, assemble
from gearfem.compliance.harmonic_ring import CutRing
from gearfem.compliance.load_lines import LoadLines, forces
from gearfem.compliance.uneven_ring import polar_of_cuts
from gearfem.definition.setup import Material
from gearfem.foundation import Array


class Seam:
    """A sector with a seam, condensed to what sees the crack.

    Parameters
    ----------
    section : CrackedSection
        The sector.
    plane : Plane
        Plane strain or plane stress.
    material : Material
        Isotropic material.
    teeth : int
        Number of sectors of the whole gear.
    lines : LoadLines
        Loads on the described side, above the seam.

    Notes
    -----
    One factorisation with the seam open leaves the nodes under load, both sides of the seam and the cuts; closing it ties its
    sides in the dense remainder, so that the difference of both states keeps its digits.
    """

    def __init__(self, section: CrackedSection, plane: Plane, material: Material, teeth: int, lines: LoadLines) -> None:
        nodes, copies = section.mesh.doflocs.shape[1], len(section.seam)
        total = nodes + copies
        load = forces(section, lines)
        used = np.setdiff1d(np.flatnonzero(load.any(axis=1).reshape(2, nodes).any(axis=0)), section.seam)
        cuts = [cut[~np.isin(cut, section.held)] for cut in (section.lower, section.upper)]
        tail = np.concatenate([used, section.seam, nodes + np.arange(copies), *cuts])
        order = dissect(section.mesh)
        order = np.concatenate([order[~np.isin(order, np.concatenate([tail, section.held]))], tail])
        unknowns = np.stack([order, order + total], axis=1).ravel()
        matrix = _stiffness(section, plane.lame(material), total)
        seen = Trailing(matrix[unknowns][:, unknowns], 0, 2 * len(tail)).schur

        self.cuts = slice(2 * len(tail) - 4 * len(cuts[0]), None)
        turn = np.eye(2 * len(tail))
        turn[self.cuts, self.cuts] = polar_of_cuts(len(cuts[0]), np.pi / teeth)
        self.open: Array = turn.T @ seen @ turn
        self.load = np.zeros((2 * len(tail), load.shape[1]))
        taken = tail[: len(used) + copies]
        self.load[: 2 * len(taken)] = load[np.stack([taken, taken + nodes], axis=1).ravel()]
        first = 2 * len(used) + np.arange(2 * copies)
        self._tie = np.eye(2 * len(tail))
        self._tie[first + 2 * copies, first] = 1.0
        self._tie = np.delete(self._tie, first + 2 * copies, axis=1)
        # The seam runs across the tooth's axis: above it lies the tooth, and the gap opens along x.
        self._gap = np.zeros((2 * len(tail), copies))
        self._gap[first[::2], np.arange(copies)] = 1.0
        self._gap[first[::2] + 2 * copies, np.arange(copies)] = -1.0

    @cached_property
    def _closed(self) -> tuple[Array, Array]:
        """Stiffness seen at the cuts and what the loads are worth there, the seam closed, lower cut first."""
        stiffness, load = self._tie.T @ self.open @ self._tie, self._tie.T @ self.load
        size = len(stiffness) - len(self.open) + self.cuts.start
        inner = np.linalg.solve(stiffness[:size, :size], np.hstack([stiffness[:size, size:], load[:size]]))
        through = stiffness[size:, :size] @ inner
        width = len(stiffness) - size
        return stiffness[size:, size:] - through[:, :width], load[size:] - through[:, width:]

    @property
    def schur(self) -> Array:
        """Stiffness of the sector with its seam closed, seen at the two cuts, lower cut first, shape (4 c, 4 c)."""
        return self._closed[0]

    def increments(self, ring: CutRing, offsets: tuple[int, ...]) -> tuple[Array, Array]:
        """Return what the crack adds to the displacements of the loads, each along itself and along those of other teeth.

        Parameters
        ----------
        ring : CutRing
            The sound ring, its cuts divided as those of this sector.
        offsets : tuple of int
            Numbers of the other teeth, 0 excluded.

        Returns
        -------
        own : ndarray, shape (k,)
            [m per N/m].
        others : ndarray, shape (len(offsets), k, k)
            Along load i of the other tooth under load j of this one [m per N/m].
        """
        matrix = self.open.copy()
        matrix[self.cuts, self.cuts] += ring.whole - ring.schur
        moved, apart = np.split(np.linalg.solve(matrix, np.hstack([self.load, self._gap])), [self.load.shape[1]], axis=1)
        moved += apart @ pressed(self._gap.T @ apart, self._gap.T @ moved)
        moved -= self._tie @ np.linalg.solve(self._tie.T @ matrix @ self._tie, self._tie.T @ self.load)
        own: Array = (self.load * moved).sum(axis=0)
        return own, self._closed[1].T @ ring.cuts(ring.whole @ moved[self.cuts], offsets)


def pressed(compliance: Array, gap: Array) -> Array:
    """Return the forces that keep gaps from closing and pull nowhere, shape (s, k).

    Parameters
    ----------
    compliance : ndarray, shape (s, s)
        Gaps that the forces open.
    gap : ndarray, shape (s, k)
        Gaps without them, negative where surfaces overlap.

    Notes
    -----
    f >= 0, g = A f + b >= 0, f g = 0 is the least of f'Af/2 + b'f over f >= 0: with A = R'R, of |R f + inv(R')b|.
    """
    root = np.linalg.cholesky(0.5 * (compliance + compliance.T)).T
    aim = -np.linalg.solve(root.T, gap)
    force = np.zeros_like(gap)
    for case in np.flatnonzero((gap < 0.0).any(axis=0)):
        force[:, case] = nnls(root, aim[:, case])[0]
    return force


def _stiffness(section: CrackedSection, lame: tuple[float, float], nodes: int) -> Any:
    basis = skfem.CellBasis(section.mesh, ELEMENT, quadrature=QUADRATURE)
    grad = np.stack([shape[0].grad for shape in basis.basis]).transpose(1, 2, 0, 3)
    return assemble(grad, basis.dx, section.open_cells, nodes, lame)
