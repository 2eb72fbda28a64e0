"""Coupling of neighbour teeth and tip edges of a calibration: what they leave as it was, and what they change."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gearfem.assembly import assemble
from gearfem.compliance import make_compliance
from gearfem.definition.setup import Setup
from gearfem.flank import make_flanks
from gearfem.model import make_setup
from gearfem.sensing import observe, requests

SETUP = make_setup(
    {
        "pair": {"module_mm": 3.0, "face_width_mm": 20.0},
        "pinion": {"teeth": 19},
        "wheel": {"teeth": 26},
        "operation": {"pinion_torque_Nm": 100.0, "pinion_speed_rpm": 1000.0},
    }
)


def built(**scales: float) -> Setup:
    return dataclasses.replace(SETUP, calibration=dataclasses.replace(SETUP.calibration, **scales))


def error(setup: Setup) -> np.ndarray:
    """Return the slow transmission error over one pitch [m]."""
    angle = np.linspace(0.0, setup.pair.pinion.pitch_angle, 60, endpoint=False)
    wanted = requests()["static_transmission_error"](
        axis=angle, pinion_torque=100.0, pinion_speed=0.0, gear="pinion", tooth=0, file="te.csv"
    )
    return observe(assemble(setup), wanted)


def test_scales_of_one_change_no_bit() -> None:
    flanks = make_flanks(SETUP)
    compliance = make_compliance(flanks)
    assert flanks.edged(1.0).pinion.gear.tip_edge_radius == flanks.pinion.gear.tip_edge_radius
    for gear in ("pinion", "wheel"):
        same, was = compliance.coupled(1.0).of(gear), compliance.of(gear)
        assert np.array_equal(same.deflection, was.deflection)
        assert np.array_equal(same.coupling, was.coupling)


@pytest.mark.parametrize("scale", [0.0, 0.4, 1.6])
def test_two_neighbours_under_equal_loads_yield_as_before(scale: float) -> None:
    was = make_compliance(make_flanks(SETUP)).wheel
    tooth = was.coupled(scale)
    behind, ahead = (was.offsets.index(offset) for offset in (-1, 1))

    def together(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return one + 0.5 * (np.diagonal(other[behind]) + np.diagonal(other[ahead]))

    assert together(tooth.deflection, tooth.coupling) == pytest.approx(together(was.deflection, was.coupling), rel=1e-12, abs=0.0)


def test_less_coupling_raises_the_swing_of_the_transmission_error_and_not_its_mean() -> None:
    nominal, loose = error(SETUP), error(built(coupling_scale=0.4))
    assert 1.05 * np.ptp(nominal) < np.ptp(loose)
    # Two pairs lie at two heights of their flanks, and one pair alone yields more: the mean moves by little.
    assert loose.mean() == pytest.approx(nominal.mean(), rel=0.08, abs=0.0)


def test_sharper_edges_bring_pairs_together_for_longer() -> None:
    nominal, sharp = error(SETUP), error(built(tip_edge_scale=0.2))
    assert sharp.mean() < nominal.mean()
    assert sharp.max() == pytest.approx(nominal.max(), rel=0.01, abs=0.0)
