"""The beam of true thickness against the trapezoid where both are the same, and its own refinement and refusals."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gearfem.compliance import Castigliano, FilletMiddle, FormCircle, beam
from gearfem.compliance.beam import beam_deflection
from gearfem.compliance.castigliano import trapezoid_compliance
from gearfem.definition.setup import Material
from gearfem.flank import Outline
from gearfem.foundation import InputError

LOADS = [2.7, 2.9, 3.0]


@pytest.fixture(scope="module")
def outline(coal_combine) -> Outline:
    return Outline(gear=coal_combine.pair.pinion)


class Straight:
    """An outline with straight sides between its foot and its load, for a beam whose exact deflection is known."""

    worn = False

    def __init__(self, outline: Outline) -> None:
        self.gear, self._true = outline.gear, outline
        self._foot, self._load = outline.point(2.0), outline.point(3.0)

    def point(self, u: np.ndarray) -> np.ndarray:
        return self._foot + (np.asarray(u, float)[..., None] - 2.0) * (self._load - self._foot)

    def normal(self, u: np.ndarray) -> np.ndarray:
        return self._true.normal(u)


def test_straight_sides_give_the_trapezoid(outline):
    trapezoid = Castigliano(base=FormCircle()).curve(outline, [3.0])
    # The trapezoidal rule over 2000 steps: square of the step.
    np.testing.assert_allclose(beam_deflection(Straight(outline), [3.0], 2.0), trapezoid.deflection, rtol=1e-6)


def test_reading_at_the_crossing_is_a_trapezoid_cut_there(outline):
    straight = Straight(outline)
    point, normal, foot = straight.point(3.0), straight.normal(3.0), straight.point(2.0)
    crossing = point[0] - normal[0] / normal[1] * point[1]
    chord = 2.0 * (point[1] + (crossing - point[0]) / (foot[0] - point[0]) * (foot[1] - point[1]))
    angle = np.arctan2(normal[0], normal[1])
    length = crossing - foot[0]
    # The load on the axis at the crossing: bending by its transverse part alone.
    bending = trapezoid_compliance(length=length, load_chord=chord, base_chord=2.0 * foot[1], angle=0.0, material=outline.gear.material)[0]
    parts = trapezoid_compliance(length=length, load_chord=chord, base_chord=2.0 * foot[1], angle=angle, material=outline.gear.material)
    expected = bending * np.cos(angle) ** 2 + parts[1] + parts[2]
    np.testing.assert_allclose(beam_deflection(straight, [3.0], 2.0, at_crossing=True), expected, rtol=1e-6)


def test_twice_the_stations_change_nothing(outline, monkeypatch):
    coarse = beam_deflection(outline, LOADS, 1.0)
    monkeypatch.setattr(beam, "STATIONS", 2 * beam.STATIONS - 1)
    # As stated beside the number of stations.
    np.testing.assert_allclose(coarse, beam_deflection(outline, LOADS, 1.0), rtol=1e-5)


def test_plane_strain_divides_all_but_shear(outline):
    stiff = Outline(
        gear=dataclasses.replace(outline.gear, material=Material(youngs_modulus=206e9 / 0.91, poissons_ratio=0.3 / 0.91 + 0.09 / 0.91))
    )
    # E' = E/(1 - nu^2) with the same G: 1 + nu' = E'/(2 G) = (1 + nu)/(1 - nu^2).
    assert stiff.gear.material.shear_modulus == pytest.approx(outline.gear.material.shear_modulus, rel=1e-12, abs=0.0)
    np.testing.assert_allclose(beam_deflection(outline, LOADS, 1.5, plane_strain=True), beam_deflection(stiff, LOADS, 1.5), rtol=1e-12)


def test_bulging_flanks_are_stiffer_than_the_trapezoid(outline):
    base = FilletMiddle().parameter(outline)
    high = beam_deflection(outline, [2.95], base)
    # A beam thicker than the trapezoid at each height up to the load deflects less.
    assert high[0] < Castigliano().curve(outline, [2.95]).deflection[0]


def test_feet_off_the_fillet_and_loads_below_it_are_refused(outline):
    with pytest.raises(InputError, match="foot"):
        beam_deflection(outline, LOADS, 2.5)
    with pytest.raises(InputError, match="above the foot"):
        beam_deflection(outline, [2.0, 3.0], 2.0, at_crossing=True)
