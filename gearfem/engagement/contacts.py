"""Where unworn teeth touch: on the line of action, and with their tip rounds before and behind it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearfem.engagement.record import Contacts
from gearfem.flank import Flanks, Outline
from gearfem.flank.outline import LOADED_END, ROUND
from gearfem.foundation import Array, SolveError
from gearfem.placement import Placement

# Gap in modules that no load closes: steel teeth break long before they deflect by a tenth of it.
REACH = 0.1


class _Touch(NamedTuple):
    """One kind of contact at many angles; all arrays have the shape of the angles."""

    reach: NDArray[np.bool_]
    wheel_angle: Array
    u1: Array
    u2: Array
    direction: Array
    point: Array
    curvature: Array
    flank_curvature: Array
    edge: Array
    edge_radius: Array
    rolling1: Array
    rolling2: Array


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
    Three kinds of contact exist for unworn teeth: involute on involute, on the straight line of action;
    the pinion's tip round on the wheel's involute behind it; the wheel's tip round on the pinion's involute
    before it. The centre of a round of radius rho touches where it lies on the involute moved out by rho,
    which is an involute of the same base circle: the contact is exact, not a search. Derived here.
    """
    angle = np.asarray(pinion_angle, float)[:, None] - np.asarray(pairs)[None, :] * placement.pair.pinion.pitch_angle
    kinds = [
        _on_path(flanks, placement, angle),
        _pinion_tip(flanks, placement, angle),
        _wheel_tip(flanks, placement, angle),
    ]
    ideal = angle / placement.pair.ratio
    base2 = placement.pair.wheel.base_radius
    # The first touch is the smallest lag of the wheel; a pair out of reach gets a lag of one module.
    lags = np.stack([np.where(kind.reach, (ideal - kind.wheel_angle) * base2, placement.pair.wheel.module) for kind in kinds])
    lags[0][kinds[0].reach] = 0.0
    lags[lags > REACH * placement.pair.wheel.module] = placement.pair.wheel.module
    first = np.argmin(lags, axis=0)
    chosen = _Touch(*(_choose(first, [kind[field] for kind in kinds]) for field in range(len(_Touch._fields))))
    return _contacts(placement, np.asarray(pinion_angle, float), pairs, chosen, np.min(lags, axis=0))


def _choose(first: NDArray[np.intp], options: list[Any]) -> Any:
    """Take from each position the option of the number `first` holds there."""
    stacked = np.stack(options)
    index = first if stacked.ndim == first.ndim + 1 else np.repeat(first[..., None], stacked.shape[-1], axis=-1)
    return np.take_along_axis(stacked, index[None], axis=0)[0]


def _contacts(placement: Placement, pinion_angle: Array, pairs: tuple[int, ...], touch: _Touch, gap: Array) -> Contacts:
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


def _on_path(flanks: Flanks, placement: Placement, angle: Array) -> _Touch:
    """Involute on involute: the contact lies r_b1 phi from the pitch point on the line of action."""
    pinion, wheel = flanks.pinion, flanks.wheel
    slope = math.tan(placement.working_pressure_angle)
    base1, base2 = pinion.gear.base_radius, wheel.gear.base_radius
    along = base1 * angle
    roll1, roll2 = base1 * slope + along, base2 * slope - along
    reach = _within(pinion, roll1) & _within(wheel, roll2)
    roll1, roll2 = _bounded(pinion, roll1), _bounded(wheel, roll2)
    direction = np.full_like(angle, np.pi / 2.0 - placement.working_pressure_angle)
    u1, u2 = pinion.parameter(roll1), wheel.parameter(roll2)
    edge1, edge2 = pinion.edge_distance(u1), wheel.edge_distance(u2)
    pitch_radius = placement.centre_distance / (1.0 + placement.pair.ratio)
    point = np.stack([pitch_radius + along * np.cos(direction), along * np.sin(direction)], axis=-1)
    return _Touch(
        reach=reach,
        wheel_angle=angle / placement.pair.ratio,
        u1=u1,
        u2=u2,
        direction=direction,
        point=point,
        curvature=1.0 / roll1 + 1.0 / roll2,
        flank_curvature=1.0 / roll1 + 1.0 / roll2,
        edge=np.minimum(edge1, edge2),
        edge_radius=np.where(edge1 <= edge2, pinion.gear.tip_edge_radius, wheel.gear.tip_edge_radius),
        rolling1=base1 * slope + along,
        rolling2=(base2 * slope - along) / placement.pair.ratio,
    )


def _pinion_tip(flanks: Flanks, placement: Placement, angle: Array) -> _Touch:
    """Tip round of the pinion on the involute of the wheel: the wheel's angle follows in closed form."""
    pinion, wheel = flanks.pinion, flanks.wheel
    start, distance = placement.pinion_start, placement.centre_distance
    axis1 = angle + start
    lead, radius = pinion.round_centre
    polar = axis1 + lead
    centre = radius * _unit(polar)
    # Seen from the wheel, turned by half a turn: x from O2 to O1, y down.
    seen = np.stack([distance - centre[..., 0], -centre[..., 1]], axis=-1)
    axis2, roll2 = _axis_of_offset_involute(wheel, seen, pinion.gear.tip_edge_radius)
    direction = wheel.normal_direction(roll2) + axis2
    u1 = pinion.round_parameter(direction - axis1)
    # Travel on the involute by the roll length of the centre; on the round by the turn of the normal.
    roll_rate = distance * radius * np.sin(polar) / (_bounded(wheel, roll2) + pinion.gear.tip_edge_radius)
    point = centre + pinion.gear.tip_edge_radius * _unit(direction)
    ratio = _ratio(distance, point, direction)
    turn = -roll_rate / wheel.gear.base_radius - ratio - 1.0
    end = placement.pair.recess_length / pinion.gear.base_radius
    near = (angle > end - 0.1 * pinion.gear.pitch_angle) & (angle < end + pinion.gear.pitch_angle)
    reach = near & _within(wheel, roll2) & (u1 >= ROUND) & (u1 <= LOADED_END)
    u1 = np.where(reach, u1, ROUND)
    return _Touch(
        reach=reach,
        wheel_angle=-axis2 - placement.wheel_start,
        u1=u1,
        u2=wheel.parameter(_bounded(wheel, roll2)),
        direction=direction,
        point=point,
        curvature=1.0 / pinion.gear.tip_edge_radius + 1.0 / _bounded(wheel, roll2),
        flank_curvature=1.0 / pinion.flank_end + 1.0 / _bounded(wheel, roll2),
        edge=pinion.edge_distance(u1),
        edge_radius=np.full_like(angle, pinion.gear.tip_edge_radius),
        rolling1=-pinion.gear.tip_edge_radius * turn,
        rolling2=-(roll2 / wheel.gear.base_radius) * roll_rate,
    )


def _wheel_tip(flanks: Flanks, placement: Placement, angle: Array) -> _Touch:
    """Tip round of the wheel on the involute of the pinion: the mirror problem, solved for the wheel's angle."""
    pinion, wheel = flanks.pinion, flanks.wheel
    distance, edge = placement.centre_distance, wheel.gear.tip_edge_radius
    lead, radius = wheel.round_centre
    axis1 = angle + placement.pinion_start

    def touch(axis2: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Return centre, pinion's axis, roll length, direction of the force and l1/l2 at angles of the wheel's tooth."""
        polar2 = axis2 + lead
        centre = np.stack([distance - radius * np.cos(polar2), -radius * np.sin(polar2)], axis=-1)
        required, roll1 = _axis_of_offset_involute(pinion, centre, edge)
        direction = pinion.normal_direction(roll1) + required
        return centre, required, roll1, direction, _ratio(distance, centre - edge * _unit(direction), direction)

    # The pinion's angle falls steadily with the wheel's: a table brackets the answer, Newton's method finishes it.
    start = -((wheel.gear.base_radius * math.tan(placement.working_pressure_angle) - wheel.flank_end) / pinion.gear.base_radius)
    table = -(-start / placement.pair.ratio + placement.wheel_start) + np.linspace(0.0, 0.4, 401) * wheel.gear.pitch_angle
    _, known, rolls, _, ratios = touch(table)
    good = (ratios > 0.0) & _within(pinion, rolls) & (np.diff(known, prepend=np.inf) < 0.0)
    count = int(np.argmin(good)) if not good.all() else len(good)
    inside = (axis1 <= known[0]) & (axis1 >= known[max(count - 1, 0)])
    axis2 = np.interp(axis1, known[:count][::-1], table[:count][::-1]) if count > 1 else np.full_like(axis1, table[0])
    for _ in range(20):
        centre, required, roll1, direction, ratio = touch(axis2)
        # d axis2/d axis1 of a rigid contact is -l1/l2.
        step = np.where(inside, (required - axis1) * ratio, 0.0)
        axis2 = axis2 + step
        if np.abs(step).max() < 1e-13:
            break
    else:
        raise SolveError("the contact of the wheel's tip round with the pinion's flank did not converge")
    polar2 = axis2 + lead
    u2 = wheel.round_parameter(direction - axis2)
    reach = inside & _within(pinion, roll1) & (u2 >= ROUND) & (u2 <= LOADED_END)
    u2 = np.where(reach, u2, ROUND)
    roll_rate = -ratio * distance * radius * np.sin(polar2) / (_bounded(pinion, roll1) + edge)
    turn = -roll_rate / pinion.gear.base_radius + 1.0 + ratio
    return _Touch(
        reach=reach,
        wheel_angle=-axis2 - placement.wheel_start,
        u1=pinion.parameter(_bounded(pinion, roll1)),
        u2=u2,
        direction=direction,
        point=centre - edge * _unit(direction),
        curvature=1.0 / _bounded(pinion, roll1) + 1.0 / edge,
        flank_curvature=1.0 / _bounded(pinion, roll1) + 1.0 / wheel.flank_end,
        edge=wheel.edge_distance(u2),
        edge_radius=np.full_like(angle, edge),
        rolling1=(roll1 / pinion.gear.base_radius) * roll_rate,
        rolling2=edge * turn,
    )


def _unit(direction: Array) -> Array:
    return np.stack([np.cos(direction), np.sin(direction)], axis=-1)


def _within(outline: Outline, roll: Array) -> NDArray[np.bool_]:
    return (roll >= outline.flank_start) & (roll <= outline.flank_end)


def _bounded(outline: Outline, roll: Array) -> Array:
    """Return roll lengths moved to the ends of the flank; used only to fill rows that `reach` excludes."""
    return np.clip(roll, outline.flank_start, outline.flank_end)


def _axis_of_offset_involute(outline: Outline, centre: Array, edge: float) -> tuple[Array, Array]:
    """Return the tooth's axis angle at which its involute, moved out by `edge`, holds `centre`; and the roll length.

    The involute moved out by rho begins rho/r_b later on the base circle and has the roll length s + rho.
    """
    base = outline.gear.base_radius
    offset = np.sqrt(np.maximum((centre**2).sum(axis=-1) - base**2, 0.0))
    involute = offset / base - np.arctan(offset / base)
    polar = np.arctan2(centre[..., 1], centre[..., 0])
    return polar - (outline.gear.base_half_angle + edge / base - involute), offset - edge


def _ratio(distance: float, point: Array, direction: Array) -> Array:
    """Return dphi2/dphi1 = l1/l2 of a rigid contact with its force along `direction`."""
    x, y = point[..., 0], point[..., 1]
    fx, fy = np.cos(direction), np.sin(direction)
    return (x * fy - y * fx) / ((distance - x) * fy + y * fx)
