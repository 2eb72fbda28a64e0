"""Pictures of a diagnosis: maps of what is left before and after, and measured beside computed."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from gearfem.definition.setup import Member
from gearfem.diagnosis.diagnose import Diagnosis
from gearfem.diagnosis.localising.localise import Localisation, Map
from gearfem.diagnosis.localising.zones import PHASES
from gearfem.diagnosis.reading.roles import ROLES
from gearfem.foundation import Array
from gearfem.foundation.units import RPM, digits, written
from gearfem.report import style

# Power in parts of what noise and nuisances leave: from noise alone to thirty times its size.
SCALE = LogNorm(1.0, 1000.0)
COLOURS = "magma_r"
ORDERS = 12
ONE_RECORD = 3.0


class Field(NamedTuple):
    """A map to draw: rows are records, columns cells; NaN where a record has no such cell."""

    rows: list[str]
    columns: list[str]
    power: Array


def write_diagnosis_pictures(diagnosis: Diagnosis, out: Path) -> dict[str, Path]:
    """Draw and write the pictures of a diagnosis.

    Parameters
    ----------
    diagnosis : Diagnosis
        Of a campaign.
    out : Path
        Folder.

    Returns
    -------
    dict of str to Path
        By name; those for which the campaign has no data are left out.
    """
    drawn = {
        "map_mesh_phase": plot_phase(diagnosis),
        "map_order": plot_orders(diagnosis),
        "map_pinion": plot_teeth(diagnosis, "pinion"),
        "map_wheel": plot_teeth(diagnosis, "wheel"),
        "records": plot_records(diagnosis),
        "gap": plot_gap(diagnosis),
    }
    return {name: style.save(figure, Path(out) / f"{name}.png") for name, figure in drawn.items() if figure is not None}


@style.styled
def plot_phase(diagnosis: Diagnosis) -> Figure | None:
    """Draw what is left over the mesh phase, one row for each record, before and after."""
    fields = _both(diagnosis, "mesh_phase", "cells")
    if fields is None:
        return None
    figure, axes = _panels(fields)
    for axis in axes:
        axis.set_xlabel("phase of the mesh, pitches from the pitch point")
        count = len(fields[0].columns)
        axis.set_xticks(np.linspace(-0.5, count - 0.5, 5), [f"{share:.2g}" for share in np.linspace(0.0, 1.0, 5)])
    return figure


@style.styled
def plot_orders(diagnosis: Diagnosis) -> Figure | None:
    """Draw what is left over the orders that are strongest before, one row for each record, before and after."""
    fields = _both(diagnosis, "order", "")
    if fields is None:
        return None
    strongest = np.argsort(-np.nanmax(np.nan_to_num(fields[0].power), axis=0))[:ORDERS]
    chosen = np.sort(strongest)
    fields = [Field(field.rows, [field.columns[i] for i in chosen], field.power[:, chosen]) for field in fields]
    figure, axes = _panels(fields)
    for axis in axes:
        axis.set_xlabel("order of the pinion's turns, the strongest ones")
        axis.set_xticks(range(len(chosen)), fields[0].columns, rotation=60, ha="right")
    return figure


@style.styled
def plot_teeth(diagnosis: Diagnosis, gear: Member) -> Figure | None:
    """Draw what is left over the teeth of one gear, one row for each record, before and after."""
    fields = _both(diagnosis, "tooth", gear)
    if fields is None:
        return None
    figure, axes = _panels(fields)
    numbers = [name.split(":")[1] for name in fields[0].columns]
    step = math.ceil(len(numbers) / 16)
    for axis in axes:
        axis.set_xlabel(f"tooth of the {gear}")
        axis.set_xticks(range(0, len(numbers), step), numbers[::step])
    return figure


@style.styled
def plot_records(diagnosis: Diagnosis) -> Figure | None:
    """Draw what is left of each record over three pitches: nuisances alone, and with what is named, if anything is."""
    gaps = [gap for gap in diagnosis.proof.records if gap.measurement.quantity.axis == "angle"]
    if not gaps:
        return None
    pitch, bench = diagnosis.campaign.setup.pair.pinion.pitch_angle, diagnosis.problem.bench(())
    figure, axes = style.make_figure((11.4, 0.9 + 1.7 * ((len(gaps) + 1) // 2)), rows=(len(gaps) + 1) // 2, columns=2)
    for axis, gap in zip(axes, gaps, strict=False):
        record = gap.measurement
        place = bench.turned(record.axis, diagnosis.naming.fit.settings) / pitch
        place = place - np.ceil(place[0])
        shown = (place >= 0.0) & (place <= ONE_RECORD) & record.keep
        axis.plot(place[shown], gap.nuisances_only[shown] * record.to_file, color=style.ORANGE, linewidth=1.0, label="nuisances alone")
        if diagnosis.naming.fit.effects:
            axis.plot(place[shown], gap.after[shown] * record.to_file, color=style.BLUE, linewidth=1.0, label="with what is named")
        axis.axhspan(-gap.floor_rms * record.to_file, gap.floor_rms * record.to_file, color=style.SHADE, zorder=0, label="floor")
        axis.set_title(f"{record.file}, {ROLES[gap.role]}")
        axis.set_ylabel(written(record.quantity.unit))
    for axis in axes[len(gaps) :]:
        axis.set_visible(False)
    for axis in axes[-2:]:
        axis.set_xlabel("pinion angle from the first whole pitch of the record on, pitches")
    style.legend_below(figure, axes[0])
    return figure


@style.styled
def plot_gap(diagnosis: Diagnosis) -> Figure | None:
    """Draw the gap of each record in parts of its floor: before, nuisances alone, smooth correction, after."""
    gaps = diagnosis.proof.records
    figure, axes = style.make_figure((11.4, 1.3 + 0.42 * len(gaps)))
    series = (
        ("before", style.GREY, [gap.before for gap in gaps]),
        ("nuisances alone", style.ORANGE, [gap.nuisances_only for gap in gaps]),
        ("smooth correction", style.GREEN, [gap.smooth for gap in gaps]),
        *([("after", style.BLUE, [gap.after for gap in gaps])] if diagnosis.naming.fit.effects else []),
    )
    for label, colour, left in series:
        parts = zip(gaps, left, strict=True)
        rows = [(gap.rms(values) / gap.floor_rms, -number) for number, (gap, values) in enumerate(parts) if values.size]
        if not rows:
            continue
        axes[0].plot(*zip(*rows, strict=True), "o", color=colour, label=label, markersize=7 if label == "after" else 5)
    axes[0].axvline(1.0, color=style.INK, linewidth=1.0, linestyle=":", label="floor: noise and waviness")
    axes[0].set_xscale("log")
    axes[0].set_yticks([-number for number in range(len(gaps))], [f"{gap.measurement.file}, {ROLES[gap.role]}" for gap in gaps])
    axes[0].set_ylim(0.6 - len(gaps), 0.4)
    axes[0].set_xlabel("root mean square of what is left, in parts of the floor")
    axes[0].xaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
    for set_formatter in (axes[0].xaxis.set_major_formatter, axes[0].xaxis.set_minor_formatter):
        set_formatter("{x:g}")
    style.legend_below(figure, axes[0], columns=5)
    return figure


# ---- maps -----------------------------------------------------------------------------------------------


def _both(diagnosis: Diagnosis, domain: str, part: str) -> list[Field] | None:
    """Return the maps of one domain before and, where anything is named, after; records in the order of torque and speed."""
    found = (diagnosis.before, diagnosis.after) if diagnosis.naming.fit.effects else (diagnosis.before,)
    fields = [_field(diagnosis, localisation, domain, part) for localisation in found]
    return [field for field in fields if field is not None] if all(field is not None for field in fields) else None


def _field(diagnosis: Diagnosis, localisation: Localisation, domain: str, part: str) -> Field | None:
    maps = {one.record: one for one in localisation.maps if one.domain == domain and one.part == part}
    records = sorted(
        (r for r in diagnosis.campaign.of("fit") if r.file in maps), key=lambda r: (r.quantity.moving, r.pinion_torque, r.pinion_speed)
    )
    if not records:
        return None
    columns = _columns([maps[record.file] for record in records], domain)
    power = np.full((len(records), len(columns)), np.nan)
    for row, record in enumerate(records):
        one = maps[record.file]
        places = [columns.index(label) for label in one.label]
        power[row, places] = one.power / np.maximum(one.expected, 1e-12)
    rows = [f"{digits(r.pinion_torque)} N m" + (f", {digits(r.pinion_speed / RPM)} rpm" if r.pinion_speed else "") for r in records]
    return Field(rows, columns, power)


def _columns(maps: list[Map], domain: str) -> list[str]:
    if domain == "mesh_phase":
        return [f"{cell / PHASES:.4g}" for cell in range(PHASES)]
    labels = {label for one in maps for label in one.label}
    return sorted(labels, key=lambda label: float(label.split(":")[-1]))


def _panels(fields: list[Field]) -> tuple[Figure, list[Axes]]:
    figure, axes = style.make_figure((11.4, 1.5 + 0.3 * len(fields[0].rows)), columns=len(fields))
    words = ("before: nuisances alone", "after: with what is named") if len(fields) > 1 else ("nuisances alone; nothing is named",)
    for number, (axis, field, word) in enumerate(zip(axes, fields, words, strict=True)):
        picture = _map(axis, field, number == 0)
        axis.set_title(word)
    _bar(figure, axes, picture)
    return figure, axes


def _map(axis: Axes, field: Field, named: bool) -> object:
    picture = axis.imshow(field.power, aspect="auto", cmap=COLOURS, norm=SCALE, interpolation="nearest")
    axis.set_facecolor(style.SHADE)
    axis.grid(False)
    axis.set_yticks(range(len(field.rows)), field.rows if named else [""] * len(field.rows))
    return picture


def _bar(figure: Figure, axes: list[Axes], picture: object) -> None:
    bar = figure.colorbar(picture, ax=axes, fraction=0.03, pad=0.01, extend="both")  # type: ignore[arg-type]
    bar.set_label("power over what is expected")
