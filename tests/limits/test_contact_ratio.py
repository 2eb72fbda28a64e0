"""Engagement from hardly more than one pair to four at a time: racks of low and of tall teeth."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import gearfem
from gearfem.engagement.engage import Mesh, engage
from gearfem.engagement.sharing import share_torque
from gearfem.foundation import Array
from gearfem.foundation.units import DEG

# Contact ratio, teeth, addendum, dedendum and tip radius of the rack [modules], pressure angle, and pairs that carry under load.
PAIRS = {
    1.106: (20, 24, 0.66, 0.91, 0.3, 20.0 * DEG, {1, 2}),
    2.039: (40, 50, 1.2, 1.45, 0.2, 20.0 * DEG, {2, 3}),
    2.542: (50, 60, 1.5, 1.75, 0.15, 20.0 * DEG, {2, 3}),
    3.040: (70, 80, 1.45, 1.7, 0.12, 15.0 * DEG, {3, 4}),
}
TORQUE = 100.0


class LinearLaw:
    """A contact that yields in proportion to its load."""

    def approach(self, force: Array, *_: object) -> Array:
        return 3e-12 * force

    def respond(self, force: Array, *_: object) -> tuple[Array, Array]:
        return self.approach(force), np.full_like(force, 3e-12)


@pytest.fixture(scope="module", params=PAIRS)
def case(request) -> tuple[float, Mesh, set[int]]:
    teeth1, teeth2, addendum, dedendum, tip_radius, pressure_angle, carrying = PAIRS[request.param]
    setup = gearfem.make_setup(
        {
            "pair": {"module_mm": 2.0, "face_width_mm": 20.0, "pressure_angle_deg": pressure_angle / DEG},
            "rack": {"addendum": addendum, "dedendum": dedendum, "tip_radius": tip_radius},
            "pinion": {"teeth": teeth1},
            "wheel": {"teeth": teeth2},
            "operation": {"pinion_torque_Nm": TORQUE, "pinion_speed_rpm": 1000.0},
        }
    )
    assert setup.pair.contact_ratio == pytest.approx(request.param, abs=1e-3)
    return request.param, gearfem.run(setup, until="compliance").mesh, carrying


def pitch(mesh: Mesh, steps: int) -> Array:
    return np.arange(steps + 1) / steps * mesh.placement.pair.pinion.pitch_angle


def test_pairs_share_the_load(case) -> None:
    ratio, mesh, carrying = case
    loaded = engage(mesh, pitch(mesh, 200), TORQUE)
    count = (loaded.force > 0.0).sum(axis=1)
    print(f"contact ratio {ratio}: {count.mean():.3f} pairs in the mean under load, largest share {loaded.load_share.max():.3f}")
    assert set(count) == carrying
    assert loaded.load_share.sum(axis=1) == pytest.approx(1.0, rel=1e-12, abs=0.0)
    assert (loaded.force * loaded.contacts.arm1).sum(axis=1) == pytest.approx(TORQUE, rel=1e-11, abs=0.0)
    # Bent teeth touch early and part late, so that load widens the engagement; the least pairs decide the largest share.
    assert ratio - 0.01 < count.mean() < ratio + 0.35
    assert 1.0 / max(carrying) < loaded.load_share.max() < 1.3 / min(carrying)


def test_error_is_continuous(case) -> None:
    """Steps halve with the angle's step; a jump would keep its size."""
    _, mesh, _ = case
    steps = [np.abs(np.diff(engage(mesh, pitch(mesh, count), TORQUE).transmission_error)).max() for count in (400, 800)]
    assert steps[1] < 0.65 * steps[0]


def test_error_grows_with_torque(case) -> None:
    _, mesh, _ = case
    errors = np.array([engage(mesh, pitch(mesh, 60), TORQUE * part).transmission_error for part in (1e-3, 0.1, 0.5, 1.0, 2.0)])
    assert (np.diff(errors, axis=0) > 0.0).all()
    assert errors[0].max() < 3e-3 * errors[3].max()


def test_stiffness_is_the_slope_of_force(case) -> None:
    _, mesh, _ = case
    angle, step = pitch(mesh, 60), 1e-4
    after, before = (engage(mesh, angle, TORQUE * (1.0 + sign * step)).transmission_error for sign in (1, -1))
    slope = 2.0 * step * TORQUE / mesh.placement.pair.pinion.base_radius / (after - before)
    # Where a pair enters within the step the difference is a mean of two slopes.
    assert np.mean(np.abs(slope / engage(mesh, angle, TORQUE).mesh_stiffness - 1.0) < 1e-5) > 0.96


def test_large_torque_tends_to_all_pairs_in_contact(case) -> None:
    """With linear contact the slope becomes that of all pairs in reach at once, 1/(arm K lever)."""
    _, mesh, carrying = case
    angle = pitch(mesh, 12)
    contacts = mesh.contacts(angle)
    system, law = mesh.system(contacts), LinearLaw()
    # Pairs out of reach stay so: no finite load brings them into contact.
    system = dataclasses.replace(system, gap=np.where(contacts.reach, system.gap, 1e9))
    shared = share_torque(system, law, 1e7)
    assert ((shared.force > 0.0) == contacts.reach).all()
    assert contacts.reach.sum(axis=1).max() >= max(carrying)
    for row, inside in enumerate(contacts.reach):
        flexible = system.linear[row][np.ix_(inside, inside)] + 3e-12 * np.eye(inside.sum())
        stiffness = system.arm[row, inside] @ np.linalg.solve(flexible, system.lever[row, inside])
        assert shared.slope[row] == pytest.approx(1.0 / stiffness, rel=1e-9, abs=0.0)
    # The secant follows as 1/torque: ten times nearer with ten times the load.
    secants = [share_torque(system, law, torque).transmission_error / torque / shared.slope - 1.0 for torque in (1e7, 1e8)]
    assert secants[1] == pytest.approx(0.1 * secants[0], rel=1e-6, abs=1e-9)


def test_half_the_compliance_halves_the_error_of_linear_contact(case) -> None:
    """A frame for the whole chain: compliance and gaps scaled together scale the error, and leave the shares."""
    _, mesh, _ = case
    system = mesh.system(mesh.contacts(pitch(mesh, 30)))

    class Half(LinearLaw):
        def approach(self, force: Array, *_: object) -> Array:
            return 1.5e-12 * force

        def respond(self, force: Array, *_: object) -> tuple[Array, Array]:
            return self.approach(force), np.full_like(force, 1.5e-12)

    whole = share_torque(system, LinearLaw(), TORQUE)
    half = share_torque(dataclasses.replace(system, linear=0.5 * system.linear, gap=0.5 * system.gap), Half(), TORQUE)
    assert half.transmission_error == pytest.approx(0.5 * whole.transmission_error, rel=1e-10, abs=0.0)
    assert half.force == pytest.approx(whole.force, rel=1e-9, abs=1e-9 * whole.force.max())
