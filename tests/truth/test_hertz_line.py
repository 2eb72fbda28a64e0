"""Hertz line contact against the half space loaded by line loads, and against its own derivative."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from gearfem.contact import SMALLEST_LINE_LOAD, HertzLine
from gearfem.definition.setup import Material

STEEL = Material()
CAST_IRON = Material(youngs_modulus=105e9, poissons_ratio=0.26)
LAW = HertzLine(pinion=STEEL, wheel=CAST_IRON)
LOAD, RADIUS = 3.5e5, 23e-3


def stresses(z: float, peak: float, a: float) -> tuple[float, float]:
    """Return s_z and s_x at depth z on the axis: line loads of Flamant's half space summed over Hertz's ellipse."""

    def summed(vertical: float, across: float) -> float:
        def kernel(t: float) -> float:
            x = a * np.sin(t)
            return peak * np.cos(t) * x**across * z**vertical / (x * x + z * z) ** 2 * a * np.cos(t)

        # The kernel has the width z about t = 0: quad is told where it turns.
        turns = [0.0, *(t for t in (min(z / a, 1.5), 0.1) if t < np.pi / 2.0)]
        return 2.0 * quad(kernel, 0.0, np.pi / 2.0, points=turns, epsabs=0.0, epsrel=1e-11, limit=400)[0]

    return -2.0 / np.pi * summed(3.0, 0.0), -2.0 / np.pi * summed(1.0, 2.0)


def strained_depth(material: Material, depth: float, load: float) -> float:
    """Return the shortening of the axis from the surface to the depth, by quadrature of plane strain."""
    a, peak = float(LAW.half_width(load, RADIUS)), float(LAW.pressure(load, RADIUS))
    nu = material.poissons_ratio

    def strain(z: float) -> float:
        down, across = stresses(z, peak, a)
        return (down - nu * (across + nu * (down + across))) / material.youngs_modulus

    breaks = [part * a for part in (0.1, 1.0, 3.0) if part * a < depth]
    return -quad(strain, 0.0, depth, points=breaks, epsabs=0.0, epsrel=1e-9, limit=200)[0]


@pytest.mark.parametrize("ratio", [0.3, 1.0, 8.0, 40.0])
def test_approach_is_the_strain_under_the_load(ratio):
    depth = ratio * float(LAW.half_width(LOAD, RADIUS))
    expected = strained_depth(STEEL, depth, LOAD) + strained_depth(CAST_IRON, 1.7 * depth, LOAD)
    # The nested quadratures are asked for 1e-9.
    assert LAW.approach(LOAD, RADIUS, depth, 1.7 * depth) == pytest.approx(expected, rel=3e-9, abs=0.0)


def test_pressure_carries_the_load():
    force = np.array([1.0, 1e3, 4e5, 2e6])
    carried = np.pi / 2.0 * LAW.pressure(force, RADIUS) * LAW.half_width(force, RADIUS)
    np.testing.assert_allclose(carried, force, rtol=1e-14)


def test_compliance_is_the_derivative_of_the_approach():
    force = np.logspace(-2.0, 9.0, 45)
    step = 1e-4 * force
    args = (RADIUS, 9e-3, 4e-3)
    slope = (LAW.approach(force + step, *args) - LAW.approach(force - step, *args)) / (2.0 * step)
    # Central difference: (1e-4)^2 times a third derivative that is of the order of the first over F^2, rounding 1e-16/1e-4.
    np.testing.assert_allclose(LAW.compliance(force, *args), slope, rtol=2e-8)


def test_approach_grows_and_stiffens_at_every_load():
    """Also at loads whose contact is far wider than the depth, where the usual asymptote falls."""
    force = np.logspace(-3.0, 12.0, 301)
    a = LAW.half_width(force, RADIUS)
    assert a[0] < 1e-4 * 1e-3 < 1e2 * 1e-3 < a[-1]
    for depth in (1e-3, 10e-3):
        approach, slope = LAW.approach(force, RADIUS, depth, depth), LAW.compliance(force, RADIUS, depth, depth)
        assert (np.diff(approach) > 0.0).all()
        assert (slope > 0.0).all()
        assert (np.diff(slope) < 0.0).all()


def test_without_load_nothing_moves():
    force = np.array([0.0, 5e-324, 1e-300, SMALLEST_LINE_LOAD])
    approach = LAW.approach(force, RADIUS, 10e-3, 10e-3)
    assert approach[0] == 0.0
    assert LAW.half_width(0.0, RADIUS) == LAW.pressure(0.0, RADIUS) == 0.0
    # The bound that the constant's comment states: below it the slope is held, and the error is less than an atom.
    assert 0.0 < approach[-1] < 2e-13
    slope = LAW.compliance(force, RADIUS, 10e-3, 10e-3)
    assert (slope == slope[-1]).all()
    assert np.isfinite(slope).all()


def test_bodies_are_alike():
    mirrored = HertzLine(pinion=CAST_IRON, wheel=STEEL)
    assert mirrored.approach(LOAD, RADIUS, 4e-3, 9e-3) == pytest.approx(float(LAW.approach(LOAD, RADIUS, 9e-3, 4e-3)), rel=1e-15, abs=0.0)
    assert mirrored.half_width(LOAD, RADIUS) == pytest.approx(float(LAW.half_width(LOAD, RADIUS)), rel=1e-15, abs=0.0)


def test_lengths_scale():
    """Twice the size under twice the line load: same pressure, approach and width twice."""
    assert LAW.approach(2 * LOAD, 2 * RADIUS, 18e-3, 8e-3) == pytest.approx(
        2.0 * float(LAW.approach(LOAD, RADIUS, 9e-3, 4e-3)), rel=1e-14, abs=0.0
    )
    assert LAW.pressure(2 * LOAD, 2 * RADIUS) == pytest.approx(float(LAW.pressure(LOAD, RADIUS)), rel=1e-14, abs=0.0)
