"""Pictures of wear: its depth over the flank as the pair ages, and what follows from it."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearfem.definition.setup import Member, Setup
from gearfem.flank import Deviation, make_flanks
from gearfem.foundation.units import MM, UM
from gearfem.report import style
from gearfem.wear import Life
from gearfem.wear.volume import MM3

MEMBERS: tuple[Member, Member] = ("pinion", "wheel")
AGES = 6


@style.styled
def plot_depths(life: Life) -> Figure:
    """Draw the depth of wear over the roll length of both gears at several ages.

    Parameters
    ----------
    life : Life
        From `gearfem.wear.wear_over`.

    Returns
    -------
    Figure
    """
    figure, axes = style.make_figure(style.WIDE, columns=2)
    rows = np.unique(np.searchsorted(life.turns, np.linspace(0.0, 1.0, AGES + 1)[1:] * life.turns[-1] * (1.0 - 1e-12)))
    colours = matplotlib.colormaps["viridis"](np.linspace(0.9, 0.0, rows.size))
    for axis, member in zip(axes, MEMBERS, strict=True):
        gear = getattr(life.setup.pair, member)
        roll = Deviation.none(gear).roll
        for row, colour in zip(rows, colours, strict=True):
            axis.plot(roll / MM, life.depth(member)[row] / UM, color=colour, label=f"{life.hours[row]:.4g} h")
        mark_flank(axis, life.setup, member)
        axis.set_ylim(bottom=0.0)
        axis.set_title(f"{member}, z = {gear.teeth}")
    axes[0].set_ylabel("depth worn off, µm")
    style.legend_below(figure, axes[0], columns=AGES + 2)
    return figure


def mark_flank(axis: Axes, setup: Setup, member: Member) -> None:
    """Mark pitch point and lowest contact point over the roll length, and cut the axis off at the ends of the flank."""
    pair, flanks = setup.pair, make_flanks(setup)
    outline, mate = flanks.of(member), flanks.of("wheel" if member == "pinion" else "pinion")
    lowest = pair.centre_distance * np.sin(pair.working_pressure_angle) - mate.flank_end
    middle = outline.gear.base_radius * np.tan(pair.working_pressure_angle)
    axis.axvline(middle / MM, color=style.INK, linewidth=0.8, linestyle="--", label="pitch point")
    axis.axvline(lowest / MM, color=style.GREY, linewidth=0.8, linestyle=":", label="lowest contact")
    axis.set_xlim(outline.flank_start / MM, outline.flank_end / MM)
    axis.set_xlabel("roll length, mm (root left, tip right)")


@style.styled
def plot_life(life: Life) -> Figure:
    """Draw volumes and transmission error over the life.

    Parameters
    ----------
    life : Life
        From `gearfem.wear.wear_over`.

    Returns
    -------
    Figure
    """
    figure, (upper, lower) = style.make_figure((style.SINGLE[0], 4.6), rows=2)
    upper.plot(life.hours, life.pinion_volume / MM3, color=style.BLUE, label="pinion")
    upper.plot(life.hours, life.wheel_volume / MM3, color=style.VERMILION, linestyle="--", label="wheel")
    upper.set_ylabel("metal missing\nfrom a flank, mm³")
    lower.plot(life.hours, life.transmission_error / UM, color=style.INK)
    lower.set_ylabel("transmission error,\npeak to peak, µm")
    lower.set_xlabel("time, h")
    for axis in (upper, lower):
        axis.set_ylim(bottom=0.0)
    lower.set_xlim(0.0, life.hours[-1])
    figure.align_ylabels()
    style.legend_below(figure, upper)
    return figure


def write_wear_pictures(life: Life, out: Path) -> tuple[Path, ...]:
    """Write wear_depth.png and wear_life.png."""
    return style.save(plot_depths(life), Path(out) / "wear_depth.png"), style.save(plot_life(life), Path(out) / "wear_life.png")
