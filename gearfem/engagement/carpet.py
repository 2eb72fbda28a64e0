"""Transmission error over torque and angle."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.engagement.engage import Mesh, largest_torque
from gearfem.engagement.sharing import share_torque
from gearfem.foundation import Array, Record
from gearfem.foundation.progress import Progress, quiet

TORQUES, ABOVE = 25, 1.5


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Carpet(Record):
    """Transmission error at many torques.

    Parameters
    ----------
    pinion_angle : ndarray, shape (n,)
        Angles [rad].
    pinion_torque : ndarray, shape (t,)
        Increasing torques, from 0 [N m].
    transmission_error : ndarray, shape (t, n)
        Lag of the wheel along the line of action [m]; at torque 0 that of the first touch.
    pairs_in_contact : ndarray of int, shape (t, n)
        Number of pairs that carry; 0 at torque 0.
    """

    pinion_angle: Array
    pinion_torque: Array
    transmission_error: Array
    pairs_in_contact: Array


def error_carpet(mesh: Mesh, pinion_angle: Array, torque: float, progress: Progress = quiet) -> Carpet:
    """Return the transmission error from no torque to half as much again as a given one.

    Parameters
    ----------
    mesh : Mesh
        Flanks, placement, compliance and contact law.
    pinion_angle : ndarray, shape (n,)
        Angles [rad].
    torque : float
        Torque on the pinion [N m]; the carpet ends lower where the teeth would move by a twentieth of the module.
    progress : Progress
        Told after each torque.

    Returns
    -------
    Carpet

    Raises
    ------
    SolveError
        If any angle does not converge.
    """
    contacts = mesh.touching(mesh.contacts(np.asarray(pinion_angle, float)))
    system = mesh.system(contacts, ABOVE * torque)
    unloaded = system.gap.min(axis=1)
    operating = share_torque(system, mesh.law, torque).transmission_error - unloaded
    top = min(ABOVE * torque, largest_torque(mesh, torque, float(operating.max())))
    torques = np.linspace(0.0, top, TORQUES)
    errors, pairs = [unloaded], [np.zeros(len(unloaded))]
    for number, one in enumerate(torques[1:], start=1):
        progress("carpet of the transmission error", number - 1, TORQUES - 1)
        shared = share_torque(system, mesh.law, float(one))
        errors.append(shared.transmission_error)
        pairs.append(contacts.count_pairs(shared.force > 0.0).astype(float))
    progress("carpet of the transmission error", TORQUES - 1, TORQUES - 1)
    return Carpet(
        pinion_angle=contacts.pinion_angle,
        pinion_torque=torques,
        transmission_error=np.array(errors),
        pairs_in_contact=np.array(pairs),
    )
