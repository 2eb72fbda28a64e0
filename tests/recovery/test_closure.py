"""What share of a gap closes where nuisances and errors of the model do the work of effects."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem.diagnosis import Diagnosis
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.index_errors import odd_of, turns_often, uneven, waves_of
from gearfem.diagnosis.fitting.score import stays
from gearfem.diagnosis.naming.gap import closure
from gearfem.foundation import Array


def _at(fit: Fit, unknown: Array) -> Fit:
    """Return a fit with other unknowns, as if it had ended there and left what it left."""
    return dataclasses.replace(fit, point=dataclasses.replace(fit.point, unknown=unknown))


def test_waves_of_index_errors_do_the_work_of_an_effect(found: Diagnosis) -> None:
    """Teeth late by chance are none, a wave twice a turn is: brought back, it leaves the gap that it had closed."""
    problem, fit = found.problem, found.naming.alone
    late, turn = problem.unknowns.late, 2.0 * math.pi * np.arange(17) / 17

    def with_errors(wave: float, order: int = 2) -> Fit:
        unknown = np.zeros_like(fit.point.unknown)
        unknown[late] = np.random.default_rng(5).normal(size=30)
        unknown[late][13:] += wave * np.cos(order * turn + 0.3)
        return _at(fit, unknown)

    chance, wavy = with_errors(0.0), with_errors(6.0)
    tooth, waves = uneven(problem, wavy)
    assert waves[1] == pytest.approx(6.0 * math.sqrt(17 / 2), rel=0.25, abs=0.0)
    assert waves[1] > 5.0 > 3.0 > max(waves[0], *tooth, *uneven(problem, chance).ravel())
    assert stays(problem, chance)
    assert not stays(problem, wavy)
    assert [turns_often(problem, fit) for fit in (chance, with_errors(6.0, 1), wavy)] == [False, False, True]
    assert closure(chance, chance, problem) == pytest.approx(0.0, abs=1e-9)
    assert closure(wavy, chance, problem) > 0.5
    late = np.array([0.5, -0.4, 8.0, 0.1, -0.2, 0.3, -9.0])
    assert odd_of(late) == pytest.approx([0.0, 0.0, 4.9, 0.0, 0.0, 0.0, -6.1], abs=1e-9, rel=0.0)
    assert waves_of(np.cos(2.0 * turn) + 3.0 + np.cos(5.0 * turn)) == pytest.approx(np.cos(2.0 * turn), abs=1e-12, rel=0.0)


def test_errors_of_the_model_that_do_the_work_of_an_effect_close_no_gap(found: Diagnosis) -> None:
    problem, fit = found.problem, found.naming.alone

    def with_bodies(moved: float) -> Fit:
        unknown = np.zeros_like(fit.point.unknown)
        unknown[problem.unknowns.wrong][1] = moved
        return _at(fit, unknown)

    assert closure(with_bodies(2.9), with_bodies(0.0), problem) == pytest.approx(0.0, abs=1e-9)
    assert closure(with_bodies(8.0), with_bodies(0.0), problem) > 0.2


def test_forms_of_all_teeth_that_do_the_work_of_an_effect_close_no_gap(found: Diagnosis) -> None:
    """All of them together, as far as they are beyond three prior deviations."""
    problem, fit = found.problem, found.naming.alone
    forms = problem.unknowns.forms

    def with_forms(size: float) -> Fit:
        unknown = np.zeros_like(fit.point.unknown)
        unknown[forms][:2] = 0.6 * size, 0.8 * size
        return _at(fit, unknown)

    assert closure(with_forms(2.9), with_forms(0.0), problem) == pytest.approx(0.0, abs=1e-9)
    assert closure(with_forms(40.0), with_forms(0.0), problem) > 0.2
