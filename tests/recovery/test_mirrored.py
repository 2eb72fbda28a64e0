"""Transmission errors of the other sign are refused; those that an effect leaves far off are not."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from gearfem.diagnosis import read_campaign
from gearfem.diagnosis.comparing.mirrored import refuse_mirrored
from gearfem.diagnosis.fitting.approach import ROUGH, fit_from, lost
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.bench import neutral
from gearfem.diagnosis.modelling.system_bench import bench_of
from gearfem.diagnosis.reading.noise import measure_noise
from gearfem.foundation import InputError
from tests.recovery.rig import HIDDEN, PLAN, on_the_rig


def roughly(folder: Path, sign: float, hidden: dict[str, object]) -> tuple[Problem, Fit]:
    """Return records of the rig that count either way, and nuisances alone fitted to them in a few rounds."""
    campaign = read_campaign(on_the_rig(folder, hidden, PLAN | {"record": PLAN["record"][1:3]}))
    records = tuple(dataclasses.replace(one, value=sign * one.value) for one in campaign.fitted)
    noises = tuple(measure_noise(one, campaign.setup.pair) for one in records)
    problem = Problem(campaign, records, noises, bench=lambda effects: dataclasses.replace(bench_of(campaign, effects), errors=()))
    return problem, fit_from(problem, neutral(campaign.setup.pair), ROUGH)


def test_a_wheel_that_leads_where_it_should_lag_is_refused_by_file_and_column(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"te_40Nm\.csv: column transmission_error_um: found what the model meets turned over"):
        refuse_mirrored(*roughly(tmp_path, -1.0, {}))


def test_what_an_effect_leaves_far_off_is_not_taken_for_the_other_sign(tmp_path: Path) -> None:
    problem, rough = roughly(tmp_path, 1.0, {"effect": [HIDDEN]})
    assert lost(problem, rough)
    refuse_mirrored(problem, rough)
