"""The engagement over all tooth combinations: how many there are, and what the command writes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gearfem
from gearfem.engagement.engage import engage
from gearfem.report.hunting import PER_PITCH, combinations, over_combinations, write_hunting

MODEL = {
    "pair": {"module_mm": 3.0, "face_width_mm": 30.0},
    "pinion": {"teeth": 17},
    "wheel": {"teeth": 23},
    "operation": {"pinion_torque_Nm": 75.4, "pinion_speed_rpm": 1500.0},
}
LATE = {"name": "pitch_error", "gear": "pinion", "tooth": 4, "amount_um": 8.0}
RUNOUT = {"name": "runout", "gear": "wheel", "eccentricity_um": 12.0, "angle_rad": 0.5}


@pytest.mark.parametrize(("effects", "pitches"), [([], 1), ([LATE], 17), ([RUNOUT], 23), ([LATE, RUNOUT], 17 * 23)])
def test_only_differing_gears_lengthen_the_period(effects: list[dict[str, object]], pitches: int) -> None:
    mesh = gearfem.run(gearfem.make_setup({**MODEL, "effect": effects}), until="compliance").mesh
    assert mesh is not None
    assert combinations(mesh) == pitches


def test_the_late_tooth_is_met_once_a_turn_and_the_table_closes(tmp_path: Path) -> None:
    setup = gearfem.make_setup({**MODEL, "effect": [LATE]})
    mesh = gearfem.run(setup, until="compliance").mesh
    assert mesh is not None
    turns = over_combinations(mesh, 75.4)
    error = turns.transmission_error
    # The last angle is the first one a period later, solved from other starting loads.
    assert error[-1] == pytest.approx(error[0], rel=1e-6, abs=0.0)
    sound = gearfem.run(gearfem.make_setup(MODEL), until="compliance").mesh
    assert sound is not None
    first = engage(sound, turns.pinion_angle[:PER_PITCH], 75.4).transmission_error
    excess = (error[:-1].reshape(17, PER_PITCH) - first).max(axis=1)
    assert int(np.argmax(excess)) in (3, 4)
    assert excess.max() > 6e-6
    assert np.abs(excess[8:16]).max() < 1e-8
    table, picture = write_hunting(setup, mesh, 75.4, tmp_path)
    assert picture.is_file()
    rows = np.genfromtxt(table, delimiter=",", names=True, skip_header=1)
    assert len(rows) == 17 * PER_PITCH + 1
    assert rows["transmission_error_um"] == pytest.approx(error * 1e6, rel=1e-8, abs=0.0)
