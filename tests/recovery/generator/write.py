"""Files of a case, exactly as people exchange them; the label lies in a folder of its own."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from .campaign import Case
from .gear import Array
from .observe import COLUMNS, STATIC_OF_ONE_GEAR, Spec


def write_case(case: Case, folder: Path, name: str) -> None:
    """Write FOLDER/NAME with the campaign and FOLDER/labels/NAME.json; a twin's deciding campaign goes beside its label."""
    place = folder / name
    labels = folder / "labels"
    labels.mkdir(parents=True, exist_ok=True)
    _campaign(case, place, case.specs, case.series, name)
    if case.deciding:
        more = [case.measure_more(s) for s in case.deciding]
        _campaign(case, labels / f"{name}_decided", [*case.specs, *case.deciding], [*case.series, *more], f"{name} and the deciding record")
    (labels / f"{name}.json").write_text(json.dumps({"case": name, **case.label}, indent=1) + "\n", encoding="utf-8")


def _campaign(case: Case, place: Path, specs: list[Spec], series: list[tuple[Array, Array]], name: str) -> None:
    place.mkdir(parents=True, exist_ok=True)
    (place / "nominal.toml").write_text(_model(case.model), encoding="utf-8")
    lines = [f'name = "{name}"', 'model = "nominal.toml"', f'angle_zero = "{case.angle_zero}"']
    for spec, columns in zip(specs, series, strict=True):
        lines += ["", "[[record]]", *_record(spec)]
        _series(place / spec.file, spec, columns)
    (place / "campaign.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _record(spec: Spec) -> list[str]:
    lines = [f'file = "{spec.file}"', f'quantity = "{spec.quantity}"']
    if spec.quantity in STATIC_OF_ONE_GEAR:
        lines.append(f'gear = "{("pinion", "wheel")[spec.gear]}"')
        if spec.quantity == "flank_profile":
            lines.append(f"tooth = {spec.tooth}")
        elif spec.tooth_zero_unknown:
            lines.append('tooth_zero = "unknown"')
    else:
        lines.append(f"pinion_torque_Nm = {spec.torque!r}")
        if spec.quantity != "dynamic_factor":
            lines.append(f"pinion_speed_rpm = {round(spec.speed * 30.0 / math.pi, 3)!r}")
    if spec.stated:
        lines.append(f"noise_std = {float(f'{spec.noise:.4g}')!r}")
    if spec.role is not None:
        lines.append(f'role = "{spec.role}"')
    return lines


def _series(path: Path, spec: Spec, columns: tuple[Array, Array]) -> None:
    first, second = columns
    whole = spec.quantity in ("radial_runout", "pitch_deviation")
    shape = "%d,%.6g" if whole else "%.9g,%.7g"
    np.savetxt(path, np.stack([first, second], 1), fmt=shape, header=",".join(COLUMNS[spec.quantity]), comments="", encoding="utf-8")


def _model(model: dict[str, Any]) -> str:
    lines = [f'name = "{model["name"]}"']
    for table, values in model.items():
        if isinstance(values, dict):
            lines += ["", f"[{table}]", *(f"{key} = {value!r}" for key, value in values.items())]
    return "\n".join(lines) + "\n"
