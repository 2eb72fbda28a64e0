"""How the deflection at the centreline converges as the mesh is refined, and what the error estimate says of it."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.compliance import Bore, FiniteElements, Root, load_positions
from gearfem.definition.setup import Rack
from gearfem.flank import Outline


@pytest.fixture(scope="module")
def outline(gear_factory) -> Outline:
    return Outline(gear=gear_factory(17, 1e-3, 9.5e-3, rack=Rack(tip_radius=0.38), bore_radius=5.2e-3))


@pytest.mark.parametrize(("support", "first"), [(Bore(), 2.05), (Root(), 2.4)])
def test_deflection_converges_with_the_third_power_of_the_element(outline: Outline, support: Bore | Root, first: float) -> None:
    u = np.linspace(first, 2.95, 19)
    at = {r: FiniteElements(support=support, resolution=r).curve(outline, u).deflection for r in (1, 2, 3, 4, 6)}
    sizes = np.array([1.0, 1 / 2, 1 / 3])
    changes = [np.sqrt(np.mean((at[r] / at[2 * r] - 1.0) ** 2)) for r in (1, 2, 3)]
    order = np.polyfit(np.log(sizes), np.log(changes), 1)[0]
    # Load and reading are point sources for elements of degree 2: their product leaves h^(2 + 1). The places of loads
    # within their elements change from mesh to mesh and scatter the fit by about 0.3.
    assert order == pytest.approx(3.0, abs=0.4)


def test_default_mesh_is_within_a_fifth_of_a_per_cent_of_its_limit(coal_combine) -> None:
    for gear in (coal_combine.pair.pinion, coal_combine.pair.wheel):
        outline = Outline(gear=gear)
        u = load_positions(outline, 20)
        fine = FiniteElements(resolution=6).curve(outline, u).deflection
        error = np.abs(FiniteElements().curve(outline, u).deflection / fine - 1.0)
        # At order 3 twice the resolution keeps an eighth of the error: the limit is farther by a seventh.
        assert error.max() * 8.0 / 7.0 < 0.002


def test_estimated_error_covers_the_true_one(outline: Outline) -> None:
    u = load_positions(outline, 20)
    method = FiniteElements(resolution=2)
    true = np.abs(method.curve(outline, u).deflection / FiniteElements(resolution=6).curve(outline, u).deflection - 1.0)
    estimate = method.error(outline, u)
    assert estimate.max() < 5.0 * true.max()
    # The estimate is no bound: its sign changes along the flank may hide the error of a position.
    assert np.mean(true <= estimate) >= 0.9
