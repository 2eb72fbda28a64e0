"""Pictures of `gearfem stiffness`: stiffness with its zones of contact, and the carpet of the transmission error."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gearfem.definition.setup import Setup
from gearfem.engagement.carpet import Carpet
from gearfem.engagement.record import Engagement
from gearfem.foundation import Array
from gearfem.foundation.units import N_PER_UM, UM
from gearfem.report import style
from gearfem.report.summary import iso_stiffness

COLOURS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE, style.ORANGE)
CURVES = 9


@style.styled
def plot_zones(setup: Setup, engagements: Sequence[Engagement]) -> Figure:
    """Draw the mesh stiffness of each torque over the pinion angle, and below it when each pair carries.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.
    engagements : sequence of Engagement
        One per torque; shades and bars are those of the first.

    Returns
    -------
    Figure
        Bars run through approach (before the pitch point) and recess (behind it), paler where a tip edge touches off the path.
    """
    first, pitch = engagements[0], setup.pair.pinion.pitch_angle
    figure = style.make_figure((6.4, 4.6))[0]
    figure.clear()
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[3.0, 1.0])
    style.shade_zones(upper, first, pitch)
    style.shade_zones(lower, first, pitch, labels=False)
    x = first.contacts.pinion_angle / pitch
    for number, one in enumerate(engagements):
        colour = COLOURS[number % len(COLOURS)]
        torque = f"{one.pinion_torque:.5g} N m"
        upper.plot(x, one.mesh_stiffness / N_PER_UM, color=colour, label=f"slope dF/dδ, {torque}")
        if len(engagements) < 3:
            upper.plot(x, one.secant_stiffness / N_PER_UM, color=colour, linestyle="--", label=f"secant F/δ, {torque}")
    iso = iso_stiffness(setup).mesh_stiffness * setup.pair.face_width / N_PER_UM
    upper.axhline(iso, color=style.INK, linewidth=0.9, linestyle=":", label=r"ISO 6336-1 B, $c_{\gamma\alpha}\,b$")
    upper.set_ylim(bottom=0.0)
    upper.set_ylabel("mesh stiffness, N/µm")
    _bars(lower, first, x)
    style.over_pitches(lower, f"pair, at\n{first.pinion_torque:.5g} N m", float(x[0]), float(x[-1]))
    figure.align_ylabels()
    handles, labels = upper.get_legend_handles_labels()
    more, names = lower.get_legend_handles_labels()
    figure.legend(handles + more, labels + names, loc="outside lower center", ncols=3)
    return figure


def _bars(axis: Axes, engagement: Engagement, x: Array) -> None:
    """Draw one bar for each pair that carries: approach, recess, and tip edges."""
    contacts, half = engagement.contacts, 0.5 * float(x[1] - x[0])
    loaded_columns = [number for number, force in enumerate(engagement.force.T) if force.any()]
    carrying = sorted({contacts.pairs[number] for number in loaded_columns})
    kinds = {
        ("approach", ""): (style.BLUE, 0.85),
        ("approach", " on a tip edge"): (style.BLUE, 0.4),
        ("recess", ""): (style.VERMILION, 0.85),
        ("recess", " on a tip edge"): (style.VERMILION, 0.4),
    }
    for name, (colour, strength) in kinds.items():
        axis.broken_barh([], (0.0, 0.0), facecolor=colour, alpha=strength, linewidth=0, label="".join(name))
    for number in loaded_columns:
        row = carrying.index(contacts.pairs[number])
        loaded, on_path = engagement.force[:, number] > 0.0, contacts.on_flanks[:, number]
        for (side, edge), (colour, strength) in kinds.items():
            part = loaded & ((x < contacts.pairs[number]) == (side == "approach")) & (on_path == (not edge))
            spans = [(float(x[run[0]]) - half, float(x[run[-1]] - x[run[0]]) + 2.0 * half) for run in _runs(part)]
            axis.broken_barh(spans, (row - 0.32, 0.64), facecolor=colour, alpha=strength, linewidth=0)
    axis.set_yticks(range(len(carrying)), [f"{pair:+d}" if pair else "0" for pair in carrying])
    axis.set_ylim(-0.6, len(carrying) - 0.4)
    axis.grid(False, axis="y")


def _runs(flags: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """Return the stretches of two and more neighbouring samples whose flags are set."""
    numbers = np.flatnonzero(flags)
    return [run for run in np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1) if run.size > 1]


@style.styled
def plot_carpet(setup: Setup, carpet: Carpet) -> Figure:
    """Draw the transmission error over angle and torque: curves, and the change over the pitch in colour.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.
    carpet : Carpet
        Transmission errors.

    Returns
    -------
    Figure
        Left the error itself at some torques, right its difference from the mean of each torque, lines where the number of
        pairs changes.
    """
    figure, (left, right) = style.make_figure((11.4, 4.4), columns=2)
    x = carpet.pinion_angle / setup.pair.pinion.pitch_angle
    error = carpet.transmission_error / UM
    shown = np.unique(np.linspace(0, len(error) - 1, CURVES).round().astype(int))
    for row in shown:
        part = carpet.pinion_torque[row] / carpet.pinion_torque[-1]
        left.plot(x, error[row], color=style.BLUE, alpha=0.35 + 0.65 * part, linewidth=1.2)
        left.annotate(
            f"{carpet.pinion_torque[row]:.4g} N m",
            (1.0, error[row, -1]),
            xycoords=("axes fraction", "data"),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            fontsize=7.5,
            color=style.INK,
        )
    style.over_pitches(left, "lag of the wheel along the line of action, µm", float(x[0]), float(x[-1]))
    swing = error - error.mean(axis=1, keepdims=True)
    most = max(float(np.abs(swing).max()), 1e-9)
    colours = right.pcolormesh(x, carpet.pinion_torque, swing, cmap="RdBu_r", vmin=-most, vmax=most, shading="gouraud", rasterized=True)
    figure.colorbar(colours, ax=right, label="lag less its mean at this torque, µm", pad=0.02)
    pairs, torques = carpet.pairs_in_contact[1:], carpet.pinion_torque[1:]
    steps = np.arange(pairs.min(), pairs.max()) + 0.5
    if steps.size:
        right.contour(x, torques, pairs, levels=steps, colors=style.INK, linewidths=0.7)
    style.over_pitches(right, "torque on the pinion, N m", float(x[0]), float(x[-1]))
    right.grid(False)
    right.set_title("lines: another pair comes into contact or leaves it", fontsize=8.0, color=style.GREY)
    return figure


def write_stiffness_pictures(setup: Setup, engagements: Sequence[Engagement], carpet: Carpet, out: Path) -> tuple[Path, Path]:
    """Write mesh_stiffness.png and transmission_error_carpet.png.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.
    engagements : sequence of Engagement
        One per torque.
    carpet : Carpet
        Transmission errors.
    out : Path
        Folder.

    Returns
    -------
    tuple of Path
        The files.
    """
    zones = style.save(plot_zones(setup, engagements), Path(out) / "mesh_stiffness.png")
    return zones, style.save(plot_carpet(setup, carpet), Path(out) / "transmission_error_carpet.png")
