"""The cells in which a gap is looked for: mesh phase, orders and teeth of each record, and fixed frequencies over all."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.comparison import Compared, Comparison
from gearfem.diagnosis.zones import PHASES, ZONES, in_zones, leading_teeth, order_lines, phase_cells
from gearfem.foundation import Array, Record
from gearfem.foundation.units import RPM

Domain = Literal["mesh_phase", "order", "tooth", "frequency"]
HARMONICS = 8.0
BANDS = 24
FEWEST = 12


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Sheet(Record):
    """Cells of one map, before anything is known of what noise does in them.

    Parameters
    ----------
    record, domain, part, label : str, str, str, tuple of str
        As in `gearfem.diagnosis.localise.Map`.
    size : ndarray, shape (c,)
        Samples, or lines, in each cell.
    measure : callable
        Takes the whitened residual of all records, shape (m,), and returns the power of each cell, shape (c,).
    """

    record: str
    domain: Domain
    part: str
    label: tuple[str, ...]
    size: Array
    measure: Callable[[Array], Array]


def sheets_of(record: Compared, comparison: Comparison) -> list[Sheet]:
    """Return the sheets of one record: zones and cells of the mesh phase, teeth of both gears, lines of the order spectrum."""
    measurement = record.measurement
    if measurement.quantity.axis != "angle":
        return [_whole(record)]
    pair = comparison.campaign.setup.pair
    angle = measurement.axis[measurement.keep] + comparison.settings.angle_offset
    rows = slice(*record.rows)
    pinion, wheel = leading_teeth(angle, pair)
    cells = [
        _zone_sheet(measurement.file, rows, angle, pair),
        _cell_sheet(
            measurement.file, rows, "mesh_phase", "cells", phase_cells(angle, pair), tuple(f"{i / PHASES:.4g}" for i in range(PHASES))
        ),
        _cell_sheet(measurement.file, rows, "tooth", "pinion", pinion, tuple(f"pinion:{i}" for i in range(pair.pinion.teeth))),
        _cell_sheet(measurement.file, rows, "tooth", "wheel", wheel, tuple(f"wheel:{i}" for i in range(pair.wheel.teeth))),
        _order_sheet(measurement.file, rows, angle, pair),
    ]
    return [sheet for sheet in cells if sheet.label]


def _whole(record: Compared) -> Sheet:
    rows = slice(*record.rows)
    return Sheet(
        record=record.measurement.file,
        domain="mesh_phase",
        part="zones",
        label=("all",),
        size=np.array([float(rows.stop - rows.start)]),
        measure=lambda white: np.array([np.mean(white[rows] ** 2)]),
    )


def _zone_sheet(file: str, rows: slice, angle: Array, pair: GearPair) -> Sheet:
    inside = in_zones(angle, pair)
    used = np.flatnonzero(inside.sum(axis=0) >= FEWEST)
    weight = inside[:, used].astype(float)
    count = weight.sum(axis=0)
    return Sheet(
        record=file,
        domain="mesh_phase",
        part="zones",
        label=tuple(ZONES[i] for i in used),
        size=count,
        measure=lambda white: (white[rows] ** 2) @ weight / count,
    )


def _cell_sheet(file: str, rows: slice, domain: Domain, part: str, cell: NDArray[Any], names: tuple[str, ...]) -> Sheet:
    count = np.bincount(cell, minlength=len(names))
    used = np.flatnonzero(count >= FEWEST)
    size = count[used].astype(float)
    return Sheet(
        record=file,
        domain=domain,
        part=part,
        label=tuple(names[i] for i in used),
        size=size,
        measure=lambda white: np.bincount(cell, white[rows] ** 2, minlength=len(names))[used] / size,
    )


def _order_sheet(file: str, rows: slice, angle: Array, pair: GearPair) -> Sheet:
    """Lines of shafts and mesh; neighbours closer than the record resolves are told apart by nothing, and the strongest stands for them."""
    turns = float(np.ptp(angle)) / (2.0 * math.pi)
    highest = min(HARMONICS * pair.pinion.teeth, 0.4 * len(angle) / max(turns, 1e-9))
    lines = [line for line in order_lines(pair, highest) if line[1] * turns > 0.7]
    waves = np.exp(-1j * np.outer([order for _, order in lines], angle)) * math.sqrt(2.0 / len(angle))
    return Sheet(
        record=file,
        domain="order",
        part="",
        label=tuple(name for name, _ in lines),
        size=np.ones(len(lines)),
        measure=lambda white: np.abs(waves @ white[rows]) ** 2 / 2.0,
    )


def frequencies(comparison: Comparison) -> list[Sheet]:
    """Bands of fixed frequency over all records taken at speed: a resonance of sensor or shaft stands still where orders move."""
    moving = [r for r in comparison.records if r.measurement.quantity.moving and r.measurement.quantity.axis == "angle"]
    speeds = {round(r.measurement.pinion_speed / RPM, 3) for r in moving}
    if len(speeds) < 2:
        return []
    rates = [r.measurement.pinion_speed / (2.0 * math.pi) for r in moving]
    highest = min(
        0.4 * len(r.white) / (float(np.ptp(r.measurement.axis)) / (2.0 * math.pi)) * rate for r, rate in zip(moving, rates, strict=True)
    )
    edges = np.geomspace(max(rates), highest, BANDS + 1)
    spectra = [np.fft.rfftfreq(len(r.white), float(np.ptp(r.measurement.axis)) / len(r.white) / r.measurement.pinion_speed) for r in moving]
    band = [np.searchsorted(edges, spectrum) - 1 for spectrum in spectra]
    count = sum(np.bincount(b[(b >= 0) & (b < BANDS)], minlength=BANDS) for b in band)

    def measure(white: Array) -> Array:
        total = np.zeros(BANDS)
        for record, cell in zip(moving, band, strict=True):
            part = white[slice(*record.rows)]
            power = np.abs(np.fft.rfft(part)) ** 2 / len(part)
            inside = (cell >= 0) & (cell < BANDS)
            total += np.bincount(cell[inside], power[inside], minlength=BANDS)
        return np.asarray(total / np.maximum(count, 1))

    middle = np.sqrt(edges[1:] * edges[:-1])
    return [
        Sheet(
            record="speeds",
            domain="frequency",
            part="",
            label=tuple(f"{f:.4g}" for f in middle),
            size=np.asarray(count, float),
            measure=measure,
        )
    ]
