"""Contact of two flanks of any shape: the first touch, found globally over both flanks and tip rounds."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearfem.engagement.corners import Touch, rigid_ratio
from gearfem.flank import Outline
from gearfem.flank.outline import FLANK, LOADED_END, ROUND, TIP
from gearfem.foundation import Array, SolveError
from gearfem.placement import Placement

# Pinion points on flank and round; points over the wheel's round; within a candidate; of the table that ranks them.
ON_FLANK, ON_ROUND, OVER_ROUND, ZOOMED, RANKED = 193, 49, 65, 17, (1025, 257)
TANGENT, EDGE1, EDGE2 = 0, 1, 2
# The equivalent curvature of worn flanks is not taken below this part of that of the involutes.
FLATTEST = 0.1
ITERATIONS, SMALLEST_STEP = 100, 1e-12
# Normals of the flanks in contact differ by no more [rad]; what exceeds it is a corner.
PARALLEL = 1e-9


class Candidates(NamedTuple):
    """Parts of the pinion's outline that hold one touch each; flat arrays.

    Parameters
    ----------
    row : ndarray
        Number of the angle.
    low, high, start : ndarray
        Ends of the part, and where to begin.
    kind : ndarray
        `TANGENT`, or the number of the gear whose edge touches (`EDGE1`, `EDGE2`).
    """

    row: NDArray[np.intp]
    low: Array
    high: Array
    start: Array
    kind: NDArray[np.intp]


class Meeting(NamedTuple):
    """Pinion points and the wheel's points at the same radius from its axis; flat arrays.

    Parameters
    ----------
    u1, u2, axis2 : ndarray
        Parameters, and the polar angle of the wheel's tooth at which both points meet [rad].
    direction1, direction2 : ndarray
        Directions of the pinion's outward and the wheel's inward normal in the fixed frame [rad].
    mismatch : ndarray
        Their difference, falling through 0 at a touch from root to tip [rad]; +-1 where the wheel has no point.
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
    it is lower in truth, the contact is computed too soft by at most ln(0.1/its part) F/(pi E*) on each body.
    """
    axis1 = angle + placement.pinion_start
    candidates = _candidates(pinion, wheel, placement, axis1)
    met = _refined(pinion, wheel, placement, axis1, candidates)
    return _touch(pinion, wheel, placement, angle, *_first(candidates, met))


# ---- candidates ---------------------------------------------------------------------------------


class Ranked(NamedTuple):
    """Dense points of flank and tip round: parameters, and x, y, radius and polar angle in the tooth's frame."""

    u: Array
    x: Array
    y: Array
    radius: Array
    polar: Array


@functools.lru_cache(maxsize=256)
def _ranked(outline: Outline, on_flank: int, on_round: int) -> Ranked:
    u = np.concatenate([np.linspace(FLANK, ROUND, on_flank), np.linspace(ROUND, TIP, on_round)[1:]])
    x, y = np.moveaxis(outline.point(u), -1, 0)
    return Ranked(u, x, y, np.hypot(x, y), np.arctan2(y, x))


def _standing(wheel: Outline, distance: float, axis1: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Return R2 and the angle axis2 that each pinion point asks for, infinite where the wheel has no point; by table."""
    table = _ranked(wheel, *RANKED)
    cosine, sine = np.cos(axis1)[:, None], np.sin(axis1)[:, None]
    across, along = distance - (x * cosine - y * sine), -(x * sine + y * cosine)
    radius = np.sqrt(across**2 + along**2)
    axis2 = np.arctan2(along, across) - np.interp(radius, table.radius, table.polar)
    axis2[(radius < table.radius[0]) | (radius > table.radius[-1])] = np.inf
    return radius, axis2


def _candidates(pinion: Outline, wheel: Outline, placement: Placement, axis1: Array) -> Candidates:
    """Return all parts of the pinion's outline in which the first touch may lie."""
    grid, distance = _ranked(pinion, ON_FLANK, ON_ROUND), placement.centre_distance
    radius, axis2 = _standing(wheel, distance, axis1, grid.x, grid.y)
    u = np.broadcast_to(grid.u, axis2.shape)
    # The wheel's round is met within a narrow part of the pinion's outline, which gets points of its own.
    low, high = np.minimum(radius[:, :-1], radius[:, 1:]), np.maximum(radius[:, :-1], radius[:, 1:])
    over = (high >= wheel.flank_end_radius) & (low <= wheel.gear.tip_radius)
    rows = np.flatnonzero(over.any(axis=1))
    first = np.maximum(np.argmax(over[rows], axis=1) - 1, 0)
    last = np.minimum(over.shape[1] - np.argmax(over[rows, ::-1], axis=1) + 1, len(grid.u) - 1)
    fine = np.linspace(grid.u[first], grid.u[last], OVER_ROUND, axis=1)
    dense = _ranked(pinion, *RANKED)
    _, fine2 = _standing(wheel, distance, axis1[rows], np.interp(fine, dense.u, dense.x), np.interp(fine, dense.u, dense.y))
    lowest = axis2.min(axis=1)
    np.minimum.at(lowest, rows, fine2.min(axis=1))
    wide, _ = _minima(u, axis2, np.arange(len(axis1)), lowest)
    narrow, _ = _minima(fine, fine2, rows, lowest)
    tangent = _joined(wide, narrow)
    closer = np.linspace(tangent.low, tangent.high, ZOOMED, axis=1)
    x, y = np.interp(closer, dense.u, dense.x), np.interp(closer, dense.u, dense.y)
    inner, part = _minima(closer, _standing(wheel, distance, axis1[tangent.row], x, y)[1], tangent.row, lowest)
    # A part with one minimum keeps its own ends: those of the table's dense points err beside so small differences.
    several = np.bincount(part, minlength=tangent.row.size)[part] > 1
    return _joined(tangent, _taken(inner, several), *_edges(pinion, wheel, grid.u, radius))


def _joined(*parts: Candidates) -> Candidates:
    row, low, high, start, kind = (np.concatenate(values) for values in zip(*parts, strict=True))
    return Candidates(row, low, high, start, kind)


def _taken(found: Candidates, which: NDArray[Any]) -> Candidates:
    return Candidates(found.row[which], found.low[which], found.high[which], found.start[which], found.kind[which])


def _minima(u: Array, axis2: Array, rows: NDArray[np.intp], lowest: Array) -> tuple[Candidates, NDArray[np.intp]]:
    """Return the local minima that may be the least of their angle, if convex between samples, and their rows here."""
    fence = np.full((len(axis2), 1), np.inf)
    before, after = np.concatenate([fence, axis2[:, :-1]], axis=1), np.concatenate([axis2[:, 1:], fence], axis=1)
    row, column = np.nonzero(np.isfinite(axis2) & (axis2 <= before) & (axis2 < after))
    middle = axis2[row, column]
    fall = np.maximum(before[row, column] - middle, after[row, column] - middle)
    keep = middle - fall <= lowest[rows[row]]
    row, column = row[keep], column[keep]
    low, high = u[row, np.maximum(column - 1, 0)], u[row, np.minimum(column + 1, u.shape[1] - 1)]
    return Candidates(rows[row], low, high, u[row, column], np.full(row.size, TANGENT)), row


def _edges(pinion: Outline, wheel: Outline, u: Array, radius: Array) -> list[Candidates]:
    """Return where edges at the form circle meet the mate: the pinion's at the start of its flank, the wheel's at R2 of its own."""
    found = []
    if pinion.edged:
        row, start = np.arange(len(radius)), np.full(len(radius), FLANK)
        found.append(Candidates(row, start, start, start, np.full(row.size, EDGE1)))
    if wheel.edged:
        row, column = np.nonzero((radius[:, :-1] >= wheel.form_radius) & (radius[:, 1:] < wheel.form_radius))
        found.append(Candidates(row, u[column], u[column + 1], u[column], np.full(row.size, EDGE2)))
    return found


# ---- refinement ---------------------------------------------------------------------------------


def _meet(pinion: Outline, wheel: Outline, distance: float, axis1: Array, u1: Array) -> Meeting:
    """Return where pinion points would meet the wheel, exactly."""
    place, direction = pinion.evaluate(u1)
    cosine, sine = np.cos(axis1), np.sin(axis1)
    x, y = place[:, 0] * cosine - place[:, 1] * sine, place[:, 0] * sine + place[:, 1] * cosine
    radius = np.hypot(distance - x, y)
    u2 = wheel.at_radius(radius)
    mate, normal2 = wheel.evaluate(u2)
    axis2 = np.arctan2(-y, distance - x) - np.arctan2(mate[:, 1], mate[:, 0])
    direction1, direction2 = direction + axis1, normal2 + axis2
    mismatch = np.where(radius > wheel.gear.tip_radius, 1.0, np.where(radius < wheel.form_radius, -1.0, direction1 - direction2))
    return Meeting(u1, u2, axis2, direction1, direction2, mismatch, np.stack([x, y], axis=-1), radius)


def _refined(pinion: Outline, wheel: Outline, placement: Placement, axis1: Array, candidates: Candidates) -> Meeting:
    """Return the touch in each candidate by Newton's method inside a bracket, halved where Newton leaves it or dawdles."""
    low, high, u = np.array(candidates.low), np.array(candidates.high), np.array(candidates.start)
    before, active, distance = high - low, np.arange(len(u)), placement.centre_distance
    for _ in range(ITERATIONS):
        at = u[active]
        met = _meet(pinion, wheel, distance, axis1[candidates.row[active]], at)
        missing, slope = _missing(pinion, wheel, distance, candidates.kind[active], met)
        low[active], high[active] = np.where(missing > 0.0, at, low[active]), np.where(missing > 0.0, high[active], at)
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = at + missing / slope
        steady = (newton >= low[active]) & (newton <= high[active]) & (slope > 0.0) & (np.abs(newton - at) < 0.5 * before[active])
        u[active] = np.where(steady & (np.abs(met.mismatch) < 0.5), newton, (low[active] + high[active]) / 2.0)
        before[active] = np.abs(u[active] - at)
        active = active[before[active] > SMALLEST_STEP]
        if not active.size:
            return _meet(pinion, wheel, distance, axis1[candidates.row], u)
    raise SolveError(f"the contact point of two worn flanks did not converge at {active.size} of {len(u)} places")


def _missing(pinion: Outline, wheel: Outline, distance: float, kind: NDArray[np.intp], met: Meeting) -> tuple[Array, Array]:
    """Return what falls through 0 at the touch, and its fall per parameter: the angle of the normals, or R2 above the wheel's edge."""
    stretch = pinion.stretch(met.u1)
    fall = (pinion.curvature(met.u1) + wheel.curvature(met.u2)) * stretch
    edge = kind == EDGE2
    if not edge.any():
        return met.mismatch, fall
    x, y = met.point[:, 0] - distance, met.point[:, 1]
    nearing = (y * np.cos(met.direction1) - x * np.sin(met.direction1)) / met.radius * stretch
    return np.where(edge, met.radius - wheel.form_radius, met.mismatch), np.where(edge, nearing, fall)


def _first(candidates: Candidates, met: Meeting) -> tuple[Candidates, Meeting]:
    """Return the touch with the least axis2 of each angle that has one."""
    parallel = np.abs(met.mismatch) < PARALLEL
    touching = np.where(candidates.kind == TANGENT, parallel, np.where(candidates.kind == EDGE1, np.abs(met.mismatch) < 1.0, True))
    order = np.lexsort((met.axis2, candidates.row))
    order = order[touching[order]]
    _, first = np.unique(candidates.row[order], return_index=True)
    chosen = order[first]
    return _taken(candidates, chosen), Meeting(*(values[chosen] for values in met))


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
        below = np.where(sharp, -turn * gear.tip_edge_radius, outline.edge_distance(FLANK) - edge)
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
