"""What errors of our own model would do to the records of a campaign."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.modelling.differences import one_sided
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.modelling.teeth import Scatter
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.effects.effect import MEMBERS, Effect
from gearfem.foundation import Array
from gearfem.foundation.units import UM
from gearfem.variants import Variant

# Form errors that all teeth of a gear share, beside the waviness of each: of a sound flank, and as a share of what is missing from it,
# since no relief, wear or slope has quite the shape that its name stands for.
COMMON_FORM, SHAPE = 0.1 * UM, Effect.form
# Step of derivatives over errors of the model, in standard deviations, forward; half a one puts them off by a quarter near resonances.
STEP = 0.02


def error_slope(record: Measurement, bench: SystemBench, settings: Settings, here: Array, errors: tuple[Variant, ...], place: int) -> Array:
    """Return the derivative of a record over an error of the model, at one standard deviation [SI], shape (n,).

    Parameters
    ----------
    record : Measurement
        Any record.
    bench : SystemBench
        The model.
    settings : Settings
        Where it stands.
    here : ndarray, shape (n,)
        What it predicts there.
    errors : tuple of Variant
        Those that are unknown, the first ones of the bench's.
    place : int
        Which of them.

    Raises
    ------
    InputError, SolveError, FloatingPointError
        If it cannot be computed on either side.
    """
    moved = settings.errors or (0.0,) * len(errors)

    def quotient(step: float) -> Array:
        ahead = (*moved[:place], moved[place] + step, *moved[place + 1 :])
        return (bench.predict(record, dataclasses.replace(settings, errors=ahead)) - here) / step

    return one_sided(quotient, STEP if moved[place] + STEP <= errors[place].most else -STEP)


def form_errors(bench: SystemBench) -> tuple[float, float]:
    """Return the deviation of the form that all teeth of the pinion, and of the wheel, share [m]."""
    pinion, wheel = (math.hypot(COMMON_FORM, SHAPE * bench.depth(gear)) for gear in MEMBERS)
    return pinion, wheel


def common_forms(teeth: Array, bench: SystemBench, scatter: Scatter) -> Array:
    """Return what form errors that all teeth of the pinion, and of the wheel, share do to a record, at one standard deviation.

    Parameters
    ----------
    teeth : ndarray, shape (n, (z1 + z2) (terms + 1))
        From `tooth_columns`.
    bench : SystemBench
        The model.
    scatter : Scatter
        Terms of the form of a flank.

    Returns
    -------
    ndarray, shape (n, 2 terms)
    """
    first = scatter.counts(bench.pair)[0]
    waves = teeth.reshape(len(teeth), -1, scatter.terms + 1)[:, :, 1:]
    pinion, wheel = (size * scatter.shapes() for size in form_errors(bench))
    return np.concatenate([waves[:, :first].sum(axis=1) * pinion, waves[:, first:].sum(axis=1) * wheel], axis=1)
