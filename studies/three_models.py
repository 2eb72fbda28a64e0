"""Rigid, elastic and classical model side by side under the same excitation: what a variable gear ratio adds.

The elastic model is taken apart: with the variable ratio, with the same flank error as a displacement on constant arms,
and without it; each with the inertias of the whole drive and (the classical model) of the gears alone. Worn flanks are
stood in for by a ratio that swings smoothly by 3 % once per tooth.

    python studies/three_models.py --out results
"""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from common import HERE, print_table, write_rows

from gearfem import Setup, load_model, run
from gearfem.dynamics import classical_motion, elastic_motion, make_drive, rigid_motion, uniform_transport, unloaded_transport
from gearfem.dynamics.periodic import kinked, smooth
from gearfem.engagement.engage import engage, mesh_force
from gearfem.engagement.record import MeshForce
from gearfem.foundation import Array
from gearfem.report import style

RIPPLE = 0.03
COLUMNS = 200
PAIRS = {"coal combine": "coal_combine", "Myga's rig": "myga_rig"}
MODELS = ("rigid", "elastic", "elastic, constant arms", "elastic, no error", "classical", "classical, no error")


def with_error(mesh: MeshForce, error: Array, slope: Array | float = 0.0) -> MeshForce:
    """Return the mesh of flanks with an unloaded transmission error e_u(phi1) [m].

    Its slope over the pinion angle [m/rad] sets the arms by the work of the normal force, l1 = r_b1 - e_u' and l2 = r_b2; with
    0 the error displaces the teeth and leaves the arms alone.
    """
    factor = 1.0 - np.broadcast_to(slope, error.shape)[:, None] / mesh.base_radius1
    columns = np.linspace(0.0, float(error.max() + mesh.deflection[-1]), COLUMNS)

    def moved(table: Array) -> Array:
        rows = [np.interp(columns - e, mesh.deflection, row, left=0.0) for e, row in zip(error, table, strict=True)]
        beyond = np.maximum(columns - error[:, None] - mesh.deflection[-1], 0.0)
        slope = (table[:, -1:] - table[:, -2:-1]) / (mesh.deflection[-1] - mesh.deflection[-2])
        return np.array(rows) + slope * beyond

    names = ("normal_force", "pinion_moment", "wheel_moment", "pinion_friction", "wheel_friction")
    tables = {name: moved(getattr(mesh, name)) for name in names}
    tables["pinion_moment"] = factor * tables["pinion_moment"]
    return dataclasses.replace(mesh, deflection=columns, unloaded_error=error, **tables)


def swinging(mesh: MeshForce, ripple: float) -> tuple[Array, Array]:
    """Return e_u and its slope for a rigid ratio that swings by `ripple` once per tooth.

    r_b1 phi1 - r_b2 phi2 = e_u = A (1 - cos(z1 phi1)) with A = ripple r_b1/z1 gives 1/i = (r_b1 - e_u')/r_b2.
    """
    order = 2.0 * np.pi / mesh.period
    slope = ripple * mesh.base_radius1 * np.sin(order * mesh.pinion_angle)
    return ripple * mesh.base_radius1 / order * (1.0 - np.cos(order * mesh.pinion_angle)), slope


def models(setup: Setup, ripple: float, speed: float) -> dict[str, tuple[Array, Array]]:
    """Return angle over pitch and Kw over one cycle of every model, at a multiple of the operating speed."""
    operation, pair = setup.operation, setup.pair
    made = run(setup, until="compliance").mesh
    drive = dataclasses.replace(make_drive(setup), pinion_speed=speed * operation.pinion_speed)
    plain = mesh_force(made, operation.pinion_torque)
    discs = tuple(gear.disc_inertia(pair.face_width) for gear in (pair.pinion, pair.wheel))
    found = {}
    angle = np.arange(1600) / 1600 * plain.period
    if ripple:
        ratio = pair.ratio / (1.0 - ripple * np.sin(2.0 * np.pi * angle / plain.period))
        found["rigid"] = rigid_motion(angle, ratio, plain.period, drive, smooth)
    else:
        found["rigid"] = rigid_motion(angle, engage(made, angle, operation.pinion_torque).gear_ratio_force, plain.period, drive, kinked)
    full = displaced = plain
    if ripple:
        error, slope = swinging(plain, ripple)
        full, displaced = with_error(plain, error, slope), with_error(plain, error)
    fine = {"cycles": 1, "tolerance": 1e-6}
    found["elastic"] = elastic_motion(full, drive, unloaded_transport(full, drive), **fine)
    if ripple:
        found["elastic, constant arms"] = elastic_motion(displaced, drive, uniform_transport(displaced, drive), **fine)
        found["elastic, no error"] = elastic_motion(plain, drive, uniform_transport(plain, drive), **fine)
        found["classical, no error"] = classical_motion(plain, drive, *discs, **fine)
    found["classical"] = classical_motion(displaced, drive, *discs, **fine)
    return {name: (motion.pinion_angle / plain.period, motion.dynamic_factor) for name, motion in found.items()}


def main(arguments: list[str] | None = None) -> list[dict[str, Any]]:
    """Compute all cases, write three_models.csv and three_models.png, print the table and what it says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder for three_models.csv and three_models.png")
    parser.add_argument("--small", action="store_true", help="the coal combine pair at its own speed only")
    options = parser.parse_args(arguments)
    setups = {name: load_model(HERE / folder / "model.toml") for name, folder in PAIRS.items()}
    cases = [(name, ripple) for name in (("coal combine",) if options.small else PAIRS) for ripple in (0.0, RIPPLE)]
    rows, curves = [], {}
    for name, ripple in cases:
        for speed in (1.0,) if options.small else (0.5, 1.0, 2.0):
            found = models(setups[name], ripple, speed)
            if speed == 1.0:
                curves[f"{name}, {f'ratio swinging by {ripple:.0%}' if ripple else 'unworn'}"] = found
            for model in MODELS:
                if model in found:
                    factor = found[model][1]
                    numbers = {"largest_dynamic_factor": float(factor.max()), "least_dynamic_factor": float(factor.min())}
                    rows.append({"pair": name, "ratio_ripple": ripple, "speed_over_nominal": speed, "model": model, **numbers})
    write_rows(options.out / "three_models.csv", rows, ("Kw = M1/T1, moment of the teeth on the pinion over its torque",))
    draw(curves, options.out / "three_models.png")
    print_table("Dynamic factor by three models under the same excitation", rows)
    for name in dict(cases):
        print(sentence(name, rows))
    return rows


def sentence(name: str, rows: list[dict[str, Any]]) -> str:
    """Return what a variable ratio adds for one pair, at its own speed."""
    mine = [row for row in rows if row["pair"] == name and row["speed_over_nominal"] == 1.0 and row["ratio_ripple"]]
    kw = {row["model"]: row["largest_dynamic_factor"] for row in mine}
    arms = kw["elastic"] - kw["elastic, constant arms"]
    return (
        f"{name}: a ratio swinging by {RIPPLE:.0%} adds {kw['elastic'] - kw['elastic, no error']:+.3f} to the largest Kw of the elastic "
        "model "
        f"({kw['elastic, no error']:.3f} without, {kw['elastic']:.3f} with; the rigid model says {kw['rigid']:.3f}), of which the swinging "
        f"arms are {arms:+.3f}; in the classical model, which takes it as a displacement of light gears, it adds "
        f"{kw['classical'] - kw['classical, no error']:+.3f}."
    )


@style.styled
def draw(curves: dict[str, dict[str, tuple[Array, Array]]], path: Path) -> Path:
    """Draw Kw over one mesh cycle, one panel per case."""
    figure, axes = style.make_figure(style.WIDE, columns=2, rows=(len(curves) + 1) // 2)
    colours = {"rigid": style.BLUE, "elastic": style.VERMILION, "classical": style.GREEN}
    for axis, (title, found) in zip(np.ravel(axes), curves.items(), strict=False):
        for model, colour in colours.items():
            place, factor = found[model]
            axis.plot(place - place[0], factor, color=colour, label=model)
        axis.set_title(title)
        axis.set_xlabel("pinion angle, pitches")
    np.ravel(axes)[0].set_ylabel("dynamic factor")
    style.legend_below(figure, np.ravel(axes)[0])
    return style.save(figure, path)


if __name__ == "__main__":
    main()
