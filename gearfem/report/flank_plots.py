"""Measured flanks beside their fits: points, curve, breakpoints, residuals and outliers, drawn and as a table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from gearfem.flank import FittedFlank, fitted_flanks
from gearfem.foundation import Array
from gearfem.foundation.files import write_csv
from gearfem.foundation.units import MM, UM
from gearfem.pipeline import Results
from gearfem.report import style
from gearfem.report.summary import identity

# Further flanks are in the table; side by side they could not be read.
MOST_DRAWN = 4
# Points of dense records hide each other unless they are small.
DENSE = 200


@style.styled
def plot_flanks(flanks: Sequence[FittedFlank]) -> Figure:
    """Draw the points and the fit of measured flanks, and below them what is left.

    Parameters
    ----------
    flanks : sequence of FittedFlank
        One column each, the first four.

    Returns
    -------
    Figure
    """
    shown = flanks[:MOST_DRAWN]
    figure = Figure(figsize=(max(style.SINGLE[0], 3.8 * len(shown)), 5.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, len(shown), sharex="col", squeeze=False)
    for column, flank in zip(axes.T, shown, strict=True):
        _fit(column[0], flank)
        _residuals(column[1], flank)
    axes[0, 0].set_ylabel("metal missing, µm")
    axes[1, 0].set_ylabel("residual, µm")
    style.legend_below(figure, axes[0, 0], columns=4)
    return figure


def plot_measured_flanks(results: Results) -> Figure:
    """Draw the measured flanks of a model; as `plot_flanks`."""
    return plot_flanks(fitted_flanks(results.setup))


def _fit(axis: Axes, flank: FittedFlank) -> None:
    size = 2.0 if flank.roll.size > DENSE else 4.0
    kept = flank.kept
    axis.plot(flank.roll[kept] / MM, flank.depth[kept] / UM, "o", color=style.BLUE, markersize=size, alpha=0.6, label="points")
    _outliers(axis, flank, flank.depth)
    nodes = flank.deviation.roll
    axis.plot(nodes / MM, flank.deviation.depth / UM, color=style.GREY, linewidth=1.0, linestyle=":", label="spline, run out")
    inside = np.linspace(flank.roll[0], flank.roll[-1], 600)
    axis.plot(inside / MM, flank.deviation.at(inside) / UM, color=style.INK, label="fit")
    _breaks(axis, flank, "breakpoint")
    teeth = "all teeth" if flank.points.tooth is None else f"tooth {flank.points.tooth}"
    axis.set_title(f"{flank.points.member}, {teeth}: degree {', '.join(map(str, flank.curve.degrees))}")


def _residuals(axis: Axes, flank: FittedFlank) -> None:
    size = 2.0 if flank.roll.size > DENSE else 4.0
    axis.axhspan(-flank.residual_std / UM, flank.residual_std / UM, color=style.SHADE, zorder=0, linewidth=0)
    axis.plot(flank.roll[flank.kept] / MM, flank.residual[flank.kept] / UM, "o", color=style.BLUE, markersize=size, alpha=0.6)
    _outliers(axis, flank, flank.residual)
    _breaks(axis, flank, None)
    axis.set_title(f"standard deviation {flank.residual_std / UM:.3g} µm (shaded)")
    axis.set_xlabel("roll length, mm")
    margin = 0.1 * (flank.roll[-1] - flank.roll[0])
    axis.set_xlim((flank.roll[0] - margin) / MM, (flank.roll[-1] + margin) / MM)


def _outliers(axis: Axes, flank: FittedFlank, values: Array) -> None:
    wrong = ~flank.kept
    if wrong.any():
        axis.plot(flank.roll[wrong] / MM, values[wrong] / UM, "x", color=style.VERMILION, markersize=7, label="outliers, with rows")
    for roll, value, row in zip(flank.roll[wrong], values[wrong], flank.row[wrong], strict=True):
        axis.annotate(f"{row}", (roll / MM, value / UM), xytext=(5, 3), textcoords="offset points", color=style.VERMILION, fontsize=7.5)


def _breaks(axis: Axes, flank: FittedFlank, label: str | None) -> None:
    for number, place in enumerate(flank.curve.breakpoints):
        axis.axvline(place / MM, color=style.GREEN, linewidth=0.8, linestyle="--", label=label if number == 0 else None)


def write_measured_flanks(results: Results, out: Path) -> Path:
    """Write measured_flanks.csv: every point of every measured flank, what the fit makes of it, and what is left.

    Parameters
    ----------
    results : Results
        Of a model with measured flanks.
    out : Path
        Folder.

    Returns
    -------
    Path
        The file; its comments hold one sentence for each flank.
    """
    flanks = fitted_flanks(results.setup)
    columns: dict[str, list[Any]] = {
        name: [] for name in ("gear", "tooth", "row", "use", "roll_length_mm", "deviation_um", "fit_um", "residual_um")
    }
    for flank in flanks:
        points = flank.points
        fit = flank.deviation.at(points.roll)
        aside, wrong = set(flank.aside.tolist()), set(flank.outliers)
        for row, roll, depth, value in zip(points.row.tolist(), points.roll, points.depth, fit, strict=True):
            use = "outlier" if row in wrong else "aside" if row in aside else "fitted"
            tooth = "all" if points.tooth is None else str(points.tooth)
            line = (points.member, tooth, row, use, roll / MM, depth / UM, value / UM, (depth - value) / UM)
            for column, item in zip(columns.values(), line, strict=True):
                column.append(item)
    path = Path(out) / "measured_flanks.csv"
    write_csv(path, columns, (identity(results.setup), *(flank.sentence for flank in flanks)))
    return path


def write_measured_picture(results: Results, out: Path) -> Path:
    """Write measured_flanks.png, `plot_measured_flanks`, and return the file."""
    return style.save(plot_measured_flanks(results), Path(out) / "measured_flanks.png")
