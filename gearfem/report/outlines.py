"""Outlines of several teeth in the fixed frame, for pictures."""

from __future__ import annotations

import math

import numpy as np

from gearfem.flank import Outline
from gearfem.foundation import Array
from gearfem.pipeline import Results


def several_teeth(outline: Outline, centre_x: float, axis: float, turn: float, neighbours: int = 2) -> Array:
    """Return the outline of several teeth in the fixed frame.

    Parameters
    ----------
    outline : Outline
        Working side of a tooth; the idle one is without wear.
    centre_x : float
        Where the gear's axis lies on the line of centres [m].
    axis : float
        Polar angle of the axis of tooth 0 about the gear's centre [rad].
    turn : float
        +1 if tooth k follows tooth 0 clockwise, as on the pinion; -1 as on the wheel.
    neighbours : int
        Teeth to draw on each side of tooth 0.

    Returns
    -------
    ndarray, shape (n, 2)
        Points [m] in order of increasing polar angle about the gear's centre.
    """
    # Sixty points on each of the five segments keep the chord error of the largest under a micrometre.
    u = np.linspace(0.0, 5.0, 301)
    tooth = np.concatenate([Outline(gear=outline.gear).point(u)[:-1] * (1.0, -1.0), outline.point(u)[::-1]])
    parts = []
    for number in range(neighbours, -neighbours - 1, -1) if turn > 0.0 else range(-neighbours, neighbours + 1):
        angle = axis - turn * number * outline.gear.pitch_angle
        cosine, sine = math.cos(angle), math.sin(angle)
        parts.append(tooth @ np.array([[cosine, sine], [-sine, cosine]]) + (centre_x, 0.0))
    return np.concatenate(parts)


def engaged_outlines(results: Results, neighbours: int = 2) -> tuple[Array, Array]:
    """Return pinion and wheel at angle 0, where pair 0 touches at the pitch point.

    Parameters
    ----------
    results : Results
        With its flanks.
    neighbours : int
        Teeth on each side of tooth 0.

    Returns
    -------
    pinion, wheel : ndarray, shape (n, 2)
        Points in the fixed frame, origin at the pinion's axis, x towards the wheel's [m].

    Notes
    -----
    The driving flank of the pinion is the described side y > 0 and lies on the pitch point, so the axis of its
    tooth 0 stands at minus the half angle at the working pitch circle. The wheel's tooth stands above it: its
    axis at pi minus its half angle, which turns its described side down, on to the pinion's flank.
    """
    pair = results.setup.pair
    cosine = math.cos(pair.working_pressure_angle)
    start1 = -pair.pinion.half_angle(pair.pinion.base_radius / cosine)
    start2 = math.pi - pair.wheel.half_angle(pair.wheel.base_radius / cosine)
    pinion = several_teeth(results.flanks.pinion, 0.0, start1, 1.0, neighbours)
    wheel = several_teeth(results.flanks.wheel, pair.centre_distance, start2, -1.0, neighbours)
    return pinion, wheel


def teeth_around(outline: Outline, neighbours: int = 2) -> Array:
    """Return tooth 0 on the x axis and its neighbours, in the tooth's frame.

    Parameters
    ----------
    outline : Outline
        One side of a tooth.
    neighbours : int
        Teeth on each side.

    Returns
    -------
    ndarray, shape (n, 2)
        Points [m] in order of increasing polar angle.
    """
    return several_teeth(outline, 0.0, 0.0, 1.0, neighbours)
