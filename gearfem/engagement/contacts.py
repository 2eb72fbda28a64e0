"""Where unworn teeth touch: on the line of action, and with their corners before and behind it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.engagement.corners import Touch, bounded, corner_on_corner, corners, nearest_edge, pinion_corner, wheel_corner, within
from gearfem.engagement.record import Contacts
from gearfem.flank import Flanks
from gearfem.foundation import Array
from gearfem.placement import Placement

# Gap in modules beyond which contacts are not followed; `engage` refuses loads that could close it.
REACH = 0.2


def find_contacts(flanks: Flanks, placement: Placement, pinion_angle: Array, pairs: tuple[int, ...]) -> Contacts:
    """Return the contact of each pair at each angle, as if it touched alone and rigid.

    Parameters
    ----------
    flanks : Flanks
        Outlines of both gears.
    placement : Placement
        Where the teeth stand.
    pinion_angle : ndarray, shape (n,)
        Angles of the pinion [rad].
    pairs : tuple of int
        Pairs to look at.

    Returns
    -------
    Contacts

    Raises
    ------
    SolveError
        If the wheel's angle of a corner contact does not converge.

    Notes
    -----
    Two kinds of contact exist for unworn teeth: involute on involute, on the straight line of action, and a
    corner of one tooth on the involute of the other, before and behind it: a tip round, or the edge that undercut
    leaves at the form circle.
    """
    angle = np.asarray(pinion_angle, float)[:, None] - np.asarray(pairs)[None, :] * placement.pair.pinion.pitch_angle
    corners1, corners2 = corners(flanks.pinion), corners(flanks.wheel)
    kinds = [_on_path(flanks, placement, angle)]
    kinds += [pinion_corner(flanks, placement, corner, angle) for corner in corners1]
    kinds += [wheel_corner(flanks, placement, corner, angle) for corner in corners2]
    kinds += [corner_on_corner(placement, edge, corners2[0], angle) for edge in corners1[1:]]
    kinds += [corner_on_corner(placement, corners1[0], edge, angle) for edge in corners2[1:]]
    ideal = angle / placement.pair.ratio
    base2 = placement.pair.wheel.base_radius
    # The first touch is the smallest lag of the wheel; a pair out of reach gets a lag of one module.
    lags = np.stack([np.where(kind.reach, (ideal - kind.wheel_angle) * base2, placement.pair.wheel.module) for kind in kinds])
    lags[0][kinds[0].reach] = 0.0
    lags[lags > REACH * placement.pair.wheel.module] = placement.pair.wheel.module
    first = np.argmin(lags, axis=0)
    chosen = Touch(*(_choose(first, [kind[field] for kind in kinds]) for field in range(len(Touch._fields))))
    return _contacts(placement, np.asarray(pinion_angle, float), pairs, chosen, np.min(lags, axis=0))


def _choose(first: NDArray[np.intp], options: list[Any]) -> Any:
    """Take from each position the option of the number `first` holds there."""
    stacked = np.stack(options)
    index = first if stacked.ndim == first.ndim + 1 else np.repeat(first[..., None], stacked.shape[-1], axis=-1)
    return np.take_along_axis(stacked, index[None], axis=0)[0]


def _contacts(placement: Placement, pinion_angle: Array, pairs: tuple[int, ...], touch: Touch, gap: Array) -> Contacts:
    x, y = touch.point[..., 0], touch.point[..., 1]
    fx, fy = np.cos(touch.direction), np.sin(touch.direction)
    beyond = placement.centre_distance - x
    return Contacts(
        pinion_angle=pinion_angle,
        pairs=pairs,
        reach=touch.reach & (gap <= REACH * placement.pair.wheel.module),
        gap=gap,
        u1=touch.u1,
        u2=touch.u2,
        point=touch.point,
        pressure_angle=np.pi / 2.0 - touch.direction,
        arm1=x * fy - y * fx,
        arm2=beyond * fy + y * fx,
        friction_arm1=x * fx + y * fy,
        friction_arm2=beyond * fx - y * fy,
        equivalent_radius=1.0 / touch.curvature,
        flank_radius=1.0 / touch.flank_curvature,
        edge=touch.edge,
        edge_radius=touch.edge_radius,
        rolling_velocity1=touch.rolling1,
        rolling_velocity2=touch.rolling2,
        sliding_velocity=touch.rolling1 - touch.rolling2,
    )


def _on_path(flanks: Flanks, placement: Placement, angle: Array) -> Touch:
    """Involute on involute: the contact lies r_b1 phi from the pitch point on the line of action."""
    pinion, wheel = flanks.pinion, flanks.wheel
    slope = math.tan(placement.working_pressure_angle)
    base1, base2 = pinion.gear.base_radius, wheel.gear.base_radius
    along = base1 * angle
    roll1, roll2 = base1 * slope + along, base2 * slope - along
    reach = within(pinion, roll1) & within(wheel, roll2)
    roll1, roll2 = bounded(pinion, roll1), bounded(wheel, roll2)
    direction = np.full_like(angle, np.pi / 2.0 - placement.working_pressure_angle)
    edge1, edge2 = nearest_edge(pinion, roll1), nearest_edge(wheel, roll2)
    pitch_radius = placement.centre_distance / (1.0 + placement.pair.ratio)
    point = np.stack([pitch_radius + along * np.cos(direction), along * np.sin(direction)], axis=-1)
    return Touch(
        reach=reach,
        wheel_angle=angle / placement.pair.ratio,
        u1=pinion.parameter(roll1),
        u2=wheel.parameter(roll2),
        direction=direction,
        point=point,
        curvature=1.0 / roll1 + 1.0 / roll2,
        flank_curvature=1.0 / roll1 + 1.0 / roll2,
        edge=np.minimum(edge1, edge2),
        edge_radius=np.where(edge1 <= edge2, pinion.gear.tip_edge_radius, wheel.gear.tip_edge_radius),
        rolling1=base1 * slope + along,
        rolling2=(base2 * slope - along) / placement.pair.ratio,
    )
