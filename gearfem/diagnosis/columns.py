"""Derivatives of all records over all nuisances at one point, and what eliminates them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gearfem.diagnosis.bench import Settings
from gearfem.diagnosis.first_pitches import Seen
from gearfem.diagnosis.largest import EXPECTED_RISE, at_peaks
from gearfem.diagnosis.model_form import model_form
from gearfem.diagnosis.noise import Noise
from gearfem.diagnosis.nuisances import slopes
from gearfem.diagnosis.system_bench import SystemBench
from gearfem.diagnosis.teeth import Scatter, tooth_columns
from gearfem.diagnosis.unknowns import FREE, Unknowns
from gearfem.foundation import Array
from gearfem.variants import Variant

# Least Kw - 1 in parts of which anything is told.
LEAST = 0.01


class Columns(NamedTuple):
    """Derivatives of records over all nuisances at one point.

    Parameters
    ----------
    inner : tuple of ndarray, shapes (n, i)
        Of each record over the inner unknowns in prior deviations [SI]: constants, teeth, model form, rise of the largest Kw.
    white : tuple of ndarray, shapes (m_r, i + outer)
        The same whitened, and the outer unknowns behind them: scales and the zero of the angle.
    rise : tuple of ndarray, shapes (n,)
        What waviness is expected to add to the largest Kw of a turn, in parts of Kw - 1; 0 in all other records.
    predicted : tuple of (ndarray of shape (n,), ndarray of shape (m,))
        Each record there, and the rows of it that changes are read from.
    """

    inner: tuple[Array, ...]
    white: tuple[Array, ...]
    rise: tuple[Array, ...]
    predicted: tuple[tuple[Array, Array], ...]


def make_columns(seen: tuple[Seen, ...], noises: tuple[Noise, ...], unknowns: Unknowns, bench: SystemBench, unknown: Array) -> Columns:
    """Return the columns of records at a point.

    Parameters
    ----------
    seen : tuple of Seen
        What was measured, and the rows of it that changes are read from.
    noises : tuple of Noise
        Of each record.
    unknowns : Unknowns
        What stands where.
    bench : SystemBench
        The model.
    unknown : ndarray, shape (k,)
        The point.
    """
    settings = unknowns.settings(unknown)
    inner, white, rises, predicted = [], [], [], []
    for number, (one, noise) in enumerate(zip(seen, noises, strict=True)):
        whole = bench.predict(one.whole, settings)
        near = bench.predict(one.rows, settings) if one.in_part else whole
        linear = _inner(one, number, unknowns, bench, settings, near)
        rise = EXPECTED_RISE * linear[:, -1] / np.maximum(np.abs(whole - 1.0), LEAST)
        outer = one.spread(slopes(one.rows, bench, settings, unknowns.nuisances, unknown[: unknowns.outer], near))
        inner.append(linear)
        rises.append(rise)
        white.append(noise.whitener.apply(np.concatenate([linear, outer * (1.0 + rise)[:, None]], axis=1)))
        predicted.append((whole, near))
    return Columns(tuple(inner), tuple(white), tuple(rises), tuple(predicted))


def _inner(seen: Seen, number: int, unknowns: Unknowns, bench: SystemBench, settings: Settings, near: Array) -> Array:
    offset = np.zeros((len(seen.whole.axis), len(unknowns.offsets)))
    if number in unknowns.offsets:
        offset[:, unknowns.offsets.index(number)] = FREE
    return np.concatenate([offset, errors_of(seen, bench, settings, unknowns.scatter, near, unknowns.errors)], axis=1)


def errors_of(seen: Seen, bench: SystemBench, settings: Settings, scatter: Scatter, here: Array, errors: tuple[Variant, ...]) -> Array:
    """Return what errors of single teeth and of our own model do to a record [SI], at one deviation each.

    Parameters
    ----------
    seen : Seen
        The record, and the rows of it that changes are read from.
    bench, settings : SystemBench, Settings
        As of `tooth_columns`.
    scatter : Scatter
        What is expected of single teeth.
    here : ndarray, shape (m,)
        What the model predicts in those rows.
    errors : tuple of Variant
        How the model may be wrong.

    Returns
    -------
    ndarray, shape (n, i)
        Single teeth, or what these still do to means; model form, see `model_form`; and how far the rise of the largest Kw of a turn by
        waviness may be off, see `at_peaks`.
    """
    record = seen.rows
    teeth = tooth_columns(record, bench, settings, scatter)
    largest = record.quantity.name == "dynamic_factor"
    shared, rise = at_peaks(record, bench, settings, scatter) if largest else (teeth, np.zeros(len(here)))
    form = model_form(record, bench, settings, here, shared, scatter, errors)
    single = scatter.rest[record.file] if scatter.rest is not None else teeth * scatter.deviations(bench.pair)
    return np.column_stack([single, seen.spread(form), seen.spread(rise / EXPECTED_RISE)])
