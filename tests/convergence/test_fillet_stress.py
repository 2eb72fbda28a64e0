"""The largest fillet stress converges, is free of the mesh to a hundredth, and its estimated error covers the true one."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.compliance import FiniteElements
from gearfem.compliance.root_stress import fillet_stress, stress_error
from gearfem.flank import Outline

LOADS = [2.3, 2.6, 2.95]


@pytest.fixture(scope="module")
def stresses(coal_combine):
    """Largest stress at five resolutions, pinion of the coal combine."""
    outline = Outline(gear=coal_combine.pair.pinion)
    return {n: fillet_stress(outline, LOADS, FiniteElements(resolution=float(n))).stress for n in (2, 3, 4, 6, 12)}


@pytest.mark.slow
def test_maximum_converges_with_an_order_above_two(stresses):
    coarse = {n: values for n, values in stresses.items() if n < 12}
    error = [np.abs(values / stresses[12] - 1.0).max() for values in coarse.values()]
    order = -np.polyfit(np.log(list(coarse)), np.log(error), 1)[0]
    print(f"errors {np.round(error, 5)} at resolutions {list(coarse)}: order {order:.2f}")
    # The derivative of quadratic elements: 2 at any point, 3 at the Gauss points of a regular mesh; half an order for the scatter
    # of four points whose error changes sign.
    assert 1.5 < order < 3.5


def test_default_is_free_of_the_mesh(stresses, coal_combine):
    outline = Outline(gear=coal_combine.pair.pinion)
    error = np.abs(stresses[6] / stresses[12] - 1.0)
    print(f"error at the default resolution {np.round(error, 5)}, estimated {np.round(stress_error(outline, LOADS), 5)}")
    assert error.max() < 0.01
    assert (error < stress_error(outline, LOADS)).all()
