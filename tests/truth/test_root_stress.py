"""Stress along a free surface against uniform tension and pure bending, and ISO's root section against the outline."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from gearfem.compliance import FiniteElements, PlaneStrain, PlaneStress, Root
from gearfem.compliance.iso6336_root import root_factors, root_section
from gearfem.compliance.root_stress import fillet_stress, surface_stress
from gearfem.definition.setup import Material, Rack
from gearfem.flank import Outline
from gearfem.foundation import InputError

STEEL = Material()
TILT = math.radians(25.0)
ALONG, ACROSS = np.array([math.cos(TILT), math.sin(TILT)]), np.array([-math.sin(TILT), math.cos(TILT)])
EDGES = 5


def straight_edge() -> np.ndarray:
    return np.linspace(0.0, 10e-3, 2 * EDGES + 1)[:, None] * ALONG


@pytest.mark.parametrize(("plane", "modulus"), [(PlaneStress(), STEEL.youngs_modulus), (PlaneStrain(), STEEL.plane_strain_modulus)])
def test_uniform_tension_is_recovered(plane, modulus):
    nodes, stress = straight_edge(), 120e6
    moved = nodes * (stress / modulus)
    # Linear displacements lie in the element's space: rounding alone remains.
    np.testing.assert_allclose(surface_stress(nodes, moved[None], plane, STEEL), stress, rtol=1e-12)


def test_pure_bending_is_recovered_on_the_curved_fibre():
    # Beam of height 2 c bent to the curvature k: on the fibre y = c, u = k x y and v = -k x^2/2, stress E k c.
    curvature, c = 0.2, 2e-3
    nodes = straight_edge()
    x = nodes @ ALONG
    moved = (curvature * x * c)[:, None] * ALONG - (0.5 * curvature * x**2)[:, None] * ACROSS
    stress = surface_stress(nodes, moved[None], PlaneStress(), STEEL)
    # Quadratic displacements lie in the element's space: rounding alone remains.
    np.testing.assert_allclose(stress, STEEL.youngs_modulus * curvature * c, rtol=1e-12)


def test_rotation_makes_no_stress():
    nodes = straight_edge()
    spin = 1e-3 * np.stack([-nodes[:, 1], nodes[:, 0]], axis=1)
    # Terms of 206 MPa cancel to rounding.
    assert np.abs(surface_stress(nodes, spin[None], PlaneStrain(), STEEL)).max() < 1e-6


def test_plane_state_hardly_changes_stress_under_given_loads(coal_combine):
    # Michell: stresses of a traction problem do not depend on the elastic constants but for the held bore and holes.
    outline = Outline(gear=coal_combine.pair.pinion)
    strain, stress = (fillet_stress(outline, [2.3, 2.9], FiniteElements(plane=plane)) for plane in (PlaneStrain(), PlaneStress()))
    # Measured 0.1 %, which the bore of 30 mm, held, lets through; twice that is the band.
    np.testing.assert_allclose(strain.stress, stress.stress, rtol=2e-3)


def test_stress_falls_with_module_and_not_with_modulus(coal_combine, gear_factory):
    small, large = (Outline(gear=gear_factory(20, m, 11.0 * m)) for m in (1e-3, 8e-3))
    soft = Outline(gear=gear_factory(20, 1e-3, 11e-3, material=Material(youngs_modulus=70e9)))
    values = [fillet_stress(outline, [2.8], FiniteElements()).stress[0] for outline in (small, large, soft)]
    # Similar meshes and linear equations: rounding of the solution, whose condition is about 1e6.
    assert values[0] / values[1] == pytest.approx(8.0, rel=1e-8, abs=0.0)
    assert values[2] == pytest.approx(values[0], rel=1e-8, abs=0.0)


def test_clamped_root_is_refused(coal_combine):
    with pytest.raises(InputError, match="support: found root; allowed: bore"):
        fillet_stress(Outline(gear=coal_combine.pair.pinion), [2.5], FiniteElements(support=Root()))


@pytest.mark.parametrize(
    ("teeth", "shift", "thinning", "rounding"),
    [(16, 0.8, 0.055e-3, 0.3), (51, 1.175, 0.0, 0.3), (20, 0.0, 0.0, 0.38), (17, 0.2, 2e-5, 0.2)],
)
def test_root_section_of_iso_lies_on_the_outline(gear_factory, teeth, shift, thinning, rounding):
    module = 2e-3
    rack = Rack(tip_radius=rounding)
    tip = (teeth / 2.0 + shift + 0.7) * module
    outline = Outline(gear=gear_factory(teeth, module, tip, shift, flank_thinning=thinning, rack=rack))

    def turned(u: float) -> float:
        normal = outline.normal(u)
        return math.atan2(normal[1], normal[0]) - math.radians(60.0)

    u = brentq(turned, 1.0, 2.0, xtol=1e-15)
    section = root_section(outline)
    # Closed forms of one curve: rounding alone, on lengths of the module.
    np.testing.assert_allclose([section.height, section.chord / 2.0], outline.point(u), rtol=0.0, atol=1e-12 * module)
    step = 1e-4
    turn = np.hypot(*(outline.normal(u + step) - outline.normal(u - step)))
    radius = np.hypot(*(outline.point(u + step) - outline.point(u - step))) / turn
    # Central differences over 2e-4 of a fillet of a radian: 1e-8.
    assert section.fillet_radius == pytest.approx(radius, rel=1e-7, abs=0.0)


def test_form_factor_is_the_bending_stress_of_the_section(coal_combine):
    outline = Outline(gear=coal_combine.pair.wheel)
    u = np.array([2.5, 2.8, 3.0])
    factors = root_factors(outline, u)
    point, normal = outline.point(u), outline.normal(u)
    # By hand: force across the axis times its arm at the crossing, over s^2/6.
    crossing = point[:, 0] - normal[:, 0] / normal[:, 1] * point[:, 1]
    stress = normal[:, 1] * (crossing - factors.section.height) * 6.0 / factors.section.chord**2
    form = stress * outline.gear.module / math.cos(outline.gear.pressure_angle)
    np.testing.assert_allclose(factors.form_factor, form, rtol=1e-10)
    # By hand at the last: L = s/h, q = s/(2 rho).
    slender, notch = factors.section.chord / factors.bending_arm[-1], factors.notch
    assert factors.stress_correction[-1] == pytest.approx(
        (1.2 + 0.13 * slender) * notch ** (1.0 / (1.21 + 2.3 / slender)), rel=1e-14, abs=0.0
    )


def test_loads_without_a_bending_arm_have_no_factor(coal_combine):
    outline = Outline(gear=coal_combine.pair.wheel)
    factors = root_factors(outline, [2.1, 2.9])
    assert factors.u.tolist() == [2.9]
    with pytest.raises(InputError, match="from 2"):
        root_factors(outline, [1.9, 2.9])
