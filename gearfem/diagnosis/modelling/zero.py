"""First guess of the unknown zero of the pinion angle: the mesh lines of all slow records, turned until they fit."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy.signal import argrelmin

from gearfem.diagnosis.modelling.bench import Bench, Settings
from gearfem.diagnosis.modelling.mesh_lines import HARMONICS, mesh_lines
from gearfem.diagnosis.reading.measurement import Measurement

STEPS = 240
GUESSES = 3


def guess_zero(records: tuple[Measurement, ...], bench: Bench, settings: Settings, deviations: tuple[float, ...]) -> list[float]:
    """Return the likeliest angle offsets within half a pitch [rad], best first, up to three.

    Parameters
    ----------
    records : tuple of Measurement
        Those over the pinion angle.
    bench : Bench
        The model.
    settings : Settings
        Everything but the zero.
    deviations : tuple of float
        Noise of each record, which weighs it.

    Notes
    -----
    Line k of the mesh turns by k times the angle in pitches, whatever the teeth scatter. Lines of both sides are fitted over one pitch
    by least squares, a constant and the slow course of the record beside them.
    """
    pitch = bench.pair.pinion.pitch_angle
    shifts = (np.arange(STEPS) / STEPS - 0.5) * pitch
    misfit = np.zeros(STEPS)
    for record, deviation in zip(records, deviations, strict=True):
        level = dataclasses.replace(settings, angle_offset=0.0)
        measured = mesh_lines(record.axis[record.keep], record.value[record.keep], pitch)
        predicted = mesh_lines(record.axis[record.keep], bench.predict(record, level)[record.keep], pitch)
        turned = predicted * np.exp(2j * math.pi * np.outer(shifts, np.arange(1, HARMONICS + 1)) / pitch)
        misfit += (np.abs(turned - measured) ** 2).sum(axis=1) / (deviation**2 + 0.01 * float((np.abs(measured) ** 2).sum()))
    lowest = argrelmin(misfit, mode="wrap")[0]
    order = lowest[np.argsort(misfit[lowest])] if len(lowest) else np.array([int(np.argmin(misfit))])
    return [float(shifts[place]) for place in order[:GUESSES]]
