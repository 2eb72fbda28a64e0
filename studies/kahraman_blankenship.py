"""The 50/50 pair of Kahraman and Blankenship's experiments: softening resonance, jump and loss of contact.

    python studies/kahraman_blankenship.py --out results

A. Kahraman, G. W. Blankenship, Experiments on nonlinear dynamic behavior of an oscillator with clearance and periodically
time-varying parameters, J. Appl. Mech. 64 (1997) 217-226. Pair: 50/50 teeth, m 3 mm, 20 deg, b 20 mm, a 150 mm.
Assumed, since the rig's own numbers are not at hand: unmodified full-depth teeth, the inertias of solid discs with a bore of
20 mm radius (the rig's shafts and flywheels let the gears swing alone), 3 % of critical damping (2 and 5 % beside it), no
tooth friction, no errors of the teeth, 0.1 mm of backlash. So qualitative features are compared, and no amplitudes.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np
from common import print_table, write_rows

from gearfem import make_setup, run
from gearfem.dynamics import make_drive
from gearfem.dynamics.sweep import sweep
from gearfem.dynamics.sweep_record import Sweep
from gearfem.engagement.engage import mesh_force
from gearfem.foundation.units import UM
from gearfem.report import style

Case = tuple[float, float]
TEETH = 50
# Torque [N m] and damping ratio; the first three are drawn.
CASES = ((100.0, 0.03), (200.0, 0.03), (300.0, 0.03), (200.0, 0.02), (200.0, 0.05))
MODEL = {
    "name": "50/50 pair",
    "pair": {"module_mm": 3.0, "centre_distance_mm": 150.0, "face_width_mm": 20.0, "normal_backlash_mm": 0.1},
    "pinion": {"teeth": TEETH, "bore_radius_mm": 20.0},
    "wheel": {"teeth": TEETH, "bore_radius_mm": 20.0},
    "operation": {"pinion_torque_Nm": 100.0, "pinion_speed_rpm": 3000.0, "damping_ratio": 0.02},
}


def sweeps(cases: tuple[Case, ...], count: int) -> dict[Case, Sweep]:
    """Return the sweep up and down over mesh frequencies of 0.25 to 1.3 natural ones for every torque and damping."""
    made = run(make_setup(MODEL), until="compliance").mesh
    found = {}
    for torque, damping in cases:
        operation = {**MODEL["operation"], "pinion_torque_Nm": torque, "damping_ratio": damping}
        drive = make_drive(make_setup({**MODEL, "operation": operation}))
        forces = mesh_force(made, torque)
        mass = 0.5 * drive.pinion_inertia / forces.base_radius1**2
        natural = math.sqrt(forces.mean_stiffness / mass)
        speeds = np.linspace(0.25, 1.3, count) * natural / TEETH
        found[torque, damping] = sweep(forces, drive, speeds, both_ways=True)
    return found


def features(case: Case, result: Sweep) -> dict[str, Any]:
    """Return what the experiments are known for, as numbers, of one torque and damping.

    The leaning branch is the stretch of speeds below the natural frequency's in which up and down differ, from its upper end on.
    """
    tuning = np.array([point.tuning for point in result.branch("up")])
    up, down = (result.column("error_rms", way) / UM for way in ("up", "down"))
    apart = np.abs(up - down) > 0.05 * np.maximum(up, down)
    last = int(np.flatnonzero(apart)[-1]) if apart.any() else int(np.argmax(down))
    first = last
    while first > 0 and apart[first - 1]:
        first -= 1
    branch = slice(first, last + 1)
    return {
        "pinion_torque_Nm": case[0],
        "damping_ratio": case[1],
        "natural_frequency_Hz": result.points[0].natural_frequency,
        "two_motions": bool(apart.any()),
        "jump_down_at": float(tuning[first]),
        "jump_up_at": float(tuning[last]),
        "rms_up_um": float(up[branch].max()),
        "rms_down_um": float(down[branch].max()),
        "contact_loss_up": float(result.column("contact_loss", "up")[branch].max()),
        "contact_loss_down": float(result.column("contact_loss", "down")[branch].max()),
        "double_sided_impact": bool((result.column("back_contact", "down")[branch] > 0.0).any()),
    }


def sentence(row: dict[str, Any]) -> str:
    """Return the features of one case in words."""
    start = f"{row['pinion_torque_Nm']:g} N m, damping {row['damping_ratio']:g}: "
    if not row["two_motions"]:
        return (
            start + f"one motion at every speed, largest rms {row['rms_down_um']:.2f} um, contact lost for {row['contact_loss_down']:.0%}."
        )
    return start + (
        f"two motions from {row['jump_down_at']:.3f} to {row['jump_up_at']:.3f} of the natural frequency (softening); there "
        f"the rms is at most {row['rms_up_um']:.2f} um going up and {row['rms_down_um']:.2f} going down, with contact lost for "
        f"{row['contact_loss_down']:.0%} of the time."
    )


def main(arguments: list[str] | None = None) -> list[dict[str, Any]]:
    """Sweep, write kahraman_blankenship.csv, features.csv and the plot, print the features and what they say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder for tables and plot")
    parser.add_argument("--small", action="store_true", help="one torque, few speeds")
    options = parser.parse_args(arguments)
    found = sweeps(CASES[1:2] if options.small else CASES, 43 if options.small else 141)
    names = ("error_rms", "error_mean")
    rows = [
        {
            "pinion_torque_Nm": torque,
            "damping_ratio": damping,
            "direction": point.direction,
            "mesh_frequency_Hz": point.mesh_frequency,
            "mesh_over_natural": point.tuning,
            **{f"{name}_um": getattr(point, name) / UM for name in names},
            "dynamic_factor": point.dynamic_factor_max,
            "contact_loss": point.contact_loss,
            "period_cycles": point.period_cycles,
        }
        for (torque, damping), result in found.items()
        for point in result.points
    ]
    write_rows(options.out / "kahraman_blankenship.csv", rows, tuple(__doc__.splitlines()[5:10]))
    table = [features(case, result) for case, result in found.items()]
    write_rows(options.out / "features.csv", [{key: str(value) for key, value in row.items()} for row in table])
    draw(found, options.out / "kahraman_blankenship.png")
    print_table("Main resonance of the 50/50 pair, sweep up and down", table)
    for row in table:
        print(sentence(row))
    return table


@style.styled
def draw(found: dict[Case, Sweep], path: Path) -> Path:
    """Draw rms of the dynamic transmission error over the mesh frequency, one panel for each torque."""
    drawn = dict(list(found.items())[:3])
    figure, axes = style.make_figure(style.WIDE, columns=len(drawn))
    for axis, ((torque, _), result) in zip(axes, drawn.items(), strict=True):
        for way, colour, mark in (("up", style.BLUE, "^"), ("down", style.VERMILION, "v")):
            frequency = [point.mesh_frequency for point in result.branch(way)]
            axis.plot(frequency, result.column("error_rms", way) / UM, mark, markersize=2.5, color=colour, label=f"speed going {way}")
        axis.axvline(result.points[0].natural_frequency, color=style.GREY, linewidth=0.8)
        axis.set_title(f"{torque:g} N m")
        axis.set_xlabel("mesh frequency, Hz")
    axes[0].set_ylabel("dynamic transmission error, rms, um")
    style.legend_below(figure, axes[0])
    return style.save(figure, path)


if __name__ == "__main__":
    main()
