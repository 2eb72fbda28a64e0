"""The tip edge of a surface yield pressure: Hertz's pressure on it equals the limit, and its curvature runs out as a parabola."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from gearfem import load_model
from gearfem.contact import HertzLine
from gearfem.flank import make_flanks
from gearfem.foundation import InputError

COAL = Path(__file__).parents[2] / "studies/coal_combine/model.toml"


def limited(limit, *more):
    return load_model(COAL, [f"material.surface_yield_pressure_MPa={limit}", *more])


@pytest.mark.parametrize("limit", [2500.0, 4000.0])
def test_the_whole_load_on_the_edge_presses_with_the_limit(limit):
    setup = limited(limit)
    pair = setup.pair
    law = HertzLine(pinion=pair.pinion.material, wheel=pair.wheel.material)
    load = setup.operation.pinion_torque / pair.pinion.base_radius / pair.face_width
    for gear in (pair.pinion, pair.wheel):
        far = pair.centre_distance * math.sin(pair.working_pressure_angle) - math.sqrt(gear.tip_radius**2 - gear.base_radius**2)
        radius = 1.0 / (1.0 / gear.tip_edge_radius + 1.0 / far)
        assert float(law.pressure(load, radius)) == pytest.approx(limit * 1e6, rel=1e-12, abs=0.0)
        # Two and a half widths of that contact.
        assert gear.tip_run_out == pytest.approx(5.0 * float(law.half_width(load, radius)), rel=1e-12, abs=0.0)


@pytest.mark.parametrize("limit", [2500.0, 4000.0])
def test_curvature_runs_out_as_a_parabola(limit):
    flanks = make_flanks(limited(limit))
    for outline in (flanks.pinion, flanks.wheel):
        gear, u = outline.gear, np.linspace(2.0, 3.0, 20001)
        away = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
        place = np.interp(-away * gear.tip_run_out, -outline.edge_distance(u), u)
        edge, flank = 1.0 / gear.tip_edge_radius, 1.0 / outline.flank_end
        error = outline.curvature(place) - flank - (edge - flank) * (1.0 - away) ** 2
        # Stated with the rule: 0.11 of the edge's curvature where the round begins, 0.035 below.
        assert abs(error[0]) < 0.12 * edge
        assert np.abs(error[1:]).max() < 0.04 * edge
        # Below the run-out nothing is missing.
        assert float(outline.deviation.at(0.9 * outline.flank_end)) == pytest.approx(0.0, abs=1e-9)


def test_tensile_yield_of_the_coal_combine_asks_for_what_no_tooth_has():
    with pytest.raises(InputError) as refusal:
        limited(1200.0)
    assert refusal.value.where == "material.surface_yield_pressure_MPa"
    # The equivalent radius is 8.9 mm; against the wheel's flank of 79 mm the edge itself would have 10 mm.
    assert "10 mm" in str(refusal.value.found)
    assert "several times its tensile yield strength" in refusal.value.allowed


def test_the_limit_of_the_refusal_is_the_one_that_passes():
    with pytest.raises(InputError) as refusal:
        limited(1200.0)
    least = float(refusal.value.allowed.split()[1])
    with pytest.raises(InputError):
        limited(0.99 * least)


def test_a_given_radius_rules_and_without_a_limit_nothing_changes():
    setup = limited(4000.0, "pinion.tip_edge_radius_mm=0.3")
    assert setup.pair.pinion.tip_edge_radius == pytest.approx(0.3e-3, rel=1e-12, abs=0.0)
    assert setup.pair.pinion.tip_run_out == 0.0
    assert setup.pair.wheel.tip_run_out > 0.0
    plain = load_model(COAL).pair
    assert plain.pinion.tip_edge_radius == pytest.approx(0.02 * plain.pinion.module, rel=1e-12, abs=0.0)
    assert plain.wheel.tip_run_out == 0.0
    assert make_flanks(load_model(COAL)).wheel.deviation is None


def test_a_gear_may_have_a_limit_of_its_own():
    pair = load_model(COAL, ["wheel.material.surface_yield_pressure_MPa=4000"]).pair
    assert pair.pinion.tip_run_out == 0.0
    assert pair.wheel.tip_run_out > 0.0
