"""The nuisances that were fitted to measurements, in SI."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.foundation import Array, Record

# Bounds of scales of which each fit takes a part.
COUPLING_SCALE, TIP_EDGE_SCALE = (0.0, 3.0), (0.01, 3.0)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Calibration(Record):
    """What a fit found wrong in a model beside its effects.

    Parameters
    ----------
    stiffness_scale : float
        True stiffness of teeth, bodies and contact over the computed one.
    torque_scale : float
        True torques over stated ones.
    inertia_scale, damping_scale : float
        True inertias on the two gears, and true damping ratio, over those of model and effects.
    gain : float
        Readings of angle series, accelerations and stiffness over true values.
    series_compliance : float
        Compliance along the line of action that the model misses, in series with all pairs [m/N]; negative where it has too much.
    coupling_scale : float
        What neighbour teeth feel through the bodies, true over computed; the rest is the loaded tooth's own deflection.
    tip_edge_scale : float
        Radius of the tip edges, true over that of the model.
    contact_scale, body_scale, depth_scale : float
        Compliance of the contact and of the gear bodies, and depth down to which the contact yields, true over those of model and effects.
    evenness : float
        How far contact over tip edges yields as on flanks that go on past them, from 0 to 1.
    friction : float
        Coefficient of tooth friction beside that of model and effects.
    misalignment, centre_distance : float
        By how much the gap opens over the face width, and the gears stand farther apart, than model and effects say [m].
    angle_offset : float
        Pinion angle of the model at which measured angles are 0 [rad].
    pinion_late, wheel_late : ndarray, shapes (z1,), (z2,) or (0,)
        Index errors along the line of action [m], positive late; empty: none.
    offsets : tuple of (str, float)
        Files of records and the constants in them [m].
    firsts : tuple of (str, int)
        Files of records over the teeth of a gear and the teeth that they begin with, where they do not begin with tooth 0.
    kicks : tuple of (str, (float, float))
        Files of records of motions that do not begin as the slow engagement, and how they do, see `gearfem.dynamics.turns.march_turns`.
    """

    stiffness_scale: float = 1.0
    torque_scale: float = 1.0
    inertia_scale: float = 1.0
    damping_scale: float = 1.0
    gain: float = 1.0
    series_compliance: float = 0.0
    coupling_scale: float = 1.0
    tip_edge_scale: float = 1.0
    contact_scale: float = 1.0
    body_scale: float = 1.0
    depth_scale: float = 1.0
    evenness: float = 0.0
    friction: float = 0.0
    misalignment: float = 0.0
    centre_distance: float = 0.0
    angle_offset: float = 0.0
    pinion_late: Array = dataclasses.field(default_factory=lambda: np.zeros(0))
    wheel_late: Array = dataclasses.field(default_factory=lambda: np.zeros(0))
    offsets: tuple[tuple[str, float], ...] = ()
    firsts: tuple[tuple[str, int], ...] = ()
    kicks: tuple[tuple[str, tuple[float, float]], ...] = ()

    def offset(self, file: str) -> float:
        """Return the constant in a record [m], 0 where none was fitted."""
        return dict(self.offsets).get(file, 0.0)

    def first_tooth(self, file: str) -> int:
        """Return the tooth that a record over the teeth of a gear begins with."""
        return dict(self.firsts).get(file, 0)

    def kick(self, file: str) -> tuple[float, float]:
        """Return how the motion of a record begins beside the slow engagement."""
        return dict(self.kicks).get(file, (0.0, 0.0))
