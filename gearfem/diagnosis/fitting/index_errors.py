"""What index errors hold that is no scatter of single teeth: one that stands out, and waves that turn with a gear."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.stats import median_abs_deviation

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.straying import LOST, STRAYED
from gearfem.foundation import Array

# Waves a turn of index errors that are looked at.
WAVES = 3
# Part of an index error that counts as told at least: of teeth of which records tell next to nothing none stands out.
TOLD = 0.5


def uneven(problem: Problem, fit: Fit) -> Array:
    """Return how far the index errors of a fit are from those of single teeth, shape (2, 2), see `deviating`.

    Of either gear (columns) the tooth that stands out most, 0 on the gear where it does so less, and the largest wave.
    """
    found = np.zeros((2, 2))
    for gear, (teeth, waves) in enumerate(deviating(problem, fit)):
        found[:, gear] = teeth.max(), waves.max()
    # What stands out on both gears may be one tooth, met with no other one.
    found[0, np.argmin(found[0])] = 0.0
    return found


def turns_often(problem: Problem, fit: Fit) -> bool:
    """Return whether index errors of a fit hold waves twice or three times a turn, which neither chance makes nor an eccentric gear."""
    return any(waves[1:].max() > LOST for _, waves in deviating(problem, fit))


def deviating(problem: Problem, fit: Fit) -> Iterator[tuple[Array, Array]]:
    """Yield of either gear how far each tooth, shape (z,), and waves once, twice and three times a turn, shape (3,), are from chance.

    In deviations of what is left of the index errors; nothing where these stand still. Teeth late by chance make none of either; an
    eccentric gear makes waves, and so does what turns with the gear and is no tooth. What records tell of two teeth together a fit shares
    out, and each stands out by so much less, but so does each one that is late by chance (`Fit.told`).
    """
    late = fit.point.unknown[problem.unknowns.late]
    first = problem.campaign.setup.pair.pinion.teeth
    for own, told in zip(np.split(late, [first]), np.split(fit.told, [first]), strict=True) if late.size else ():
        waves = waves_of(own)
        amplitude = math.sqrt(2.0 / own.size) * np.abs(np.fft.rfft(waves))[1 : WAVES + 1]
        deviation, rest = (max(1.0, float(median_abs_deviation(one, scale="normal"))) for one in (own, own - waves))
        yield np.abs(own - np.median(own)) / np.maximum(told, TOLD) / deviation, amplitude / rest


def odd_of(late: Array) -> Array:
    """Return what index errors of a gear, shape (z,), have beyond three of their deviations from the middle one: no scatter of teeth."""
    apart = late - np.median(late)
    most = STRAYED * max(1.0, float(median_abs_deviation(late, scale="normal")))
    return np.asarray(apart - np.clip(apart, -most, most))


def waves_of(late: Array) -> Array:
    """Return the waves once, twice and three times a turn of what all teeth of a gear have, shape (z,)."""
    lines = np.fft.rfft(late)
    lines[0], lines[WAVES + 1 :] = 0.0, 0.0
    return np.fft.irfft(lines, late.size)
