"""Checks of the arguments of contact laws."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gearfem.foundation import Array, InputError


def finite(name: str, values: ArrayLike) -> Array:
    """Return the values as an array of floats; raise InputError if one is NaN or infinite."""
    array = np.asarray(values, float)
    if not np.isfinite(array).all():
        raise InputError(name, "NaN or infinity", "finite numbers")
    return array


def not_negative(name: str, values: ArrayLike) -> Array:
    """Return the values as an array of floats; raise InputError if one is negative or not finite."""
    array = finite(name, values)
    if (array < 0.0).any():
        raise InputError(name, f"{array.min():g}", "0 or more")
    return array


def positive(name: str, values: ArrayLike) -> Array:
    """Return radii [m] as an array of floats; raise InputError if one is not positive or not finite."""
    array = finite(name, values)
    if (array <= 0.0).any():
        raise InputError(name, f"{array.min():g} m", "more than 0 m: two convex flanks, or one in a hollow of larger radius")
    return array
