"""The engagement does not care about names and sizes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gearfem.definition.setup import Setup
from gearfem.engagement.engage import engage
from gearfem.pipeline import run


def scaled(setup: Setup, factor: float) -> Setup:
    """Return a setup whose every length is multiplied."""
    gears = {}
    for member in ("pinion", "wheel"):
        gear = getattr(setup.pair, member)
        lengths = ("module", "flank_thinning", "root_radius", "tip_radius", "tip_edge_radius", "bore_radius")
        gears[member] = dataclasses.replace(gear, **{name: getattr(gear, name) * factor for name in lengths})
    lengths = {name: getattr(setup.pair, name) * factor for name in ("centre_distance", "face_width", "normal_backlash")}
    return dataclasses.replace(setup, pair=dataclasses.replace(setup.pair, **gears, **lengths))


def test_driver_and_driven_swap_roles(coal_combine) -> None:
    """With the wheel driving, what happened in recess happens in approach: errors and stiffness mirror."""
    pair = coal_combine.pair
    swapped = dataclasses.replace(coal_combine, pair=dataclasses.replace(pair, pinion=pair.wheel, wheel=pair.pinion))
    path = np.linspace(-0.5, 0.5, 101) * pair.base_pitch
    torque = 1605.0
    one = engage(run(coal_combine, until="compliance").mesh, path / pair.pinion.base_radius, torque)
    # Swap the torque too, so that both carry the same normal force.
    other = engage(run(swapped, until="compliance").mesh, -path / pair.wheel.base_radius, torque * pair.ratio)
    # Off the path the torque is given on the driver, whose arm is another: the two differ by the ratio of the forces.
    on_path = np.abs(one.gear_ratio_force / pair.ratio - 1.0) < 1e-12
    assert on_path.sum() > 60
    assert other.transmission_error[on_path] == pytest.approx(one.transmission_error[on_path], rel=1e-9, abs=0.0)
    assert other.mesh_stiffness[on_path] == pytest.approx(one.mesh_stiffness[on_path], rel=1e-9, abs=0.0)
    assert other.transmission_error == pytest.approx(one.transmission_error, rel=0.01, abs=0.0)


def test_size_scales_out(small_pair) -> None:
    """Twice the size under twice the line load deflects twice as far: stiffness per face width stays."""
    angle = np.linspace(-0.5, 0.5, 61) * small_pair.pair.pinion.pitch_angle
    small = engage(run(small_pair, until="compliance").mesh, angle, 50.0)
    large = engage(run(scaled(small_pair, 2.0), until="compliance").mesh, angle, 50.0 * 8.0)
    assert large.transmission_error == pytest.approx(2.0 * small.transmission_error, rel=1e-9, abs=0.0)
    assert large.mesh_stiffness == pytest.approx(2.0 * small.mesh_stiffness, rel=1e-8, abs=0.0)
    assert large.load_share == pytest.approx(small.load_share, abs=1e-9)
