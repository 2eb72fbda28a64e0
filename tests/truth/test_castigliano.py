"""Castigliano's trapezoid against quadrature of its energy, beams in closed form and hand calculations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from gearfem.compliance.castigliano import Castigliano, FilletMiddle, FormCircle, RootEnd, trapezoid_compliance
from gearfem.definition.setup import Material
from gearfem.flank import Outline

STEEL = Material()
SHAPES = [
    # length, load chord, base chord, angle in degrees: slender, stubby, nearly parallel, parallel, narrowing, steep, pulling
    (16e-3, 6e-3, 17e-3, 25.0),
    (3e-3, 14e-3, 17e-3, 5.0),
    (9e-3, 8e-3, 8e-3 * (1.0 + 1e-7), 20.0),
    (9e-3, 8e-3, 8e-3, 20.0),
    (9e-3, 8e-3, 6e-3, 20.0),
    (12e-3, 2e-3, 16e-3, 80.0),
    (4e-3, 9e-3, 11e-3, -8.0),
]


def energy(force: float, length: float, load_chord: float, base_chord: float, angle: float) -> float:
    """Return the strain energy of one width by quadrature, with section forces from vectors; the root is at x = 0."""
    push = force * np.array([-math.sin(angle), -math.cos(angle)])
    point = np.array([length, 0.5 * load_chord])

    def density(x: float) -> float:
        chord = base_chord + (load_chord - base_chord) * x / length
        arm = point - np.array([x, 0.0])
        moment = arm[0] * push[1] - arm[1] * push[0]
        bending = moment**2 / (2.0 * STEEL.youngs_modulus * chord**3 / 12.0)
        shear = 1.2 * push[1] ** 2 / (2.0 * STEEL.shear_modulus * chord)
        return bending + shear + push[0] ** 2 / (2.0 * STEEL.youngs_modulus * chord)

    return quad(density, 0.0, length, epsabs=0.0, epsrel=1e-13, limit=200)[0]


@pytest.mark.parametrize("shape", SHAPES)
def test_deflection_is_the_derivative_of_the_energy(shape):
    length, load_chord, base_chord, degrees = shape
    angle = math.radians(degrees)
    parts = trapezoid_compliance(length=length, load_chord=load_chord, base_chord=base_chord, angle=angle, material=STEEL)
    force, step = 2e5, 1e5
    upper, lower = (energy(force + sign * step, length, load_chord, base_chord, angle) for sign in (1.0, -1.0))
    slope = (upper - lower) / (2.0 * step)
    # The energy is quadratic in the force, so the central difference is exact; 1e-10 leaves room for rounding alone.
    assert float(sum(parts)) * force == pytest.approx(slope, rel=1e-10, abs=0.0)


def test_parallel_sides_are_euler_with_shear():
    length, chord = 30e-3, 5e-3
    bending, shear, compression = trapezoid_compliance(length=length, load_chord=chord, base_chord=chord, angle=0.0, material=STEEL)
    assert bending == pytest.approx(4.0 * length**3 / (STEEL.youngs_modulus * chord**3), rel=1e-14, abs=0.0)
    assert shear == pytest.approx(1.2 * length / (STEEL.shear_modulus * chord), rel=1e-14, abs=0.0)
    assert compression == 0.0


def test_no_digits_are_lost_towards_parallel_sides():
    tapers = np.concatenate([-(10.0 ** np.arange(-15.0, -1.0)), 10.0 ** np.arange(-15.0, -1.0)])
    bending, _, _ = trapezoid_compliance(length=1.0, load_chord=1.0, base_chord=1.0 + tapers, angle=0.0, material=STEEL)
    # int s^2 (1 + k s)^-3 ds as a power series in k; with 30 terms its remainder at k = 0.1 is below 1e-27.
    rounded = (1.0 + tapers) - 1.0
    series = sum((-1.0) ** j * math.comb(j + 2, 2) * rounded**j / (j + 3) for j in range(30))
    # Rounding of the hypergeometric function: a few units in the last place.
    np.testing.assert_allclose(bending * STEEL.youngs_modulus / 12.0, series, rtol=5e-15)


def test_pressing_on_the_near_edge_bends_the_tooth_back():
    """By hand, E = h = 1, L = 2, 45 deg: M = (t - 1/2)/sqrt 2, so 12 int M^2 dt = 7; pulling, M = (t + 1/2)/sqrt 2 gives 31."""
    unit = Material(youngs_modulus=1.0)
    shape = {"length": 2.0, "load_chord": 1.0, "base_chord": 1.0, "material": unit}
    assert trapezoid_compliance(angle=math.pi / 4.0, **shape)[0] == pytest.approx(7.0, rel=1e-14, abs=0.0)
    assert trapezoid_compliance(angle=-math.pi / 4.0, **shape)[0] == pytest.approx(31.0, rel=1e-14, abs=0.0)


def test_axial_load_is_an_eccentric_column():
    """Pressed or pulled along one edge: N^2 gives L/(E h), the moment N h/2 gives 3 L/(E h), and there is no shear."""
    for angle in (math.pi / 2.0, -math.pi / 2.0):
        bending, shear, compression = trapezoid_compliance(length=2.0, load_chord=0.5, base_chord=0.5, angle=angle, material=STEEL)
        column = 2.0 / (STEEL.youngs_modulus * 0.5)
        assert bending == pytest.approx(3.0 * column, rel=1e-14, abs=0.0)
        assert compression == pytest.approx(column, rel=1e-14, abs=0.0)
        # cos(pi/2) is 6e-17 in floating point.
        assert float(shear) < 1e-30 * column


@pytest.mark.parametrize("base", [FilletMiddle(), RootEnd(), FormCircle()])
def test_curve_is_the_energy_of_the_tooth_it_describes(coal_combine, base):
    """The whole way from the outline: points and normals of the flank, load line, base chord, energy by quadrature."""
    outline = Outline(gear=coal_combine.pair.pinion)
    curve = Castigliano(base=base).curve(outline, np.linspace(2.4, 3.4, 5))
    bottom = outline.point(base.parameter(outline))
    for k, u in enumerate(curve.u):
        point, inward = outline.point(u), -outline.normal(u)
        angle = math.atan2(-inward[0], -inward[1])
        expected = 2.0 * energy(1.0, point[0] - bottom[0], 2.0 * point[1], 2.0 * bottom[1], angle)
        assert curve.deflection[k] == pytest.approx(expected, rel=1e-10, abs=0.0)
        # The depth leads from the load point along the load to the centreline; rounding of coordinates of 0.07 m.
        assert (point + curve.depth[k] * inward)[1] == pytest.approx(0.0, abs=1e-16)


def test_deflection_grows_towards_the_tip(coal_combine):
    for gear in (coal_combine.pair.pinion, coal_combine.pair.wheel):
        curve = Castigliano().curve(Outline(gear=gear), np.linspace(2.0, 3.0, 101))
        assert (curve.deflection > 0.0).all()
        assert (np.diff(curve.deflection) > 0.0).all()
