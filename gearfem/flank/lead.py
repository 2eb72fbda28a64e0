"""How the gap of the flanks opens along the face width."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from gearfem.foundation import Array, Record

NODES = 129
# Share of a lead by which models of what it does differ. For the approach that whole solids give under tilts and crownings of 1.5 to 4
# deflections, independent slices as stiff as the pair take 0.65 to 1 times the lead, slices that share by their contacts alone 1.2 to 3.4
# times (three pairs, 100 and 300 N/mm), and shafts that tilt under load give way to it.
DISPUTED = 0.5


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Lead(Record):
    """Gap between the flanks of all pairs along the face width, of both gears together.

    Parameters
    ----------
    place : ndarray, shape (n,)
        Places along the face width, from -1/2 to +1/2 of it, increasing.
    gap : ndarray, shape (n,)
        Metal missing there, along the normal [m].

    Examples
    --------
    >>> float(Lead().plus(lambda place: 8e-6 * (place + 0.5)).gap[-1])
    8e-06
    """

    place: Array = dataclasses.field(default_factory=lambda: np.linspace(-0.5, 0.5, NODES))
    gap: Array = dataclasses.field(default_factory=lambda: np.zeros(NODES))

    def plus(self, gap: Callable[[Array], Array]) -> Lead:
        """Return this lead and a further gap [m] as a function of places."""
        return dataclasses.replace(self, gap=self.gap + gap(self.place))

    @property
    def uniform(self) -> bool:
        """Whether the flanks are parallel."""
        return not np.ptp(self.gap) > 0.0
