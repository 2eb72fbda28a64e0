"""Plane stress becomes plane strain by the known change of the elastic constants."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.compliance import Bore, FiniteElements, PlaneStrain, PlaneStress, Root
from gearfem.definition.setup import Material
from gearfem.flank import Outline


@pytest.mark.parametrize("support", [Bore(), Root()])
def test_plane_stress_with_changed_constants_is_plane_strain(gear_factory, support: Bore | Root) -> None:
    steel = Material(youngs_modulus=206e9, poissons_ratio=0.3)
    changed = Material(youngs_modulus=206e9 / (1 - 0.3**2), poissons_ratio=0.3 / (1 - 0.3))
    u = np.linspace(2.3, 3.3, 7)
    curves = [
        FiniteElements(plane=plane, support=support, resolution=1.0).curve(
            Outline(gear=gear_factory(20, 2e-3, 22e-3, material=material)), u
        )
        for plane, material in ((PlaneStrain(), steel), (PlaneStress(), changed), (PlaneStress(), steel))
    ]
    # Equal constants give equal matrices up to rounding.
    assert curves[1].deflection == pytest.approx(curves[0].deflection, rel=1e-9, abs=0.0)
    assert np.abs(curves[2].deflection / curves[0].deflection - 1.0).min() > 0.005


def test_without_lateral_contraction_both_states_agree(gear_factory) -> None:
    outline = Outline(gear=gear_factory(20, 2e-3, 22e-3, material=Material(poissons_ratio=0.0)))
    strain, stress = (FiniteElements(plane=p, resolution=1.0).curve(outline, [2.3, 2.8]) for p in (PlaneStrain(), PlaneStress()))
    assert strain.deflection == pytest.approx(stress.deflection, rel=1e-12, abs=0.0)
