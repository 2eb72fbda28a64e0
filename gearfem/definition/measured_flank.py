"""The record of a flank's measured points."""

from __future__ import annotations

import dataclasses
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class MeasuredFlank(Record):
    """Measured points of a working flank, referred to the nominal involute.

    Parameters
    ----------
    member : {"pinion", "wheel"}
        Gear.
    tooth : int or None
        Number of the tooth; None where all teeth are alike.
    file, system : str
        File as the model names it, and how its points were given.
    row : ndarray of int, shape (n,)
        Rows of the points in the file, from 1.
    roll, depth : ndarray, shape (n,)
        Roll lengths from the base circle and metal missing along the normal, positive into the tooth [m].
    below : ndarray of int, shape (k,)
        Rows inside the base circle, where the involute has no normal.
    """

    member: Literal["pinion", "wheel"]
    tooth: int | None
    file: str
    system: str
    row: NDArray[np.int_]
    roll: Array
    depth: Array
    below: NDArray[np.int_]

    @property
    def name(self) -> str:
        """Gear, tooth and file in words."""
        teeth = "all teeth" if self.tooth is None else f"tooth {self.tooth}"
        return f"{self.member}, {teeth} ({self.file})"
