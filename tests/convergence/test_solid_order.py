"""How the three-dimensional deflection converges, in the section and along the face width."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.compliance import Root
from gearfem.compliance.solid import SolidElements
from gearfem.definition.setup import Rack
from gearfem.flank import Outline


@pytest.fixture(scope="module")
def outline(gear_factory) -> Outline:
    return Outline(gear=gear_factory(17, 1e-3, 9.5e-3, rack=Rack(tip_radius=0.38), bore_radius=5.2e-3))


@pytest.mark.slow
def test_refined_sections_converge_with_the_third_power(outline: Outline) -> None:
    u = np.linspace(2.4, 2.95, 9)
    at = {r: SolidElements(support=Root(), resolution=r, layers=2).curve(outline, u, 2e-3).deflection for r in (0.5, 1.0, 1.5, 2.0, 3.0)}
    sizes = np.array([1.0, 1 / 2, 1 / 3])
    changes = [np.sqrt(np.mean((at[r] / at[2 * r] - 1.0) ** 2)) for r in (0.5, 1.0, 1.5)]
    order = np.polyfit(np.log(sizes), np.log(changes), 1)[0]
    print(f"order of the deflection in the section: {order:.2f}")
    # As in the plane: point loads and readings in the section leave h^(2 + 1); few positions scatter the fit by half.
    assert order == pytest.approx(3.0, abs=0.6)


def test_more_layers_converge(outline: Outline) -> None:
    counts = (4, 8, 16, 32)
    averages = np.array([SolidElements(support=Root(), resolution=0.5, layers=n).profile(outline, 2.8, 10e-3).average for n in counts])
    changes = np.abs(np.diff(averages)) / averages[-1]
    order = -np.polyfit(np.log(counts[:-1]), np.log(changes), 1)[0]
    print(f"order of the width average in the layers: {order:.2f}, changes {changes}")
    # Clamp and line load meet the free ends in points where stress is unbounded; they keep the order below the 4 of smooth loads.
    assert order > 2.0
    # So the default of 12 layers is worth less than a ten-thousandth.
    assert changes[1:].sum() * (12 / 8) ** -order < 1e-4
