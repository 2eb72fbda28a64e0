"""Corners of teeth on the flanks of their mates: tip rounds, and the edges that undercut leaves at the form circle."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearfem.flank import Flanks, Outline
from gearfem.flank.outline import FLANK, LOADED_END, ROUND
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


class Corner(NamedTuple):
    """A corner of a tooth, in the frame of its `Outline`.

    Parameters
    ----------
    outline : Outline
        Of the tooth.
    at_tip : bool
        Whether it is the tip round; if not, the edge at the form circle of an undercut tooth.
    lead, radius : float
        Polar angle [rad] and radius [m] of the centre of the round, or of the edge itself.
    round : float
        Radius of the round [m]; 0 for the edge, whose contact is counted with the radius of the tip round.
    """

    outline: Outline
    at_tip: bool
    lead: float
    radius: float
    round: float

    @property
    def roll(self) -> float:
        """Roll length at which the flank ends in the corner [m]."""
        return self.outline.flank_end if self.at_tip else self.outline.flank_start

    def parameters(self, direction: Array) -> tuple[NDArray[np.bool_], Array, Array]:
        """Return where normals of these directions [rad] touch: whether at all, u, and the arc from the end of the flank, negative."""
        if self.at_tip:
            u = self.outline.round_parameter(direction)
            inside = (u >= ROUND) & (u <= LOADED_END)
            u = np.where(inside, u, ROUND)
            return inside, u, self.outline.edge_distance(u)
        turn = direction - self.outline.flank_direction(self.outline.flank_start)
        inside = (turn >= 0.0) & (turn <= self.outline.undercut_turn)
        arc = -np.where(inside, turn, 0.0) * self.outline.gear.tip_edge_radius
        return inside, np.full_like(direction, FLANK), arc


def corners(outline: Outline) -> list[Corner]:
    """Return the corners of a tooth that may touch its mate.

    Parameters
    ----------
    outline : Outline
        Of the tooth.

    Returns
    -------
    list of Corner
        The tip round; of an undercut tooth the edge at the form circle too.
    """
    lead, radius = outline.round_centre
    found = [Corner(outline, True, lead, radius, outline.gear.tip_edge_radius)]
    if outline.undercut:
        found.append(Corner(outline, False, outline.gear.half_angle(outline.form_radius), outline.form_radius, 0.0))
    return found


def nearest_edge(outline: Outline, roll: Array) -> Array:
    """Return the arc [m] from flank points of these roll lengths [m] to the nearer end of the flank that is an edge."""
    arcs: list[Array] = [np.abs(corner.roll**2 - roll**2) / (2.0 * outline.gear.base_radius) for corner in corners(outline)]
    return arcs[0] if len(arcs) == 1 else np.minimum(*arcs)


def pinion_corner(flanks: Flanks, placement: Placement, corner: Corner, angle: Array) -> Touch:
    """Return the contact of a corner of the pinion with the involute of the wheel: the wheel's angle follows in closed form.

    Parameters
    ----------
    flanks, placement : records
        Of the stages of these names.
    corner : Corner
        Of the pinion.
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
    wheel, distance = flanks.wheel, placement.centre_distance
    axis1 = angle + placement.pinion_start
    polar = axis1 + corner.lead
    centre = corner.radius * _unit(polar)
    # Seen from the wheel, turned by half a turn: x from O2 to O1, y down.
    seen = np.stack([distance - centre[..., 0], -centre[..., 1]], axis=-1)
    axis2, roll2 = _axis_of_offset_involute(wheel, seen, corner.round)
    direction = wheel.flank_direction(roll2) + axis2
    point = centre + corner.round * _unit(direction)
    # Travel on the involute by the roll length of the centre; on the round by the turn of the normal.
    roll_rate = distance * corner.radius * np.sin(polar) / (bounded(wheel, roll2) + corner.round)
    turn = -roll_rate / wheel.gear.base_radius - rigid_ratio(distance, point, direction) - 1.0
    inside, u1, edge = corner.parameters(direction - axis1)
    end = corner.roll / corner.outline.gear.base_radius - math.tan(placement.working_pressure_angle)
    beyond = (angle - end) / corner.outline.gear.pitch_angle * (1.0 if corner.at_tip else -1.0)
    own = corner.outline.gear.tip_edge_radius
    return Touch(
        reach=inside & within(wheel, roll2) & (beyond > -1e-6) & (beyond < FOLLOWED),
        wheel_angle=-axis2 - placement.wheel_start,
        u1=u1,
        u2=wheel.parameter(bounded(wheel, roll2)),
        direction=direction,
        point=point,
        curvature=1.0 / own + 1.0 / bounded(wheel, roll2),
        flank_curvature=1.0 / corner.roll + 1.0 / bounded(wheel, roll2),
        edge=edge,
        edge_radius=np.full_like(angle, own),
        rolling1=-corner.round * turn,
        rolling2=-(roll2 / wheel.gear.base_radius) * roll_rate,
    )


def wheel_corner(flanks: Flanks, placement: Placement, corner: Corner, angle: Array) -> Touch:
    """Return the contact of a corner of the wheel with the involute of the pinion, solved for the wheel's angle.

    Parameters
    ----------
    flanks, placement, angle
        As for `pinion_corner`.
    corner : Corner
        Of the wheel.

    Returns
    -------
    Touch

    Raises
    ------
    SolveError
        If the wheel's angle does not converge.
    """
    pinion, distance = flanks.pinion, placement.centre_distance
    axis1 = angle + placement.pinion_start
    axis2, inside = _wheel_axis(pinion, placement, corner, axis1)
    centre, _, roll1, direction, ratio = _touched(pinion, distance, corner, axis2)
    roll_rate = -ratio * distance * corner.radius * np.sin(axis2 + corner.lead) / (bounded(pinion, roll1) + corner.round)
    turn = -roll_rate / pinion.gear.base_radius + 1.0 + ratio
    on_corner, u2, edge = corner.parameters(direction - axis2)
    own = corner.outline.gear.tip_edge_radius
    return Touch(
        reach=inside & on_corner & within(pinion, roll1),
        wheel_angle=-axis2 - placement.wheel_start,
        u1=pinion.parameter(bounded(pinion, roll1)),
        u2=u2,
        direction=direction,
        point=centre - corner.round * _unit(direction),
        curvature=1.0 / bounded(pinion, roll1) + 1.0 / own,
        flank_curvature=1.0 / bounded(pinion, roll1) + 1.0 / corner.roll,
        edge=edge,
        edge_radius=np.full_like(angle, own),
        rolling1=(roll1 / pinion.gear.base_radius) * roll_rate,
        rolling2=corner.round * turn,
    )


def corner_on_corner(placement: Placement, first: Corner, second: Corner, angle: Array) -> Touch:
    """Return the contact of the edge of an undercut tooth with the tip round of its mate.

    Parameters
    ----------
    placement : Placement
        Where the teeth stand.
    first, second : Corner
        Of the pinion and of the wheel; one of them is an edge at a form circle.
    angle : ndarray, shape (n, p)
        Angles of the pinion, counted for each pair from its own pitch point [rad].

    Returns
    -------
    Touch

    Notes
    -----
    The centres of two rounds in contact are the sum of their radii apart: the law of cosines gives the wheel's angle.
    """
    distance, apart = placement.centre_distance, first.round + second.round
    axis1 = angle + placement.pinion_start
    centre1 = first.radius * _unit(axis1 + first.lead)
    away = np.hypot(distance - centre1[..., 0], centre1[..., 1])
    cosine = (away**2 + second.radius**2 - apart**2) / (2.0 * away * second.radius)
    # The wheel's centre lies on the far side of the pinion's, which seen from O2 is the smaller angle.
    axis2 = np.arctan2(-centre1[..., 1], distance - centre1[..., 0]) - np.arccos(np.clip(cosine, -1.0, 1.0)) - second.lead
    polar2 = axis2 + second.lead
    centre2 = np.stack([distance - second.radius * np.cos(polar2), -second.radius * np.sin(polar2)], axis=-1)
    direction = np.arctan2(*np.moveaxis(centre2 - centre1, -1, 0)[::-1])
    point = centre1 + first.round * _unit(direction)
    inside1, u1, edge1 = first.parameters(direction - axis1)
    inside2, u2, edge2 = second.parameters(direction - axis2)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = rigid_ratio(distance, point, direction)
    # The normal turns with the velocity of one centre seen from the other.
    moving = np.stack([ratio * centre2[..., 1] + centre1[..., 1], ratio * (distance - centre2[..., 0]) - centre1[..., 0]], axis=-1)
    turn = (moving[..., 1] * np.cos(direction) - moving[..., 0] * np.sin(direction)) / apart
    reach = inside1 & inside2 & (np.abs(cosine) <= 1.0)
    turn, ratio = np.where(reach, turn, 0.0), np.where(reach, ratio, 1.0)
    edge = first if not first.at_tip else second
    slope = math.tan(placement.working_pressure_angle)
    end = edge.roll / edge.outline.gear.base_radius - slope
    beyond = end - angle if edge is first else angle * first.outline.gear.base_radius / second.outline.gear.base_radius + end
    own1, own2 = first.outline.gear.tip_edge_radius, second.outline.gear.tip_edge_radius
    reach &= (beyond > -1e-6) & (beyond < FOLLOWED * edge.outline.gear.pitch_angle)
    return Touch(
        reach=reach,
        wheel_angle=-axis2 - placement.wheel_start,
        u1=u1,
        u2=u2,
        direction=direction,
        point=point,
        curvature=np.full_like(angle, 1.0 / own1 + 1.0 / own2),
        flank_curvature=np.full_like(angle, 1.0 / first.roll + 1.0 / second.roll),
        edge=np.minimum(edge1, edge2),
        edge_radius=np.where(edge1 <= edge2, own1, own2),
        rolling1=-first.round * (turn - 1.0),
        rolling2=second.round * (turn + ratio),
    )


def _touched(pinion: Outline, distance: float, corner: Corner, axis2: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return the corner's centre, the pinion's axis, roll length, direction of the force and l1/l2 at angles of the wheel's tooth."""
    polar2 = axis2 + corner.lead
    centre = np.stack([distance - corner.radius * np.cos(polar2), -corner.radius * np.sin(polar2)], axis=-1)
    required, roll1 = _axis_of_offset_involute(pinion, centre, corner.round)
    direction = pinion.flank_direction(roll1) + required
    return centre, required, roll1, direction, rigid_ratio(distance, centre - corner.round * _unit(direction), direction)


def _wheel_axis(pinion: Outline, placement: Placement, corner: Corner, axis1: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the angles of the wheel's tooth at which its corner touches, and where there are any.

    The pinion's angle falls steadily with the wheel's: a table brackets the answer, Newton's method finishes it.
    """
    distance, gear = placement.centre_distance, corner.outline.gear
    end = math.tan(placement.working_pressure_angle) - corner.roll / gear.base_radius
    table = -(end + placement.wheel_start) + (1.0 if corner.at_tip else -1.0) * np.linspace(0.0, FOLLOWED, 401) * gear.pitch_angle
    _, known, rolls, _, ratios = _touched(pinion, distance, corner, table)
    falling = np.diff(known, prepend=known[0]) * (table[1] - table[0]) <= 0.0
    # The tip may dip below the form circle of an undercut mate and come up again: the caller looks where it is on the flank.
    good = (ratios > 0.0) & (rolls + corner.round > 0.0) & falling
    count = int(np.argmin(good)) if not good.all() else len(good)
    if count < 2:
        return np.full_like(axis1, table[0]), np.zeros(axis1.shape, bool)
    order = slice(None, None, -1) if corner.at_tip else slice(None)
    known, table = known[:count][order], table[:count][order]
    inside = (axis1 >= known[0]) & (axis1 <= known[-1])
    axis2 = np.interp(axis1, known, table)
    for _ in range(20):
        _, required, _, _, ratio = _touched(pinion, distance, corner, axis2)
        # d axis2/d axis1 of a rigid contact is -l1/l2.
        step = np.where(inside, (required - axis1) * ratio, 0.0)
        axis2 = axis2 + step
        if np.abs(step).max() < 1e-13:
            return axis2, inside
    raise SolveError("the contact of a corner of the wheel with the pinion's flank did not converge")


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
