"""Measured points of a working flank: from the file's columns to roll length and missing metal, exactly."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.measured_flank import MeasuredFlank
from gearfem.definition.setup import Gear, Member
from gearfem.foundation import Array, InputError
from gearfem.foundation.columns import read_columns
from gearfem.foundation.units import MM, UM

ROLLS, POINTS = ("roll_length_mm", "deviation_um"), ("x_mm", "y_mm")
FEWEST = 8
# Points may stand out of the outline of the rack's tooth by so many modules: wear removes metal, burrs and error add some.
BEYOND = 0.1


def read_flank(path: Path, file: str, member: Member, tooth: int | None, gear: Gear) -> MeasuredFlank:
    """Return the measured points of a file.

    Parameters
    ----------
    path : Path
        CSV file with the header `roll_length_mm,deviation_um` or `x_mm,y_mm`.
    file : str
        Its name as the model gives it.
    member, tooth : str, int or None
        Gear and tooth that were measured; None is every tooth.
    gear : Gear
        Nominal gear to whose involute the points are referred.

    Returns
    -------
    MeasuredFlank

    Raises
    ------
    InputError
        On the first fault, with file, row and column; points (x, y) that fit neither system, or points outside the tooth.

    Notes
    -----
    x and y are counted in the tooth's system (Wojnarowski & Onishchenko 2003, eq. 1: x along the tooth's axis from
    X0 = r_b cos g0, y from the axis) or in the gear's (x from the gear's centre), whichever all points can lie in. g0 is
    the half angle on the base circle of the gear as it is, thinned for its backlash, since eq. 1 counts from the start of
    the involute; with the unthinned one x would differ by r_b sin(g0) times the thinning over r_b, 7 um on the pinion
    of the coal combine.
    """
    columns = read_columns(path, (ROLLS, POINTS), FEWEST)
    if columns.names == ROLLS:
        roll, depth = columns.values[:, 0] * MM, columns.values[:, 1] * UM
        system, row = "roll length", np.arange(1, len(roll) + 1)
        _refuse_rolls(roll, depth, gear, str(path))
    else:
        points, system = _in_gear(columns.values * MM, gear, str(path))
        row = 1 + np.flatnonzero(np.hypot(*points.T) >= gear.base_radius)
        roll, depth = from_points(points[row - 1], gear)
    below = np.setdiff1d(np.arange(1, len(columns.values) + 1), row)
    return MeasuredFlank(member=member, tooth=tooth, file=file, system=system, row=row, roll=roll, depth=depth, below=below)


def from_points(points: Array, gear: Gear) -> tuple[Array, Array]:
    """Return roll lengths and missing metal of points beside the involute.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        x along the tooth's axis from the gear's centre and y towards the flank [m], not inside the base circle.
    gear : Gear
        Whose nominal involute is meant.

    Returns
    -------
    roll, depth : ndarray, shape (n,)
        Roll length s of the normal that runs through the point, and metal missing along it, d [m].

    Notes
    -----
    Every normal of the involute touches the base circle. From the point the tangent to it has the length
    t = sqrt(R^2 - r_b^2) and touches at the polar angle theta - atan(t/r_b), where the normal of the roll length s touches
    at g0 - s/r_b: so s = r_b (g0 - theta) + r_b atan(t/r_b) and d = s - t. Exact (derived here).
    """
    base = gear.base_radius
    tangent = np.sqrt(np.maximum(points[:, 0] ** 2 + points[:, 1] ** 2 - base**2, 0.0))
    roll = base * (gear.base_half_angle - np.arctan2(points[:, 1], points[:, 0]) + np.arctan(tangent / base))
    return roll, roll - tangent


def to_points(roll: Array, depth: Array, gear: Gear) -> Array:
    """Return the points (n, 2) [m] in the gear's system that lie a depth below the involute; the inverse of `from_points`."""
    tangent = roll - depth
    polar = gear.base_half_angle - roll / gear.base_radius + np.arctan(tangent / gear.base_radius)
    radius = np.hypot(gear.base_radius, tangent)
    return np.stack([radius * np.cos(polar), radius * np.sin(polar)], axis=-1)


def tip_roll(gear: Gear) -> float:
    """Return the roll length [m] of the tip circle."""
    return math.sqrt(gear.tip_radius**2 - gear.base_radius**2)


def farthest_roll(gear: Gear) -> float:
    """Return the roll length [m] up to which points are taken: a tenth of the module beyond the tip circle."""
    return tip_roll(gear) + BEYOND * gear.module


def _refuse_rolls(roll: Array, depth: Array, gear: Gear, file: str) -> None:
    far = farthest_roll(gear)
    for row in np.flatnonzero((roll < 0.0) | (roll > far)):
        allowed = f"from 0 (base circle) to {far / MM:.4f} mm (a tenth of the module beyond the tip circle)"
        raise InputError(f"row {row + 1}, column roll_length_mm", f"{roll[row] / MM:g}", allowed, file)
    for row in np.flatnonzero((depth >= roll) | _outside(to_points(roll, depth, gear), gear)):
        allowed = "metal missing along the normal that leaves the point between the tooth's axis and the middle of the space"
        raise InputError(f"row {row + 1}, column deviation_um", f"{depth[row] / UM:g} at {roll[row] / MM:g} mm", allowed, file)


def _outside(points: Array, gear: Gear) -> NDArray[np.bool_]:
    """Say which points in the gear's system lie outside the half pitch of this flank, or off its height."""
    radius, polar = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    slack = BEYOND * gear.module
    off_height = (radius < gear.root_radius - slack) | (radius > gear.tip_radius + slack)
    return np.asarray(off_height | (polar <= 0.0) | (polar >= np.pi / gear.teeth))


def _in_gear(points: Array, gear: Gear, file: str) -> tuple[Array, str]:
    """Return points of either system in the gear's, and the name of the system in which they were given."""
    start = np.array([gear.base_radius * math.cos(gear.base_half_angle), 0.0])
    systems = {"the tooth's system": points + start, "the gear's system": points}
    outside = {name: _outside(moved, gear) for name, moved in systems.items()}
    fitting = [name for name, wrong in outside.items() if not wrong.any()]
    if len(fitting) == 1:
        return systems[fitting[0]], fitting[0]
    bounds = (gear.root_radius / MM, gear.tip_radius / MM)
    ranges = (
        f"points on the side y > 0 of the tooth, x from {bounds[0]:.3f} to {bounds[1]:.3f} mm in the gear's system "
        f"or from {bounds[0] - start[0] / MM:.3f} to {bounds[1] - start[0] / MM:.3f} mm in the tooth's"
    )
    if fitting:
        raise InputError(
            "columns x_mm and y_mm", "points that can lie in either system", f"roll_length_mm,deviation_um here: {ranges}", file
        )
    nearest = min(outside, key=lambda name: int(outside[name].sum()))
    row = int(np.flatnonzero(outside[nearest])[0])
    found = f"({points[row, 0] / MM:g}, {points[row, 1] / MM:g}), outside the tooth"
    raise InputError(f"row {row + 1}, columns x_mm and y_mm", found, ranges, file)
