"""Rows that are left out, refusals, and the small contracts of the compliance stage."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.compliance import Bore, FiniteElements, Root, RootChord, load_positions, make_compliance
from gearfem.compliance.elasticity import QUADRATURE
from gearfem.compliance.patchwork import join, refuse_folds
from gearfem.flank import Outline, make_flanks
from gearfem.foundation import InputError, SolveError, digest


@pytest.fixture(scope="module")
def wheel(coal_combine) -> Outline:
    return Outline(gear=coal_combine.pair.wheel)


def test_rows_whose_reading_lies_under_the_clamp_are_left_out(wheel: Outline) -> None:
    u = np.linspace(2.0, 3.2, 121)
    whole, arc, chord = (FiniteElements(support=s, resolution=1.0).curve(wheel, u) for s in (Bore(), Root(), RootChord()))
    assert len(whole.u) == len(u)
    assert 0 < len(arc.u) < len(chord.u) < len(u)
    point, normal = wheel.point(u), wheel.normal(u)
    crossing = point[:, 0] - point[:, 1] / normal[:, 1] * normal[:, 0]
    np.testing.assert_array_equal(arc.u, u[crossing > wheel.gear.root_radius])


def test_a_stiffer_support_gives_a_smaller_deflection(wheel: Outline) -> None:
    u = [2.6, 2.9]
    whole, arc, chord = (FiniteElements(support=s, resolution=1.0).curve(wheel, u).deflection for s in (Bore(), Root(), RootChord()))
    assert np.all(arc < chord)
    assert np.all(chord < whole)


@pytest.mark.parametrize("u", [[1.9, 2.5], [2.5, 4.0], [2.5, 2.5], [2.6, 2.5], [], [2.5, float("nan")]])
def test_positions_that_are_not_on_the_flank_are_refused(wheel: Outline, u: list[float]) -> None:
    with pytest.raises(InputError, match="load positions u"):
        FiniteElements(resolution=1.0).curve(wheel, u)


def test_lines_that_all_pass_under_the_clamp_are_refused(wheel: Outline) -> None:
    with pytest.raises(InputError, match="support root"):
        FiniteElements(support=Root(), resolution=1.0).curve(wheel, [2.0, 2.01])


def test_coupling_needs_the_whole_gear(wheel: Outline) -> None:
    with pytest.raises(InputError, match="bore"):
        FiniteElements(support=Root(), resolution=1.0).tooth(wheel, [2.6, 2.9])
    with pytest.raises(InputError, match="without 0"):
        FiniteElements(resolution=1.0).tooth(wheel, [2.6, 2.9], (-1, 0, 1))


@pytest.mark.parametrize("resolution", [0.5, 0.0, float("nan")])
def test_a_resolution_too_coarse_is_refused(resolution: float) -> None:
    with pytest.raises((InputError, FloatingPointError)):
        FiniteElements(resolution=resolution)


def test_no_error_estimate_without_a_coarser_mesh(wheel: Outline) -> None:
    with pytest.raises(InputError, match="coarser"):
        FiniteElements(resolution=1.4).error(wheel, [2.5])


def test_more_neighbours_than_the_gear_has_are_refused(wheel: Outline) -> None:
    with pytest.raises(InputError, match="0 to 25"):
        FiniteElements(resolution=1.0).field(wheel, 2.5, 1e5, neighbours=26)


def test_a_bore_outside_the_root_is_refused(gear_factory) -> None:
    outline = Outline(gear=gear_factory(20, 2e-3, 22e-3, bore_radius=18e-3))
    with pytest.raises(InputError, match="bore_radius_mm"):
        FiniteElements().curve(outline, [2.5])


def test_a_folded_mesh_is_named_with_its_remedy() -> None:
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 3), np.linspace(0.0, 1.0, 3))
    # First and second direction exchanged: the elements are traversed the wrong way round.
    patch = np.stack([y, x], axis=-1)
    with pytest.raises(SolveError, match=r"folds over near .* change the bore"):
        refuse_folds(join((patch,)).mesh, QUADRATURE[0], "change the bore")


def test_a_tooth_alone_has_a_field_without_neighbours(wheel: Outline) -> None:
    field = FiniteElements(support=Root(), resolution=1.0).field(wheel, 2.6, 1e5, neighbours=3)
    assert np.abs(np.arctan2(field.nodes[:, 1], field.nodes[:, 0])).max() < np.pi / 51
    assert field.quads.max() == len(field.nodes) - 1


def test_reading_of_the_field_is_the_curve(wheel: Outline) -> None:
    u = 2.6
    curve = FiniteElements(resolution=2.0).curve(wheel, [u])
    field = FiniteElements(resolution=2.0).field(wheel, u, 1e5)
    place = field.load_point + curve.depth[0] * field.load_direction
    axis = np.flatnonzero(np.abs(field.nodes[:, 1]) < 1e-12)
    axis = axis[np.argsort(field.nodes[axis, 0])]
    along = field.displacement[axis] @ field.load_direction
    # Linear interpolation between nodes of the axis, 0.9 mm apart.
    assert np.interp(place[0], field.nodes[axis, 0], along) == pytest.approx(1e5 * curve.deflection[0], rel=2e-3, abs=0.0)


def test_the_stage_holds_both_gears_and_repeats_bit_for_bit(small_pair) -> None:
    flanks = make_flanks(small_pair)
    seen: list[tuple[str, int, int]] = []
    first = make_compliance(flanks, FiniteElements(resolution=1.0), 12, progress=lambda *step: seen.append(step))
    again = make_compliance(flanks, FiniteElements(resolution=1.0), 12)
    assert seen[-1][1:] == (2, 2)
    assert digest(first) == digest(again)
    for tooth, outline in ((first.pinion, flanks.pinion), (first.wheel, flanks.wheel)):
        np.testing.assert_array_equal(tooth.u, load_positions(outline, 12))
        assert tooth.method == "fe_plane_strain"
        assert tooth.support == "bore"
        assert tooth.coupling.shape == (len(tooth.offsets), 12, 12)


def test_load_positions_cover_flank_and_half_of_the_round(wheel: Outline) -> None:
    u = load_positions(wheel, 30)
    assert len(u) == 30
    assert u[0] == 2.0
    assert 3.0 in u
    assert np.all(np.diff(u) > 0.0)
    with pytest.raises(ValueError, match="10 load positions"):
        load_positions(wheel, 9)
