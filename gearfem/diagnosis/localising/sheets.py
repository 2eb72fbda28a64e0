"""The cells in which a gap is looked for: mesh phase, orders and teeth of each record, and fixed frequencies over all."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.localising.zones import PHASES, ZONES, in_zones, leading_teeth, order_lines, phase_cells
from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.reading.measurement import Measurement
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
        As in `gearfem.diagnosis.localising.localise.Map`.
    size : ndarray, shape (c,)
        Samples, or lines, in each cell.
    measure : callable
        Takes whitened residuals of all records, shape (m, p), and returns the power of each cell, shape (c, p).
    """

    record: str
    domain: Domain
    part: str
    label: tuple[str, ...]
    size: Array
    measure: Callable[[Array], Array]


def sheets_of(problem: Problem, settings: Settings) -> list[Sheet]:
    """Return the sheets of all records of a problem.

    Parameters
    ----------
    problem : Problem
        Prepared: its rows are those of the whitened residuals.
    settings : Settings
        Where the gears stand.

    Returns
    -------
    list of Sheet
        Of each record zones and cells of the mesh phase, teeth of both gears and lines of the order spectrum; then fixed frequencies. None
        of erratic motions.
    """
    pair, bench = problem.campaign.setup.pair, problem.bench(())
    told = [(record, own) for record, own in zip(problem.records, problem.linear.rows, strict=True) if not record.erratic]
    angles = [bench.turned(record.axis[record.keep], settings) for record, _ in told]
    return [sheet for item, angle in zip(told, angles, strict=True) for sheet in _of_record(*item, angle, pair)] + _frequencies(told)


def _of_record(measurement: Measurement, rows: slice, angle: Array, pair: GearPair) -> list[Sheet]:
    """Return the sheets of one record at true pinion angles, which those that are over something else have not."""
    file = measurement.file
    if measurement.quantity.axis != "angle":
        return [_cell_sheet(file, rows, "mesh_phase", "zones", np.ones((rows.stop - rows.start, 1), bool), ("all",), fewest=1)]
    pinion, wheel = leading_teeth(angle, pair)
    phases = tuple(f"{i / PHASES:.4g}" for i in range(PHASES))
    teeth = {"pinion": pair.pinion.teeth, "wheel": pair.wheel.teeth}
    names = {gear: tuple(f"{gear}:{i}" for i in range(count)) for gear, count in teeth.items()}
    sheets = [
        _cell_sheet(file, rows, "mesh_phase", "zones", in_zones(angle, pair), ZONES),
        _cell_sheet(file, rows, "mesh_phase", "cells", _one_hot(phase_cells(angle, pair), PHASES), phases),
        _cell_sheet(file, rows, "tooth", "pinion", _one_hot(pinion, teeth["pinion"]), names["pinion"]),
        _cell_sheet(file, rows, "tooth", "wheel", _one_hot(wheel, teeth["wheel"]), names["wheel"]),
        _order_sheet(file, rows, angle, pair),
    ]
    return [sheet for sheet in sheets if sheet.label]


def _one_hot(cell: NDArray[Any], count: int) -> NDArray[Any]:
    """Return which cell each sample is in, shape (n, count)."""
    return np.asarray(cell[:, None] == np.arange(count))


def _cell_sheet(
    file: str, rows: slice, domain: Domain, part: str, inside: NDArray[Any], names: tuple[str, ...], fewest: int = FEWEST
) -> Sheet:
    used = np.flatnonzero(inside.sum(axis=0) >= fewest)
    weight = inside[:, used].T.astype(float)
    count = weight.sum(axis=1)
    return Sheet(
        record=file,
        domain=domain,
        part=part,
        label=tuple(names[i] for i in used),
        size=count,
        measure=lambda white: weight @ white[rows] ** 2 / count[:, None],
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


def _frequencies(told: list[tuple[Measurement, slice]]) -> list[Sheet]:
    """Bands of fixed frequency over all records taken at speed: a resonance of sensor or shaft stands still where orders move."""
    moving = [(record, own) for record, own in told if record.quantity.is_motion]
    if len({round(record.pinion_speed / RPM, 3) for record, _ in moving}) < 2:
        return []
    # Samples in a second of each record.
    rates = [(own.stop - own.start) / float(np.ptp(record.axis)) * record.pinion_speed for record, own in moving]
    lowest = max(record.pinion_speed for record, _ in moving) / (2.0 * math.pi)
    edges = np.geomspace(lowest, 0.4 * min(rates), BANDS + 1)
    spectra = [np.fft.rfftfreq(own.stop - own.start, 1.0 / rate) for (_, own), rate in zip(moving, rates, strict=True)]
    bands = [_one_hot(np.searchsorted(edges, spectrum) - 1, BANDS).T.astype(float) for spectrum in spectra]
    count = np.asarray(sum(band.sum(axis=1) for band in bands))

    def measure(white: Array) -> Array:
        parts = zip(moving, bands, strict=True)
        powers = (band @ np.abs(np.fft.rfft(white[own], axis=0)) ** 2 / (own.stop - own.start) for (_, own), band in parts)
        return np.asarray(sum(powers) / np.maximum(count, 1.0)[:, None])

    middle = np.sqrt(edges[1:] * edges[:-1])
    return [
        Sheet(record="speeds", domain="frequency", part="", label=tuple(f"{f:.4g}" for f in middle), size=count, measure=measure),
    ]
