"""Nuisances that stray so far from what is known of them that they do the work of an effect."""

from __future__ import annotations

import numpy as np

from gearfem.foundation import Array

# Prior deviations from which on a nuisance is a finding itself, and at which it costs as much as a name must gain.
STRAYED, LOST = 3.0, 5.0


def beyond(moved: Array) -> Array:
    """Return how far nuisances have strayed, of any shape: 0 within `STRAYED` prior deviations, 1 where one is lost."""
    return np.maximum(np.abs(moved) - STRAYED, 0.0) / (LOST - STRAYED)


def halves(moved: Array) -> tuple[Array, Array]:
    """Return half the slope and half the curvature of the square of `beyond` over nuisances of any shape, both of that shape."""
    strayed, steep = beyond(moved), 1.0 / (LOST - STRAYED)
    return np.sign(moved) * strayed * steep, np.where(strayed > 0.0, steep**2, 0.0)
