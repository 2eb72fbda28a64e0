"""How closely a tooth pair is tabulated over its way and over its load."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from gearfem.engagement.contacts import REACH
from gearfem.foundation import Array, Record

# Motions may press the teeth this many times as much as the torque does.
LARGEST_OVERLOAD = 4.0
# The least approach that is tabulated, in modules, and the step of its logarithm: the load is met to 1e-6.
LOWEST, LEVEL = 3e-8, 0.3


def largest_approach(module: float) -> float:
    """Return the approach of a pair at rest [m] up to which teeth of a module [m] are followed."""
    return REACH / LARGEST_OVERLOAD * module


def levels(module: float) -> Array:
    """Return the logarithms of the approaches [m] at which laws are tabulated, for a gear module [m]: up to the largest one."""
    top = math.log(largest_approach(module))
    count = math.ceil((top - math.log(LOWEST * module)) / LEVEL) + 1
    return np.asarray(top - LEVEL * np.arange(count)[::-1], np.float64)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Grid(Record):
    """Cells of the way of a pair between kinks.

    Parameters
    ----------
    cells : int
        Cells to the pitch away from kinks.
    growth : float
        Of each cell over the one before it, away from a kink.
    """

    cells: int
    growth: float


# Of the deviation of a slow transmission error the coarse one misses 1e-4 of what the fine one has, and a fiftieth at single angles where a
# hollow begins.
FINE, COARSE = Grid(cells=192, growth=1.1), Grid(cells=64, growth=1.3)
