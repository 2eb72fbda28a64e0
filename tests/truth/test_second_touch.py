"""Worn pairs that touch on both sides of a hollow: a half space pressed by two ridges, and the loaded gears of a study."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gearfem.assembly import assemble
from gearfem.compliance.same_tooth import likeness
from gearfem.contact import EdgedLine, Line
from gearfem.definition.setup import Material
from gearfem.engagement.engage import Mesh, engage
from gearfem.engagement.sharing import PairSystem, share_torque
from gearfem.foundation import Array
from gearfem.model import load_model

STEEL = Material()
LAW = EdgedLine(pinion=STEEL, wheel=STEEL)
STUDY = Path(__file__).parents[2] / "studies" / "coal_combine"
DEPTH, RADIUS, APART, RIGID = 4e-3, 20e-3, 1.2e-3, 1e-16


@pytest.fixture(scope="module")
def worn() -> tuple[Mesh, float]:
    system = assemble(load_model(STUDY / "case_1.toml"))
    return system.mesh, system.drive.pinion_torque


def strips(load: float, behind: float, cells: int = 1200) -> tuple[float, float]:
    """Press two parabolas, one lying behind the other, onto half spaces cut into strips; return approach and the first one's share."""
    edges = np.linspace(-0.8e-3, APART + 0.8e-3, cells + 1)
    x, width = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
    gap = np.minimum(x**2 / (2.0 * RADIUS), behind + (x - APART) ** 2 / (2.0 * RADIUS))

    def raised(u: Array) -> Array:
        """The integral of the surface's displacement, less that at the depth below, over a strip."""
        ray = u * np.log(np.hypot(u, DEPTH)) + DEPTH * np.arctan(u / DEPTH) - u * np.log(np.abs(u))
        return ray - DEPTH * np.arctan(u / DEPTH) / (2.0 * (1.0 - STEEL.poissons_ratio))

    ends = (np.arange(-cells, cells) + 0.5) * width
    kernel = np.diff(raised(ends)) * 4.0 / (np.pi * STEEL.plane_strain_modulus)
    influence = kernel[np.abs(np.subtract.outer(np.arange(cells), np.arange(cells))) + cells - 1]
    touching, approach = gap < gap.min() + 4e-6, 0.0
    for _ in range(200):
        inside = np.flatnonzero(touching)
        column = -np.ones((inside.size, 1))
        one = np.block([[influence[np.ix_(inside, inside)], column], [-width * column.T, np.zeros((1, 1))]])
        solved = np.linalg.solve(one, np.append(-gap[inside], load))
        pressure, approach = np.zeros(cells), float(solved[-1])
        pressure[inside] = solved[:-1]
        wrong = (pressure < 0.0) | (~touching & (influence @ pressure + gap < approach))
        if not wrong.any():
            break
        touching ^= wrong
    else:
        raise AssertionError("the strips do not settle")
    return approach, float(pressure[x < 0.5 * APART].sum() * width / load)


@pytest.mark.parametrize(("load", "behind"), [(1e5, 0.3e-6), (3.5e5, 0.0), (3.5e5, 1e-6), (3.5e5, 2.5e-6)])
def test_two_ridges_share_as_half_spaces_in_strips_do(load, behind):
    row = np.ones((1, 2))
    line = Line(RADIUS * row, DEPTH * row, DEPTH * row, row, 1e-4 * row)
    beside = float(LAW.beside(load, APART, Line(*(values[0, 0] for values in line))))
    system = PairSystem(linear=np.array([[[RIGID, beside], [beside, RIGID]]]), lever=row, arm=row, gap=np.array([[0.0, behind]]), line=line)
    shared = share_torque(system, LAW, load)
    approach, share = strips(load, behind)
    # The band's width beside the distance: (a/s)^2/8 of ln, below 1 % of both; the strips' own error is below 0.2 %.
    assert shared.transmission_error[0] == pytest.approx(approach, rel=6e-3, abs=0.0)
    assert shared.force[0, 0] / load == pytest.approx(share, rel=0.0, abs=0.02)
    alone = float(LAW.approach(load, Line(*(values[0, 0] for values in line))))
    assert approach < 0.97 * alone


def test_nothing_yields_more_beside_a_load_than_under_it():
    line = Line(*map(np.array, (0.3, 4e-3, 6e-3, 1.0, 1e-4)))
    under = LAW.compliance(3.5e5, line)
    beside = LAW.beside(3.5e5, np.array([1e-7, 1e-4, 5e-4, 2e-3]), line)
    assert (np.diff(beside) < 0.0).all()
    # The half width is 1.1 mm, a quarter of the depth: terms of (a/d)^2.
    assert beside[0] == pytest.approx(float(under), rel=0.03, abs=0.0)
    assert beside[0] < under * (1.0 + 1e-3)


def test_strips_are_hertz_under_one_ridge():
    approach, share = strips(2e5, 20e-6)
    line = Line(*map(np.array, (RADIUS, DEPTH, DEPTH, 1.0, 1e-4)))
    assert share == pytest.approx(1.0, rel=1e-12, abs=0.0)
    assert approach == pytest.approx(float(LAW.approach(2e5, line)), rel=2e-3, abs=0.0)


def test_a_contact_does_not_jump_over_a_hollow_under_load(worn):
    """The largest steps of the transmission error over 1/4000 pitch, with one contact per pair and with two."""
    mesh, torque = worn
    angle = np.linspace(0.36, 0.38, 81) * mesh.placement.pair.pinion.pitch_angle
    first = mesh.contacts(angle)
    assert np.abs(np.diff(first.u1[:, first.pairs.index(0)])).max() > 0.04
    step = {}
    for name, contacts in {"one": first, "two": mesh.touching(first)}.items():
        error = share_torque(mesh.system(contacts, torque), mesh.law, torque).transmission_error
        step[name] = np.abs(np.diff(error, 2)).max()
    assert step["one"] > 3e-7
    assert step["two"] < 1e-8


@pytest.mark.parametrize("number", [1, 2])
def test_load_leaves_a_hollow_that_closes_by_degrees(number):
    """Steps of the transmission error within 1/4000 pitch, all over the pitch, beside its deflection of 25 um."""
    system = assemble(load_model(STUDY / f"case_{number}.toml"))
    mesh = system.mesh
    angle = np.linspace(0.0, 1.0, 4001) * mesh.placement.pair.pinion.pitch_angle
    first = mesh.contacts(angle)
    one, several = (
        share_torque(mesh.system(contacts, system.drive.pinion_torque), mesh.law, system.drive.pinion_torque).transmission_error
        for contacts in (first, mesh.touching(first))
    )
    assert np.abs(np.diff(one, 2)).max() > 2e-6
    assert np.abs(np.diff(several, 2)).max() < 3e-7


def test_loads_of_both_touches_balance_the_torque(worn):
    mesh, torque = worn
    engagement = engage(mesh, np.linspace(-0.5, 0.5, 101) * mesh.placement.pair.pinion.pitch_angle, torque)
    contacts = engagement.contacts
    assert len(contacts.pairs) > len(set(contacts.pairs))
    assert (engagement.force * contacts.arm1).sum(axis=1) == pytest.approx(torque, rel=1e-10, abs=0.0)
    twice = (engagement.force > 0.0).sum(axis=1) > engagement.pairs_in_contact
    assert 0.02 < twice.mean() < 0.5
    assert contacts.first.pairs == tuple(sorted(set(contacts.pairs)))
    # Second touches lie behind the first ones, and no nearer than a twentieth of a module.
    for column, pair in enumerate(contacts.pairs[len(contacts.first.pairs) :], start=len(contacts.first.pairs)):
        one, both = contacts.pairs.index(pair), contacts.reach[:, column]
        assert (contacts.gap[both, column] >= contacts.gap[both, one]).all()
        assert np.hypot(*(contacts.point[both, column] - contacts.point[both, one]).T).min() >= 0.05 * mesh.placement.pair.pinion.module


def test_any_tooth_may_come_first(worn):
    mesh, torque = worn
    angle = np.linspace(0.3, 0.8, 26) * mesh.placement.pair.pinion.pitch_angle
    here, later = (engage(mesh, angle + shift * mesh.placement.pair.pinion.pitch_angle, torque) for shift in (0, 5))
    assert later.transmission_error == pytest.approx(here.transmission_error, rel=0.0, abs=1e-14)
    assert later.gear_ratio_force == pytest.approx(here.gear_ratio_force, rel=1e-9, abs=0.0)
    assert (later.pairs_in_contact == here.pairs_in_contact).all()


def test_a_tooth_yields_alike_at_one_place(coal_combine):
    tooth = assemble(coal_combine).compliance.pinion
    table = likeness(tooth)
    assert np.diag(table) == pytest.approx(1.0, rel=1e-12, abs=0.0)
    assert np.array_equal(table, table.T)
    flank = tooth.u <= 3.0
    near = (np.abs(np.subtract.outer(tooth.radius, tooth.radius)) < 2e-3) & flank & flank[:, None]
    assert 0.9 < table[near].min() < 1.0


def test_unworn_teeth_touch_once(coal_combine):
    mesh = assemble(coal_combine).mesh
    contacts = mesh.contacts(np.linspace(-0.5, 0.5, 11) * mesh.placement.pair.pinion.pitch_angle)
    assert mesh.touching(contacts) is contacts
