"""The engagement over many turns: it is `engage` where teeth are equal, and hand calculation where they are not."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem.compliance import make_compliance
from gearfem.contact import EdgedLine
from gearfem.effects.lead_misalignment import LeadMisalignment
from gearfem.engagement import Mesh, engage
from gearfem.engagement.grid import COARSE, levels
from gearfem.engagement.pair_table import pair_table
from gearfem.engagement.turns import Turns, static
from gearfem.flank import make_flanks
from gearfem.flank.deviation import Deviation
from gearfem.foundation import InputError
from gearfem.placement import make_placement


@pytest.fixture(scope="module", params=["coal_combine", "small_pair"])
def case(request) -> tuple[Mesh, float]:
    setup = request.getfixturevalue(request.param)
    flanks, pair = make_flanks(setup), setup.pair
    law = EdgedLine(pinion=pair.pinion.material, wheel=pair.wheel.material)
    mesh = Mesh(flanks=flanks, placement=make_placement(setup), compliance=make_compliance(flanks), law=law)
    return mesh, setup.operation.pinion_torque


@pytest.fixture(scope="module")
def mesh(case) -> Mesh:
    return case[0]


@pytest.fixture(scope="module")
def torque(case) -> float:
    return case[1]


def placed(mesh: Mesh, **changes: object) -> Turns:
    return Turns(mesh=dataclasses.replace(mesh, placement=dataclasses.replace(mesh.placement, **changes)))


def pitch_of(mesh: Mesh) -> float:
    return mesh.placement.pair.pinion.pitch_angle


def single(mesh: Mesh) -> float:
    """Return an angle [rad] at which pair 0 carries alone, off the pitch point."""
    return 0.02 * pitch_of(mesh)


@pytest.mark.parametrize("part", [0.1, 1.0, 3.0])
def test_equal_teeth_at_random_angles_are_engage(mesh, torque, part) -> None:
    """Measured: at most 6e-6 of the mean, 0.01 pitches off the ends of the path, where the band meets the edge; 3e-7 rms."""
    angle = np.random.default_rng(3).uniform(-4.0, 4.0, 400) * pitch_of(mesh)
    slow, exact = static(Turns(mesh=mesh), angle, part * torque), engage(mesh, angle, part * torque)
    miss = (slow.transmission_error - exact.transmission_error) / exact.transmission_error.mean()
    assert np.abs(miss).max() < 1e-5
    assert np.sqrt((miss**2).mean()) < 5e-7
    assert slow.mesh_stiffness == pytest.approx(exact.mesh_stiffness, rel=5e-4, abs=0.0)
    assert slow.force.sum(axis=1) == pytest.approx(exact.force.sum(axis=1), rel=1e-5, abs=0.0)


def deviating(turns: Turns, angle: np.ndarray, torque: float) -> np.ndarray:
    """Return by how much the tables miss `engage`, over the mean deflection."""
    exact = engage(turns.mesh, angle, torque)
    deflection = float(np.mean(exact.transmission_error - exact.contacts.gap.min(axis=1)))
    return (static(turns, angle, torque).transmission_error - exact.transmission_error) / deflection


def test_late_and_eccentric_teeth_are_those_of_engage(mesh, torque) -> None:
    """Measured: 1e-5; the coupling is read at the place of an even tooth."""
    rng = np.random.default_rng(8)
    teeth = Turns(mesh=mesh).teeth
    late1, late2 = rng.normal(0.0, 2e-6, teeth[0]), rng.normal(0.0, 2e-6, teeth[1])
    turns = placed(mesh, pinion_late=late1, wheel_late=late2, pinion_runout=(8e-6, -3e-6), wheel_runout=(-5e-6, 9e-6))
    angle = rng.uniform(0.0, 3.0, 150) * pitch_of(mesh)
    assert np.abs(deviating(turns, angle, torque)).max() < 5e-5


def uneven(mesh: Mesh) -> Mesh:
    """Return a mesh with a hollow on one tooth of the pinion, and a soft one."""
    outline, softer = mesh.flanks.pinion, dataclasses.replace(mesh.compliance.pinion, deflection=1.4 * mesh.compliance.pinion.deflection)
    none = Deviation.none(outline.gear)
    end, wide = none.roll[-1], 0.6 * outline.gear.module
    hollow = none.plus(lambda roll: 4e-6 * np.where(np.abs(roll - 0.6 * end) < wide, 1.0 + np.cos(np.pi * (roll - 0.6 * end) / wide), 0.0))
    flanks = dataclasses.replace(mesh.flanks, pinion_odd=((2, dataclasses.replace(outline, deviation=hollow)),))
    compliance = dataclasses.replace(mesh.compliance, pinion_odd=((4, softer),))
    return dataclasses.replace(mesh, flanks=flanks, compliance=compliance)


def test_odd_teeth_are_those_of_engage(mesh, torque) -> None:
    """Measured: 1e-5 and 1e-4, where the curvature of the hollow changes within a cell."""
    angle = np.random.default_rng(9).uniform(1.0, 5.0, 150) * pitch_of(mesh)
    miss = deviating(Turns(mesh=uneven(mesh)), angle, torque)
    assert np.abs(miss).max() < 5e-4
    assert np.sqrt((miss**2).mean()) < 5e-5


@pytest.mark.parametrize(("kind", "rms", "most"), [("even", 3e-5, 4e-4), ("misaligned", 3e-5, 4e-4), ("uneven", 2e-3, 4e-2)])
@pytest.mark.parametrize("part", [0.05, 1.0, 3.0])
def test_coarse_tables_miss_what_the_grid_says(mesh, torque, kind, rms, most, part) -> None:
    """Measured: 1e-5 and 2e-4 of the deviation; with a hollow 1e-3 and 2e-2."""
    flanks = LeadMisalignment(slope=5e-6).act(mesh.flanks, None)
    own = {"even": mesh, "misaligned": dataclasses.replace(mesh, flanks=flanks), "uneven": uneven(mesh)}[kind]
    angle = np.random.default_rng(10).uniform(0.0, 5.0, 600) * pitch_of(mesh)
    fine, coarse = (
        static(Turns(mesh=one), angle, part * torque).transmission_error for one in (own, dataclasses.replace(own, grid=COARSE))
    )
    assert np.sqrt(((coarse - fine) ** 2).mean()) < rms * fine.std()
    assert np.abs(coarse - fine).max() < most * fine.std()


def test_order_and_turns_do_not_matter(mesh, torque) -> None:
    angle = np.random.default_rng(4).uniform(0.0, 1.0, 50) * pitch_of(mesh)
    here = static(Turns(mesh=mesh), angle, torque).transmission_error
    later = static(Turns(mesh=mesh), angle[::-1] + 7.0 * math.tau, torque).transmission_error[::-1]
    # Rounding of 100 pitches over the slope of the transmission error, 0.1 r_b1.
    assert later == pytest.approx(here, rel=1e-9, abs=0.0)


def test_law_of_the_table_is_the_law(mesh) -> None:
    """At angles and approaches between knots and levels; measured: 2e-5 where the band just meets an edge, 2e-6 for 99 of 100."""
    table, pitch = pair_table(mesh, 0), pitch_of(mesh)
    at = np.random.default_rng(5).uniform(table.kinks[0], table.kinks[-1], 100)
    system = mesh.system(mesh.contacts(at * pitch))
    column = mesh.contacts(at * pitch).pairs.index(0)
    steps = levels(mesh.placement.pair.pinion.module)
    misses = []
    for row, x in enumerate(at):
        cell = int(np.searchsorted(table.knots, x, side="right") - 1)
        value = np.moveaxis(table.law[cell], -1, 0)
        d = x - table.knots[cell]
        nodes = ((value[0] * d + value[1]) * d + value[2]) * d + value[3]
        line = type(system.line)(*(part[row, column] for part in system.line))
        for level in range(15, steps.size - 4, 6):
            h = steps[level + 1] - steps[level]
            secant = 0.5 * (nodes[level, 0] + nodes[level + 1, 0]) + h / 8.0 * (nodes[level, 1] - nodes[level + 1, 1])
            approach = math.exp(0.5 * (steps[level] + steps[level + 1]))
            load = approach * secant
            exact = system.linear[row, column, column] * load + float(mesh.law.approach(load, line))
            misses.append(abs(exact / approach - 1.0))
    assert max(misses) < 3e-5
    assert np.quantile(misses, 0.98) < 5e-6


def test_weights_are_the_derivatives(mesh, torque) -> None:
    """Those of the pinion leave out what a tooth that stands behind changes in stiffness: 3e-4."""
    angle = np.random.default_rng(6).uniform(0.0, 3.0, 12) * pitch_of(mesh)
    slow = static(Turns(mesh=mesh), angle, torque)
    one, two = slow.by_index_errors("pinion"), slow.by_index_errors("wheel")
    small = 1e-10
    for tooth in (0, 1, 2, 3):
        ahead, behind = (
            static(placed(mesh, pinion_late=sign * small * np.eye(slow.teeth[0])[tooth]), angle, torque).transmission_error
            for sign in (1, -1)
        )
        assert (ahead - behind) / (2.0 * small) == pytest.approx(one[:, tooth], abs=1e-3)
        ahead, behind = (
            static(placed(mesh, wheel_late=sign * small * np.eye(slow.teeth[1])[tooth]), angle, torque).transmission_error
            for sign in (1, -1)
        )
        assert (ahead - behind) / (2.0 * small) == pytest.approx(two[:, tooth], abs=2e-4)
    # A lag of all wheel teeth is a lag of the wheel.
    assert two.sum(axis=1) == pytest.approx(1.0, rel=1e-9, abs=0.0)


def test_slope_is_the_derivative(mesh, torque) -> None:
    angle = np.random.default_rng(7).uniform(0.0, 1.0, 12) * pitch_of(mesh)
    turns, small = Turns(mesh=mesh), 1e-4 * torque
    ahead, behind = (static(turns, angle, torque + sign * small, 0.1).transmission_error for sign in (1, -1))
    assert (ahead - behind) / (2.0 * small) == pytest.approx(static(turns, angle, torque, 0.1).slope, rel=1e-4, abs=0.0)


def test_late_tooth_lags_by_its_index_error_where_it_carries_alone(mesh, torque) -> None:
    """Positive late, positive transmission error, once a turn of its own gear, and nowhere else."""
    if mesh.placement.pair.contact_ratio > 1.2:
        pytest.skip("needs a long zone of one pair")
    late = np.zeros(51)
    late[7] = 3e-6
    angle = single(mesh) + np.arange(0, 120) * pitch_of(mesh)
    change = (
        static(placed(mesh, wheel_late=late), angle, torque).transmission_error - static(Turns(mesh=mesh), angle, torque).transmission_error
    )
    expected = np.where(np.arange(120) % 51 == 7, 3e-6, 0.0)
    assert change == pytest.approx(expected, abs=1e-14)


def test_late_tooth_and_its_mate_count_together(mesh, torque) -> None:
    teeth = Turns(mesh=mesh).teeth
    one, two = np.full(teeth[0], 2e-6), np.full(teeth[1], 1e-6)
    angle = np.linspace(-0.3, 0.3, 7) * pitch_of(mesh)
    change = static(placed(mesh, pinion_late=one, wheel_late=two), angle, torque).transmission_error
    change = change - static(Turns(mesh=mesh), angle, torque).transmission_error
    # A late pinion tooth also stands behind on its way, which turns the normal of a corner contact.
    assert change == pytest.approx(3e-6, rel=0.02, abs=0.0)


def test_runout_is_the_offset_along_the_line_of_action(mesh, torque) -> None:
    """By hand: at angle 0 the middle of pinion tooth 0 lies `pinion_start` from the line of centres."""
    placement, size = mesh.placement, 4e-6
    pressed = math.pi / 2.0 - placement.working_pressure_angle
    base = float(static(Turns(mesh=mesh), 0.0, torque).transmission_error[0])

    def change(**runout: tuple[float, float]) -> float:
        return float(static(placed(mesh, **runout), 0.0, torque).transmission_error[0]) - base

    # The centre moved towards its mate along the line of action: early contact, the wheel leads.
    towards1 = (math.cos(pressed - placement.pinion_start), -math.sin(pressed - placement.pinion_start))
    assert change(pinion_runout=(size * towards1[0], size * towards1[1])) == pytest.approx(-size, rel=1e-9, abs=0.0)
    across = (-towards1[1], towards1[0])
    assert change(pinion_runout=(size * across[0], size * across[1])) == pytest.approx(0.0, abs=1e-15)
    # The wheel's own normal points back at the pinion: from O2, the direction (-cos, -sin) of `pressed` in the fixed frame.
    tooth = np.array([-math.cos(placement.wheel_start), math.sin(placement.wheel_start)])
    counted = np.array([-math.sin(placement.wheel_start), -math.cos(placement.wheel_start)])
    back = -np.array([math.cos(pressed), math.sin(pressed)])
    assert change(wheel_runout=(size * float(back @ tooth), size * float(back @ counted))) == pytest.approx(-size, rel=1e-9, abs=0.0)


def test_runout_comes_once_a_turn(mesh, torque) -> None:
    teeth = Turns(mesh=mesh).teeth
    angle = 0.1 * pitch_of(mesh) + np.arange(teeth[0]) * pitch_of(mesh)
    wave = static(placed(mesh, pinion_runout=(3e-6, 4e-6)), angle, torque).transmission_error
    wave = wave - static(Turns(mesh=mesh), angle, torque).transmission_error
    spectrum = 2.0 * np.abs(np.fft.rfft(wave)) / wave.size
    assert spectrum[1] == pytest.approx(5e-6, rel=1e-9, abs=0.0)
    assert np.delete(spectrum, 1).max() < 1e-14


def test_supports_yield_in_series(mesh, torque) -> None:
    angle = np.linspace(0.0, 1.0, 9) * pitch_of(mesh)
    stiff, soft = static(Turns(mesh=mesh), angle, torque), static(placed(mesh, series=2e-9), angle, torque)
    added = soft.transmission_error - stiff.transmission_error
    # Corner contacts, a small part of the load, are turned out of the line of action.
    assert added == pytest.approx(2e-9 * torque / mesh.placement.pair.pinion.base_radius, rel=5e-3, abs=0.0)
    assert np.abs(deviating(placed(mesh, series=2e-9), angle, torque)).max() < 1e-5


def test_friction_steps_at_the_pitch_point(mesh, torque) -> None:
    """One pair, F (l1 + f s h1) = T: the load steps by the stated arms between approach and recess, at angle 0 itself."""
    if mesh.placement.pair.contact_ratio > 1.2:
        pytest.skip("needs one pair in contact at the pitch point")
    pair = mesh.placement.pair
    height = pair.pinion.base_radius * math.tan(mesh.placement.working_pressure_angle)
    tiny = 1e-9
    force = static(Turns(mesh=mesh), np.array([-tiny, tiny]), torque, 0.1).force.sum(axis=1)
    expected = [torque / (pair.pinion.base_radius + sign * 0.1 * height) for sign in (-1.0, 1.0)]
    assert force == pytest.approx(expected, rel=1e-7, abs=0.0)


def test_torque_may_differ_at_every_angle(mesh, torque) -> None:
    angle = np.linspace(0.0, 2.0, 11) * pitch_of(mesh)
    ripple = torque * (1.0 + 0.3 * np.cos(3.0 * angle))
    together = static(Turns(mesh=mesh), angle, ripple).transmission_error
    alone = [float(static(Turns(mesh=mesh), one, load).transmission_error[0]) for one, load in zip(angle, ripple, strict=True)]
    assert together == pytest.approx(alone, rel=1e-12, abs=0.0)


def test_one_odd_tooth_asks_for_two_tables(mesh, torque) -> None:
    softer = dataclasses.replace(mesh.compliance.pinion, deflection=1.5 * mesh.compliance.pinion.deflection)
    turns = Turns(mesh=dataclasses.replace(mesh, compliance=dataclasses.replace(mesh.compliance, pinion_odd=((3, softer),))))
    angle = np.linspace(0.0, math.tau, 200)
    assert turns.stack(angle / pitch_of(mesh)).knots.shape[0] == 2
    assert Turns(mesh=mesh).stack(angle / pitch_of(mesh)).knots.shape[0] == 1


def test_impossible_torques_are_refused(mesh, torque) -> None:
    with pytest.raises(InputError, match="positive torque"):
        static(Turns(mesh=mesh), [0.0, 0.1], [1.0, 0.0])
    with pytest.raises(InputError, match="twentieth of the module"):
        static(Turns(mesh=mesh), 0.0, 1e3 * torque)
    with pytest.raises(InputError, match="one value per tooth"):
        placed(mesh, pinion_late=np.zeros(3))
