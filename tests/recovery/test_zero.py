"""The unknown zero of the pinion angle, where what is missing from all flanks moves the mesh lines."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from gearfem.diagnosis import read_campaign
from gearfem.diagnosis.comparing.compare import _apart, _zero
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.system_bench import bench_of
from gearfem.diagnosis.modelling.teeth import Scatter
from gearfem.diagnosis.reading.noise import measure_noise
from gearfem.foundation.progress import quiet

from .generator import make_case, write_case


def test_wear_that_turns_the_mesh_lines_by_half_a_pitch_does_not_move_the_zero(tmp_path: Path) -> None:
    """To a twentieth of a pitch; flanks as the model has them suit a zero that is nearly half of one off."""
    case = make_case((313, 0), "single", "profile_wear", "easy")
    write_case(case, tmp_path, "worn")
    campaign = read_campaign(tmp_path / "worn" / "campaign.toml")
    noises = tuple(measure_noise(record, campaign.setup.pair) for record in campaign.fitted)
    bench = lambda effects: dataclasses.replace(bench_of(campaign, effects), errors=())  # noqa: E731
    rough = Problem(campaign, campaign.fitted, noises, Scatter(), bench)
    true = case.label["nuisances"]["angle_offset_rad"]
    assert _apart(_zero(rough, quiet), true, campaign.setup.pair) < 0.05
