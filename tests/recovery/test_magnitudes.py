"""Records in other units than they say, told by their noise and their mesh lines, and records that only look so."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gearfem.diagnosis import read_campaign
from gearfem.diagnosis.comparing.magnitudes import refuse_magnitudes
from gearfem.diagnosis.modelling.bench import neutral
from gearfem.diagnosis.modelling.mesh_lines import mesh_lines
from gearfem.diagnosis.modelling.system_bench import bench_of
from gearfem.diagnosis.reading.noise import roughness
from gearfem.foundation import InputError
from tests.recovery.rig import PLAN, on_the_rig

LATE = {"name": "pitch_error", "gear": "pinion", "tooth": 3, "amount_um": 16.0}


def measured(folder: Path, rows: int, factor: float = 1.0) -> Path:
    """Measure a pair with a late tooth, 13 teeth to the turn of so many rows; values are then multiplied."""
    record: dict[str, Any] = PLAN["record"][-1] | {"samples_per_turn": rows, "turns": 2.0, "noise_std": 0.1}
    file = on_the_rig(folder, {"effect": [LATE]}, PLAN | {"record": [record]})
    series = file.parent / record["file"]
    heading, *lines = (line for line in series.read_text().splitlines() if not line.startswith("#"))
    parts = (line.split(",") for line in lines)
    series.write_text("\n".join([heading, *(f"{angle},{factor * float(value):.9g}" for angle, value in parts)]) + "\n")
    return file


@pytest.mark.parametrize("rows", [6, 8, 12, 36])
def test_rows_show_the_lines_that_they_resolve_and_no_others(rows: int) -> None:
    """Of a whole number of rows to a pitch the others look like lower lines, or like half of one."""
    pitch = 2.0 * np.pi / 13.0
    angle, resolved = np.arange(26 * rows) * pitch / rows, min(6, (rows - 1) // 2)
    lines = np.array([3.0 - 1.0j, 2.0j, 1.0, 0.5, -0.3j, 0.2])[:resolved]
    value = (lines * np.exp(2j * np.pi * np.outer(angle, np.arange(1, resolved + 1)) / pitch)).real.sum(axis=1)
    found = mesh_lines(angle, value, pitch)
    assert found[:resolved] == pytest.approx(lines, rel=1e-9, abs=1e-9)
    assert not found[resolved:].any()


def test_a_late_tooth_in_few_rows_to_a_pitch_is_in_the_unit_that_it_says(tmp_path: Path) -> None:
    """Rough by the mesh, seven times its noise, and with mesh lines of the model's size."""
    campaign = read_campaign(measured(tmp_path, 104))
    (record,), bench, pitch = campaign.records, bench_of(campaign), campaign.setup.pair.pinion.pitch_angle
    sizes = [np.linalg.norm(mesh_lines(record.axis, own, pitch)) for own in (record.value, bench.predict(record, neutral(bench.pair)))]
    assert roughness(record) > 5.0 * record.noise_std
    assert 0.5 < sizes[0] / sizes[1] < 2.0
    assert refuse_magnitudes(campaign, bench) is None


@pytest.mark.parametrize("rows", [104, 468])
def test_values_tenfold_too_large_are_refused(tmp_path: Path, rows: int) -> None:
    campaign = read_campaign(measured(tmp_path, rows, 10.0))
    with pytest.raises(InputError, match="allowed: values in um, as noise_std"):
        refuse_magnitudes(campaign, bench_of(campaign))
