"""Largest tensile fillet stress of finite elements against the nominal stress of ISO 6336-3: an option of fe_vs_castigliano."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from common import gears, print_table, write_rows

from gearfem import Setup
from gearfem.compliance import FiniteElements
from gearfem.compliance.iso6336_root import NOTCH_HIGH, NOTCH_LOW, root_factors
from gearfem.compliance.root_stress import fillet_stress, stress_error
from gearfem.foundation.units import MM
from gearfem.report import style


def study(setup: Setup, out: Path, small: bool) -> list[dict[str, Any]]:
    """Write root_stress.csv and root_stress.png, print the comparison and return its rows."""
    method = FiniteElements(resolution=3.0 if small else 6.0)
    rows = []
    for member, outline, (low, high) in gears(setup):
        u = np.linspace(low, high, 6 if small else 21)
        factors = root_factors(outline, u)
        fe, error = fillet_stress(outline, factors.u, method), stress_error(outline, factors.u, method)
        module = outline.gear.module
        if not factors.in_range:
            print(f"{member}: q_s = {factors.notch:.3f} lies outside {NOTCH_LOW:g} to {NOTCH_HIGH:g}, for which ISO 6336-3 gives Y_S")
        if factors.u.size < u.size:
            print(f"{member}: {u.size - factors.u.size} of {u.size} loads cross the axis under the 30 degree section and have no Y_F")
        for k in range(factors.u.size):
            rows.append(
                {
                    "gear": member,
                    "radius_mm": float(fe.radius[k]) / MM,
                    "form_factor": float(factors.form_factor[k]),
                    "stress_correction": float(factors.stress_correction[k]),
                    "iso_stress_times_module": float(factors.stress[k] * module),
                    "fe_stress_times_module": float(fe.stress[k] * module),
                    "fe_error": float(error[k]),
                    "iso_over_fe": float(factors.stress[k] / fe.stress[k]),
                    "fe_tangent_angle_deg": float(np.degrees(fe.tangent_angle[k])),
                }
            )
    write_rows(out / "root_stress.csv", rows, ("stress times module per line load, dimensionless: Y_F Y_S cos(alpha) for ISO 6336-3",))
    draw(rows, out / "root_stress.png")
    print_table(
        "Largest tensile fillet stress times module per line load: FE (bore held, plane strain) and ISO 6336-3, Y_F Y_S cos(alpha)", rows
    )
    for gear in dict.fromkeys(row["gear"] for row in rows):
        ratio = [row["iso_over_fe"] for row in rows if row["gear"] == gear]
        angle = [row["fe_tangent_angle_deg"] for row in rows if row["gear"] == gear]
        print(
            f"{gear}: ISO 6336-3 over FE runs from {ratio[0]:.3f} at the lowest load that has a factor to {ratio[-1]:.3f} at the tip; "
            f"the stress is largest where the tangent stands at {angle[0]:.0f} to {angle[-1]:.0f} degrees, not always 30."
        )
    return rows


@style.styled
def draw(rows: list[dict[str, Any]], path: Path) -> Path:
    """Draw both stresses over the load radius."""
    names = list(dict.fromkeys(row["gear"] for row in rows))
    figure, axes = style.make_figure(style.WIDE, columns=len(names))
    for axis, gear in zip(axes, names, strict=True):
        mine = [row for row in rows if row["gear"] == gear]
        radius = [row["radius_mm"] for row in mine]
        axis.plot(
            radius, [row["fe_stress_times_module"] for row in mine], color=style.BLUE, label="finite elements, bore held, plane strain"
        )
        axis.plot(radius, [row["iso_stress_times_module"] for row in mine], color=style.VERMILION, label="ISO 6336-3, nominal")
        axis.set_title(f"{gear}: largest tensile stress in the fillet")
        axis.set_xlabel("radius of the load point, mm")
        axis.set_ylim(bottom=0.0)
    axes[0].set_ylabel("stress times module per line load")
    style.legend_below(figure, axes[0], columns=2)
    return style.save(figure, path)
