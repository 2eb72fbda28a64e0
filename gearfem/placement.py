"""The placement stage: where the teeth of both gears stand when the pinion's angle is 0."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.definition.setup import GearPair, Setup
from gearfem.foundation import Array, Record


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
    pinion_late, wheel_late : ndarray, shapes (z1,), (z2,)
        Index errors of the working flanks along the line of action [m], positive where a tooth comes into contact late.
    pinion_runout, wheel_runout : (float, float)
        Eccentricity of each toothing about the axis it turns on [m]: towards the centre of tooth 0, and towards the
        direction in which teeth are counted (against the sense of rotation).
    normal_backlash : float
        Play between working and idle flanks along the line of action [m].
    support : float
        Yield of both supports along the line of action per force [m/N], common to all pairs.
    """

    pair: GearPair
    centre_distance: float
    working_pressure_angle: float
    pinion_start: float
    wheel_start: float
    pinion_late: Array
    wheel_late: Array
    normal_backlash: float
    pinion_runout: tuple[float, float] = (0.0, 0.0)
    wheel_runout: tuple[float, float] = (0.0, 0.0)
    support: float = 0.0


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
        pinion_late=np.zeros(pair.pinion.teeth),
        wheel_late=np.zeros(pair.wheel.teeth),
        normal_backlash=pair.working_backlash,
    )
