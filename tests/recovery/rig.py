"""A small pair on the virtual rig, and one gear of it off the rig."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gearfem.diagnosis import read_campaign
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.bench import neutral
from gearfem.diagnosis.ranking.candidate import View, view_of
from gearfem.diagnosis.reading.noise import measure_noise
from gearfem.foundation.toml import write_toml
from gearfem.model import load_model
from gearfem.rig import measure, read_plan

NOMINAL: dict[str, Any] = {
    "name": "small pair",
    "pair": {"module_mm": 3.0, "face_width_mm": 20.0, "normal_backlash_mm": 0.1},
    "pinion": {"teeth": 13, "profile_shift": 0.3},
    "wheel": {"teeth": 17},
    "operation": {"pinion_torque_Nm": 100.0, "pinion_speed_rpm": 1000.0},
}
HIDDEN = {"name": "tip_relief", "gear": "wheel", "amount_um": 14.0, "length_mm": 2.5}
TORQUES = (6.0, 40.0, 80.0, 120.0)
PLAN: dict[str, Any] = {
    "name": "rig 7",
    "seed": 7,
    "scatter": {"index_error_um": 0.5},
    "instrument": {"noise_std": 0.2},
    "record": [
        {"file": f"te_{torque:g}Nm.csv", "quantity": "static_transmission_error", "pinion_torque_Nm": torque}
        | {"samples_per_turn": 234, "turns": 1.4}
        for torque in TORQUES
    ],
}


def on_the_rig(folder: Path, hidden: dict[str, Any], plan: dict[str, Any] = PLAN, nominal: dict[str, Any] = NOMINAL) -> Path:
    """Measure the nominal pair with what is hidden in it on the virtual rig; return the campaign file."""
    write_toml(folder / "true.toml", nominal | hidden)
    write_toml(folder / "plan.toml", plan)
    true = load_model(folder / "true.toml")
    measure(true, read_plan(folder / "plan.toml", true.pair), nominal, folder / "rig")
    return folder / "rig" / "campaign.toml"


def beside_nuisances(folder: Path, hidden: Sequence[dict[str, Any]], records: list[dict[str, Any]]) -> View:
    """Measure records of the nominal pair with hidden effects; return them beside nuisances alone, quickly fitted."""
    campaign = read_campaign(on_the_rig(folder, {"effect": list(hidden)} if hidden else {}, PLAN | {"record": records}))
    problem = Problem(campaign, campaign.records, tuple(measure_noise(record, campaign.setup.pair) for record in campaign.records))
    alone = problem.fit((), problem.prepare((), problem.unknowns.of(neutral(campaign.setup.pair))))
    return view_of(problem, alone, alone.point.weights, alone.squares)


def runout_off_the_rig(folder: Path, eccentricity: float) -> Path:
    """Write a campaign of one gear without its mate: its runout twice, with noise and scatter of its teeth [um]."""
    random = np.random.default_rng(11)
    write_toml(folder / "nominal.toml", NOMINAL)
    for name in ("fit", "holdout"):
        teeth = np.arange(34)
        values = eccentricity * np.cos(2.0 * math.pi * teeth / 17.0 - 1.0) + random.normal(scale=1.0, size=34)
        rows = "".join(f"{tooth},{value:.3f}\n" for tooth, value in zip(teeth, values, strict=True))
        (folder / f"{name}.csv").write_text("tooth,radial_deviation_um\n" + rows)
    records = [{"file": f"{role}.csv", "quantity": "radial_runout", "gear": "wheel", "role": role} for role in ("fit", "holdout")]
    write_toml(folder / "campaign.toml", {"model": "nominal.toml", "angle_zero": "unknown", "record": records})
    return folder / "campaign.toml"
