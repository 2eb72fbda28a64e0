"""The placement stage: where the teeth of both gears stand when the pinion's angle is 0."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from gearfem.definition.setup import Gear, GearPair, Setup, involute
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.units import MM


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
    series : float
        Yield along the line of action per force [m/N] that is common to all pairs and moves no mass.
    pinion_support, wheel_support : float
        Yield of the support under each gear [m/N], on which its mass moves at speed.
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
    series: float = 0.0
    pinion_support: float = 0.0
    wheel_support: float = 0.0

    @property
    def support(self) -> float:
        """What all pairs yield together under a steady force along the line of action [m/N]."""
        return self.series + self.pinion_support + self.wheel_support


def rigidly_held(placement: Placement) -> Placement:
    """Return the same gears on supports that do not yield."""
    return dataclasses.replace(placement, series=0.0, pinion_support=0.0, wheel_support=0.0)


def evenly_spaced(placement: Placement) -> Placement:
    """Return the same gears centred, every tooth in its place."""
    return dataclasses.replace(
        placement,
        pinion_late=np.zeros_like(placement.pinion_late),
        wheel_late=np.zeros_like(placement.wheel_late),
        pinion_runout=(0.0, 0.0),
        wheel_runout=(0.0, 0.0),
    )


def make_placement(setup: Setup) -> Placement:
    """Return the placement of perfectly spaced teeth on perfectly mounted axes.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.

    Returns
    -------
    Placement
    """
    pair = setup.pair
    start1, start2 = _starts(pair, pair.centre_distance)
    return Placement(
        pair=pair,
        centre_distance=pair.centre_distance,
        working_pressure_angle=pair.working_pressure_angle,
        pinion_start=start1,
        wheel_start=start2,
        pinion_late=np.zeros(pair.pinion.teeth),
        wheel_late=np.zeros(pair.wheel.teeth),
        normal_backlash=pair.working_backlash,
    )


def mounted(placement: Placement, centre_distance: float) -> Placement:
    """Return the same gears at another centre distance, angle 0 again that of pair 0 at the pitch point.

    Parameters
    ----------
    placement : Placement
        Of the gears so far.
    centre_distance : float
        New distance of the axes [m].

    Returns
    -------
    Placement
        With the working pressure angle of cos(alpha_w) = (r_b1 + r_b2)/a, and the play grown by
        2 (r_b1 + r_b2) (inv(alpha_w) - inv(alpha_w before)); all else as it was.

    Raises
    ------
    InputError
        If the base circles of the gears would overlap.
    """
    pair = placement.pair
    bases = pair.pinion.base_radius + pair.wheel.base_radius
    if not centre_distance > bases:
        raise InputError("pair.centre_distance_mm", f"{centre_distance / MM:.4f} mm", f"more than both base radii, {bases / MM:.4f} mm")
    angle = math.acos(bases / centre_distance)
    start1, start2 = _starts(pair, centre_distance)
    return dataclasses.replace(
        placement,
        centre_distance=centre_distance,
        working_pressure_angle=angle,
        pinion_start=start1,
        wheel_start=start2,
        normal_backlash=placement.normal_backlash + 2.0 * bases * (involute(angle) - involute(placement.working_pressure_angle)),
    )


def runout_gap(placement: Placement, pinion_angle: Array) -> tuple[Array, Array]:
    """Return what the eccentricities add to the gaps of all pairs, and its change with the pinion's angle.

    Parameters
    ----------
    placement : Placement
        With the eccentricities E1 and E2 of both toothings.
    pinion_angle : ndarray, shape (n,)
        Angles [rad].

    Returns
    -------
    gap : ndarray, shape (n,)
        [m].
    slope : ndarray, shape (n,)
        [m/rad].

    Notes
    -----
    A toothing that is displaced moves its flanks along the line of action f, the pinion's towards the wheel's and
    the wheel's away from the pinion's: gap = E2 f - E1 f. Tooth 0 of the pinion stands at phi + pinion_start, that of the
    wheel at pi - phi/i - wheel_start in the fixed frame; teeth are counted clockwise on the pinion,
    anticlockwise on the wheel. First order: pressure angle and contact point shift with the centre distance, which adds
    gaps of the order E^2/a, and E/a times the slope of the flanks' deviations and of gaps off the path.
    """
    first, slope1 = _along_action(placement, placement.pinion_runout, pinion_angle + placement.pinion_start, -1.0)
    turned = pinion_angle / placement.pair.ratio
    second, slope2 = _along_action(placement, placement.wheel_runout, np.pi - turned - placement.wheel_start, 1.0)
    return second - first, -slope2 / placement.pair.ratio - slope1


def _along_action(placement: Placement, runout: tuple[float, float], tooth: Array, counting: float) -> tuple[Array, Array]:
    """Return the part of an eccentricity along the line of action, and its change with the angle of the tooth."""
    beside = np.pi / 2.0 - placement.working_pressure_angle - tooth
    towards, across = runout[0], counting * runout[1]
    return towards * np.cos(beside) + across * np.sin(beside), towards * np.sin(beside) - across * np.cos(beside)


def _starts(pair: GearPair, centre_distance: float) -> tuple[float, float]:
    """Return the starts of both gears with pair 0 at the pitch point.

    The pinion's working flank leads its tooth's axis by the half angle at the working pitch circle, the wheel's trails it.
    """
    share = centre_distance / (pair.pinion.teeth + pair.wheel.teeth)

    def half(gear: Gear) -> float:
        return gear.half_angle(share * gear.teeth)

    return -half(pair.pinion), half(pair.wheel)
