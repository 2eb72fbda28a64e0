"""Speed sweeps as CSV."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from gearfem.definition.setup import Setup
from gearfem.dynamics.measures import HARMONICS
from gearfem.dynamics.sweep_record import Sweep, SweepPoint
from gearfem.foundation.files import write_csv
from gearfem.foundation.units import factor
from gearfem.report.summary import identity

# Column, and the number of a point that it holds.
COLUMNS: dict[str, Callable[[SweepPoint], float | int | str]] = {
    "pinion_speed_rpm": lambda point: point.pinion_speed,
    "direction": lambda point: point.direction,
    "mesh_frequency_Hz": lambda point: point.mesh_frequency,
    "natural_frequency_Hz": lambda point: point.natural_frequency,
    "tuning": lambda point: point.tuning,
    "dynamic_factor": lambda point: point.dynamic_factor_max,
    "dynamic_factor_min": lambda point: point.dynamic_factor_min,
    "mesh_force_max_N": lambda point: point.mesh_force_max,
    "mesh_force_mean_N": lambda point: point.mesh_force_mean,
    "transmission_error_mean_um": lambda point: point.error_mean,
    "transmission_error_rms_um": lambda point: point.error_rms,
    "contact_loss": lambda point: point.contact_loss,
    "back_contact": lambda point: point.back_contact,
    "period_cycles": lambda point: point.period_cycles,
    "growth_per_cycle": lambda point: point.growth,
    "wheel_torque_Nm": lambda point: point.wheel_torque,
    "steps_per_cycle": lambda point: point.steps,
}


def write_sweep(sweep: Sweep, setup: Setup, out: Path) -> tuple[Path, Path]:
    """Write sweep.csv, one row per direction and speed, and sweep_spectrum.csv, one row per line of its spectra.

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
        The two files.

    Notes
    -----
    Columns of sweep.csv: `direction` is `rest` (each speed from rest), `up` or `down`; `tuning` the mesh frequency over
    `natural_frequency_Hz`; `dynamic_factor` the largest Kw and `dynamic_factor_min` the least; `mesh_force_*` the normal
    force of all pairs together; `transmission_error_rms_um` without its mean; `contact_loss` the part of the time without contact on
    the working flank and `back_contact` that on the back flank; `period_cycles` the mesh cycles after which the motion repeats, 0
    where it does not (the row then holds statistics of 96 cycles), and where teeth differ those after which the same ones meet again;
    `growth_per_cycle` the largest Floquet multiplier per
    cycle, or the mean growth of neighbouring motions; then `te_harmonic_n_um` and `te_harmonic_n_phase_rad`, n = 1 to 6, of the
    dynamic transmission error A cos(n z1 phi1 + phase), angle 0 being pair 0 at the pitch point.
    In sweep_spectrum.csv `order` counts per turn of the pinion; lines without amplitude are left out.
    """
    points = sweep.points
    columns: dict[str, ArrayLike] = {}
    for name, take in COLUMNS.items():
        values = np.array([take(point) for point in points])
        columns[name] = values / factor(name) if factor(name) != 1.0 else values
    for number in range(HARMONICS):
        columns[f"te_harmonic_{number + 1}_um"] = np.array([point.harmonic_amplitude[number] for point in points]) / factor("_um")
        columns[f"te_harmonic_{number + 1}_phase_rad"] = np.array([point.harmonic_phase[number] for point in points])
    table, spectra = Path(out) / "sweep.csv", Path(out) / "sweep_spectrum.csv"
    write_csv(table, columns, comments=(identity(setup),))
    write_csv(spectra, _spectra(sweep, setup), comments=(identity(setup),))
    return table, spectra


def _spectra(sweep: Sweep, setup: Setup) -> dict[str, ArrayLike]:
    lines = [(point, number) for point in sweep.points for number in np.flatnonzero(point.line_amplitude)]
    return {
        "pinion_speed_rpm": np.array([point.pinion_speed for point, _ in lines]) / factor("_rpm"),
        "direction": np.array([point.direction for point, _ in lines]),
        "order": np.array([point.line_order[number] for point, number in lines]) * setup.pair.pinion.teeth,
        "transmission_error_um": np.array([point.line_amplitude[number] for point, number in lines]) / factor("_um"),
    }
