"""The unknown zero of the pinion angle, where what is missing from all flanks moves the mesh lines."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from gearfem.assembly import assemble
from gearfem.diagnosis import Campaign, read_campaign
from gearfem.diagnosis.comparing.compare import _apart, _zero
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.bench import neutral
from gearfem.diagnosis.modelling.system_bench import SystemBench, bench_of
from gearfem.diagnosis.modelling.teeth import Scatter, tooth_columns
from gearfem.diagnosis.reading.measurement import make_record
from gearfem.diagnosis.reading.noise import measure_noise
from gearfem.foundation.progress import quiet
from gearfem.model import make_setup

from .generator import make_case, write_case
from .rig import NOMINAL, on_the_rig

LARGER: dict[str, Any] = {
    "pair": {"module_mm": 3.0, "face_width_mm": 25.0, "normal_backlash_mm": 0.09},
    "pinion": {"teeth": 25},
    "wheel": {"teeth": 40},
    "operation": {"pinion_torque_Nm": 150.0, "pinion_speed_rpm": 1000.0, "friction_coefficient": 0.05, "damping_ratio": 0.08},
}


def test_teeth_are_where_the_zero_puts_them_that_the_model_has_or_that_is_fitted() -> None:
    """A model with a fitted zero in its calibration has the same teeth in contact as one beside which it is fitted."""
    nominal, zero = make_setup(NOMINAL), 1.7 * 2.0 * math.pi / NOMINAL["pinion"]["teeth"]
    known = dataclasses.replace(nominal, calibration=dataclasses.replace(nominal.calibration, angle_offset=zero))
    level, record = neutral(nominal.pair), make_record("static_transmission_error", np.linspace(0.0, 9.0, 40), pinion_torque=50.0)
    fitted, stated = (
        tooth_columns(record, SystemBench(system=assemble(setup)), settings, Scatter())
        for setup, settings in ((nominal, dataclasses.replace(level, angle_offset=zero)), (known, level))
    )
    assert np.abs(fitted).max() > 0.1
    np.testing.assert_allclose(stated, fitted, rtol=0.0, atol=1e-12)


def test_wear_that_turns_the_mesh_lines_by_half_a_pitch_does_not_move_the_zero(tmp_path: Path) -> None:
    """To a twentieth of a pitch; flanks as the model has them suit a zero that is nearly half of one off."""
    case = make_case((313, 0), "single", "profile_wear", "easy")
    write_case(case, tmp_path, "worn")
    campaign = read_campaign(tmp_path / "worn" / "campaign.toml")
    assert _off(campaign, case.label["nuisances"]["angle_offset_rad"]) < 0.05


def test_a_late_tooth_does_not_move_the_zero_to_where_worn_flanks_begin_lower(tmp_path: Path) -> None:
    """The first round of sound flanks leaves more than three of worn ones half a pitch off; led on, it leaves less."""
    records = [
        {"file": f"te_{torque:g}Nm.csv", "quantity": "static_transmission_error", "pinion_torque_Nm": torque, "role": "fit"}
        | {"samples_per_turn": to_a_turn, "turns": turns, "noise_std": 0.1}
        for torque, turns, to_a_turn in ((20.0, 4.0, 1800), (150.0, 1.0, 200))
    ]
    late = {"effect": [{"name": "pitch_error", "gear": "pinion", "tooth": 3, "amount_um": 12.0}]}
    plan = {"name": "late", "seed": 3, "angle_zero": "unknown", "scatter": {"index_error_um": 0.7}, "record": records}
    campaign = on_the_rig(tmp_path, late, plan, LARGER)
    true = json.loads((campaign.parent / "truth.json").read_text())["angle_offset_rad"]
    assert _off(read_campaign(campaign), true) < 0.05


def _off(campaign: Campaign, true: float) -> float:
    """Return how far the zero that is found is from the true one, in pitches."""
    noises = tuple(measure_noise(record, campaign.setup.pair) for record in campaign.fitted)
    bench = lambda effects: dataclasses.replace(bench_of(campaign, effects), errors=())  # noqa: E731
    rough = Problem(campaign, campaign.fitted, noises, Scatter(), bench)
    return _apart(_zero(rough, quiet), true, campaign.setup.pair)
