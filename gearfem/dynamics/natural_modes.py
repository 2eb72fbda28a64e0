"""Natural modes of a drive train with its teeth in contact at their mean stiffness."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy.linalg import eigh

from gearfem.dynamics.record import DriveTrain
from gearfem.dynamics.shafting import Shafting
from gearfem.engagement.record import MeshForce
from gearfem.foundation import Array, Record

# Below this part of the highest natural frequency a mode is the common rotation, 0 but for rounding.
ROTATION = 1e-6


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Modes(Record):
    """Modes of n coordinates, in order of frequency; the first is the common rotation.

    Parameters
    ----------
    frequency : ndarray, shape (n,)
        Natural frequencies without damping [Hz].
    damping_ratio : ndarray, shape (n,)
        Part of critical damping of each mode, its coupling to the others left out; 0 for the rotation.
    names : tuple of str
        Coordinates: pinion and its chain, wheel and its chain [rad], then displacements on yielding supports [m].
    shape : ndarray, shape (n, n)
        Columns are modes, of unit modal mass [1/(kg^0.5 m) for angles, 1/kg^0.5 for displacements].
    mesh_share : ndarray, shape (n,)
        Share of the teeth in the elastic energy of each mode: near 1 for a mesh mode, near 0 for one of the shafts.
    """

    frequency: Array
    damping_ratio: Array
    names: tuple[str, ...]
    shape: Array
    mesh_share: Array


def modes(drive: DriveTrain, mesh: MeshForce) -> Modes:
    """Return the natural modes of a drive train whose teeth stay in contact.

    Parameters
    ----------
    drive : DriveTrain
        Inertias, shafts, supports and damping; friction is left out.
    mesh : MeshForce
        Mean stiffness and base radii.

    Returns
    -------
    Modes

    Notes
    -----
    (Z^T k Z + C g g^T) v = omega^2 m v, Z the stretches of shafts and supports, C the mean stiffness of the mesh and g the
    approach of the flanks per coordinate. Two inertias have omega = sqrt(C/M).

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> drive = DriveTrain(pinion_inertia=0.02, wheel_inertia=0.02, pinion_torque=10.0, wheel_torque=10.0,
    ...     efficiency=1.0, pinion_speed=50.0, friction_coefficient=0.0, damping_ratio=0.05)
    >>> found = modes(drive, SimpleNamespace(base_radius1=0.1, base_radius2=0.1, mean_stiffness=4e8))
    >>> (2 * np.pi * found.frequency).round(6).tolist(), found.damping_ratio.round(9).tolist()
    ([0.0, 20000.0], [0.0, 0.05])
    """
    train = Shafting(drive)
    r1, r2 = mesh.base_radius1, mesh.base_radius2
    approach = train.depth_row(r1, r2)
    mass1, mass2 = drive.pinion_inertia / r1**2, drive.wheel_inertia / r2**2
    teeth = 2.0 * drive.damping_ratio * math.sqrt(mesh.mean_stiffness * mass1 * mass2 / (mass1 + mass2))
    shafts = train.stretches.T @ (train.springs[:, None] * train.stretches)
    damping = train.stretches.T @ (train.dampers[:, None] * train.stretches) + teeth * np.outer(approach, approach)
    squares, shape = eigh(shafts + mesh.mean_stiffness * np.outer(approach, approach), np.diag(train.masses))
    omega = np.sqrt(np.maximum(squares, 0.0))
    turning = omega < ROTATION * omega[-1]
    omega[turning] = 0.0
    whole = np.where(turning, 1.0, omega**2)
    return Modes(
        frequency=omega / (2.0 * math.pi),
        damping_ratio=np.where(turning, 0.0, np.einsum("im,ij,jm->m", shape, damping, shape) / (2.0 * np.sqrt(whole))),
        names=train.names,
        shape=shape,
        mesh_share=np.where(turning, 0.0, mesh.mean_stiffness * (approach @ shape) ** 2 / whole),
    )
