"""Tip rounds on the involutes of their mates: contact before and behind the path of unworn teeth, in closed form."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearfem.flank import Flanks, Outline
from gearfem.flank.outline import LOADED_END, ROUND
from gearfem.foundation import Array, SolveError
from gearfem.placement import Placement

# Corners are followed over this part of a pitch beyond the path; no load closes the gaps farther off.
FOLLOWED = 0.4


class Touch(NamedTuple):
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


def nearest_edge(outline: Outline, roll: Array) -> Array:
    """Return the arc [m] from points of an involute at roll lengths [m] to the nearer end of it that is an edge."""
    ends = (outline.flank_end, outline.flank_start) if outline.undercut else (outline.flank_end,)
    arcs: list[Array] = [np.abs(end**2 - roll**2) / (2.0 * outline.gear.base_radius) for end in ends]
    return arcs[0] if len(arcs) == 1 else np.minimum(*arcs)


def pinion_corner(flanks: Flanks, placement: Placement, angle: Array) -> Touch:
    """Return the contact of the pinion's tip round with the involute of the wheel: the wheel's angle follows in closed form.

    Parameters
    ----------
    flanks, placement : records
        Of the stages of these names.
    angle : ndarray, shape (n, p)
        Angles of the pinion, counted for each pair from its own pitch point [rad].

    Returns
    -------
    Touch

    Notes
    -----
    The centre of a round of radius rho touches where it lies on the mate's involute moved out by rho, which is an
    involute of the same base circle: exact, not a search. Derived here.
    """
    pinion, wheel, distance = flanks.pinion, flanks.wheel, placement.centre_distance
    (lead, far), own = pinion.round_centre, pinion.gear.tip_edge_radius
    axis1 = angle + placement.pinion_start
    polar = axis1 + lead
    centre = far * _unit(polar)
    # Seen from the wheel, turned by half a turn: x from O2 to O1, y down.
    seen = np.stack([distance - centre[..., 0], -centre[..., 1]], axis=-1)
    axis2, roll2 = _axis_of_offset_involute(wheel, seen, own)
    direction = wheel.flank_direction(roll2) + axis2
    point = centre + own * _unit(direction)
    # Travel on the involute by the roll length of the centre; on the round by the turn of the normal.
    roll_rate = distance * far * np.sin(polar) / (bounded(wheel, roll2) + own)
    turn = -roll_rate / wheel.gear.base_radius - rigid_ratio(distance, point, direction) - 1.0
    inside, u1, edge = _on_round(pinion, direction - axis1)
    end = pinion.flank_end / pinion.gear.base_radius - math.tan(placement.working_pressure_angle)
    beyond = (angle - end) / pinion.gear.pitch_angle
    return Touch(
        reach=inside & within(wheel, roll2) & (beyond > -1e-6) & (beyond < FOLLOWED),
        wheel_angle=-axis2 - placement.wheel_start,
        u1=u1,
        u2=wheel.parameter(bounded(wheel, roll2)),
        direction=direction,
        point=point,
        curvature=1.0 / own + 1.0 / bounded(wheel, roll2),
        flank_curvature=1.0 / pinion.flank_end + 1.0 / bounded(wheel, roll2),
        edge=edge,
        edge_radius=np.full_like(angle, own),
        rolling1=-own * turn,
        rolling2=-(roll2 / wheel.gear.base_radius) * roll_rate,
    )


def wheel_corner(flanks: Flanks, placement: Placement, angle: Array) -> Touch:
    """Return the contact of the wheel's tip round with the involute of the pinion, solved for the wheel's angle.

    Parameters
    ----------
    flanks, placement, angle
        As for `pinion_corner`.

    Returns
    -------
    Touch

    Raises
    ------
    SolveError
        If the wheel's angle does not converge.
    """
    pinion, wheel, distance = flanks.pinion, flanks.wheel, placement.centre_distance
    (lead, far), own = wheel.round_centre, wheel.gear.tip_edge_radius
    axis1 = angle + placement.pinion_start
    axis2, inside = _wheel_axis(flanks, placement, axis1)
    centre, _, roll1, direction, ratio = _touched(flanks, distance, axis2)
    roll_rate = -ratio * distance * far * np.sin(axis2 + lead) / (bounded(pinion, roll1) + own)
    turn = -roll_rate / pinion.gear.base_radius + 1.0 + ratio
    on_round, u2, edge = _on_round(wheel, direction - axis2)
    return Touch(
        reach=inside & on_round & within(pinion, roll1),
        wheel_angle=-axis2 - placement.wheel_start,
        u1=pinion.parameter(bounded(pinion, roll1)),
        u2=u2,
        direction=direction,
        point=centre - own * _unit(direction),
        curvature=1.0 / bounded(pinion, roll1) + 1.0 / own,
        flank_curvature=1.0 / bounded(pinion, roll1) + 1.0 / wheel.flank_end,
        edge=edge,
        edge_radius=np.full_like(angle, own),
        rolling1=(roll1 / pinion.gear.base_radius) * roll_rate,
        rolling2=own * turn,
    )


def _on_round(outline: Outline, direction: Array) -> tuple[NDArray[np.bool_], Array, Array]:
    """Return where normals of these directions [rad] touch the tip round: whether at all, u, and the arc from the flank, negative."""
    u = outline.round_parameter(direction)
    inside = (u >= ROUND) & (u <= LOADED_END)
    u = np.where(inside, u, ROUND)
    return inside, u, outline.edge_distance(u)


def _touched(flanks: Flanks, distance: float, axis2: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return the round's centre, the pinion's axis, roll length, direction of the force and l1/l2 at angles of the wheel's tooth."""
    (lead, far), own = flanks.wheel.round_centre, flanks.wheel.gear.tip_edge_radius
    polar2 = axis2 + lead
    centre = np.stack([distance - far * np.cos(polar2), -far * np.sin(polar2)], axis=-1)
    required, roll1 = _axis_of_offset_involute(flanks.pinion, centre, own)
    direction = flanks.pinion.flank_direction(roll1) + required
    return centre, required, roll1, direction, rigid_ratio(distance, centre - own * _unit(direction), direction)


def _wheel_axis(flanks: Flanks, placement: Placement, axis1: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the angles of the wheel's tooth at which its tip round touches, and where there are any.

    The pinion's angle falls steadily with the wheel's: a table brackets the answer, Newton's method finishes it.
    """
    distance, wheel = placement.centre_distance, flanks.wheel
    end = math.tan(placement.working_pressure_angle) - wheel.flank_end / wheel.gear.base_radius
    table = -(end + placement.wheel_start) + np.linspace(0.0, FOLLOWED, 401) * wheel.gear.pitch_angle
    _, known, rolls, _, ratios = _touched(flanks, distance, table)
    falling = np.diff(known, prepend=known[0]) * (table[1] - table[0]) <= 0.0
    good = (ratios > 0.0) & (rolls + wheel.gear.tip_edge_radius > 0.0) & falling
    count = int(np.argmin(good)) if not good.all() else len(good)
    if count < 2:
        return np.full_like(axis1, table[0]), np.zeros(axis1.shape, bool)
    known, table = known[:count][::-1], table[:count][::-1]
    inside = (axis1 >= known[0]) & (axis1 <= known[-1])
    axis2 = np.interp(axis1, known, table)
    for _ in range(20):
        _, required, _, _, ratio = _touched(flanks, distance, axis2)
        # d axis2/d axis1 of a rigid contact is -l1/l2.
        step = np.where(inside, (required - axis1) * ratio, 0.0)
        axis2 = axis2 + step
        if np.abs(step).max() < 1e-13:
            return axis2, inside
    raise SolveError("the contact of the wheel's tip round with the pinion's flank did not converge")


def rigid_ratio(distance: float, point: Array, direction: Array) -> Array:
    """Return dphi2/dphi1 = l1/l2 of a rigid contact with its force along `direction`."""
    x, y = point[..., 0], point[..., 1]
    fx, fy = np.cos(direction), np.sin(direction)
    return (x * fy - y * fx) / ((distance - x) * fy + y * fx)


def _unit(direction: Array) -> Array:
    return np.stack([np.cos(direction), np.sin(direction)], axis=-1)


def within(outline: Outline, roll: Array) -> NDArray[np.bool_]:
    """Return whether roll lengths [m] lie on the flank."""
    return (roll >= outline.flank_start) & (roll <= outline.flank_end)


def bounded(outline: Outline, roll: Array) -> Array:
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
