"""The load along the face width, over the pinion angle and where it is largest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gearfem.definition.setup import Setup
from gearfem.engagement.width_load import WidthLoad
from gearfem.foundation.units import MM, N_PER_MM
from gearfem.report import style

COLOURS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE)


def name(pair: int) -> str:
    """Return the number of a pair with its sign, 0 without one."""
    return f"{pair:+d}" if pair else "0"


@style.styled
def plot_width(setup: Setup, torque: float, along: WidthLoad) -> Figure:
    """Draw the line load of all pairs over angle and face width, and that of each pair where it is largest.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.
    torque : float
        Torque on the pinion [N m].
    along : WidthLoad
        Loads along the face width under it.

    Returns
    -------
    Figure
    """
    figure, (left, right) = style.make_figure((11.4, 4.2), columns=2)
    x, place = along.pinion_angle / setup.pair.pinion.pitch_angle, along.place / MM
    total = along.line_load.sum(axis=1) / N_PER_MM
    colours = left.pcolormesh(x, place, total.T, cmap="viridis", vmin=0.0, shading="gouraud", rasterized=True)
    figure.colorbar(colours, ax=left, label="line load, all pairs together, N/mm", pad=0.02)
    style.over_pitches(left, "place along the face width, mm", float(x[0]), float(x[-1]))
    left.grid(False)
    left.set_title(f"{torque:.5g} N m, face load factor $K_{{Hβ}}$ up to {along.face_load_factor.max():.3f}")
    row, column = divmod(int(along.line_load.max(axis=2).argmax()), len(along.pairs))
    left.axvline(x[row], color="white", linewidth=0.8, linestyle=":")
    for number in np.flatnonzero(along.force[row] > 0.0):
        colour, pair = COLOURS[abs(along.pairs[number]) % len(COLOURS)], name(along.pairs[number])
        right.plot(place, along.line_load[row, number] / N_PER_MM, color=colour, marker="o", markersize=3, label=f"pair {pair}")
        mean = along.force[row, number] / along.face_width / N_PER_MM
        right.axhline(mean, color=colour, linewidth=0.8, linestyle=":", label=f"mean of pair {pair}")
    right.set_ylim(bottom=0.0)
    right.set_xlabel("place along the face width, mm")
    right.set_ylabel("line load, N/mm")
    right.set_title(f"at {x[row]:+.3f} pitches, where pair {name(along.pairs[column])} has the largest line load")
    right.legend()
    return figure


def write_width_picture(setup: Setup, torque: float, along: WidthLoad, out: Path) -> Path:
    """Write load_over_width.png; arguments as `plot_width`, and the folder."""
    return style.save(plot_width(setup, torque, along), Path(out) / "load_over_width.png")
