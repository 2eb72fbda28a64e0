"""The placement stage: where the teeth of both gears stand when the pinion's angle is 0."""

from __future__ import annotations

import dataclasses

from gearfem.definition.setup import GearPair, Setup
from gearfem.foundation import Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Placement(Record):
    """Axes and tooth positions of the mounted pair.

    Parameters
    ----------
    pair : GearPair
        The gears.
    centre_distance, working_pressure_angle : float
        Of the axes as mounted [m], [rad].
    pinion_start, wheel_start : float
        Polar angles [rad] of the axes of tooth 0 of both gears at pinion angle 0, when pair 0 touches at the
        pitch point; each about its own centre, from the line of centres, positive in its sense of rotation.
    """

    pair: GearPair
    centre_distance: float
    working_pressure_angle: float
    pinion_start: float
    wheel_start: float


def make_placement(setup: Setup) -> Placement:
    """Return the placement of perfectly spaced teeth on perfectly mounted axes.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.

    Returns
    -------
    Placement

    Notes
    -----
    The pinion's working flank leads its tooth's axis by the half angle at the working pitch circle, the
    wheel's trails it.
    """
    pair = setup.pair
    share = pair.centre_distance / (pair.pinion.teeth + pair.wheel.teeth)
    return Placement(
        pair=pair,
        centre_distance=pair.centre_distance,
        working_pressure_angle=pair.working_pressure_angle,
        pinion_start=-pair.pinion.half_angle(share * pair.pinion.teeth),
        wheel_start=pair.wheel.half_angle(share * pair.wheel.teeth),
    )
