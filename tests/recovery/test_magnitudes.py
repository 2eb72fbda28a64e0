"""Records in other units than they say, told by their noise and their mesh lines, and records that only look so."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from gearfem.diagnosis import read_campaign
from gearfem.diagnosis.comparing.magnitudes import refuse_magnitudes
from gearfem.diagnosis.modelling.system_bench import bench_of
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


@pytest.mark.parametrize("rows", [104, 468])
def test_few_rows_to_a_pitch_are_rough_by_the_mesh_and_not_by_another_unit(tmp_path: Path, rows: int) -> None:
    campaign = read_campaign(measured(tmp_path, rows))
    refuse_magnitudes(campaign, bench_of(campaign))


@pytest.mark.parametrize("rows", [104, 468])
def test_values_tenfold_too_large_are_refused(tmp_path: Path, rows: int) -> None:
    campaign = read_campaign(measured(tmp_path, rows, 10.0))
    with pytest.raises(InputError, match="allowed: values in um, as noise_std"):
        refuse_magnitudes(campaign, bench_of(campaign))
