"""Myga's rig: what each unpublished number does to the largest dynamic factor, beside 1.20 measured and 1.36 computed.

    python studies/myga_rig/unknowns.py --out results

One unknown at a time is moved from the base (solid discs, damping ratio 0.06, no friction, perfect teeth, one of the four
meshes), then the ends of all ranges together. Tooth errors are a flank error once per tooth whose peak-to-peak value is the
form deviation of the grade: errors that differ from tooth to tooth need a longer period and are left out. Four pinions on one
wheel: all drive it, its torque is the sum; at 90 degrees 36 teeth put all meshes in step, and other places shift them.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from common import print_table, write_rows
from three_models import with_error

from gearfem import Setup, load_model, run
from gearfem.definition.drive_parts import Support
from gearfem.dynamics import DriveTrain, elastic_motion, make_drive, uniform_transport
from gearfem.dynamics.flank_force import flank_force
from gearfem.dynamics.iso6336_kv import form_deviation, iso6336_dynamic_factor
from gearfem.dynamics.sweep import sweep
from gearfem.engagement.engage import mesh_force
from gearfem.engagement.record import MeshForce
from gearfem.foundation import Array
from gearfem.report import style

MEASURED, AUTHORS = 1.20, 1.36
PHASES = {"four pinions, in step": (0.0, 0.0, 0.0, 0.0), "four pinions, a quarter pitch apart": (0.0, 0.25, 0.5, 0.75)}
CYCLES, STEP = 8, 0.05
# End of the plot's axis.
SHOWN = 1.7


def largest(mesh: MeshForce, drive: DriveTrain) -> float:
    """Return the largest Kw at the drive's own speed."""
    return float(sweep(mesh, drive, [drive.pinion_speed]).column("dynamic_factor_max", "rest")[0])


def with_form_error(mesh: MeshForce, size: float, turn: float) -> MeshForce:
    """Return flanks with a sinusoidal error of this peak-to-peak size, `turn` of a pitch late."""
    place = 2.0 * np.pi * (mesh.pinion_angle / mesh.period - turn)
    return with_error(mesh, 0.5 * size * (1.0 - np.cos(place)))


def four_pinions(mesh: MeshForce, drive: DriveTrain, phases: tuple[float, ...]) -> float:
    """Return the largest Kw of any pinion where several drive one wheel, their meshes `phases` of a pitch apart.

    J1 psi_k'' = T1 - P_k r_b1, J2 psi'' = sum P_k r_b2 - n T1 r_b2/r_b1; classical Runge-Kutta, last of 8 cycles.
    """
    r1, r2, count = mesh.base_radius1, mesh.base_radius2, len(phases)
    force = flank_force(mesh)
    mass = 1.0 / (r1**2 / drive.pinion_inertia + r2**2 / drive.wheel_inertia)
    damping = 2.0 * drive.damping_ratio * np.sqrt(mesh.mean_stiffness * mass)
    push = drive.pinion_torque / r1
    shift = mesh.pinion_angle[0] + np.array(phases) * mesh.period

    def loads(time: float, x: Array, rate: Array) -> Array:
        values, _ = force(shift + drive.pinion_speed * time, x, shift, False)
        pressed = np.where(x > 0.0, np.maximum(values[:, 0] + damping * rate, 0.0), 0.0)
        back = np.where(x < -mesh.normal_backlash, np.minimum(mesh.mean_stiffness * (x + mesh.normal_backlash), 0.0), 0.0)
        return pressed + back

    def change(time: float, y: Array) -> Array:
        p = loads(time, y[0], y[1])
        return np.array([y[1], r1**2 / drive.pinion_inertia * (push - p) - r2**2 / drive.wheel_inertia * (p.sum() - count * push)])

    length = mesh.period / drive.pinion_speed
    steps = int(np.ceil(length * np.sqrt(mesh.mean_stiffness / mass) / STEP))
    h, y, top = length / steps, np.array([np.full(count, push / mesh.mean_stiffness), np.zeros(count)]), 0.0
    for step in range(CYCLES * steps):
        t = step * h
        k1 = change(t, y)
        k2 = change(t + 0.5 * h, y + 0.5 * h * k1)
        k3 = change(t + 0.5 * h, y + 0.5 * h * k2)
        y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + change(t + h, y + h * k3))
        if step >= (CYCLES - 1) * steps:
            top = max(top, float(loads(t + h, y[0], y[1]).max()))
    return top / push


def rows_of(setup: Setup, small: bool) -> list[dict[str, Any]]:
    """Return one row for each value of each unknown: its Kw."""
    made = run(setup, until="compliance").mesh
    mesh, drive = mesh_force(made, setup.operation.pinion_torque), make_drive(setup)
    gear = setup.pair.wheel
    rows: list[tuple[str, str, float]] = [("base", "", largest(mesh, drive))]

    def scaled(factor: float) -> DriveTrain:
        return dataclasses.replace(drive, pinion_inertia=factor * drive.pinion_inertia, wheel_inertia=factor * drive.wheel_inertia)

    rows += [("inertia of the drive", f"discs times {k:g}", largest(mesh, scaled(k))) for k in (0.5, 2.0, 5.0, 20.0)]
    rows += [("damping ratio", f"{z:g}", largest(mesh, dataclasses.replace(drive, damping_ratio=z))) for z in (0.02, 0.12, 0.18, 0.24)]
    rows += [("tooth friction", f"{f:g}", largest(mesh, dataclasses.replace(drive, friction_coefficient=f))) for f in (0.05, 0.08, 0.12)]
    for grade in (5, 6, 7):
        size = form_deviation(gear, grade)
        for turn in (0.0, 0.5) if small else (0.0, 0.25, 0.5, 0.75):
            label = f"grade {grade}, {size * 1e6:.1f} um, {turn:g} pitch late"
            rows.append(("tooth errors", label, largest(with_form_error(mesh, size, turn), drive)))
    rows += [("four pinions", name.partition(", ")[2], four_pinions(mesh, drive, phases)) for name, phases in PHASES.items()]
    for compliance in () if small else (2e-9, 10e-9):
        support = Support(compliance=compliance, mass=1.5, damping=0.1 * np.sqrt(1.5 / compliance))
        held = dataclasses.replace(drive, pinion_support=support, wheel_support=support)
        motion = elastic_motion(mesh, held, uniform_transport(mesh, held), cycles=1, tolerance=1e-6)
        rows.append(("yielding supports", f"{compliance * 1e9:g} um/kN", motion.largest_dynamic_factor))
    sizes = [0.0, *(form_deviation(gear, grade) for grade in ((7,) if small else (5, 7)))]
    rows += together(mesh, drive, sizes, 2 if small else 13)
    return [
        {"unknown": a, "value": b, "dynamic_factor": kw, "over_measured": kw / MEASURED, "over_authors": kw / AUTHORS} for a, b, kw in rows
    ]


def together(mesh: MeshForce, drive: DriveTrain, sizes: list[float], count: int) -> list[tuple[str, str, float]]:
    """Return the least and the largest Kw over a grid of inertia, damping and tooth error of one of the four meshes."""
    found = []
    for size in sizes:
        for turn in (0.0, 0.25, 0.5, 0.75) if size else (0.0,):
            flanks = with_form_error(mesh, size, turn) if size else mesh
            for factor in np.geomspace(0.5, 20.0, count):
                for damping in (0.02, 0.06, 0.24):
                    inertias = {"pinion_inertia": factor * drive.pinion_inertia, "wheel_inertia": factor * drive.wheel_inertia}
                    label = f"discs times {factor:.3g}, damping {damping:g}, error {size * 1e6:.1f} um, {turn:g} pitch late"
                    found.append(("grid of all", label, largest(flanks, dataclasses.replace(drive, damping_ratio=damping, **inertias))))
    return [min(found, key=lambda row: row[2]), max(found, key=lambda row: row[2])]


def ranges(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the range of Kw of each unknown, the base included, and whether it holds the published figures."""
    base = rows[0]["dynamic_factor"]
    table = []
    for name in dict.fromkeys(row["unknown"] for row in rows[1:]):
        values = [base, *(row["dynamic_factor"] for row in rows if row["unknown"] == name)]
        low, high = min(values), max(values)
        held = {"holds_1_20": low <= MEASURED <= high, "holds_1_36": low <= AUTHORS <= high}
        table.append({"unknown": name, "least": low, "largest": high, **{key: "yes" if value else "no" for key, value in held.items()}})
    return table


def main(arguments: list[str] | None = None) -> dict[str, list[dict[str, Any]]]:
    """Write unknowns.csv, ranges.csv, iso6336.csv and unknowns.png, print the tables and what they say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder for tables and plot")
    parser.add_argument("--small", action="store_true", help="fewer values")
    options = parser.parse_args(arguments)
    setup = load_model(Path(__file__).with_name("model.toml"))
    rows = rows_of(setup, options.small)
    table = ranges(rows)
    operation = setup.operation
    norms = []
    for grade in (5, 6, 7, 8):
        found = iso6336_dynamic_factor(setup.pair, operation.pinion_torque, operation.pinion_speed, grade)
        numbers = ("resonance_ratio", "lower_limit", "range", "pitch_parameter", "form_parameter", "relief_parameter", "dynamic_factor")
        norms.append({"grade": grade, **{name: getattr(found, name) for name in numbers}})
    for name, part in (("unknowns", rows), ("ranges", table), ("iso6336", norms)):
        write_rows(options.out / f"{name}.csv", part)
    draw(rows, norms, options.out / "unknowns.png")
    print_table("Largest Kw of Myga's rig: 1.20 measured, 1.36 computed by the authors", rows)
    print_table("Range of each unknown", table)
    print_table("K_v by ISO 6336-1, method B, for the grade of the teeth", norms)
    both = [row["unknown"] for row in table if row["holds_1_20"] == row["holds_1_36"] == "yes"]
    print(f"Unknowns whose range alone holds both 1.20 and 1.36: {', '.join(both) or 'none'}.")
    return {"rows": rows, "ranges": table, "norms": norms}


@style.styled
def draw(rows: list[dict[str, Any]], norms: list[dict[str, Any]], path: Path) -> Path:
    """Draw every Kw by unknown, with the published figures and the standard's."""
    figure, (axis,) = style.make_figure(style.WIDE)
    names = list(dict.fromkeys(row["unknown"] for row in rows))
    axis.plot([row["dynamic_factor"] for row in rows], [names.index(row["unknown"]) for row in rows], "o", color=style.BLUE)
    axis.plot([row["dynamic_factor"] for row in norms], [len(names)] * len(norms), "s", color=style.GREEN)
    axis.axvline(MEASURED, color=style.VERMILION, label="1.20 measured")
    axis.axvline(AUTHORS, color=style.ORANGE, label="1.36 computed by the authors")
    axis.set_yticks(range(len(names) + 1), [*names, "ISO 6336-1 B, grades 5 to 8"])
    axis.set_xlabel("largest dynamic factor")
    axis.set_xlim(1.0, SHOWN)
    for row in rows:
        if row["dynamic_factor"] > SHOWN:
            place = (0.995 * SHOWN, names.index(row["unknown"]) + 0.15)
            axis.annotate(f"up to {row['dynamic_factor']:.2f}, in resonance", place, ha="right")
    style.legend_below(figure, axis)
    return style.save(figure, path)


if __name__ == "__main__":
    main()
