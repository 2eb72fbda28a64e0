"""What single teeth do to the largest Kw of a turn."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.stats import norm

from gearfem.diagnosis.modelling.bench import Bench, Settings
from gearfem.diagnosis.modelling.teeth import Scatter, tooth_columns
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.quantities import QUANTITIES
from gearfem.foundation import Array

# The rise by waviness that is expected, in its prior deviations: how wavy flanks are is known to half, and no waviness lowers the largest.
EXPECTED_RISE = 2.0
# How far beyond the peaks the largest is looked for, in deviations, and steps of a deviation.
REACH, STEPS = 8.0, 16


def at_peaks(record: Measurement, bench: Bench, settings: Settings, scatter: Scatter) -> tuple[Array, Array]:
    """Return the derivatives of the largest Kw of a turn over the scatter of all teeth, and by how much waviness raises it.

    Parameters
    ----------
    record : Measurement
        Of the dynamic factor over speed.
    bench, settings : Bench, Settings
        The model and where it stands.
    scatter : Scatter
        What is expected of single teeth.

    Returns
    -------
    columns : ndarray, shape (n, (z1 + z2) (terms + 1))
        As of `tooth_columns`: those of Kw where it is largest. They hold for what all teeth share; of the mean teeth alone where the
        scatter describes these.
    rise : ndarray, shape (n,)
        Expected.

    Notes
    -----
    What lowers the largest peak leaves the next one: waviness of single teeth raises the largest of them. With the peaks k_i of the z1
    pitches of a turn, each moved by the standard deviation s on its own, the largest is expected at the integral of
    1 - prod Phi((t - k_i)/s) over t, from below all of them on.
    """
    single, first = dataclasses.replace(scatter, rest=None), bench.pair.pinion.teeth
    waves = single.deviations(bench.pair)
    waves[:: scatter.terms + 1] = 0.0
    columns, rise = [], []
    for speed in record.axis.tolist():
        peaks = bench.peaks(record.pinion_torque, speed, settings)
        here = record.over(np.array([peaks.angle]))
        there = dataclasses.replace(here, quantity=QUANTITIES["pinion_angular_acceleration"], pinion_speed=speed)
        column = peaks.share * tooth_columns(there, bench, settings, single)
        teeth = column.reshape(1, -1, scatter.terms + 1)
        shared = np.stack([teeth[:, :first].sum(axis=1), teeth[:, first:].sum(axis=1)], axis=1).reshape(1, -1)
        columns.append(shared if scatter.common else column)
        rise.append(largest_of(peaks.factors, float(np.linalg.norm(column * waves))) - peaks.factors.max())
    return np.concatenate(columns), np.array(rise)


def expected(moved: float) -> float:
    """Return by how much waviness raises the largest Kw, over what is expected, where its nuisance has moved so many prior deviations."""
    return 1.0 + moved / EXPECTED_RISE


def largest_of(peaks: Array, deviation: float) -> float:
    """Return the expected largest of independent normal values of these means, shape (z1,), and one deviation; to a thousandth of that."""
    if deviation == 0.0:
        return float(peaks.max())
    low = peaks.max() - REACH * deviation
    step = deviation / STEPS
    place = low + (np.arange(2 * REACH * STEPS) + 0.5) * step
    below = norm.cdf((place[:, None] - peaks) / deviation).prod(axis=1)
    return float(low + step * (1.0 - below).sum())
