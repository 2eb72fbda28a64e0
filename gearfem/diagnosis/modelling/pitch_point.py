"""How tooth friction turns round at the pitch point: where and over which way is more than anyone knows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.foundation import Array

# Coefficient of friction whose whole step the samples beside the pitch point may be off by, at one deviation.
COEFFICIENT = 0.1
# Part of the largest change within a sample from which on one counts as the step.
STEP = 0.5
# Half the way over which friction may turn round, in base pitches: traction of an oil film grows with sliding up to 2 to 10 % of the
# rolling velocity, which flanks of usual pairs reach 2 to 8 % of a base pitch beside the pitch point. What lies between is a sum of both,
# to a seventh.
WAYS = (0.02, 0.08)


def turns_round(record: Measurement) -> bool:
    """Return whether a record shows the step of friction at the pitch point: motions round it, and teeth yield the same on both sides."""
    return record.quantity.name == "static_transmission_error"


def sooner_or_later(rubbing: Array) -> Array:
    """Return what a record would show if friction turned round one sample earlier, and one later, than the model has it.

    Coulomb's friction jumps at the pitch point, and the sample beside it lies on one side or the other by a trifle of the zero of the
    angle: 0.4 micrometres of transmission error, and a hundred in the objective.

    Parameters
    ----------
    rubbing : ndarray, shape (n,)
        What friction does to the record, per unit of its coefficient [SI].

    Returns
    -------
    ndarray, shape (n, 2)
        [SI]; see `COEFFICIENT`.
    """
    at, jump = _jumps(rubbing)
    turned = np.zeros((len(rubbing), 2))
    turned[at, 0], turned[at + 1, 1] = jump, -jump
    return turned


def gradually(record: Measurement, pair: GearPair, rubbing: Array) -> Array:
    """Return what a record would show if friction turned round over some way, like a hyperbolic tangent, in place of at once.

    Parameters
    ----------
    record : Measurement
        Any; others than slow transmission errors do not show it.
    pair : GearPair
        The gears.
    rubbing : ndarray, shape (n,)
        What friction does to the record, per unit of its coefficient [SI].

    Returns
    -------
    ndarray, shape (n, w)
        The change by each of `WAYS` [SI]; see `COEFFICIENT`.
    """
    if not turns_round(record):
        return np.zeros((len(rubbing), len(WAYS)))
    at, jump = _jumps(rubbing)
    beside = (record.axis[:, None] - (record.axis[at] + record.axis[at + 1]) / 2.0) / pair.pinion.pitch_angle
    return np.column_stack([(np.tanh(beside / way) - np.sign(beside)) @ jump / 2.0 for way in WAYS])


def _jumps(rubbing: Array) -> tuple[NDArray[np.intp], Array]:
    """Return after which samples friction turns round, and by how much `COEFFICIENT` changes what is read.

    Where pairs hand over it changes too, though not as suddenly: that is no part of it.
    """
    change = np.diff(rubbing)
    at = np.flatnonzero(np.abs(change) > STEP * np.abs(change).max(initial=0.0))
    return at, COEFFICIENT * change[at]
