"""The unknown zero of the pinion angle, where what is missing from all flanks moves the mesh lines."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np

from gearfem.assembly import assemble
from gearfem.diagnosis import read_campaign
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
from .rig import NOMINAL


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
    noises = tuple(measure_noise(record, campaign.setup.pair) for record in campaign.fitted)
    bench = lambda effects: dataclasses.replace(bench_of(campaign, effects), errors=())  # noqa: E731
    rough = Problem(campaign, campaign.fitted, noises, Scatter(), bench)
    true = case.label["nuisances"]["angle_offset_rad"]
    assert _apart(_zero(rough, quiet), true, campaign.setup.pair) < 0.05
