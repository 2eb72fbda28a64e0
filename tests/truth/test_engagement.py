"""The loaded engagement: identities that hold whatever the compliance is."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.definition.setup import Setup
from gearfem.engagement.engage import Mesh, engage, mesh_force, standard_angles
from gearfem.foundation import InputError
from gearfem.pipeline import run


@pytest.fixture(scope="module", params=["coal_combine", "small_pair"])
def setup(request) -> Setup:
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="module")
def mesh(setup) -> Mesh:
    return run(setup, until="compliance").mesh


@pytest.fixture(scope="module")
def engagement(setup, mesh):
    return engage(mesh, standard_angles(mesh.placement), setup.operation.pinion_torque)


def test_torques_are_in_the_ratio_of_the_teeth_on_the_path(setup, engagement) -> None:
    """In single and in double contact: every loaded pair on the path has the arms r_b1 and r_b2."""
    contacts = engagement.contacts
    loaded = engagement.force > 0.0
    on_path = np.all(~loaded | (contacts.gap == 0.0), axis=1)
    double = on_path & (loaded.sum(axis=1) == 2)
    assert double.any()
    assert (on_path & ~double).any()
    assert engagement.gear_ratio_force[on_path] == pytest.approx(setup.pair.ratio, rel=1e-12, abs=0.0)


def test_forces_balance_the_torque(setup, engagement) -> None:
    moment = (engagement.force * engagement.contacts.arm1).sum(axis=1)
    assert moment == pytest.approx(setup.operation.pinion_torque, rel=1e-11, abs=0.0)
    assert engagement.load_share.sum(axis=1) == pytest.approx(1.0, rel=1e-12, abs=0.0)


def test_everything_repeats_after_a_pitch(engagement) -> None:
    half = len(engagement.transmission_error) // 2
    for name in ("transmission_error", "mesh_stiffness", "gear_ratio", "gear_ratio_force"):
        values = getattr(engagement, name)
        # The ratio is a difference of errors over 2e-4 pitches, so that their rounding grows by 1e4.
        assert values[: half + 1] == pytest.approx(values[half:], rel=1e-8, abs=0.0), name


def test_any_angle_can_be_asked(setup, mesh) -> None:
    """Angles many pitches away repeat those near 0, with the numbers of their own pairs."""
    pitch, torque = setup.pair.pinion.pitch_angle, setup.operation.pinion_torque
    near = engage(mesh, np.array([0.1, 0.4, 0.6]) * pitch, torque)
    far = engage(mesh, np.array([7.1, 7.4, 7.6]) * pitch, torque)
    assert far.transmission_error == pytest.approx(near.transmission_error, rel=1e-9, abs=0.0)
    number = far.contacts.pairs.index(7)
    assert far.load_share[:, number] == pytest.approx(near.load_share[:, near.contacts.pairs.index(0)], rel=1e-8, abs=0.0)


def test_energy_is_conserved_over_a_pitch(setup, mesh) -> None:
    """The wheel's work is the pinion's: the mean of sum P l2/sum P l1 over phi2 is z2/z1, whatever the teeth store."""
    pitch = setup.pair.pinion.pitch_angle
    count = 6400
    angle = (np.arange(count) + 0.5) / count * pitch
    loaded = engage(mesh, angle, setup.operation.pinion_torque)
    wheel_angle = angle / setup.pair.ratio - loaded.transmission_error / setup.pair.wheel.base_radius
    advance = np.diff(wheel_angle, append=wheel_angle[0] + pitch / setup.pair.ratio)
    middle = (loaded.gear_ratio_force + np.roll(loaded.gear_ratio_force, -1)) / 2.0
    mean = (middle * advance).sum() / (pitch / setup.pair.ratio)
    # The contact points that enter the compliance are those of the rigid gears: the work they
    # neglect is the deflection over the module, 1e-3, times the share of the corners, a twentieth.
    assert mean == pytest.approx(setup.pair.ratio, rel=5e-5, abs=0.0)


def test_stiffness_is_the_slope_of_force(setup, mesh, engagement) -> None:
    torque, step = setup.operation.pinion_torque, 1e-4
    angle = engagement.contacts.pinion_angle
    after, before = (engage(mesh, angle, torque * (1.0 + sign * step)).transmission_error for sign in (1, -1))
    slope = 2.0 * step * torque / setup.pair.pinion.base_radius / (after - before)
    # Where a pair enters within the step the difference is a mean of two slopes; elsewhere it errs by its square.
    assert np.mean(np.abs(slope / engagement.mesh_stiffness - 1.0) < 1e-5) > 0.98
    assert (engagement.secant_stiffness < engagement.mesh_stiffness * 1.0001).mean() > 0.5


def test_small_torque_tends_to_the_unloaded_teeth(setup, mesh) -> None:
    angle = standard_angles(mesh.placement, 40)
    lag = [engage(mesh, angle, torque).transmission_error.max() for torque in (1.0, 1e-3)]
    assert lag[1] < 2e-3 * lag[0]
    assert engage(mesh, angle, 1e-3).gear_ratio == pytest.approx(setup.pair.ratio, rel=1e-6, abs=0.0)


def test_error_grows_with_torque_at_every_angle(setup, mesh) -> None:
    angle = standard_angles(mesh.placement, 100)
    torques = setup.operation.pinion_torque * np.array([0.01, 0.1, 1.0, 4.0])
    errors = np.array([engage(mesh, angle, torque).transmission_error for torque in torques])
    assert (np.diff(errors, axis=0) > 0.0).all()


@pytest.mark.parametrize("torque", [0.0, -5.0, 1e6])
def test_loads_outside_the_theory_are_refused(mesh, torque) -> None:
    """Without load nothing holds the flanks together; far above it small displacements end."""
    with pytest.raises(InputError, match=r"operation\.pinion_torque_Nm"):
        engage(mesh, standard_angles(mesh.placement, 20), torque)


def test_force_table_returns_the_operating_point(setup, mesh) -> None:
    torque = setup.operation.pinion_torque
    table = mesh_force(mesh, torque, steps=60, levels=200)
    loaded = engage(mesh, table.pinion_angle, torque)
    moment = [np.interp(error, table.deflection, row) for error, row in zip(loaded.transmission_error, table.pinion_moment, strict=True)]
    # Linear interpolation between 200 levels of a force that bends little: (1/200)^2 / 8 times a few.
    assert np.array(moment) == pytest.approx(torque, rel=5e-4, abs=0.0)
    assert (table.normal_force[:, 0] == 0.0).all()


def test_pressure_is_that_of_hertz_in_single_contact(setup, mesh, engagement) -> None:
    """One pair on the path, its band clear of the edges: p0 = sqrt(F E*/(pi R b)), 1/E* = 2 (1 - nu^2)/E for one steel."""
    contacts, steel = engagement.contacts, setup.pair.pinion.material
    modulus = steel.youngs_modulus / (2.0 * (1.0 - steel.poissons_ratio**2))
    alone = (engagement.force > 0.0) & ((engagement.force > 0.0).sum(axis=1) == 1)[:, None] & (contacts.gap == 0.0)
    clear = alone & (contacts.edge > 0.02 * setup.pair.pinion.module * 2.0)
    assert clear.any()
    load = setup.operation.pinion_torque / setup.pair.pinion.base_radius / setup.pair.face_width
    expected = np.sqrt(load * modulus / (np.pi * contacts.flank_radius[clear]))
    assert engagement.contact_pressure[clear] == pytest.approx(expected, rel=1e-9, abs=0.0)
    assert ((engagement.contact_pressure > 0.0) == (engagement.force > 0.0)).all()


def test_pressure_rises_at_a_tip_edge(engagement) -> None:
    """On a round a hundred times sharper than the flanks the same load presses far harder than between flanks."""
    contacts = engagement.contacts
    corner = (engagement.force > 0.0) & (contacts.edge < 0.0)
    assert corner.any()
    per_load = engagement.contact_pressure**2 / np.where(engagement.force > 0.0, engagement.force, 1.0)
    assert per_load[corner].min() > 5.0 * np.median(per_load[(engagement.force > 0.0) & (contacts.gap == 0.0)])
