"""Derivatives of all records over all nuisances at one point, and what eliminates them."""

from __future__ import annotations

import numpy as np

from gearfem.diagnosis.bench import Settings
from gearfem.diagnosis.campaign import Measurement
from gearfem.diagnosis.marginal import Marginal, marginal
from gearfem.diagnosis.model_form import model_form
from gearfem.diagnosis.noise import Noise
from gearfem.diagnosis.nuisances import slopes
from gearfem.diagnosis.system_bench import SystemBench
from gearfem.diagnosis.teeth import tooth_columns
from gearfem.diagnosis.unknowns import FREE, Unknowns
from gearfem.foundation import Array


def make_columns(
    records: tuple[Measurement, ...], noises: tuple[Noise, ...], unknowns: Unknowns, bench: SystemBench, unknown: Array
) -> tuple[tuple[Array, ...], Marginal]:
    """Return the columns of records at a point.

    Parameters
    ----------
    records, noises : tuple of Measurement, tuple of Noise
        What was measured.
    unknowns : Unknowns
        What stands where.
    bench : SystemBench
        The model.
    unknown : ndarray, shape (k,)
        The point.

    Returns
    -------
    tuple of ndarray, shapes (n, i)
        Of each record over the inner unknowns in prior deviations [SI]: constants, teeth, model form.
    Marginal
        The same whitened, and the outer unknowns behind them: scales and the zero of the angle.
    """
    settings = unknowns.settings(unknown)
    inner, whole = [], []
    for number, (record, noise) in enumerate(zip(records, noises, strict=True)):
        here = bench.predict(record, settings)
        linear = _inner(record, number, unknowns, bench, settings, here)
        outer = slopes(record, bench, settings, unknowns.nuisances, unknown[: unknowns.outer], here)
        inner.append(linear)
        whole.append(noise.whitener.apply(np.concatenate([linear, outer], axis=1)))
    return tuple(inner), marginal(tuple(whole))


def _inner(record: Measurement, number: int, unknowns: Unknowns, bench: SystemBench, settings: Settings, here: Array) -> Array:
    offset = np.zeros((len(record.axis), len(unknowns.offsets)))
    if number in unknowns.offsets:
        offset[:, unknowns.offsets.index(number)] = FREE
    teeth = tooth_columns(record, bench, settings, unknowns.scatter)
    form = model_form(record, bench, settings, here, teeth, unknowns.scatter)
    return np.concatenate([offset, teeth * unknowns.teeth, form], axis=1)
