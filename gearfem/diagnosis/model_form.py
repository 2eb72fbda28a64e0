"""What errors of our own model would do to the records of a campaign."""

from __future__ import annotations

import numpy as np

from gearfem.diagnosis.bench import Settings
from gearfem.diagnosis.campaign import Measurement
from gearfem.diagnosis.system_bench import SystemBench
from gearfem.diagnosis.teeth import Scatter
from gearfem.foundation import Array
from gearfem.foundation.units import UM

# Form errors that all teeth of a gear share, beside the waviness of each.
COMMON_FORM = 0.1 * UM


def model_form(record: Measurement, bench: SystemBench, settings: Settings, here: Array, teeth: Array, scatter: Scatter) -> Array:
    """Return what our own errors would do to a record, at one standard deviation.

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
    teeth : ndarray, shape (n, (z1 + z2) (terms + 1))
        From `tooth_columns`.
    scatter : Scatter
        Terms of the form of a flank.

    Returns
    -------
    ndarray, shape (n, v + 2 terms)
        One column for each variant of the model, then the form errors that all teeth of the pinion, and of the wheel, share.
    """
    columns = [variant.predict(record, settings) - here for variant in bench.variants]
    return np.column_stack([*columns, _common(teeth, bench.pair.pinion.teeth, scatter)])


def _common(teeth: Array, z1: int, scatter: Scatter) -> Array:
    """Return the columns of form errors common to all teeth of either gear, shape (n, 2 terms)."""
    waves = teeth.reshape(len(teeth), -1, scatter.terms + 1)[:, :, 1:]
    sizes = COMMON_FORM * np.sqrt((2.0 * np.arange(1, scatter.terms + 1) + 1.0) / scatter.terms)
    return np.concatenate([waves[:, :z1].sum(axis=1) * sizes, waves[:, z1:].sum(axis=1) * sizes], axis=1)
