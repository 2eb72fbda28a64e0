"""Contact of two flanks of any shape: the first touch, found globally over both flanks and tip rounds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearfem.engagement.candidates import EDGE1, EDGE2, NOWHERE, SHELF, TANGENT, Candidates, find_candidates, kernel, taken
from gearfem.engagement.corners import Touch, rigid_ratio
from gearfem.flank import Outline
from gearfem.flank.outline import FLANK, LOADED_END, ROUND
from gearfem.foundation import Array, SolveError
from gearfem.placement import Placement

# The equivalent curvature of worn flanks is not taken below this part of that of the involutes.
FLATTEST = 0.1
# Two touches of one pair are told apart from this distance on, in modules: some half widths of the contact.
APART = 0.05
# Normals of the flanks in contact differ by no more [rad]; what exceeds it is a corner.
PARALLEL = 1e-9
# Those on a shelf may differ by so much [rad].
SLOPING = 0.05


class Meeting(NamedTuple):
    """Pinion points and the wheel's points at the same radius from its axis; flat arrays.

    Parameters
    ----------
    u1, u2, axis2 : ndarray
        Parameters, and the polar angle of the wheel's tooth at which both points meet [rad].
    direction1, direction2 : ndarray
        Directions of the pinion's outward and the wheel's inward normal in the fixed frame [rad].
    mismatch : ndarray
        Their difference, falling through 0 at a touch from root to tip [rad]; +-`NOWHERE` where the wheel has no point.
    point : ndarray, shape (..., 2)
        In the fixed frame [m].
    radius : ndarray
        Distance from the wheel's axis [m].
    """

    u1: Array
    u2: Array
    axis2: Array
    direction1: Array
    direction2: Array
    mismatch: Array
    point: Array
    radius: Array


def search_contacts(pinion: Outline, wheel: Outline, placement: Placement, angle: Array) -> Touch:
    """Return the first touch of two teeth at pinion angles, whatever their shape.

    Parameters
    ----------
    pinion, wheel : Outline
        The two teeth.
    placement : Placement
        Where the teeth stand.
    angle : ndarray, shape (n,)
        Angles of the pinion, counted from the pair's own pitch point [rad].

    Returns
    -------
    Touch
        Where `reach` is false the other fields are placeholders.

    Raises
    ------
    SolveError
        If a contact point does not converge.

    Notes
    -----
    Radius vectors, Wojnarowski & Onishchenko (2003), eqs. 2-9: a pinion point stands R2 from the wheel's axis and
    would meet the wheel's point of the same radius when the wheel's tooth stands at

        axis2 = psi2 - polar2(R2);

    the wheel has to be ahead of all these, so that the pair touches where axis2 is least. There both tangents coincide,
    or a corner touches: the edge that undercut or wear leaves at the form circle. The least is sought among all local minima
    over points of both flanks and both tip rounds, each then found to 1e-14 m as the zero of the angle between the
    normals. Bumps narrower than 1/96 of the flank may be missed, and of two touches closer than 1/800 one.

    Travel of the contact along the flanks (eq. 12): the normal turns against each body by its curvature times the
    travel, and the travels differ by the sliding v of the points of both bodies, so that with i = l1/l2

        k1 v1 + k2 v2 = 1 + i,    v1 - v2 = v.

    Where flanks wear into each other k1 + k2 falls to 0 and with it the sense of Hertz's law: the band would be wider
    than the hollow. It is not taken below a tenth of that of the involutes, where the band is three times as wide. If
    it is lower in truth, the approach is computed too large by ln(0.1/its part) F/(pi E*), F the line load.
    """
    axis1 = angle + placement.pinion_start
    candidates = find_candidates(pinion, wheel, placement.centre_distance, axis1)
    met = _refined(pinion, wheel, placement, axis1, candidates)
    return _touch(pinion, wheel, placement, angle, *_first(candidates, met))


def search_beside(pinion: Outline, wheel: Outline, placement: Placement, angle: Array, within: float) -> tuple[Touch, Touch]:
    """Return where two teeth touch next, beside their first touch: on the other side of a hollow, or on a tip edge.

    Parameters
    ----------
    pinion, wheel, placement, angle
        As for `search_contacts`.
    within : float
        Turn of the wheel [rad] after which no touch is wanted.

    Returns
    -------
    (Touch, Touch)
        Of all local minima that are `APART` or farther from the first touch the least, and of all shelves: what a hollow leaves when it
        closes, where the gap grows slowest away from the first touch. `reach` is false where there is none.

    Raises
    ------
    SolveError
        If a contact point does not converge.

    Notes
    -----
    Points of the flanks that lie close without touching alone may touch under load; these are the ones that come first. A hollow closes
    as its far side becomes a shelf, at the same place, so that a load on it does not vanish at once.
    """
    axis1 = angle + placement.pinion_start
    candidates = find_candidates(pinion, wheel, placement.centre_distance, axis1, within)
    met = _refined(pinion, wheel, placement, axis1, candidates)
    found, first = _first(candidates, met)
    place, least = np.full((angle.size, 2), np.nan), np.full(angle.size, np.nan)
    place[found.row], least[found.row] = first.point, first.axis2
    aside = np.hypot(*(met.point - place[candidates.row]).T) >= APART * pinion.gear.module
    other = aside & (met.axis2 <= least[candidates.row] + within)
    beside, meetings = taken(candidates, other), Meeting(*(values[other] for values in met))
    minimum, shelf = (_touch(pinion, wheel, placement, angle, *_first(beside, meetings, which)) for which in (False, True))
    return minimum, shelf


# ---- refinement ---------------------------------------------------------------------------------


def _meet(pinion: Outline, wheel: Outline, distance: float, axis1: Array, u1: Array, edge2: NDArray[np.bool_]) -> Meeting:
    """Return where pinion points would meet the wheel, exactly; on its edge where they have been found there.

    By its base circle the flank turns with the root of the radius: an edge sought by that would lose half of its digits.
    """
    place, direction = pinion.evaluate(u1)
    cosine, sine = np.cos(axis1), np.sin(axis1)
    x, y = place[:, 0] * cosine - place[:, 1] * sine, place[:, 0] * sine + place[:, 1] * cosine
    radius = np.hypot(distance - x, y)
    u2 = np.where(edge2, FLANK, wheel.at_radius(radius))
    mate, normal2 = wheel.evaluate(u2)
    axis2 = np.arctan2(-y, distance - x) - np.arctan2(mate[:, 1], mate[:, 0])
    direction1, direction2 = direction + axis1, normal2 + axis2
    mismatch = np.where(radius > wheel.gear.tip_radius, NOWHERE, np.where(radius < wheel.form_radius, -NOWHERE, direction1 - direction2))
    return Meeting(u1, u2, axis2, direction1, direction2, mismatch, np.stack([x, y], axis=-1), radius)


def _refined(pinion: Outline, wheel: Outline, placement: Placement, axis1: Array, candidates: Candidates) -> Meeting:
    """Return the touch in each candidate."""
    row, low, high, start, kind = candidates
    u, distance = start.copy(), placement.centre_distance
    failed = kernel().refine(pinion.curve, wheel.curve, distance, axis1, row, low, high, kind, u)
    if failed:
        raise SolveError(f"the contact point of two worn flanks did not converge at {failed} of {len(u)} places")
    return _meet(pinion, wheel, distance, axis1[row], u, kind == EDGE2)


def _first(candidates: Candidates, met: Meeting, shelf: bool = False) -> tuple[Candidates, Meeting]:
    """Return the touch, or the shelf, with the least axis2 of each angle that has one."""
    kind, apart = candidates.kind, np.abs(met.mismatch)
    if shelf:
        touching = (kind == SHELF) & (apart < SLOPING)
    else:
        touching = np.where(kind == TANGENT, apart < PARALLEL, np.where(kind == EDGE1, apart < NOWHERE, kind == EDGE2))
    order = np.lexsort((met.axis2, candidates.row))
    order = order[touching[order]]
    _, first = np.unique(candidates.row[order], return_index=True)
    chosen = order[first]
    return taken(candidates, chosen), Meeting(*(values[chosen] for values in met))


# ---- what follows -------------------------------------------------------------------------------


class _Body(NamedTuple):
    """One tooth at its contact points: curvatures, whether it is an edge, arc to its nearest edge, whether the normal fits."""

    curvature: Array
    flank: Array
    nominal: Array
    sharp: NDArray[np.bool_]
    edge: Array
    inside: NDArray[np.bool_]


def _body(outline: Outline, u: Array, normal: Array, sharp: NDArray[np.bool_]) -> _Body:
    """Return a tooth at parameters where the contact's normal has these directions [rad] in its frame."""
    gear, on_flank = outline.gear, np.minimum(u, ROUND)
    edge = outline.edge_distance(u)
    inside = u <= LOADED_END
    if outline.edged:
        turn = normal - outline.flank_direction(outline.flank_start)
        # Off the slight edge that wear may leave there, the flank goes on into its fillet.
        above = outline.edge_distance(FLANK) - edge if outline.undercut else np.inf
        below = np.where(sharp, -turn * gear.tip_edge_radius, above)
        edge = np.where(u <= ROUND, np.minimum(edge, below), edge)
        inside &= ~sharp | ((turn >= 0.0) & (turn <= outline.undercut_turn))
    return _Body(
        curvature=np.where(sharp, 1.0 / gear.tip_edge_radius, outline.curvature(u)),
        flank=outline.curvature(on_flank),
        nominal=1.0 / np.maximum(outline.roll_length(on_flank), 1e-3 * gear.module),
        sharp=sharp,
        edge=edge,
        inside=inside,
    )


def _touch(pinion: Outline, wheel: Outline, placement: Placement, angle: Array, found: Candidates, met: Meeting) -> Touch:
    """Return all fields of the touches found."""
    row, sharp1, sharp2 = found.row, found.kind == EDGE1, found.kind == EDGE2
    direction = np.where(sharp1, met.direction2, met.direction1)
    first = _body(pinion, met.u1, direction - angle[row] - placement.pinion_start, sharp1)
    second = _body(wheel, met.u2, direction - met.axis2, sharp2)
    least = FLATTEST * (first.nominal + second.nominal)
    rolling1, rolling2 = _rolling(placement, met.point, direction, first, second, least)
    nearer = first.edge <= second.edge
    fields = {
        "wheel_angle": -met.axis2 - placement.wheel_start,
        "u1": met.u1,
        "u2": met.u2,
        "direction": direction,
        "point": met.point,
        "curvature": np.maximum(first.curvature + second.curvature, least),
        "flank_curvature": np.maximum(first.flank + second.flank, least),
        "edge": np.where(nearer, first.edge, second.edge),
        "edge_radius": np.where(nearer, pinion.gear.tip_edge_radius, wheel.gear.tip_edge_radius),
        "rolling1": rolling1,
        "rolling2": rolling2,
    }
    reach = np.zeros(angle.size, bool)
    reach[row] = first.inside & second.inside
    spread = {}
    for name, values in fields.items():
        spread[name] = np.zeros((angle.size, *values.shape[1:]))
        spread[name][row] = values
    return Touch(reach=reach, **spread)


def _rolling(placement: Placement, point: Array, direction: Array, first: _Body, second: _Body, least: Array) -> tuple[Array, Array]:
    """Return the travel of the contact along both flanks per angle of the pinion [m/rad]; an edge stays where it is."""
    ratio = rigid_ratio(placement.centre_distance, point, direction)
    x, y, fx, fy = point[:, 0], point[:, 1], np.cos(direction), np.sin(direction)
    sliding = x * fx + y * fy - ratio * ((placement.centre_distance - x) * fx - y * fy)
    lift = np.maximum(least - first.curvature - second.curvature, 0.0) / 2.0
    curvature1, curvature2 = first.curvature + lift, second.curvature + lift
    total = curvature1 + curvature2
    rolling1 = (1.0 + ratio + curvature2 * sliding) / total
    rolling2 = (1.0 + ratio - curvature1 * sliding) / total
    rolling1 = np.where(first.sharp, 0.0, np.where(second.sharp, sliding, rolling1))
    rolling2 = np.where(first.sharp, -sliding, np.where(second.sharp, 0.0, rolling2))
    return rolling1, rolling2
