"""What must not change the compliance per line load, and meshes of arbitrary sane gears."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from gearfem.compliance import Bore, FiniteElements, Root, RootChord
from gearfem.compliance.elasticity import QUADRATURE
from gearfem.compliance.section_mesh import root_mesh, sector_mesh
from gearfem.definition.setup import Material, Rack
from gearfem.flank import Outline
from gearfem.foundation import InputError

U = np.linspace(2.3, 3.4, 8)


@pytest.mark.parametrize("support", [Bore(), Root(), RootChord()])
@pytest.mark.parametrize("module", [0.5e-3, 50e-3])
def test_similar_gears_are_equally_stiff_per_line_load(gear_factory, support, module: float) -> None:
    method = FiniteElements(support=support, resolution=1.0)
    base = method.curve(Outline(gear=gear_factory(20, 1e-3, 11e-3)), U)
    scaled = method.curve(Outline(gear=gear_factory(20, module, 11.0 * module)), U)
    # Displacement per line load has the unit of 1/E: no length in it. The rest is rounding.
    assert scaled.deflection == pytest.approx(base.deflection, rel=1e-8, abs=0.0)
    assert scaled.depth == pytest.approx(base.depth * module / 1e-3, rel=1e-9, abs=0.0)


def test_deflection_is_inverse_to_youngs_modulus(gear_factory) -> None:
    method = FiniteElements(resolution=1.0)
    curves = [method.curve(Outline(gear=gear_factory(20, 1e-3, 11e-3, material=Material(youngs_modulus=e))), U) for e in (206e9, 70e9)]
    assert curves[1].deflection * 70e9 == pytest.approx(curves[0].deflection * 206e9, rel=1e-10, abs=0.0)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    teeth=st.integers(8, 200),
    module=st.floats(0.5e-3, 50e-3),
    shift=st.floats(-0.5, 1.2),
    dedendum=st.floats(1.0, 1.4),
    rack_round=st.floats(0.02, 0.4),
    addendum=st.floats(0.6, 1.2),
    edge=st.floats(0.001, 0.2),
    rim=st.one_of(st.floats(0.05, 3.0), st.none()),
    angle=st.floats(14.5, 25.0),
)
def test_meshes_of_sane_gears_do_not_fold(gear_factory, teeth, module, shift, dedendum, rack_round, addendum, edge, rim, angle) -> None:
    reference = module * teeth / 2.0
    root = reference + (shift - dedendum) * module
    # Without a rim thickness, the bore is 5 % of the root radius: nearly a full disc.
    bore = 0.05 * root if rim is None else root - rim * module
    assume(bore >= 0.05 * root)
    try:
        gear = gear_factory(
            teeth,
            module,
            reference + (addendum + shift) * module,
            shift,
            root_radius=root,
            bore_radius=bore,
            tip_edge_radius=edge * module,
            rack=Rack(dedendum=dedendum, tip_radius=rack_round),
            pressure_angle=math.radians(angle),
        )
        outline = Outline(gear=gear)
    except (InputError, ValueError):
        # Such as a pointed tip: refused by the outline, not by the mesh.
        assume(False)
    section = sector_mesh(outline, 1.0)
    for mesh in (section.mesh, root_mesh(outline, 2.0, chord=False).mesh, root_mesh(outline, 2.0, chord=True).mesh):
        assert mesh.mapping().detDF(QUADRATURE[0]).min() > 0.0
    places = section.mesh.doflocs.T
    u = np.minimum(section.outline_u, np.nextafter(5.0, 4.0))
    np.testing.assert_allclose(places[section.outline], outline.point(u), rtol=0.0, atol=1e-9 * module)
    cut = places[section.upper]
    np.testing.assert_allclose(np.arctan2(cut[:, 1], cut[:, 0]), math.pi / teeth, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(cut * [1.0, -1.0], places[section.lower])
    assert np.all(np.diff(places[section.centreline, 0]) > 0.0)
