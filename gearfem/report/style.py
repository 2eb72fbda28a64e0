"""One look for all pictures: size, colours that colour-blind readers tell apart, zones of contact, saving."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from gearfem.engagement.record import Engagement
from gearfem.foundation import Array
from gearfem.foundation.files import whole

Arguments = ParamSpec("Arguments")
Drawn = TypeVar("Drawn")

# Okabe & Ito, "Color universal design" (2008): distinct under all common kinds of colour blindness.
BLUE, VERMILION, GREEN, PURPLE, ORANGE = "#0072B2", "#D55E00", "#009E73", "#AA4499", "#E69F00"
INK, GREY, SHADE = "#222222", "#777777", "#E9EDF1"
SINGLE, WIDE, SQUARE = (5.6, 3.5), (11.4, 4.2), (5.6, 5.2)
DOTS_PER_INCH = 200

LOOK: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.5,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "xtick.color": INK,
    "ytick.color": INK,
    "text.color": INK,
}


def make_figure(size: tuple[float, float], rows: int = 1, columns: int = 1) -> tuple[Figure, list[Axes]]:
    """Return a figure with its axes in reading order; it draws with Agg, without a display.

    Parameters
    ----------
    size : tuple of float
        Width and height [inch].
    rows, columns : int
        Grid of axes; rows share x.

    Returns
    -------
    Figure, list of Axes
    """
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(rows, columns, sharex=rows > 1, squeeze=False)
    return figure, list(grid.flat)


def styled(draw: Callable[Arguments, Drawn]) -> Callable[Arguments, Drawn]:
    """Let a function draw in the common look, whatever the caller's matplotlib settings are."""

    @functools.wraps(draw)
    def wrapped(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Drawn:
        with matplotlib.rc_context(LOOK):
            return draw(*args, **kwargs)

    return wrapped


def legend_below(figure: Figure, axes: Axes, columns: int = 3) -> None:
    """Put the legend of some axes under the picture, where it hides no curve."""
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=columns)


def save(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG, whole or not at all.

    Parameters
    ----------
    figure : Figure
        From `make_figure`.
    path : Path
        Target file.

    Returns
    -------
    Path
        The same path.
    """
    with whole(path) as temporary, matplotlib.rc_context(LOOK):
        figure.savefig(temporary, dpi=DOTS_PER_INCH, format="png", metadata={"Software": None})
    return Path(path)


def shade_zones(axes: Axes, engagement: Engagement, pitch: float, labels: bool = True) -> None:
    """Shade the angles at which two or more pairs carry, and name the zones above the axes.

    Parameters
    ----------
    axes : Axes
        Over the pinion angle in pitches.
    engagement : Engagement
        Whose forces decide.
    pitch : float
        Angular pitch of the pinion [rad].
    labels : bool
        Whether to write "1 pair", "2 pairs" above.
    """
    x = engagement.contacts.pinion_angle / pitch
    count = engagement.pairs_in_contact
    step = np.flatnonzero(np.diff(count))
    edges = np.concatenate([x[:1], 0.5 * (x[step] + x[step + 1]), x[-1:]])
    numbers = count[np.concatenate([[0], step + 1])]
    for left, right, number in zip(edges[:-1], edges[1:], numbers, strict=True):
        if number > 1:
            axes.axvspan(left, right, color=SHADE, zorder=0, linewidth=0)
        # Zones narrower than a tenth of the picture have room for the number alone, below a fiftieth for nothing.
        share = (right - left) / (x[-1] - x[0])
        if labels and share > 0.02:
            text = f"{number} pair{'s' if number > 1 else ''}" if share > 0.1 else f"{number}"
            axes.annotate(
                text,
                (0.5 * (left + right), 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0, 2),
                textcoords="offset points",
                ha="center",
                color=GREY,
                fontsize=7.5,
            )


def over_pitches(axes: Axes, label: str, low: float = -1.0, high: float = 1.0) -> None:
    """Name the axes of a picture over the pinion angle in pitches."""
    axes.set_xlim(low, high)
    axes.set_xlabel("pinion angle, pitches (0: pair 0 at the pitch point)")
    axes.set_ylabel(label)


def two_pitches(angle: Array, values: Array, pitch: float) -> tuple[Array, Array]:
    """Return the last two pitches of a steady motion as a curve over -1 to 1 pitch.

    Parameters
    ----------
    angle, values : ndarray, shape (n,)
        Increasing pinion angles [rad] and any quantity there.
    pitch : float
        Angular pitch of the pinion [rad].

    Returns
    -------
    x, y : ndarray
        Angle in pitches, increasing, and the quantity; a motion of less than two pitches is repeated.
    """
    x = angle / pitch
    # A thousandth of a pitch forgives a period whose last sample is left out.
    span = 2.0 if x[-1] - x[0] > 2.0 - 2.0 / x.size - 1e-3 else 1.0
    last = x > x[-1] - span + 1e-9
    x, y = (x[last] + 1.0) % span - 1.0, values[last]
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    return (x, y) if span == 2.0 else (np.append(x, x + 1.0), np.append(y, y))
