"""What the damper of the mesh acts on: whether the flanks that bear the load, or those that touch first, is more than anyone knows."""

from __future__ import annotations

import numpy as np

from gearfem.diagnosis.modelling.bench import Bench, Settings
from gearfem.diagnosis.modelling.teeth import Ride
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.foundation import Array


def touched_first(record: Measurement, bench: Bench, settings: Settings, ride: Ride) -> Array:
    """Return what a record of a motion would show more if the damper of the mesh acted on the rate at which the first flanks approach.

    The equation of motion has one deflection and one damper, whatever number of pairs bears the load. In the model the errors of each pair
    come through the damper by its share of the load; in others it is the unloaded transmission error whose rate the damper feels. This
    steps from tooth to tooth where the tip of a late or early one comes into contact: at high speeds accelerations show that as spikes.

    Parameters
    ----------
    record : Measurement
        Of a motion over the angle.
    bench, settings : Bench, Settings
        The model and where it stands.
    ride : Ride
        The motion.

    Returns
    -------
    ndarray, shape (n,)
        Linear about the motion [SI].
    """
    rate = np.gradient(bench.unloaded(ride.angle, record.pinion_torque, settings), ride.step)[:, None]
    return settings.gain * bench.gain * ride.rows(np.zeros_like(rate), rate, record, bench)[:, 0]
