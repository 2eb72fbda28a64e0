"""What is missing from a flank: metal along the normal of its involute, over the roll length."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from gearfem.definition.setup import Gear
from gearfem.foundation import Array, Record

# 50 nodes to the millimetre of a roll length of 10 mm: a jump of 20 1/m in the second derivative is met to 1 nm.
NODES = 513


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Deviation(Record):
    """Metal missing from a flank along the normal of its nominal involute, positive into the tooth.

    Worn flanks, modifications and errors of form are one thing here: a cubic spline over the roll length, constant
    before its first node and straight beyond its last, where a worn flank may still run on to its tip circle.
    Deviations add node by node, so that those of several causes are their sum in any order.

    Parameters
    ----------
    roll : ndarray, shape (n,)
        Roll lengths from the base circle [m], increasing, equally spaced.
    depth : ndarray, shape (n,)
        Metal missing there [m].

    Examples
    --------
    >>> worn = Deviation(roll=np.linspace(0.0, 0.01, 5), depth=np.zeros(5)).plus(lambda roll: 1e-3 * roll)
    >>> f"{worn.at(0.005):.1e} {worn.slope(0.005):.1e} {worn.at(0.02):.1e}"
    '5.0e-06 1.0e-03 2.0e-05'
    """

    roll: Array
    depth: Array

    @classmethod
    def none(cls, gear: Gear) -> Deviation:
        """Return the deviation 0 of a gear, from its base circle to its tip circle, to add to."""
        end = float(np.sqrt(gear.tip_radius**2 - gear.base_radius**2))
        return cls(roll=np.linspace(0.0, end, NODES), depth=np.zeros(NODES))

    def plus(self, depth: Callable[[Array], Array]) -> Deviation:
        """Return this deviation and a further depth [m] as a function of roll lengths [m]."""
        return dataclasses.replace(self, depth=self.depth + depth(self.roll))

    @cached_property
    def _spline(self) -> CubicSpline:
        return CubicSpline(self.roll, self.depth)

    @cached_property
    def _last_slope(self) -> float:
        return float(self._spline(self.roll[-1], 1))

    @property
    def cubics(self) -> tuple[float, float, Array]:
        """First roll length and length of the cells of the spline [m], and its cubics (n - 1, 4), highest power first."""
        cells = len(self.roll) - 1
        return float(self.roll[0]), float(self.roll[-1] - self.roll[0]) / cells, np.ascontiguousarray(self._spline.c.T)

    def at(self, roll: ArrayLike) -> Array:
        """Return the depth [m] at roll lengths [m]."""
        roll = np.asarray(roll, float)
        return np.asarray(self._inside(roll, 0) + np.maximum(roll - self.roll[-1], 0.0) * self._last_slope)

    def slope(self, roll: ArrayLike) -> Array:
        """Return the first derivative over the roll length."""
        return np.where(np.asarray(roll) >= self.roll[0], self._inside(roll, 1), 0.0)

    def bend(self, roll: ArrayLike) -> Array:
        """Return the second derivative over the roll length [1/m]."""
        roll = np.asarray(roll, float)
        return np.where((roll >= self.roll[0]) & (roll <= self.roll[-1]), self._inside(roll, 2), 0.0)

    def _inside(self, roll: ArrayLike, order: int) -> Array:
        return np.asarray(self._spline(np.clip(roll, self.roll[0], self.roll[-1]), order))
