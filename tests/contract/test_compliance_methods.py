"""One suite for every way to compute a tooth's compliance: what the later stages take for granted."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import ArrayLike

from gearfem.compliance import (
    Bore,
    Castigliano,
    FilletMiddle,
    FiniteElements,
    FormCircle,
    PlaneStrain,
    PlaneStress,
    Root,
    RootChord,
    RootEnd,
    SolidCurve,
    SolidElements,
)
from gearfem.compliance.record import ComplianceCurve
from gearfem.flank import Outline
from gearfem.foundation import InputError, Record, digest


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SolidTooth(Record):
    """Solid elements on a face width in modules, so that a larger gear is wider too."""

    method: SolidElements = dataclasses.field(default_factory=lambda: SolidElements(support=Root(), resolution=0.5, layers=4))
    modules: float = 5.0

    def curve(self, outline: Outline, u: ArrayLike) -> ComplianceCurve:
        return SolidCurve(method=self.method, face_width=self.modules * outline.gear.module).curve(outline, u)


PLANES, HELD = (PlaneStrain(), PlaneStress()), (Bore(), Root(), RootChord())
METHODS = [FiniteElements(plane=plane, support=support) for plane in PLANES for support in HELD]
METHODS += [SolidTooth()]
METHODS += [Castigliano(base=base) for base in (FilletMiddle(), RootEnd(), FormCircle())]
NAMES = {"fe_plane_strain", "fe_plane_stress", "fe_3d", "castigliano"}
SUPPORTS = {"bore", "root", "root_chord"}
U = np.linspace(2.1, 3.0, 7)


@pytest.fixture(
    params=METHODS, ids=lambda method: "-".join([type(method).__name__, *(type(part).__name__ for part in vars(method).values())])
)
def method(request):
    return request.param


@pytest.fixture
def outline(gear_factory) -> Outline:
    return Outline(gear=gear_factory(25, 4e-3, 54.2e-3, 0.1))


def test_curve_says_what_it_is(method, outline) -> None:
    curve = method.curve(outline, U)
    assert curve.method in NAMES
    assert curve.support in SUPPORTS
    assert len(curve.u) == len(curve.radius) == len(curve.deflection) == len(curve.depth)
    assert set(np.round(curve.u, 12)) <= set(np.round(U, 12))
    assert curve.radius == pytest.approx(np.hypot(*outline.point(curve.u).T), rel=1e-12, abs=0.0)


def test_deflection_is_positive_and_grows_towards_the_tip(method, outline) -> None:
    curve = method.curve(outline, U)
    assert len(curve.u) >= 5
    assert (curve.deflection > 0.0).all()
    assert (np.diff(curve.deflection) > 0.0).all()


def test_depth_leads_to_the_centreline(method, outline) -> None:
    curve = method.curve(outline, U)
    reached = outline.point(curve.u) - curve.depth[:, None] * outline.normal(curve.u)
    assert np.abs(reached[:, 1]).max() < 1e-12
    assert (curve.depth > 0.0).all()


def test_compliance_falls_with_the_modulus(method, outline) -> None:
    gear = outline.gear
    material = dataclasses.replace(gear.material, youngs_modulus=2.0 * gear.material.youngs_modulus)
    stiff = Outline(gear=dataclasses.replace(gear, material=material))
    assert method.curve(stiff, U).deflection == pytest.approx(method.curve(outline, U).deflection / 2.0, rel=1e-10, abs=0.0)


def test_size_scales_out(method, outline) -> None:
    """A line load per width deflects gears of one shape by the same length, whatever their module."""
    gear = outline.gear
    lengths = ("module", "root_radius", "tip_radius", "tip_edge_radius", "bore_radius")
    large = Outline(gear=dataclasses.replace(gear, **{name: 3.0 * getattr(gear, name) for name in lengths}))
    assert method.curve(large, U).deflection == pytest.approx(method.curve(outline, U).deflection, rel=1e-8, abs=0.0)


def test_positions_do_not_disturb_each_other(method, outline) -> None:
    together = method.curve(outline, U)
    alone = method.curve(outline, U[3:4])
    assert alone.deflection[0] == pytest.approx(together.deflection[list(together.u).index(U[3])], rel=1e-10, abs=0.0)


def test_same_content_gives_the_same_result(method, outline) -> None:
    again = dataclasses.replace(method)
    assert digest(again) == digest(method)
    assert digest(again.curve(outline, U)) == digest(method.curve(outline, U))


@pytest.mark.parametrize("u", [[1.5], [4.5], [2.5, 2.4], [np.nan]])
def test_positions_off_the_flank_are_refused(method, outline, u) -> None:
    with pytest.raises(InputError):
        method.curve(outline, u)
