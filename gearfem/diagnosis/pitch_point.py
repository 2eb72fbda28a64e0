"""Where tooth friction turns round: within which sample of a record is more than anyone knows."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.diagnosis.bench import Settings
from gearfem.diagnosis.measurement import Measurement
from gearfem.diagnosis.problem import BenchOf
from gearfem.effects.friction import Friction
from gearfem.foundation import Array

# Coefficient of friction whose whole step the samples beside the pitch point may be off by, at one deviation.
COEFFICIENT = 0.1
# Part of the largest change within a sample from which on one counts as the step.
STEP = 0.5


def turned_round(record: Measurement, bench: BenchOf, settings: Settings) -> Array:
    """Return what a slow record would show if friction turned round one sample earlier, and one later, than the model has it.

    Coulomb's friction jumps at the pitch point, and the sample beside it lies on one side or the other by a trifle of the zero of the
    angle: 0.4 micrometres of transmission error, and a hundred in the objective. In oil the step is rounded anyway.

    Parameters
    ----------
    record : Measurement
        Slow, over the pinion angle.
    bench : callable
        Makes the model with effects.
    settings : Settings
        Where it stands.

    Returns
    -------
    ndarray, shape (n, 2)
        [SI]; see `COEFFICIENT`.
    """
    step = float(np.median(np.diff(record.axis)))
    rubbing, smooth = (bench((Friction(coefficient=much),)) for much in (COEFFICIENT, 0.0))

    def of_friction(shift: float) -> Array:
        there = dataclasses.replace(record, axis=record.axis + shift)
        return rubbing.predict(there, settings) - smooth.predict(there, settings)

    before, here, after = (of_friction(shift) for shift in (-step, 0.0, step))
    turned = np.column_stack([after - here, here - before])
    # Where pairs hand over friction changes too, though not as suddenly: that is no part of it.
    return np.where(np.abs(turned) > STEP * np.abs(turned).max(axis=0), turned, 0.0)
