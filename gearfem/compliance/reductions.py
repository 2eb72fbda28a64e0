"""Supports of a section as the unknowns that they leave: the tooth alone, and each harmonic of a ring of sectors."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from gearfem.compliance.section_mesh import SectionMesh


@dataclasses.dataclass(frozen=True)
class Reduction:
    """Unknowns of a supported section: nodal values are these matrices times the unknowns.

    Parameters
    ----------
    plane : csr_matrix, shape (2 n, p)
        Of displacements in the section, x components first.
    across : csr_matrix, shape (n, q)
        Of displacements along the face width.
    weight : float
        What the real part of its solution counts in the sum over all reductions.
    """

    plane: Any
    across: Any
    weight: float


def alone(nodes: int, held: NDArray[np.int64]) -> Reduction:
    """Return the reduction of a section without neighbours: its nodes that are not held."""
    free = np.setdiff1d(np.arange(nodes), held)
    across = sparse.eye_array(nodes, format="csc")[:, free].tocsr()
    return Reduction(sparse.block_diag([across, across], format="csr"), across, 1.0)


def harmonics(section: SectionMesh, teeth: int) -> Iterator[Reduction]:
    """Yield the reductions of a ring of equal sectors, loaded on one of them: one for each harmonic.

    Notes
    -----
    In harmonic n each sector does what the one before it does, turned by 2 pi / teeth and times exp(2 pi i n / teeth), so
    the upper cut of the sector follows its lower one. A load on one sector is the mean of all harmonics with the same load;
    harmonics n and -n are complex conjugates. Exact, as in `Ring`.
    """
    nodes, half = section.mesh.doflocs.shape[1], np.pi / teeth
    kept = ~np.isin(section.upper, section.held)
    lower, upper = section.lower[kept], section.upper[kept]
    inner = np.setdiff1d(np.arange(nodes), np.concatenate([lower, upper, section.held]))
    one = sparse.eye_array(nodes, format="csc")
    own, low, high = one[:, inner], one[:, lower], one[:, upper]
    for number in range(teeth // 2 + 1):
        real = number in (0, teeth / 2)
        phase = (-1.0) ** (number > 0) if real else np.exp(2j * number * half)
        # Columns of the cuts are radial and tangential displacements.
        radial = [low * np.cos(half) + high * (phase * np.cos(half)), low * -np.sin(half) + high * (phase * np.sin(half))]
        plane = sparse.block_array([[own, None, radial[0], -radial[1]], [None, own, radial[1], radial[0]]], format="csr")
        yield Reduction(plane, sparse.hstack([own, low + high * phase], format="csr"), (1.0 if real else 2.0) / teeth)
