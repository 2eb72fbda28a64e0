"""Loads along the face width: without a lead nothing changes, large leads leave part of the width, loads close them again."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.optimize import brentq

from gearfem.assembly import assemble
from gearfem.compliance import Root, SolidElements
from gearfem.contact import Line
from gearfem.effects.profile_wear import ProfileWear
from gearfem.effects.tip_relief import TipRelief
from gearfem.engagement import width
from gearfem.engagement.engage import Mesh, engage, mesh_force
from gearfem.engagement.sharing import PairSystem, share_torque
from gearfem.engagement.width import FaceSlices, path_positions, sliced_pair
from gearfem.engagement.width_load import load_over_width
from gearfem.flank.lead import Lead
from gearfem.foundation import InputError, digest
from gearfem.pipeline import run

TORQUE = 50.0
# Teeth held at their roots: the same statements as of whole gears, in a twentieth of the time.
SLICES = FaceSlices(count=8, method=SolidElements(support=Root(), resolution=0.5, layers=4))
TILT, CROWN = (lambda place: place + 0.5), (lambda place: 4.0 * place**2)


@pytest.fixture(scope="module")
def mesh(small_pair) -> Mesh:
    return dataclasses.replace(run(small_pair, until="compliance").mesh, slices=SLICES)


@pytest.fixture(scope="module")
def angle(mesh) -> np.ndarray:
    return np.linspace(-0.5, 0.5, 41) * mesh.placement.pair.pinion.pitch_angle


def with_lead(mesh: Mesh, gap) -> Mesh:
    return dataclasses.replace(mesh, flanks=dataclasses.replace(mesh.flanks, lead=Lead().plus(gap)))


def test_parallel_flanks_stay_as_they_are_and_cost_no_solids(mesh, angle, monkeypatch) -> None:
    monkeypatch.setattr(width, "_influence", lambda *_: pytest.fail("solid elements for parallel flanks"))
    coarse = dataclasses.replace(mesh, slices=FaceSlices(count=4))
    assert digest(engage(with_lead(coarse, np.zeros_like), angle, TORQUE)) == digest(engage(mesh, angle, TORQUE))


@pytest.mark.parametrize(
    "effect",
    [TipRelief(gear="wheel", amount=20e-6, length=2e-3), ProfileWear(gear="pinion", tip=20e-6, root=30e-6, pitch=3e-6)],
    ids=["relief", "wear"],
)
def test_what_is_missing_from_the_flanks_hardly_changes_what_a_lead_adds(small_pair, angle, effect) -> None:
    """It is computed from flanks as designed, once for all forms of them."""

    def tilted(*effects) -> Mesh:
        return with_lead(dataclasses.replace(assemble(small_pair, effects).mesh, slices=SLICES), lambda place: 1e-5 * TILT(place))

    def error(mesh: Mesh) -> np.ndarray:
        return engage(mesh, angle, TORQUE).transmission_error

    mesh, exact = tilted(effect), tilted(effect)
    as_they_are = width._plain(mesh.flanks, mesh.placement, mesh.compliance)
    exact.__dict__["lead"] = width._lead_table(*as_they_are, width.on_flanks(mesh.law), SLICES)
    added = error(exact) - error(with_lead(mesh, np.zeros_like))
    assert added.min() > 2e-6
    assert error(mesh) == pytest.approx(error(exact), rel=0.0, abs=5e-3 * added.mean())
    assert digest(mesh.lead) == digest(tilted().lead) != digest(exact.lead)


def test_an_even_gap_shifts_the_error(mesh, angle) -> None:
    """On the path by the gap itself; where a pair touches off it, by the gap over its lever."""
    shifted, plain = engage(with_lead(mesh, lambda place: 7e-6 + 0.0 * place), angle, TORQUE), engage(mesh, angle, TORQUE)
    on_path = ((plain.force == 0.0) | (plain.contacts.gap == 0.0)).all(axis=1)
    assert on_path.any()
    assert (shifted.transmission_error - plain.transmission_error)[on_path] == pytest.approx(7e-6, rel=1e-9, abs=0.0)
    assert shifted.force[on_path] == pytest.approx(plain.force[on_path], rel=1e-8, abs=1e-8 * plain.force.max())


@pytest.mark.parametrize("shape", [TILT, CROWN])
def test_small_leads_go_on_from_none_with_a_finite_slope(mesh, angle, shape) -> None:
    plain = engage(mesh, angle, TORQUE).transmission_error
    change = [engage(with_lead(mesh, lambda place, size=size: size * shape(place)), angle, TORQUE) for size in (1e-9, 2e-9, 1e-7)]
    slopes = [(one.transmission_error - plain) / size for one, size in zip(change, (1e-9, 2e-9, 1e-7), strict=True)]
    # Between the least and the largest gap, and the same slope for leads a hundred times as large.
    assert slopes[0].min() > 0.1
    assert slopes[0].max() < 0.9
    assert slopes[1] == pytest.approx(slopes[0], rel=2e-3, abs=0.0)
    assert slopes[2] == pytest.approx(slopes[0], rel=2e-2, abs=0.0)


def test_mirrored_leads_do_the_same(mesh, angle) -> None:
    one, other = (engage(with_lead(mesh, lambda z, sign=sign: 10e-6 * (0.5 + sign * z)), angle, TORQUE) for sign in (1, -1))
    assert other.transmission_error == pytest.approx(one.transmission_error, rel=1e-9, abs=0.0)


def test_slices_without_a_lead_are_the_solid_tooth_under_an_even_load(mesh) -> None:
    """Uniform approach against uniform load: their means differ by the square of the unevenness alone."""
    position = path_positions(mesh.flanks, mesh.placement)
    pair = sliced_pair(mesh.flanks, mesh.placement, mesh.compliance, SLICES, position)
    load = np.full(len(position), 125e3)
    _, approach = pair.load(mesh.law, load, np.zeros(8))
    even = pair.matrix.sum(axis=2).mean(axis=1) * load + mesh.law.approach(load, pair.line)
    ratio = approach / even
    print(f"approach of slices over that under an even load: {ratio.min():.5f} to {ratio.max():.5f}")
    # Asked for: 1 %.
    assert np.abs(ratio - 1.0).max() < 1e-3


@pytest.mark.parametrize("size", [4.0, 8.0])
@pytest.mark.parametrize(("by_contact", "least", "most"), [(False, 0.6, 1.05), (True, 1.1, 3.0)], ids=["independent", "by_contact"])
def test_other_models_of_slices_need_as_much_more_or_less_lead_as_is_said(mesh, size, by_contact, least, most) -> None:
    """For the same approach under a tilt of so many times the deflection, of teeth held at their roots; bodies set them farther apart."""
    pair = sliced_pair(mesh.flanks, mesh.placement, mesh.compliance, SLICES, path_positions(mesh.flanks, mesh.placement)[3:4])
    load, place = np.array([125e3]), (np.arange(8) + 0.5) / 8 - 0.5
    even = pair.matrix.sum(axis=2).mean()
    other = dataclasses.replace(pair, matrix=even * (np.full((1, 8, 8), 1.0 / 8) if by_contact else np.eye(8)[None]))

    def further(pair, tilt: float) -> float:
        gap = tilt * (TILT(place) - TILT(place)[0])
        return float(pair.load(mesh.law, load, gap)[1][0] - pair.load(mesh.law, load, np.zeros(8))[1][0])

    tilt = size * even * load[0]
    same = brentq(lambda one: further(other, one) - further(pair, tilt), 0.1 * tilt, 10.0 * tilt)
    print(f"{same / tilt:.2f} times the tilt")
    assert least < same / tilt < most


def test_large_tilt_leaves_part_of_the_width_and_load_closes_it(mesh, angle) -> None:
    tilt = 35e-6
    tilted = with_lead(mesh, lambda place: tilt * TILT(place))
    part, late, factor = [], [], []
    torques = (1.0, 20.0, 80.0, 350.0)
    for torque in torques:
        loaded = engage(tilted, angle, torque)
        along = load_over_width(tilted, loaded)
        part.append(float((along.line_load.sum(axis=1) > 0.0).mean()))
        late.append(loaded.transmission_error - engage(mesh, angle, torque).transmission_error)
        factor.append(along.face_load_factor.max())
        assert np.median(loaded.mesh_stiffness / engage(mesh, angle, torque).mesh_stiffness) < 1.0
    print("part of the width in contact", part, "face load factor", factor)
    assert part[0] < 0.3
    assert part[-1] > 0.9
    assert (np.diff(part) >= 0.0).all()
    assert (np.diff(factor) < 0.0).all()
    assert (np.diff(late, axis=0) > 0.0).all()
    # Closed, the lead adds its mean; where a further pair is drawn in, less.
    assert np.median(late[-1]) == pytest.approx(0.5 * tilt, rel=0.03, abs=0.0)


def test_saturated_lead_is_a_shift(mesh, angle) -> None:
    """Once the whole width touches, twice the torque changes what the lead adds by the curvature of Hertz's law alone."""
    crowned = with_lead(mesh, lambda place: 3e-6 * CROWN(place))
    added = [
        engage(crowned, angle, torque).transmission_error - engage(mesh, angle, torque).transmission_error for torque in (100.0, 200.0)
    ]
    # A pair that the second torque brings into contact takes its share at that angle.
    assert np.median(np.abs(added[1] / added[0] - 1.0)) < 0.01


def test_forces_lie_on_the_width(mesh, angle) -> None:
    tilted = with_lead(mesh, lambda place: 10e-6 * TILT(place))
    loaded = engage(tilted, angle, TORQUE)
    along = load_over_width(tilted, loaded)
    middle = along.line_load[..., 1:-1]
    assert middle.mean(axis=2) * along.face_width == pytest.approx(loaded.force, rel=1e-10, abs=1e-9)
    assert (along.face_load_factor > 1.0).all()
    # The pressure of the engagement comes of tables, this one of the slices: largest over least even, as the root of the load.
    plain = load_over_width(mesh, engage(mesh, angle, TORQUE))
    assert along.pair_load_factor.max() > plain.pair_load_factor.max() > 1.0
    # Metal missing at the far end: the near end carries most.
    assert (np.argmax(along.line_load.sum(axis=1), axis=1) == 0).all()


def test_stiffness_with_a_lead_is_the_slope_of_force(mesh, angle) -> None:
    tilted, step = with_lead(mesh, lambda place: 20e-6 * TILT(place)), 1e-4
    after, before = (engage(tilted, angle, TORQUE * (1.0 + sign * step)).transmission_error for sign in (1, -1))
    slope = 2.0 * step * TORQUE / mesh.placement.pair.pinion.base_radius / (after - before)
    # Cubic curves over the load: the difference errs by the step squared but where it meets a node.
    assert np.median(np.abs(slope / engage(tilted, angle, TORQUE).mesh_stiffness - 1.0)) < 1e-6


def test_force_table_holds_the_lead(mesh) -> None:
    tilted = with_lead(mesh, lambda place: 20e-6 * TILT(place))
    table = mesh_force(tilted, TORQUE, steps=12, levels=60)
    loaded = engage(tilted, table.pinion_angle, TORQUE)
    moment = [np.interp(error, table.deflection, row) for error, row in zip(loaded.transmission_error, table.pinion_moment, strict=True)]
    assert np.array(moment) == pytest.approx(TORQUE, rel=1e-2, abs=0.0)
    assert table.unloaded_error.min() == pytest.approx(20e-6 / 16, rel=1e-9, abs=0.0)


def all_slices(mesh: Mesh, angle: np.ndarray, gap: np.ndarray, uneven_coupling: float) -> tuple[np.ndarray, np.ndarray]:
    """Return error and shares with the slices of all pairs as unknowns of one problem."""
    contacts = mesh.contacts(angle)
    system = dataclasses.replace(mesh, flanks=dataclasses.replace(mesh.flanks, lead=Lead())).system(contacts)
    n, count = len(gap), contacts.gap.shape[1]
    path = path_positions(mesh.flanks, mesh.placement)
    known = sliced_pair(mesh.flanks, mesh.placement, mesh.compliance, mesh.slices, path)
    linear = np.zeros((len(angle), count, n, count, n))
    for j in range(count):
        matrix = known.between(path, np.clip(mesh.position(contacts)[:, j], path[0], path[-1])).matrix
        uneven = matrix - matrix.mean(axis=(1, 2), keepdims=True)
        for k in range(count):
            part = 1.0 if j == k else uneven_coupling * (system.linear[:, j, k] / system.linear[:, j, j])[:, None, None]
            linear[:, j, :, k, :] = system.linear[:, j, k, None, None] / n + part * uneven

    def spread(values: np.ndarray) -> np.ndarray:
        return np.repeat(values, n, axis=1)

    whole = PairSystem(
        linear=linear.reshape(len(angle), count * n, count * n),
        lever=spread(system.lever),
        arm=spread(system.arm) / n,
        gap=spread(system.gap) + np.tile(gap, count) / spread(system.lever),
        line=Line(*(spread(values) for values in system.line)),
    )
    shared = share_torque(whole, mesh.law, TORQUE)
    force = shared.force.reshape(len(angle), count, n).mean(axis=2)
    return shared.transmission_error, force / force.sum(axis=1, keepdims=True)


@pytest.mark.parametrize(("shape", "size"), [(TILT, 10e-6), (TILT, 40e-6), (CROWN, 15e-6)])
def test_curves_of_single_pairs_against_all_slices_at_once(mesh, angle, shape, size) -> None:
    """What is left out: own curves near tip edges, and coupling through the body that is uneven over the width (here at most so)."""
    tilted = with_lead(mesh, lambda place: size * shape(place))
    gap = SLICES.gap(tilted.flanks.lead)
    plain, loaded = engage(mesh, angle, TORQUE), engage(tilted, angle, TORQUE)
    added, moved = loaded.transmission_error - plain.transmission_error, loaded.load_share - plain.load_share
    on_path = ((loaded.force == 0.0) | (loaded.contacts.gap == 0.0)).all(axis=1)
    for coupling, place, error, share in ((0.0, on_path, 0.005, 0.005), (0.0, ~on_path, 0.02, 0.025), (1.0, on_path | True, 0.05, 0.05)):
        with_gap, without = (all_slices(tilted, angle, values, coupling) for values in (gap, 0.0 * gap))
        worst = np.abs((with_gap[0] - without[0] - added) / loaded.transmission_error)[place].max()
        shares = np.abs(with_gap[1] - without[1] - moved)[place].max()
        print(f"lead {1e6 * size:g} um, uneven coupling {coupling:g}: error {worst:.1e} of the transmission error, shares {shares:.1e}")
        assert worst < error
        assert shares < share


@pytest.mark.parametrize(
    "shape", [TILT, lambda place: -place, CROWN, lambda place: np.maximum(np.abs(place) - 0.4, 0.0), lambda z: 1.0 * (z > 0)]
)
def test_every_lead_has_its_solution_at_every_load(mesh, angle, shape) -> None:
    """From a thousandth of a nanometre to several deflections: tilts, crowning, end relief and a step."""
    for size in (1e-12, 1e-7, 5e-5):
        lead = with_lead(mesh, lambda place, size=size: size * shape(place))
        loaded = [engage(lead, angle[::4], torque) for torque in (1e-3, 1.0, 50.0, 400.0)]
        assert (np.diff([one.transmission_error for one in loaded], axis=0) > 0.0).all()
        assert all((one.mesh_stiffness > 0.0).all() for one in loaded)


@pytest.mark.parametrize("change", [{"count": 3}, {"positions": 1}])
def test_too_few_slices_are_refused(change) -> None:
    with pytest.raises(InputError):
        FaceSlices(**change)
