"""Compiled search for the places where two teeth touch; imported when worn teeth are first searched, never with gearfem."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gearfem.engagement.candidates import EDGE2, NOWHERE, SHELF
from gearfem.engagement.turn_kernels import compiled, inlined
from gearfem.flank.outline import FLANK, ROUND

ITERATIONS, SMALLEST_STEP = 100, 1e-12


@inlined
def depth(curve: Any, roll: float) -> tuple[float, float, float]:
    """Return what is missing at a roll length [m], and its two derivatives; see `Deviation`."""
    cells = len(curve.bends)
    place = (roll - curve.first) / curve.step
    if place < 0.0:
        return curve.bends[0, 3], 0.0, 0.0
    cell = min(int(place), cells - 1)
    c = curve.bends[cell]
    beyond = max(roll - (curve.first + cells * curve.step), 0.0)
    t = roll - (curve.first + cell * curve.step) - beyond
    slope = (3.0 * c[0] * t + 2.0 * c[1]) * t + c[2]
    bend = 6.0 * c[0] * t + 2.0 * c[1] if beyond == 0.0 else 0.0
    return ((c[0] * t + c[1]) * t + c[2]) * t + c[3] + beyond * slope, slope, bend


@inlined
def place(curve: Any, u: float) -> tuple[float, float, float]:
    """Return the point of an outline [m] and the direction of its outward normal, in the tooth's frame."""
    if u < ROUND:
        base = curve.base_radius
        roll = curve.flank_start + (u - FLANK) * (curve.flank_end - curve.flank_start)
        missing, slope, _ = depth(curve, roll)
        inner = roll - missing
        radius, polar = math.hypot(base, inner), curve.base_half_angle - (roll / base - math.atan(inner / base))
        direction = curve.base_half_angle - roll / base + 0.5 * math.pi - math.atan(base * slope / inner)
        return radius * math.cos(polar), radius * math.sin(polar), direction
    direction = curve.round_start + (u - ROUND) * (curve.round_angle - curve.round_start)
    centre, edge = curve.tip_radius - curve.edge_radius, curve.edge_radius
    x = centre * math.cos(curve.round_angle) + edge * math.cos(direction)
    return x, centre * math.sin(curve.round_angle) + edge * math.sin(direction), direction


@inlined
def bent(curve: Any, u: float) -> tuple[float, float]:
    """Return the curvature of an outline [1/m] and its arc per parameter [m]."""
    if u > ROUND:
        return 1.0 / curve.edge_radius, (curve.round_start - curve.round_angle) * curve.edge_radius
    base, length = curve.base_radius, curve.flank_end - curve.flank_start
    roll = curve.flank_start + (u - FLANK) * length
    missing, slope, bend = depth(curve, roll)
    inner = roll - missing
    lean = 1.0 + (base * slope / inner) ** 2
    turn = 1.0 / base + base * (bend * inner - slope * (1.0 - slope)) / inner**2 / lean
    return turn / (inner / base * math.sqrt(lean)), math.hypot(slope, inner / base) * length


@inlined
def at_radius(curve: Any, radius: float) -> float:
    """Return the parameter at a radius [m] between form and tip circle."""
    if radius > curve.flank_end_radius:
        centre, edge = curve.tip_radius - curve.edge_radius, curve.edge_radius
        cosine = min((radius**2 - centre**2 - edge**2) / (2.0 * centre * edge), 1.0)
        turned = curve.round_angle + math.acos(cosine) - curve.round_start
        return float(max(ROUND + turned / (curve.round_angle - curve.round_start), ROUND))
    inner = math.sqrt(radius**2 - curve.base_radius**2)
    low, high = inner + curve.least, inner + curve.most
    roll = min(max(inner + depth(curve, inner)[0], low), high)
    for _ in range(ITERATIONS):
        missing, slope, _ = depth(curve, roll)
        left = inner - (roll - missing)
        low, high = roll if left > 0.0 else low, roll if left < 0.0 else high
        following = roll + left / (1.0 - slope)
        if not low <= following <= high:
            following = 0.5 * (low + high)
        step, roll = abs(following - roll), following
        if step < 1e-15:
            break
    return float(max(FLANK + (roll - curve.flank_start) / (curve.flank_end - curve.flank_start), FLANK))


@compiled
def stand(distance: float, axis1: Any, x: Any, y: Any, table: Any, polar: Any, radius: Any, axis2: Any) -> None:
    """Set R2 and axis2 (n, m), infinite where the wheel has no point, of pinion points (1 or n, m) at angles (n,), see `search_contacts`.

    The wheel's polar angle goes by a table over its rising radii.
    """
    last = len(table) - 1
    for i in range(len(axis1)):
        cosine, sine, points, cell = math.cos(axis1[i]), math.sin(axis1[i]), i if len(x) > 1 else 0, 0
        for j in range(x.shape[1]):
            across = distance - (x[points, j] * cosine - y[points, j] * sine)
            along = -(x[points, j] * sine + y[points, j] * cosine)
            here = math.sqrt(across * across + along * along)
            radius[i, j], axis2[i, j] = here, np.inf
            if table[0] <= here <= table[last]:
                # Points of an outline lie beside each other, and so do their cells.
                while cell > 0 and here < table[cell]:
                    cell -= 1
                while cell < last - 1 and here >= table[cell + 1]:
                    cell += 1
                slope = (polar[cell + 1] - polar[cell]) / (table[cell + 1] - table[cell])
                axis2[i, j] = math.atan2(along, across) - (slope * (here - table[cell]) + polar[cell])


@compiled
def met_within(radius: Any, low: float, high: float, first: Any, last: Any) -> None:
    """Set the first and last points, one beyond, between which an outline passes radii from low to high; -1 where it does not."""
    end = radius.shape[1] - 1
    for i in range(len(radius)):
        first[i] = last[i] = -1
        for j in range(end):
            one, other = radius[i, j], radius[i, j + 1]
            if max(one, other) >= low and min(one, other) <= high:
                if first[i] < 0:
                    first[i] = max(j - 1, 0)
                last[i] = min(j + 2, end)


@compiled
def minima(axis2: Any, lowest: Any) -> Any:
    """Return rows and columns of the local minima of samples (n, m) that may be as low as a value (n,), if convex between samples."""
    end = axis2.shape[1] - 1
    place = np.empty((2, axis2.size // 2 + len(axis2)), np.intp)
    count = 0
    for i in range(len(axis2)):
        for j in range(end + 1):
            here = axis2[i, j]
            before, after = axis2[i, j - 1] if j > 0 else np.inf, axis2[i, j + 1] if j < end else np.inf
            if here < np.inf and here <= before and here < after and here - (max(before, after) - here) <= lowest[i]:
                place[0, count], place[1, count] = i, j
                count += 1
    return place[0, :count].copy(), place[1, :count].copy()


@compiled
def refine(pinion: Any, wheel: Any, distance: float, axis1: Any, row: Any, low: Any, high: Any, kind: Any, u: Any) -> int:
    """Move parameters of the pinion to the touch in each candidate; return how many did not converge.

    Newton's method inside a bracket, halved where Newton leaves it or dawdles, on the angle between the normals, or on R2 above the
    wheel's edge (`EDGE2`). The curvature changes its sign on a shelf (`SHELF`), where no slope is known.
    """
    failed = 0
    for i in range(len(u)):
        cosine, sine, lower, upper, at = math.cos(axis1[row[i]]), math.sin(axis1[row[i]]), low[i], high[i], u[i]
        before, converged = upper - lower, False
        for _ in range(ITERATIONS):
            x0, y0, normal1 = place(pinion, at)
            x, y = distance - (x0 * cosine - y0 * sine), x0 * sine + y0 * cosine
            radius, direction = math.hypot(x, y), normal1 + axis1[row[i]]
            u2 = at_radius(wheel, min(max(radius, wheel.form_radius), wheel.tip_radius))
            x2, y2, normal2 = place(wheel, u2)
            mismatch = direction - normal2 - math.atan2(-y, x) + math.atan2(y2, x2)
            if radius > wheel.tip_radius:
                mismatch = NOWHERE
            elif radius < wheel.form_radius:
                mismatch = -NOWHERE
            curvature, stretch = bent(pinion, at)
            missing, slope = mismatch, (curvature + bent(wheel, u2)[0]) * stretch
            if kind[i] == SHELF:
                missing, slope = math.copysign(1.0, mismatch) * slope, 0.0
            elif kind[i] == EDGE2:
                missing, slope = radius - wheel.form_radius, (y * math.cos(direction) + x * math.sin(direction)) / radius * stretch
            if missing > 0.0:
                lower = at
            else:
                upper = at
            following = at + missing / slope if slope > 0.0 else math.nan
            if not (lower <= following <= upper and abs(following - at) < 0.5 * before and abs(mismatch) < 0.5):
                following = 0.5 * (lower + upper)
            before, at = abs(following - at), following
            if before <= SMALLEST_STEP:
                converged = True
                break
        u[i] = at
        failed += not converged
    return failed
