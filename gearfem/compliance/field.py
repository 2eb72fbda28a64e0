"""Displacement and stress over a loaded tooth and its neighbours, for pictures."""

from __future__ import annotations

import dataclasses

import numpy as np
import skfem
from numpy.typing import NDArray

from gearfem.compliance.elasticity import ELEMENT, Plane, von_mises
from gearfem.compliance.load_lines import LoadLines
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.flank import Outline
from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Field(Record):
    """Displacement and stress of a loaded tooth and of sectors on each side of it.

    Parameters
    ----------
    nodes, displacement : ndarray, shape (n, 2)
        Places and displacements in the frame of the loaded tooth [m].
    quads : ndarray of int, shape (m, 9)
        Nodes of biquadratic elements in VTK's order (cell type 28): corners, mid-sides, centre.
    von_mises : ndarray, shape (n,)
        Von Mises stress, averaged at the nodes [Pa].
    load_point, load_direction : ndarray, shape (2,)
        Where the line load acts [m] and its unit vector.
    force_per_width : float
        The line load [N/m].
    """

    nodes: Array
    quads: NDArray[np.int64]
    displacement: Array
    von_mises: Array
    load_point: Array
    load_direction: Array
    force_per_width: float


def make_field(section: SectionMesh, moved: Array, outline: Outline, plane: Plane, line: LoadLines, force_per_width: float) -> Field:
    """Join the displacements of adjoining sectors into one field.

    Parameters
    ----------
    section : SectionMesh
        Mesh of one sector with n nodes.
    moved : ndarray, shape (2 k + 1, 2 n)
        Displacements of sectors -k ... k, each in its own frame, x components first [m].
    outline, plane : Outline, Plane
        Of the solution.
    line : LoadLines
        The one load line.
    force_per_width : float
        The line load [N/m].

    Returns
    -------
    Field
        Sectors share the nodes of their cuts.
    """
    mesh, count = section.mesh, section.mesh.doflocs.shape[1]
    beside = len(moved) // 2
    own = np.asarray(skfem.Dofs(mesh, ELEMENT).element_dofs, dtype=np.int64).T
    nodes, displacement, stress, quads = [], [], [], []
    number = np.arange(count)
    for place, offset in enumerate(range(-beside, beside + 1)):
        vector = moved[place].reshape(2, count).T
        angle = offset * outline.gear.pitch_angle
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        nodes.append(mesh.doflocs.T @ turn)
        displacement.append(vector @ turn)
        stress.append(von_mises(mesh, plane, outline.gear.material, vector))
        previous, number = number, np.arange(count) + place * count
        if place:
            number[section.lower] = previous[section.upper]
        quads.append(number[own])
    used, cells = np.unique(np.concatenate(quads), return_inverse=True)
    return Field(
        nodes=np.concatenate(nodes)[used],
        quads=cells.reshape(-1, 9),
        displacement=np.concatenate(displacement)[used],
        von_mises=np.concatenate(stress)[used],
        load_point=line.point[0],
        load_direction=line.direction[0],
        force_per_width=float(force_per_width),
    )
