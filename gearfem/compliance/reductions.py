"""Supports of a section as the unknowns that they leave: the tooth alone, and each harmonic of a ring of sectors."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.interpolate import CubicSpline

from gearfem.compliance.patchwork import mirror_images
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.foundation import Array

# Harmonics up to which all are kept where some stand for all, and the ratio of those beyond.
EVERY, APART = 4, 1.4


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
    real : bool
        Whether the unknowns see real matrices.
    """

    plane: Any
    across: Any
    weight: float
    real: bool


def alone(nodes: int, held: NDArray[np.int64]) -> Reduction:
    """Return the reduction of a section without neighbours: its nodes that are not held."""
    free = np.setdiff1d(np.arange(nodes), held)
    across = sparse.eye_array(nodes, format="csc")[:, free].tocsr()
    return Reduction(sparse.block_diag([across, across], format="csr"), across, 1.0, True)


def harmonics(section: SectionMesh, teeth: int, sparing: bool = False) -> Iterator[Reduction]:
    """Yield the reductions of a ring of equal sectors, loaded on one of them: one for each harmonic, or for some of them.

    Parameters
    ----------
    section : SectionMesh
        The sector, with its two cuts.
    teeth : int
        Number of sectors.
    sparing : bool
        Whether some harmonics stand for all, see `chosen`.

    Notes
    -----
    In harmonic n each sector does what the one before it does, turned by 2 pi / teeth and times exp(2 pi i n / teeth), so
    the upper cut of the sector follows its lower one. A load on one sector is the mean of all harmonics with the same load;
    harmonics n and -n are complex conjugates. Exact, as in `Ring`.

    The mirror image of a harmonic on a symmetric sector is its complex conjugate. Unknowns that are their own conjugated images
    (sums of two nodes, i times differences, the reverse for displacements across the mirror) see real matrices. Derived here.
    """
    nodes, half, symmetric = section.mesh.doflocs.shape[1], np.pi / teeth, section.symmetric
    kept = ~np.isin(section.upper, section.held)
    lower, upper = section.lower[kept], section.upper[kept]
    inner = np.setdiff1d(np.arange(nodes), np.concatenate([lower, upper, section.held]))
    one = sparse.eye_array(nodes, format="csc")
    own, low, high = _images(section, inner) if symmetric else one[:, inner], one[:, lower], one[:, upper]
    beside = 1j if symmetric else 1.0
    for number, weight in zip(*chosen(teeth, sparing), strict=True):
        angle = 2.0 * number * half
        first, last = (np.exp(-0.5j * angle), np.exp(0.5j * angle)) if symmetric else (1.0, np.exp(1j * angle))
        # Columns of the cuts are radial and tangential displacements.
        cosine = low * (first * np.cos(half)) + high * (last * np.cos(half))
        sine = low * (-first * np.sin(half)) + high * (last * np.sin(half))
        plane = sparse.block_array([[own, None, cosine, -beside * sine], [None, beside * own, sine, beside * cosine]], format="csr")
        yield Reduction(plane, sparse.hstack([own, low * first + high * last], format="csr"), weight, symmetric or number == 0)


def _images(section: SectionMesh, inner: NDArray[np.int64]) -> Any:
    """Return sums of inner nodes and their mirror images, and i times their differences, as columns."""
    image = mirror_images(section.mesh.doflocs)[inner]
    one = sparse.eye_array(section.mesh.doflocs.shape[1], format="csc")
    axis, above = inner == image, inner > image
    here, there = one[:, inner[above]], one[:, image[above]]
    return sparse.hstack([one[:, inner[axis]], np.sqrt(0.5) * (here + there), 1j * np.sqrt(0.5) * (here - there)], format="csc")


def chosen(teeth: int, sparing: bool = False) -> tuple[NDArray[np.int64], Array]:
    """Return numbers of harmonics and their weights in the mean over all harmonics of a ring.

    Parameters
    ----------
    teeth : int
        Number of sectors.
    sparing : bool
        Whether the others are read off a cubic spline through these, over log(1 + n).

    Returns
    -------
    number : ndarray of int, shape (k,)
    weight : ndarray, shape (k,)

    Notes
    -----
    A disc on its bore yields most in its first harmonics, 1 to 3, beyond which the response falls smoothly: up to the fourth all
    are kept, then each about 1.4 times the one before. Of what is uneven over the width in the influence of slices, that misses
    2e-4 on a gear of 20 teeth and 1e-4 on one of 51, held at a half and at three tenths of their root radii.

    Examples
    --------
    >>> chosen(51, sparing=True)[0].tolist()
    [0, 1, 2, 3, 4, 5, 7, 10, 14, 18, 25]
    """
    number = np.arange(teeth // 2 + 1)
    weight = np.where((number == 0) | (2 * number == teeth), 1.0, 2.0) / teeth
    if not sparing or number[-1] <= EVERY + 1:
        return number, weight
    steps = math.ceil(math.log(number[-1] / EVERY) / math.log(APART))
    few = np.unique(np.concatenate([number[:EVERY], np.round(np.geomspace(EVERY, number[-1], steps + 1)).astype(int)]))
    return few, weight @ CubicSpline(np.log1p(few), np.eye(len(few)))(np.log1p(number))
