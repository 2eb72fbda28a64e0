"""A drawing to scale of the two gears in engagement at angle 0."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearfem.definition.setup import GearPair
from gearfem.foundation import Array
from gearfem.foundation.units import MM
from gearfem.pipeline import Results
from gearfem.report import style
from gearfem.report.outlines import engaged_outlines


def _pitch_radii(pair: GearPair) -> tuple[float, float]:
    cosine = math.cos(pair.working_pressure_angle)
    return pair.pinion.base_radius / cosine, pair.wheel.base_radius / cosine


@style.styled
def plot_pair(results: Results) -> Figure:
    """Draw the teeth around the pitch point to scale, with pitch circles, line of action and path of contact.

    Parameters
    ----------
    results : Results
        With its flanks.

    Returns
    -------
    Figure
    """
    pair = results.setup.pair
    figure, (axis,) = style.make_figure(style.SQUARE)
    pinion, wheel = engaged_outlines(results)
    for outline, centre, colour in ((pinion, 0.0, style.BLUE), (wheel, pair.centre_distance, style.VERMILION)):
        closed = np.concatenate([outline, [[centre, 0.0]]]) / MM
        axis.fill(closed[:, 0], closed[:, 1], color=colour, alpha=0.13, linewidth=0)
        axis.plot(*(outline / MM).T, color=colour, linewidth=1.3)
    _circles(axis, pair)
    _line_of_action(axis, pair)
    reach = 1.55 * math.pi * pair.pinion.module / MM
    centre = _pitch_radii(pair)[0] / MM
    axis.set_xlim(centre - reach, centre + reach)
    axis.set_ylim(-0.92 * reach, 0.92 * reach)
    axis.set_aspect("equal")
    axis.grid(False)
    axis.set_xlabel("x from the pinion's axis towards the wheel's, mm")
    axis.set_ylabel("y, mm")
    for name, place, colour in (("pinion", 0.03, style.BLUE), ("wheel", 0.97, style.VERMILION)):
        axis.text(place, 0.03, name, transform=axis.transAxes, color=colour, ha="left" if name == "pinion" else "right", weight="bold")
    style.legend_below(figure, axis)
    return figure


def _circles(axis: Axes, pair: GearPair) -> None:
    first, second = _pitch_radii(pair)
    swing = np.linspace(-0.6, 0.6, 400)
    for radius, centre, sign in ((first, 0.0, 1.0), (second, pair.centre_distance, -1.0)):
        axis.plot(
            (centre + sign * radius * np.cos(swing)) / MM,
            radius * np.sin(swing) / MM,
            color=style.GREY,
            linewidth=0.7,
            linestyle=(0, (8, 3, 2, 3)),
            label="working pitch circles" if sign > 0.0 else None,
        )


def _line_of_action(axis: Axes, pair: GearPair) -> None:
    first, _ = _pitch_radii(pair)
    along = np.array([math.sin(pair.working_pressure_angle), math.cos(pair.working_pressure_angle)])
    pitch_point = np.array([first, 0.0])

    def stretch(low: float, high: float) -> Array:
        ends: Array = (pitch_point + np.array([[low], [high]]) * along) / MM
        return ends

    far = 2.0 * pair.base_pitch
    axis.plot(*stretch(-far, far).T, color=style.INK, linewidth=0.8, label="line of action")
    axis.plot(*stretch(-pair.approach_length, pair.recess_length).T, color=style.INK, linewidth=3.0, alpha=0.75, label="path of contact")
    touching = [k * pair.base_pitch for k in range(-2, 3) if -pair.approach_length <= k * pair.base_pitch <= pair.recess_length]
    points = (pitch_point + np.array(touching)[:, None] * along) / MM
    axis.plot(*points.T, "o", color="white", markeredgecolor=style.INK, markersize=5)
    axis.annotate("C", (first / MM, 0.0), xytext=(9, -15), textcoords="offset points", weight="bold")
