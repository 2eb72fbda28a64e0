"""How the load of each pair lies along the face width, and the face load factor."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.engagement.engage import Mesh
from gearfem.engagement.record import Engagement
from gearfem.engagement.width import path_positions, sliced_pair, with_ends
from gearfem.foundation import Array, Record
from gearfem.foundation.progress import Progress, quiet


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class WidthLoad(Record):
    """Line loads along the face width over the pinion angle.

    Parameters
    ----------
    pinion_angle : ndarray, shape (n,)
        Angles [rad].
    pairs : tuple of int, length p
        Numbers of the pairs.
    place : ndarray, shape (s,)
        Both ends of the face width and the middles of its slices, from mid-face [m].
    line_load : ndarray, shape (n, p, s)
        Line loads there [N/m]; 0 where nothing touches. Those at the ends lie straight on from the two slices before them.
    force : ndarray, shape (n, p)
        Normal force of each pair over the face width [N].
    face_width : float
        Face width [m].
    """

    pinion_angle: Array
    pairs: tuple[int, ...]
    place: Array
    line_load: Array
    force: Array
    face_width: float

    @property
    def face_load_factor(self) -> Array:
        """Largest line load over its mean at each angle, all pairs together: K_Hbeta of ISO 6336-1, shape (n,)."""
        factor: Array = self.line_load.sum(axis=1).max(axis=1) * self.face_width / self.force.sum(axis=1)
        return factor

    @property
    def pair_load_factor(self) -> Array:
        """Largest line load of each pair over its own mean, 0 where it does not touch, shape (n, p)."""
        mean = self.force / self.face_width
        factor: Array = self.line_load.max(axis=2) / np.where(mean > 0.0, mean, 1.0)
        return factor


def load_over_width(mesh: Mesh, engagement: Engagement, progress: Progress = quiet) -> WidthLoad:
    """Return how the forces of an engagement lie along the face width.

    Parameters
    ----------
    mesh : Mesh
        From which the engagement was computed.
    engagement : Engagement
        At any angles.
    progress : Progress
        Told before and after the solid elements, which take some seconds where they are not remembered.

    Returns
    -------
    WidthLoad

    Raises
    ------
    InputError, SolveError
        If solid elements or slices fail.

    Notes
    -----
    Each loaded pair is solved in slices under its force, to 1e-12 of it. Also without a lead the load is not quite even: the ends
    of the face yield more than its middle. K_Hbeta counts the sum over pairs, as the standard's line load does.
    """
    progress("load along the face width", 0, 2)
    contacts, width, slices = engagement.contacts, mesh.placement.pair.face_width, mesh.slices
    row, column = np.nonzero(engagement.force > 0.0)
    path = path_positions(mesh.flanks, mesh.placement)
    position = np.clip(mesh.position(contacts)[row, column], path[0], path[-1])
    pair = sliced_pair(mesh.flanks, mesh.placement, mesh.compliance, slices, path).between(path, position)
    progress("load along the face width", 1, 2)
    gap = slices.gap(mesh.flanks.lead)
    loads, _ = pair.load(mesh.law, engagement.force[row, column] / width, gap - gap.min())
    line_load = np.zeros((*engagement.force.shape, slices.count + 2))
    line_load[row, column] = with_ends(loads)
    middles = (np.arange(slices.count) + 0.5) / slices.count - 0.5
    progress("load along the face width", 2, 2)
    return WidthLoad(
        pinion_angle=contacts.pinion_angle,
        pairs=contacts.pairs,
        place=width * np.concatenate([[-0.5], middles, [0.5]]),
        line_load=line_load,
        force=engagement.force,
        face_width=width,
    )
