"""Pictures of motion: time series and spectrum of one speed, sweep and waterfall over the speed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gearfem.definition.setup import Setup
from gearfem.dynamics.record import ElasticMotion
from gearfem.dynamics.sweep_record import Direction, Sweep
from gearfem.foundation.units import RPM, UM
from gearfem.report import style

LOOKS: dict[Direction, tuple[str, str, str]] = {
    "rest": (style.BLUE, "-", "each speed from rest"),
    "up": (style.BLUE, "-", "speed rising"),
    "down": (style.VERMILION, "--", "speed falling"),
}
HIGHEST_ORDER = 6
MOST_SPECTRA = 40
# Half the width at which a line is drawn, in mesh orders; subharmonics of 1/8 stay apart.
HAT = 0.06


@style.styled
def plot_time_series(motion: ElasticMotion) -> Figure:
    """Draw the dynamic factor and the transmission error of the elastic model over the time.

    Parameters
    ----------
    motion : ElasticMotion
        Steady motion at one speed.

    Returns
    -------
    Figure
    """
    figure, (upper, lower) = style.make_figure(style.WIDE, rows=2)
    upper.plot(motion.time * 1e3, motion.dynamic_factor, color=style.BLUE)
    upper.set_ylabel("dynamic factor $K_w$")
    lower.plot(motion.time * 1e3, motion.transmission_error / UM, color=style.VERMILION)
    lower.set_ylabel("transmission\nerror, µm")
    lower.set_xlabel("time, ms")
    upper.set_title("" if motion.periodic else "not periodic: part of an unsettled motion")
    return figure


@style.styled
def plot_spectrum(motion: ElasticMotion, setup: Setup) -> Figure:
    """Draw amplitudes of dynamic factor and transmission error over the order of the pinion's turns.

    Parameters
    ----------
    motion : ElasticMotion
        Whole mesh cycles at equal times.
    setup : Setup
        Whose motion it is.

    Returns
    -------
    Figure
    """
    teeth = setup.pair.pinion.teeth
    cycles = round(motion.time.size * (motion.time[1] - motion.time[0]) * setup.operation.pinion_speed * teeth / (2.0 * np.pi))
    figure, (upper, lower) = style.make_figure(style.WIDE, rows=2)
    for axis, values, colour, label in (
        (upper, motion.dynamic_factor, style.BLUE, "amplitude of $K_w$"),
        (lower, motion.transmission_error / UM, style.VERMILION, "amplitude of the\ntransmission error, µm"),
    ):
        lines = 2.0 * np.abs(np.fft.rfft(values)) / values.size
        number = np.arange(1, min(lines.size, HIGHEST_ORDER * 2 * cycles + 1))
        axis.vlines(number * teeth / cycles, 0.0, lines[number], color=colour)
        axis.set_ylabel(label)
        axis.set_ylim(bottom=0.0)
    lower.set_xticks(teeth * np.arange(2 * HIGHEST_ORDER + 1))
    lower.set_xlabel(f"order, per turn of the pinion (multiples of z₁ = {teeth})")
    return figure


@style.styled
def plot_sweep(sweep: Sweep) -> Figure:
    """Draw dynamic factor, transmission error and loss of contact over the speed, both branches where both were run.

    Parameters
    ----------
    sweep : Sweep
        Points where the motion does not repeat are hollow.

    Returns
    -------
    Figure
    """
    figure, axes = style.make_figure((style.WIDE[0], 7.5), rows=3)
    shown = (
        ("dynamic_factor_max", 1.0, "largest dynamic\nfactor $K_w$"),
        ("error_rms", UM, "dynamic transmission\nerror, rms, µm"),
        ("contact_loss", 0.01, "without contact,\n% of the time"),
    )
    for direction in sweep.directions:
        colour, line, label = LOOKS[direction]
        speed, wild = sweep.column("pinion_speed", direction) / RPM, sweep.column("period_cycles", direction) == 0
        for axis, (name, unit, _) in zip(axes, shown, strict=True):
            values = sweep.column(name, direction) / unit
            axis.plot(speed, values, color=colour, linestyle=line, marker=".", markersize=3.0, label=label)
            axis.plot(speed[wild], values[wild], "o", mfc="white", mec=colour, markersize=4.0, label="_not periodic")
    for axis, (_, _, label) in zip(axes, shown, strict=True):
        axis.set_ylabel(label)
    axes[-1].set_xlabel("pinion speed, rpm")
    _resonances(figure, sweep)
    style.legend_below(figure, axes[0])
    return figure


def _resonances(figure: Figure, sweep: Sweep) -> None:
    """Mark the speeds at which the mesh frequency is the natural one, its double, and its parts."""
    speeds = np.array([point.pinion_speed for point in sweep.points])
    full = sweep.points[0].pinion_speed / sweep.points[0].tuning
    for part, name in ((2.0, "2 $f_n$"), (1.0, "$f_n$"), (0.5, "$f_n$/2"), (1.0 / 3.0, "$f_n$/3")):
        if speeds.min() <= part * full <= speeds.max():
            for number, axis in enumerate(figure.axes):
                axis.axvline(part * full / RPM, color=style.GREY, linewidth=0.7, linestyle=":")
                if number == 0:
                    axis.text(
                        part * full / RPM, 1.01, name, transform=axis.get_xaxis_transform(), ha="center", color=style.GREY, fontsize=7.5
                    )


@style.styled
def plot_waterfall(sweep: Sweep, teeth: int) -> Figure:
    """Draw the spectra of the transmission error in orders of the pinion's turns, one above the other with the speed.

    Parameters
    ----------
    sweep : Sweep
        One picture for each direction; of many speeds, some forty.
    teeth : int
        Of the pinion.

    Returns
    -------
    Figure
    """
    names = sweep.directions
    figure, axes = style.make_figure((style.WIDE[0], 5.5), columns=len(names))
    end = HIGHEST_ORDER * teeth
    for axis, direction in zip(axes, names, strict=True):
        branch = sweep.branch(direction)
        chosen = branch[:: max(1, -(-len(branch) // MOST_SPECTRA))]
        speeds = np.array([point.pinion_speed for point in chosen]) / RPM
        highest = max(float(point.line_amplitude.max()) for point in chosen)
        height = 0.2 * max(float(np.ptp(speeds)), 0.1 * speeds[0])
        colour, _, label = LOOKS[direction]
        # From behind to the front, each hat hides what is behind it.
        for layer, (speed, point) in enumerate(zip(speeds[::-1], chosen[::-1], strict=True), start=3):
            some = np.flatnonzero(point.line_amplitude > 1e-3 * highest)
            # Lines of single teeth stand closer than the lines of the mesh: their hats are narrower.
            hat = min(HAT, 0.4 * float(np.diff(point.line_order[some]).min(initial=HAT))) * teeth
            x = (teeth * point.line_order[some, None] + hat * np.array([-1.0, 0.0, 1.0])).ravel()
            x = np.concatenate([[0.0], x, [end + HAT * teeth]])
            y = np.concatenate([[0.0], (height * point.line_amplitude[some, None] / highest * np.array([0.0, 1.0, 0.0])).ravel(), [0.0]])
            axis.fill_between(x, speed, speed + y, color="white", linewidth=0.0, zorder=layer)
            axis.plot(x, speed + y, color=colour, linewidth=0.7, zorder=layer)
        axis.set_title(f"{label}; highest line {highest / UM:.2f} µm")
        axis.set_xticks(teeth * np.arange(HIGHEST_ORDER + 1))
        axis.set_xlabel("order, per turn of the pinion")
    axes[0].set_ylabel("pinion speed, rpm")
    return figure


def write_motion_pictures(motion: ElasticMotion, setup: Setup, out: Path) -> tuple[Path, ...]:
    """Write time_series.png and spectrum.png of the motion at one speed.

    Parameters
    ----------
    motion : ElasticMotion
        Of the elastic model.
    setup : Setup
        Whose motion it is.
    out : Path
        Folder.

    Returns
    -------
    tuple of Path
    """
    figures = {"time_series": plot_time_series(motion), "spectrum": plot_spectrum(motion, setup)}
    return tuple(style.save(figure, Path(out) / f"{name}.png") for name, figure in figures.items())


def write_sweep_pictures(sweep: Sweep, setup: Setup, out: Path) -> tuple[Path, ...]:
    """Write sweep.png and waterfall.png.

    Parameters
    ----------
    sweep : Sweep
        At least one point.
    setup : Setup
        Whose sweep it is.
    out : Path
        Folder.

    Returns
    -------
    tuple of Path
    """
    figures = {"sweep": plot_sweep(sweep), "waterfall": plot_waterfall(sweep, setup.pair.pinion.teeth)}
    return tuple(style.save(figure, Path(out) / f"{name}.png") for name, figure in figures.items())
