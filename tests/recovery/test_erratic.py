"""Motions that take another way for next to nothing, and what they count for then."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem.assembly import assemble
from gearfem.definition.setup import Setup
from gearfem.diagnosis import Diagnosis, averaged, localise
from gearfem.diagnosis.comparing.averages import of_single_teeth
from gearfem.diagnosis.comparing.erratic import erratic, marked, said
from gearfem.diagnosis.modelling.bench import Settings, neutral
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.proving.proof import judged
from gearfem.diagnosis.reading.measurement import Measurement, make_record
from gearfem.diagnosis.reading.noise import measure_noise
from gearfem.foundation.units import UM

RATED, LIGHT, PART = 50.0, 1.5, 0.35


@pytest.fixture(scope="module")
def bench(small_pair: Setup) -> SystemBench:
    return SystemBench(system=assemble(dataclasses.replace(small_pair, pair=dataclasses.replace(small_pair.pair, normal_backlash=80 * UM))))


@pytest.fixture(scope="module")
def settings(bench: SystemBench) -> Settings:
    """Index errors of a micrometre on all teeth."""
    rng = np.random.default_rng(2)
    late = {"pinion_late": UM * rng.normal(size=20), "wheel_late": UM * rng.normal(size=30)}
    return dataclasses.replace(neutral(bench.pair), **late)


def measured(bench: SystemBench, settings: Settings, torque: float, speed: float) -> Measurement:
    """Return a record of two turns that the model meets to a third of a micrometre."""
    name = "dynamic_transmission_error" if speed else "static_transmission_error"
    record = make_record(name, np.arange(2400) / 600.0 * math.pi, pinion_torque=torque, pinion_speed=speed)
    noise = 0.3 * UM * np.random.default_rng(3).normal(size=2400)
    return dataclasses.replace(record, value=bench.predict(record, settings) + noise)


def test_flanks_under_a_light_load_go_another_way_for_a_millionth(bench: SystemBench, settings: Settings) -> None:
    speed = PART * bench.oscillator(RATED, settings).frequency / 20
    slow, firm, light = (measured(bench, settings, *at) for at in ((RATED, 0.0), (RATED, speed), (LIGHT, speed)))
    noises = [measure_noise(record, bench.pair) for record in (slow, firm, light)]
    assert [erratic(one, noise, bench, settings) for one, noise in zip((slow, firm, light), noises, strict=True)] == [False, False, True]
    found = marked((slow, firm, light), noises, bench, settings)
    assert [record.erratic for record in found] == [False, False, True]
    assert light.file in said(found)[0]
    assert said(found[:2]) == ()
    # It is better than nothing.
    assert not marked((light,), noises[2:], bench, settings)[0].erratic


def test_an_erratic_motion_counts_for_nothing_but_what_exceeds_its_course(found: Diagnosis) -> None:
    problem = found.problem.part(np.arange(len(found.problem.records)))
    first, *others = problem.records
    problem.records = (dataclasses.replace(first, erratic=True), *others)
    settings = found.naming.alone.settings
    assert [record.file for record in averaged(problem, settings).records] == [record.file for record in others]
    course = np.std(first.value[first.keep]) / problem.noises[0].std
    bare, teeth = (of_single_teeth(one, settings, ()) for one in (found.problem, problem))
    assert teeth.floor == pytest.approx([1.0 + course**2, *bare.floor[1:]], rel=1e-12, abs=0.0)
    where = localise(dataclasses.replace(found.comparison, problem=problem), draws=100)
    assert {one.record for one in where.maps} == {record.file for record in others}


def test_an_erratic_motion_says_nothing_of_a_name(found: Diagnosis) -> None:
    gaps = found.proof.records
    assert judged(gaps, named=True).over_nuisances is not None
    wild = tuple(dataclasses.replace(gap, measurement=dataclasses.replace(gap.measurement, erratic=gap.role == "holdout")) for gap in gaps)
    proof = judged(wild, named=True)
    assert proof.over_nuisances is None
    assert proof.over_fitted is not None
    assert said([gap.measurement for gap in wild])[0] in proof.reasons
    assert not any("No record is held out" in reason for reason in proof.reasons)
