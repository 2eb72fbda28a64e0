"""Load sharing: complementarity, the paper's three cases, and the limits of small and large loads."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.contact import EdgedLine, Line
from gearfem.definition.setup import Material
from gearfem.engagement.sharing import PairSystem, share_error, share_torque, share_two_pairs
from gearfem.foundation import Array

STEEL = EdgedLine(pinion=Material(), wheel=Material())


class LinearLaw:
    """A contact that yields in proportion to its load; the closed forms hold for it alone."""

    def __init__(self, slope: float) -> None:
        self.slope = slope

    def approach(self, force: Array, *_: Array) -> Array:
        return self.slope * force

    def respond(self, force: Array, *_: Array) -> tuple[Array, Array]:
        return self.approach(force), np.full_like(force, self.slope)


def random_system(pairs: int, angles: int = 200, coupled: bool = True, seed: int = 7) -> PairSystem:
    """Return plausible pairs: compliances near 1e-11 m2/N, gaps from none to hundreds of micrometres."""
    random = np.random.default_rng(seed)
    shape = (angles, pairs)
    linear = np.zeros((angles, pairs, pairs))
    if coupled:
        linear += random.uniform(0.0, 2e-12, (angles, 1, 1))
    linear[:, range(pairs), range(pairs)] = random.uniform(8e-12, 3e-11, shape)
    gap = random.uniform(0.0, 40e-6, shape) * random.integers(0, 2, shape) * 10.0 ** random.uniform(-2, 1, shape)
    return PairSystem(
        linear=linear,
        lever=random.uniform(0.9, 1.1, shape),
        arm=random.uniform(0.9, 1.1, shape) * 0.06 * 0.075,
        gap=gap,
        line=Line(
            radius=10.0 ** random.uniform(-2.5, -1.5, shape),
            depth1=random.uniform(1e-3, 5e-3, shape),
            depth2=random.uniform(1e-3, 5e-3, shape),
            edge=random.choice([-1e-5, 1e-4, 1e-3], shape) * random.uniform(0.0, 1.0, shape),
            edge_radius=np.full(shape, 1e-4),
        ),
    )


@pytest.mark.parametrize("torque", [1e-3, 1.0, 100.0, 1e4])
@pytest.mark.parametrize("pairs", [1, 2, 3, 5])
def test_solution_is_complementary(pairs: int, torque: float) -> None:
    system = random_system(pairs)
    shared = share_torque(system, STEEL, torque)
    allowed = (shared.transmission_error[:, None] - system.gap) * system.lever
    approach = system.approach(STEEL, shared.force)
    loaded = shared.force > 0.0
    assert (system.arm * shared.force).sum(axis=1) == pytest.approx(torque, rel=1e-11, abs=0.0)
    # The solver stops at 1e-12 of the load; approaches follow to about the same part, beside the rounding of the gaps.
    tolerance = 1e-10 * approach.max() + np.spacing(system.gap.max())
    assert np.abs(approach - allowed)[loaded].max() < tolerance
    # An unloaded pair stays open against the deflection that the others bring it.
    assert (allowed - approach)[~loaded].max(initial=-1.0) <= tolerance


@pytest.mark.parametrize("backlash", [0.0, 2e-6, 9e-6, 30e-6])
def test_the_papers_three_cases(backlash: float) -> None:
    width, arm = 0.05, 0.06
    stiffness = (8e8, 5e8)
    law = LinearLaw(2e-12)
    compliance = [width / value - law.slope for value in stiffness]
    one = np.ones((1, 2))
    system = PairSystem(
        linear=np.diag(compliance)[None],
        lever=one,
        arm=one * arm * width,
        gap=np.array([[0.0, backlash]]),
        line=Line(0.01 * one, one, one, one, one),
    )
    load = 1e4
    first, second = (share_torque(system, law, load * arm).force * width)[0]
    assert (first, second) == pytest.approx(share_two_pairs(load, stiffness, backlash), rel=1e-11, abs=1e-7 * load)


def test_small_torque_tends_to_the_unloaded_error() -> None:
    system = random_system(4)
    lag = [np.abs(share_torque(system, STEEL, torque).transmission_error - system.gap.min(axis=1)).max() for torque in (1.0, 1e-2, 1e-4)]
    # In proportion to the load, but for the logarithm of Hertz.
    assert lag[1] < 0.02 * lag[0]
    assert lag[2] < 0.02 * lag[1]


def test_large_torque_tends_to_all_pairs_in_contact() -> None:
    """With linear contact the slope becomes that of all pairs at once: 1/(arm K lever)."""
    system = random_system(3)
    law = LinearLaw(3e-12)
    shared = share_torque(system, law, 1e7)
    full = np.linalg.inv(system.linear + law.slope * np.eye(3))
    stiffness = np.einsum("aj,ajk,ak->a", system.arm, full, system.lever)
    assert (shared.force > 0.0).all()
    assert shared.slope == pytest.approx(1.0 / stiffness, rel=1e-9, abs=0.0)


def test_slope_is_the_derivative_of_the_error() -> None:
    system = random_system(3)
    torque, step = 500.0, 0.05
    slope = share_torque(system, STEEL, torque).slope
    after, before = (share_torque(system, STEEL, torque + sign * step).transmission_error for sign in (1, -1))
    difference = (after - before) / (2.0 * step)
    # At a few of the random angles a pair enters within the step; elsewhere the difference is good to its square.
    assert np.median(np.abs(difference / slope - 1.0)) < 1e-7
    assert np.mean(np.abs(difference / slope - 1.0) < 1e-4) > 0.97


def test_given_error_returns_the_torque() -> None:
    system = random_system(4)
    shared = share_torque(system, STEEL, 300.0)
    again = share_error(system, STEEL, shared.transmission_error)
    assert (again.force * system.arm).sum(axis=1) == pytest.approx(300.0, rel=1e-9, abs=0.0)


def test_error_grows_with_torque() -> None:
    system = random_system(4)
    errors = np.array([share_torque(system, STEEL, torque).transmission_error for torque in (0.1, 1.0, 10.0, 100.0, 1000.0)])
    assert (np.diff(errors, axis=0) > 0.0).all()
