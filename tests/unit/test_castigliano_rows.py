"""Which rows Castigliano's curve keeps, where its bases lie, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.compliance.castigliano import Castigliano, FilletMiddle, FormCircle, RootEnd
from gearfem.flank import Outline
from gearfem.foundation import InputError, digest


@pytest.fixture(scope="module")
def outline(coal_combine):
    return Outline(gear=coal_combine.pair.wheel)


@pytest.mark.parametrize("base", [FilletMiddle(), RootEnd(), FormCircle()])
def test_rows_whose_load_line_crosses_below_the_base_are_dropped(outline, base):
    u = np.linspace(2.0, 4.0, 81)
    curve = Castigliano(base=base).curve(outline, u)
    points, normals = outline.point(u), outline.normal(u)
    bottom = outline.point(base.parameter(outline))[0]
    with np.errstate(divide="ignore"):
        crossing = points[:, 0] - points[:, 1] * normals[:, 0] / normals[:, 1]
    np.testing.assert_array_equal(curve.u, u[crossing > bottom])
    assert 0 < len(curve.u) < len(u)


def test_load_point_at_the_base_leaves_no_trapezoid(gear_factory):
    """On an undercut tooth the first normal of the flank leans to the tip, so that it crosses above the form circle."""
    undercut = Outline(gear=gear_factory(10, 1e-3, 6e-3))
    assert undercut.normal(2.0)[0] < 0.0
    assert Castigliano(base=FormCircle()).curve(undercut, [2.0, 2.5]).u.tolist() == [2.5]


def test_bases_lie_where_they_say(outline):
    height = {type(base).__name__: outline.point(base.parameter(outline))[0] for base in (FilletMiddle(), RootEnd(), FormCircle())}
    low, high = outline.point([1.0, 2.0])[:, 0]
    assert height["RootEnd"] == low
    assert height["FormCircle"] == high
    assert height["FilletMiddle"] == pytest.approx(0.5 * (low + high), rel=1e-15, abs=0.0)


@pytest.mark.parametrize("u", [[1.9, 2.5], [2.5, 4.1], [2.5, 2.5], [2.5, float("nan")], 2.5])
def test_positions_off_the_flank_are_refused(outline, u):
    with pytest.raises(InputError, match="increasing row of positions"):
        Castigliano().curve(outline, u)


def test_no_positions_give_no_rows(outline):
    assert len(Castigliano().curve(outline, []).deflection) == 0


def test_the_convention_of_the_base_is_part_of_the_content():
    assert digest(Castigliano()) == digest(Castigliano(base=FilletMiddle()))
    assert digest(Castigliano()) != digest(Castigliano(base=RootEnd()))
