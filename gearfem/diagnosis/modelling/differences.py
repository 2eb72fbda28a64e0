"""Derivatives by differences, where a model may end on one side."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gearfem.foundation import UNCOMPUTABLE, Array


def one_sided(quotient: Callable[[float], Array], step: float) -> Array:
    """Return a quotient of differences by a step, or by one the other way where the model cannot be computed a step ahead.

    Parameters
    ----------
    quotient : callable
        Of a step: the quotient, of any shape.
    step : float
        Of either sign.

    Raises
    ------
    InputError, SolveError, FloatingPointError
        If neither side can be computed.
    """
    try:
        return quotient(step)
    except UNCOMPUTABLE:
        return quotient(-step)


def two_sided(quotient: Callable[[float], Array], step: float) -> Array:
    """Return the mean of quotients of differences by a step either way, or the one that can be computed.

    Parameters and errors as those of `one_sided`.
    """
    try:
        ahead = quotient(step)
    except UNCOMPUTABLE:
        return quotient(-step)
    try:
        return np.asarray(0.5 * (ahead + quotient(-step)))
    except UNCOMPUTABLE:
        return ahead
