"""What records cost that no model meets, and over how many rows errors of a model stay alike."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
from scipy.signal import lfilter

from gearfem.diagnosis.fitting.marginal import marginal, memory_of, profile

FLOOR, MEMORY = np.array([1.5]), np.array([20.0])
ROWS = np.array([1000.0])


def cost(mean: float, floor: float = 1.5, memory: float = 20.0) -> float:
    """Return the cost of a record of a thousand rows with a mean square."""
    return float(profile(mean * ROWS, ROWS, np.array([floor]), np.array([memory]))[0][0])


@pytest.mark.parametrize("mean", [0.3, 1.4, 1.6, 4.0, 300.0])
def test_weights_are_the_slope_of_the_cost(mean: float) -> None:
    weight = profile(mean * ROWS, ROWS, FLOOR, MEMORY)[1][0]
    step = 1e-4 * mean
    assert (cost(mean + step) - cost(mean - step)) / (2.0 * step * ROWS[0]) == pytest.approx(weight, rel=1e-6, abs=0.0)


def test_the_cost_is_continuous_at_the_floor() -> None:
    assert cost(1.5 - 1e-12) == pytest.approx(cost(1.5 + 1e-12), rel=1e-10, abs=0.0)


def test_rows_of_noise_count_fully_and_errors_of_the_model_once_in_their_memory() -> None:
    noise = profile(ROWS, ROWS, np.ones(1), MEMORY)[1][0]
    far = profile(1e4 * ROWS, ROWS, np.ones(1), MEMORY)[1][0]
    assert noise == 1.0
    assert far == pytest.approx(1.0 / (20.0 * 1e4), rel=0.01, abs=0.0)


def test_without_memory_the_cost_is_the_likelihood_of_an_unknown_variance() -> None:
    # -2 ln L = m + m ln q beyond the floor, and square/floor + m ln floor below it.
    assert cost(8.0, 2.0, 1.0) - cost(4.0, 2.0, 1.0) == pytest.approx(1000.0 * np.log(2.0), rel=1e-12, abs=0.0)
    assert cost(1.0, 2.0, 1.0) - cost(0.5, 2.0, 1.0) == pytest.approx(1000.0 * 0.25, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("rho", [0.0, 0.6, 0.9])
def test_memory_is_bartletts_number_of_rows(rho: float) -> None:
    drawn = np.random.default_rng(5).standard_normal(40000)
    left = 30.0 * np.sqrt(1.0 - rho**2) * lfilter([1.0], [1.0, -rho], drawn)
    # The estimate scatters by a tenth over so many rows.
    assert memory_of(left) == pytest.approx((1.0 + rho**2) / (1.0 - rho**2), rel=0.15, abs=0.0)


def test_noise_alone_has_no_memory() -> None:
    assert memory_of(0.99 * np.random.default_rng(5).standard_normal(4000)) == 1.0


def test_products_alone_settle_what_the_rows_do() -> None:
    rng = np.random.default_rng(5)
    columns = tuple(rng.standard_normal((rows, 4)) for rows in (30, 50))
    whole, residual = marginal(columns).weighed(np.array([0.3, 1.0])), 100.0 * rng.standard_normal(80)
    squares = np.array([part @ part for part in (residual[:30], residual[30:])])
    solved, left = whole.settle(whole.pulls(residual), squares)
    rows = residual - whole.moved(whole.solve(residual))
    np.testing.assert_allclose(solved, whole.solve(residual), rtol=1e-12)
    np.testing.assert_allclose(left, [rows[:30] @ rows[:30], rows[30:] @ rows[30:]], rtol=1e-12)


def test_columns_are_let_go() -> None:
    """They take a gigabyte: nothing may hold them in a circle until the collector comes by."""
    whole = marginal((np.random.default_rng(5).normal(size=(20, 4)),))
    lighter = whole.weighed(np.array([0.5]))
    assert lighter is whole.weighed(np.array([0.5]))
    assert lighter.deviations.shape == (4,)
    held = weakref.ref(whole)
    gc.disable()
    try:
        del whole
        assert held() is None
    finally:
        gc.enable()


def test_products_without_zeros_are_the_same() -> None:
    """Columns of which a few at a time are not zero are multiplied in runs of rows."""
    rng = np.random.default_rng(6)
    columns = np.zeros((300, 40))
    for row in range(300):
        columns[row, (row // 10 + np.arange(5)) % 40] = rng.normal(size=5)
    found, residual, unknown = marginal((columns,)), rng.normal(size=300), rng.normal(size=40)
    assert found.products[0] == pytest.approx(columns.T @ columns, rel=1e-12, abs=1e-12)
    for few in (found, found.first(40), found.part(np.array([0])), found.weighed(np.array([0.5]))):
        assert few.pulls(residual)[0] == pytest.approx(columns.T @ residual, rel=1e-12, abs=1e-12)
        assert few.moved(unknown) == pytest.approx(columns @ unknown, rel=1e-12, abs=1e-12)
    assert found.first(7).pulls(residual)[0] == pytest.approx(columns[:, :7].T @ residual, rel=1e-12, abs=1e-12)


def test_deviations_of_some_unknowns_are_those_among_all() -> None:
    """Of covariances (1 + A'A)^-1."""
    columns = np.random.default_rng(4).normal(size=(9, 5)) * [0.1, 1.0, 3.0, 0.5, 2.0]
    expected = np.sqrt(np.diag(np.linalg.inv(np.eye(5) + columns.T @ columns)))
    unknowns = marginal((columns[:4], columns[4:]))
    np.testing.assert_allclose(unknowns.deviations, expected, rtol=1e-12)
    np.testing.assert_allclose(unknowns.deviations_of(np.array([3, 0])), expected[[3, 0]], rtol=1e-12)
