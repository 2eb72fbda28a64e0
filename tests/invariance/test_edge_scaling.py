"""Contact over a tip edge has no length and no modulus of its own."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from gearfem.contact import EdgedLine, Line
from gearfem.definition.setup import Material

STEEL = Material()
LAW = EdgedLine(pinion=STEEL, wheel=STEEL)
EDGES = np.array([-1e-4, -2e-5, -3e-6, 0.0, 2e-5, 2e-4, 1e-3])


def line(scale=1.0, stretch=1.0):
    """Return lines with all lengths scaled; radii also by the square of a stretch along the surface."""
    lengths = (0.029 * stretch, 3e-3, 2e-3, EDGES, 0.16e-3 * stretch)
    return Line(*(scale * part for part in np.broadcast_arrays(*lengths)))


@settings(deadline=None, max_examples=50)
@given(scale=st.floats(1e-3, 1e3), stiffer=st.floats(0.1, 10.0), load=st.floats(1e2, 1e6))
def test_lengths_and_moduli_scale(scale, stiffer, load):
    """All lengths times s and E times c, load times s c: the approach is s times as large."""
    hard = Material(youngs_modulus=STEEL.youngs_modulus * stiffer)
    law = EdgedLine(pinion=hard, wheel=hard)
    # Rounding, amplified by R/rho near the ends of the band.
    np.testing.assert_allclose(law.approach(load * scale * stiffer, line(scale)), scale * LAW.approach(load, line()), rtol=1e-12)
    np.testing.assert_allclose(law.compliance(load * scale * stiffer, line(scale)) * stiffer, LAW.compliance(load, line()), rtol=1e-11)
    np.testing.assert_allclose(
        law.centre(load * scale * stiffer, line(scale)), scale * LAW.centre(load, line()), rtol=1e-9, atol=1e-15 * scale
    )


@settings(deadline=None, max_examples=50)
@given(stretch=st.floats(1e-2, 1e2), load=st.floats(1e2, 1e6))
def test_only_load_times_radius_counts(stretch, load):
    """Small slopes: radii times c and load over c leave the band as it was, and its radius over R."""
    radius = LAW.effective_radius(load / stretch, line(stretch=stretch)) / stretch
    np.testing.assert_allclose(radius, LAW.effective_radius(load, line()), rtol=1e-11)


@settings(deadline=None, max_examples=30)
@given(load=st.floats(1e2, 1e6))
def test_bodies_may_be_swapped(load):
    """Only the order of the depths goes with the materials; whose edge it is does not matter to half planes."""
    soft = Material(youngs_modulus=1e11, poissons_ratio=0.2)
    first, second = line(), line()
    swapped = Line(second.radius, second.depth2, second.depth1, second.edge, second.edge_radius)
    one = EdgedLine(pinion=soft, wheel=STEEL).approach(load, first)
    np.testing.assert_allclose(EdgedLine(pinion=STEEL, wheel=soft).approach(load, swapped), one, rtol=1e-14)
