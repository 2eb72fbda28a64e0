"""The quantities that a campaign may hold: their columns, and which keys their records need."""

from __future__ import annotations

import dataclasses
from typing import Literal

from gearfem.foundation import Record
from gearfem.foundation.units import factor

Axis = Literal["angle", "speed", "roll", "tooth"]

# What healthy pairs leave, of their own deviation: of slow records waviness finer than the terms fitted; at speed also the linearised
# response, and teeth that act on each other by it; of a mesh stiffness, which jumps where pairs hand over, one row in fifty or so that lies
# on the wrong side of a jump; of the largest Kw of a turn, with its expected rise by waviness, a tenth to a quarter, more under light load.
SLOW, MOVING, JUMPING, LARGEST = 0.04, 0.15, 0.30, 0.25
# Speeds of records taken at speed [rpm]; slower ones are slow records: the gears would swing a million times to the turn.
SLOWEST, FASTEST = 1.0, 1e6


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Quantity(Record):
    """What was measured over what.

    Parameters
    ----------
    name : str
        As in campaign files.
    axis : {"angle", "speed", "roll", "tooth"}
        What it is measured over.
    columns : (str, str)
        Headings of the axis and of the value, each ending in its unit.
    moving : bool
        Whether the record was taken at speed, so that the dynamics shape it.
    free_constant : bool
        Whether an unknown constant is part of every record.
    accuracy : float
        Share of its own deviation to which a record is predicted when all that is named is known.
    """

    name: str
    axis: Axis
    columns: tuple[str, str]
    moving: bool = False
    free_constant: bool = False
    accuracy: float = SLOW

    @property
    def of_gear(self) -> bool:
        """Whether the record is of one gear, without torque or speed."""
        return self.axis in ("roll", "tooth")

    @property
    def is_motion(self) -> bool:
        """Whether the record follows a motion over the angle."""
        return self.moving and self.axis == "angle"

    @property
    def unit(self) -> str:
        """Unit of the value in files; empty for a dimensionless one."""
        return UNITS[self.columns[1]]

    @property
    def factors(self) -> tuple[float, float]:
        """SI values of one unit of the axis and of the value."""
        return factor(self.columns[0]), factor(self.columns[1])


UNITS = {
    "transmission_error_um": "um",
    "angular_acceleration_rad_per_s2": "rad/s2",
    "dynamic_factor": "",
    "mesh_stiffness_N_per_um": "N/um",
    "deviation_um": "um",
    "radial_deviation_um": "um",
    "pitch_deviation_um": "um",
}
ANGLE = "pinion_angle_rad"
TRANSMISSION_ERROR = (ANGLE, "transmission_error_um")
QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        Quantity(name="static_transmission_error", axis="angle", columns=TRANSMISSION_ERROR, free_constant=True),
        Quantity(
            name="dynamic_transmission_error", axis="angle", columns=TRANSMISSION_ERROR, moving=True, free_constant=True, accuracy=MOVING
        ),
        Quantity(
            name="pinion_angular_acceleration",
            axis="angle",
            columns=(ANGLE, "angular_acceleration_rad_per_s2"),
            moving=True,
            accuracy=MOVING,
        ),
        Quantity(name="dynamic_factor", axis="speed", columns=("pinion_speed_rpm", "dynamic_factor"), moving=True, accuracy=LARGEST),
        Quantity(name="mesh_stiffness", axis="angle", columns=(ANGLE, "mesh_stiffness_N_per_um"), accuracy=JUMPING),
        Quantity(name="flank_profile", axis="roll", columns=("roll_length_mm", "deviation_um")),
        Quantity(name="radial_runout", axis="tooth", columns=("tooth", "radial_deviation_um"), free_constant=True),
        Quantity(name="pitch_deviation", axis="tooth", columns=("tooth", "pitch_deviation_um"), free_constant=True),
    )
}
