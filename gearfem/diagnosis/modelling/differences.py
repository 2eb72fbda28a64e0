"""Derivatives by differences, where a model may end on one side."""

from __future__ import annotations

from collections.abc import Callable

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
