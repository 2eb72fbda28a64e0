"""Periodic curves through equally spaced samples: one for smooth ones, one for those with kinks."""

from __future__ import annotations

from typing import Protocol, cast

import numpy as np
from scipy.interpolate import Akima1DInterpolator, CubicSpline

from gearfem.foundation import Array

# Samples of the neighbouring periods that Akima's slopes look at, with some to spare.
BEYOND = 4


class Curve(Protocol):
    """A piecewise polynomial of one angle."""

    def __call__(self, angle: Array, derivative: int = 0, /) -> Array:
        """Return the values, or a derivative, at angles [rad]."""

    def antiderivative(self) -> Curve:
        """Return the integral from the first sample."""


class Through(Protocol):
    """A way to lay a periodic curve through samples."""

    def __call__(self, angle: Array, values: Array, period: float, /) -> Curve:
        """Return the curve through values at equally spaced angles [rad] of one period, its end left out."""


def smooth(angle: Array, values: Array, period: float) -> Curve:
    """Return the periodic cubic spline: its slope at the samples errs by h^4 where the values are smooth."""
    ends = np.append(angle, angle[0] + period), np.append(values, values[0])
    return cast(Curve, CubicSpline(*ends, bc_type="periodic"))


def kinked(angle: Array, values: Array, period: float) -> Curve:
    """Return Akima's periodic spline: its slopes keep to one side of a kink and do not overshoot; they err by h^2 elsewhere."""
    wide = np.concatenate([angle[-BEYOND:] - period, angle, angle[:BEYOND] + period])
    return cast(Curve, Akima1DInterpolator(wide, np.concatenate([values[-BEYOND:], values, values[:BEYOND]])))
