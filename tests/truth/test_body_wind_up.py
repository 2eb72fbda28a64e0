"""Wind-up of the body against the closed form of a clamped annulus, and the parts of the deflection of a tooth."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gearfem.compliance import FiniteElements, PlaneStrain, PlaneStress, Root, annulus_wind_up, body_compliance, load_positions
from gearfem.compliance.body import wind_up_profile
from gearfem.flank import Outline
from gearfem.foundation import InputError


@pytest.fixture(scope="module")
def wheel(coal_combine) -> Outline:
    return Outline(gear=coal_combine.pair.wheel)


@pytest.mark.parametrize("plane", [PlaneStrain(), PlaneStress()])
def test_deep_in_the_body_the_wind_up_is_that_of_an_annulus(wheel: Outline, plane) -> None:
    radius, rotation = wind_up_profile(FiniteElements(plane=plane), wheel, [2.2, 3.0])
    inside = radius < wheel.gear.root_radius - 3.0 * wheel.gear.module
    exact = annulus_wind_up(wheel.gear, radius)
    assert np.count_nonzero(inside & (exact > 0.0)) > 10
    # What repeats with the teeth fades as (r/r_f)^51, to 2 % at three modules; quadratic elements follow 1/r^2 to 1e-4.
    ratio = rotation[inside & (exact > 0.0)] / exact[inside & (exact > 0.0), None]
    assert ratio == pytest.approx(1.0, abs=3e-4)


def test_wind_up_at_the_root_is_near_the_annulus_and_the_same_for_every_load(wheel: Outline, coal_combine) -> None:
    for outline, least in ((wheel, 0.99), (Outline(gear=coal_combine.pair.pinion), 0.97)):
        parts = body_compliance(outline, np.linspace(2.4, 3.0, 7))
        ratio = parts.rotation / annulus_wind_up(outline.gear, outline.gear.root_radius)
        # In the middle of the spaces the free surface of the root turns a little less than the circle's mean.
        assert least < ratio.min() <= ratio.max() < 1.0
        assert np.ptp(ratio) < 0.01
        # The arm of every load on the flank is the base radius.
        assert parts.wind_up == pytest.approx(parts.rotation * outline.gear.base_radius**2, rel=1e-12, abs=0.0)


def test_parts_are_those_of_the_curves_and_of_the_coupling(wheel: Outline) -> None:
    u = load_positions(wheel, 14)
    u = u[u <= 3.0]
    parts = body_compliance(wheel, u)
    tooth = FiniteElements().tooth(wheel, parts.u, (-2, -1, 1, 2))
    assert 0 < len(parts.u) < len(u)
    assert parts.whole == pytest.approx(tooth.deflection, rel=1e-9, abs=0.0)
    assert parts.body + FiniteElements(support=Root()).curve(wheel, u).deflection == pytest.approx(parts.whole, rel=1e-9, abs=0.0)
    for place, column in ((0, 1), (1, 0), (2, 0), (3, 1)):
        assert parts.neighbours[:, column] == pytest.approx(np.diagonal(tooth.coupling[place]), rel=1e-9, abs=0.0)
    # Far from the loaded tooth only the wind-up is left to go down to, and locally more is added.
    assert np.all(parts.body > parts.wind_up)
    assert np.all(np.diff(parts.neighbours, axis=1) < 0.0)


@pytest.mark.parametrize("member", ["pinion", "wheel"])
def test_other_teeth_move_by_the_wind_up_less_their_share_of_the_bending(coal_combine, member) -> None:
    """Harmonics above 0 sum to nothing over all teeth: what bends the body under the load lifts the others by 1/(z - 1) of it."""
    outline = Outline(gear=getattr(coal_combine.pair, member))
    u, teeth = np.array([2.5, 2.9]), outline.gear.teeth
    tooth = FiniteElements().tooth(outline, u, tuple(range(1, teeth)))
    others = np.array([np.diagonal(table) for table in tooth.coupling]).mean(axis=0)
    parts = body_compliance(outline, u)
    below = 1.0 - others / parts.wind_up
    # The body's part in the deflection holds the bending of harmonics above 0 and what the clamp at the root kept stiff.
    assert np.all(below > 0.0)
    assert np.all(below < (parts.body / parts.wind_up - 1.0) / (teeth - 1))


def test_annulus_by_hand(wheel: Outline) -> None:
    # By hand: G = 79.231 GPa; (1/60^2 - 1/203.4^2) 1/mm2 = 253.60 1/m2; over 4 pi G: 2.5472e-10 rad per N.
    assert float(annulus_wind_up(wheel.gear, 203.4e-3)) == pytest.approx(2.5472e-10, rel=1e-4, abs=0.0)
    assert math.isclose(float(annulus_wind_up(wheel.gear, wheel.gear.bore_radius)), 0.0)


def test_a_tooth_held_at_its_root_has_no_body(wheel: Outline) -> None:
    with pytest.raises(InputError, match="bore: wind-up"):
        body_compliance(wheel, [2.5, 2.9], FiniteElements(support=Root()))
