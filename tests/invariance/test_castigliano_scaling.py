"""Deflection per line load knows neither the module nor, but for its reciprocal, the modulus."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from gearfem.compliance.castigliano import Castigliano, FilletMiddle, FormCircle, RootEnd
from gearfem.definition.setup import Material
from gearfem.flank import Outline


@settings(max_examples=20, deadline=None)
@example(module=0.021743414455517154, shift=-0.11841772609717874, teeth=20)  # Undercut by a hair: curves that barely cross.
@given(module=st.floats(0.2e-3, 50e-3), shift=st.floats(-0.2, 0.6), teeth=st.integers(18, 90))
def test_module_scales_lengths_and_leaves_deflection(gear_factory, module, shift, teeth):
    u = np.linspace(2.3, 3.0, 6)
    for base in (FilletMiddle(), RootEnd(), FormCircle()):
        small, large = (
            Castigliano(base=base).curve(Outline(gear=gear_factory(teeth, m, m * (teeth / 2.0 + shift + 0.9), shift)), u)
            for m in (1e-3, module)
        )
        assert len(small.u) == len(large.u)
        # Rounding of coordinates of up to 90 modules in differences of about 0.1: 1e-16 * 90 / 0.1, cubed at most.
        np.testing.assert_allclose(large.deflection, small.deflection, rtol=1e-11)
        np.testing.assert_allclose(large.depth / module, small.depth / 1e-3, rtol=1e-11)


def test_modulus_divides_deflection(gear_factory):
    u = np.linspace(2.3, 3.2, 6)
    soft, steel = (
        Castigliano().curve(Outline(gear=gear_factory(20, 2e-3, 22e-3, material=Material(youngs_modulus=modulus))), u).deflection
        for modulus in (70e9, 206e9)
    )
    assert soft / steel == pytest.approx(206.0 / 70.0, rel=1e-14, abs=0.0)
