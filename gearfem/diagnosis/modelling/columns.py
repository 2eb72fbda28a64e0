"""Derivatives of all records over all nuisances at one point, and what eliminates them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.modelling.first_touch import touched_first
from gearfem.diagnosis.modelling.largest import EXPECTED_RISE, at_peaks
from gearfem.diagnosis.modelling.model_form import common_forms, error_slope
from gearfem.diagnosis.modelling.nuisances import slope
from gearfem.diagnosis.modelling.pitch_point import gradually
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.modelling.teeth import Scatter, ride_of, tooth_columns
from gearfem.diagnosis.modelling.unknowns import FREE, Unknowns
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.noise import Noise
from gearfem.foundation import Array
from gearfem.foundation.side_by_side import side_by_side
from gearfem.variants import Variant

# Least Kw - 1 in parts of which anything is told.
LEAST = 0.01


def make_columns(
    records: tuple[Measurement, ...], noises: tuple[Noise, ...], unknowns: Unknowns, bench: SystemBench, unknown: Array
) -> tuple[tuple[Array, ...], tuple[Array, ...], tuple[Array, ...]]:
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
        Of each record over the inner unknowns in prior deviations [SI]: those of `error_columns` behind constants.
    tuple of ndarray, shapes (m_r, i + outer)
        The same whitened, and the outer unknowns behind them: scales and the zero of the angle.
    tuple of ndarray, shapes (n,)
        What waviness is expected to add to the largest Kw of a turn, in parts of Kw - 1; 0 in all other records.
    """
    settings, errors, nuisances = unknowns.settings(unknown), unknowns.errors, unknowns.nuisances
    predicted = [bench.predict(record, settings) for record in records]
    beside = list(zip(records, predicted, strict=True))

    def moved(place: int) -> list[Array]:
        if place < len(errors):
            return [error_slope(record, bench, settings, here, errors, place) for record, here in beside]
        place -= len(errors)
        return [slope(record, bench, settings, nuisances[place], float(unknown[place]), here) for record, here in beside]

    # Each with tables of its own, which serve all records. Of slow records alone they take no longer than children take to begin.
    share = side_by_side if any(record.quantity.moving for record in records) else map
    slopes = list(share(moved, range(len(errors) + unknowns.outer)))
    # Columns of all teeth are so long that children take longer to hand them over than they save.
    inner, whole, rises = [], [], []
    for number, (record, here) in enumerate(beside):
        wrong, outer = np.split(as_columns([series[number] for series in slopes], here), [len(errors)], axis=1)
        linear = np.concatenate(
            [_constants(here, number, unknowns), error_columns(record, bench, settings, unknowns.scatter, here, errors, wrong)], axis=1
        )
        rise = EXPECTED_RISE * linear[:, -1] / np.maximum(np.abs(here - 1.0), LEAST)
        inner.append(linear)
        whole.append(noises[number].whitener.apply(np.concatenate([linear, outer * (1.0 + rise)[:, None]], axis=1)))
        rises.append(rise)
    return tuple(inner), tuple(whole), tuple(rises)


def as_columns(series: Sequence[Array], here: Array) -> Array:
    """Return series as long as a prediction side by side, shape (n, number of them)."""
    return np.array(series).reshape(len(series), len(here)).T


def _constants(here: Array, number: int, unknowns: Unknowns) -> Array:
    """Return the columns of the constants of all records in the rows of one."""
    offset = np.zeros((len(here), len(unknowns.offsets)))
    if number in unknowns.offsets:
        offset[:, unknowns.offsets.index(number)] = FREE
    return offset


def error_columns(
    record: Measurement,
    bench: SystemBench,
    settings: Settings,
    scatter: Scatter,
    here: Array,
    errors: tuple[Variant, ...],
    wrong: Array,
) -> Array:
    """Return what errors of single teeth and of our own model do to a record [SI], at one deviation each.

    Parameters
    ----------
    record, bench, settings : Measurement, SystemBench, Settings
        As of `tooth_columns`.
    scatter : Scatter
        What is expected of single teeth.
    here : ndarray, shape (n,)
        What the model predicts.
    errors : tuple of Variant
        How the model may be wrong.
    wrong : ndarray, shape (n, number of them)
        Derivatives over these, see `error_slope`.

    Returns
    -------
    ndarray, shape (n, i)
        Single teeth, or what these still do to means; errors of the model; forms common to all teeth, see `common_forms`; over which way
        friction turns round, see `gradually`; what the damper acts on, see `touched_first`; and how far the rise of the largest Kw of a
        turn by waviness may be off, see `at_peaks`.
    """
    ride = ride_of(record, bench, settings) if record.quantity.is_motion else None
    teeth = tooth_columns(record, bench, settings, scatter, ride)
    largest = record.quantity.name == "dynamic_factor"
    shared, rise = at_peaks(record, bench, settings, scatter) if largest else (teeth, np.zeros(len(here)))
    single = scatter.rest[record.file] if scatter.rest is not None else teeth * scatter.deviations(bench.pair)
    turning = gradually(record, bench.pair, _rubbing(wrong, errors))
    touch = np.zeros(len(here)) if ride is None else touched_first(record, bench, settings, ride)
    return np.column_stack([single, wrong, common_forms(shared, bench, scatter), turning, touch, rise / EXPECTED_RISE])


def _rubbing(wrong: Array, errors: tuple[Variant, ...]) -> Array:
    """Return what friction does to a record, per unit of its coefficient; 0 where that is none of the unknowns."""
    own = [wrong[:, place] / variant.size for place, variant in enumerate(errors) if variant.name == "friction"]
    return own[0] if own else np.zeros(len(wrong))
