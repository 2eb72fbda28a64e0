"""Parts of a drive train beyond the two gears: further inertias on elastic shafts, and yielding supports."""

from __future__ import annotations

import dataclasses
import math

from gearfem.foundation import InputError, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class ShaftedInertia(Record):
    """An inertia (coupling, motor, load) and the elastic shaft that joins it to its neighbour nearer the gear.

    Parameters
    ----------
    name : str
        What it is, for tables and plots.
    inertia : float
        Moment of inertia [kg m2].
    stiffness : float
        Torsional stiffness of the shaft [N m/rad].
    damping : float
        Torsional damping of the shaft [N m s/rad].
    """

    name: str
    inertia: float
    stiffness: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        _refuse(f"inertia {self.name}", self.inertia, self.stiffness, self.damping)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Support(Record):
    """What holds a gear: shaft and bearings, which yield along the line of action under the normal force.

    Parameters
    ----------
    compliance : float
        Displacement of the gear's centre per normal force [m/N].
    mass : float
        Mass that moves with it [kg].
    damping : float
        Damping of that motion [N s/m].
    """

    compliance: float
    mass: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        _refuse("support", self.compliance, self.mass, self.damping)


def _refuse(where: str, one: float, two: float, damping: float) -> None:
    if not (0.0 < one < math.inf and 0.0 < two < math.inf and 0.0 <= damping < math.inf):
        raise InputError(where, f"{one:g}, {two:g} and damping {damping:g}", "positive numbers, and damping from 0")
