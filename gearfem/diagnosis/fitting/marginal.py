"""Everything linear and of known spread taken out of whitened records, each of which may count less than its noise says."""

from __future__ import annotations

import dataclasses
import itertools
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.sparse import csr_array

from gearfem.foundation import Array, Record

# Weights under which columns stay factorised.
KEPT = 4
# Rounds in which the weights of a point nearby are brought up to what each record deserves.
WEIGHED = 4
# Rows that are multiplied at once where at most this share of the columns is not zero: teeth out of contact do nothing to slow records.
RUN, SPARSE = 64, 0.3


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Marginal(Record):
    """Whitened columns of linear unknowns with Gaussian priors, record by record.

    Parameters
    ----------
    columns : tuple of ndarray, shapes (m_r, k)
        Whitened columns of each record, each times the prior standard deviation of its unknown.
    products : tuple of ndarray, shapes (k, k)
        Their products A_r' A_r.
    factors : tuple of ndarray or sparse array, shapes (m_r, k)
        The columns again, as they are multiplied: sparse where most are zero.
    weights : ndarray, shape (r,)
        What a squared whitened row of each record counts, at most 1.
    still : ndarray, shape (s,)
        Unknowns that stay at 0.

    Notes
    -----
    For residuals r and unknowns n in prior deviations: min over n of sum w_r |r_r - A_r n|^2 + |n|^2. With K = 1 + sum w_r A_r' A_r and
    a = sum w_r A_r' r_r it is sum w_r |r_r|^2 - a' K^-1 a. New weights cost one factorisation of K.
    """

    columns: tuple[Array, ...]
    products: tuple[Array, ...]
    factors: tuple[Any, ...]
    weights: Array
    still: NDArray[Any] = dataclasses.field(default_factory=lambda: np.empty(0, int))

    @cached_property
    def _factor(self) -> Any:
        total = np.eye(len(self.products[0]))
        for weight, product in zip(self.weights, self.products, strict=True):
            total += weight * product
        total[self.still] = total[:, self.still] = 0.0
        total[self.still, self.still] = 1.0
        return cho_factor(total, overwrite_a=True, check_finite=False)

    @cached_property
    def rows(self) -> tuple[slice, ...]:
        """Where the rows of each record stand among those of all."""
        ends = np.cumsum([0, *(len(part) for part in self.columns)])
        return tuple(slice(int(a), int(b)) for a, b in itertools.pairwise(ends))

    def first(self, count: int) -> Marginal:
        """Return the first unknowns alone; their columns and products are not copied."""
        columns, factors = (tuple(part[:, :count] for part in parts) for parts in (self.columns, self.factors))
        products = tuple(product[:count, :count] for product in self.products)
        return dataclasses.replace(self, columns=columns, products=products, factors=factors, still=self.still[self.still < count])

    def holding(self, still: NDArray[Any]) -> Marginal:
        """Return the same columns with some unknowns, and no others, at 0."""
        return dataclasses.replace(self, still=still)

    def some(self, places: NDArray[Any]) -> Marginal:
        """Return the unknowns at some places alone, to settle by their products; they have no columns. The latest ones are kept."""
        key, known = places.tobytes(), self._parts
        if key not in known:
            known.clear()
            products = tuple(one[np.ix_(places, places)] for one in self.products)
            still = np.flatnonzero(np.isin(places, self.still))
            known[key] = dataclasses.replace(self, columns=(), products=products, factors=(), still=still)
        return known[key]

    @cached_property
    def _parts(self) -> dict[bytes, Marginal]:
        """The latest of some unknowns alone."""
        return {}

    def weighed(self, weights: Array) -> Marginal:
        """Return the same columns with other weights; a fit tries its steps under the same ones, which are factorised once."""
        key, known = weights.tobytes(), self._known
        if key not in known:
            if len(known) == KEPT:
                del known[next(iter(known))]
            known[key] = dataclasses.replace(self, weights=weights)
        return known[key]

    @cached_property
    def _known(self) -> dict[bytes, Marginal]:
        """The latest with other weights, which do not hold this one: columns are too large to wait until circles are looked for."""
        return {}

    def part(self, places: NDArray[Any]) -> Marginal:
        """Return the records at some places alone."""
        columns, products, factors = (tuple(parts[i] for i in places) for parts in (self.columns, self.products, self.factors))
        return dataclasses.replace(self, columns=columns, products=products, factors=factors, weights=self.weights[places])

    def solve(self, residual: Array) -> Array:
        """Return the unknowns in prior deviations that leave least of whitened vectors, shapes (m,) or (m, p)."""
        return np.asarray(cho_solve(self._factor, self._pull(residual), check_finite=False))

    def pulls(self, residual: Array) -> Array:
        """Return what each record pulls at the unknowns at full weight, A_r' r_r of whitened (m,) or (m, p); shape (r, k) or (r, k, p)."""
        found = np.stack([part.T @ residual[rows] for part, rows in zip(self.factors, self.rows, strict=True)])
        found[:, self.still] = 0.0
        return found

    def settle(self, pulls: Array, squares: Array) -> tuple[Array, Array]:
        """Return the unknowns (k,) that leave least, and what they leave of the squares of each record (r,), from its `pulls`.

        By products alone, without a row touched: good to 1e-15 of the squares before.
        """
        solved = np.asarray(cho_solve(self._factor, self.weights @ pulls, check_finite=False))
        bent = np.array([solved @ (product @ solved) for product in self.products])
        return solved, squares - 2.0 * pulls @ solved + bent

    def left(self, residual: Array) -> Array:
        """Return whitened vectors, shapes (m,) or (m, p), without the unknowns that fit them best."""
        return np.asarray(residual - self.moved(self.solve(residual)))

    @cached_property
    def root(self) -> Array:
        """A factor F of the covariance F F' of the unknowns after the fit, in prior deviations, shape (k, k)."""
        triangle, _ = self._factor
        return np.asarray(solve_triangular(triangle, np.eye(len(triangle)), check_finite=False))

    @property
    def deviations(self) -> Array:
        """Standard deviations of the unknowns after the fit, in prior ones, shape (k,)."""
        return np.asarray(np.sqrt((self.root**2).sum(axis=1)))

    def deviations_of(self, places: NDArray[Any]) -> Array:
        """Return those `deviations` of unknowns at some places alone, for their share of the work."""
        triangle, _ = self._factor
        units = np.zeros((len(triangle), len(places)))
        units[places, np.arange(len(places))] = 1.0
        return np.asarray(np.sqrt((solve_triangular(triangle, units, trans="T", check_finite=False) ** 2).sum(axis=0)))

    def measure(self, vectors: Array, residual: Array) -> tuple[Array, Array]:
        """Return the scalar products of whitened vectors with each other and with a residual, freed from the unknowns.

        Parameters
        ----------
        vectors : ndarray, shape (m, p)
            Whitened signatures.
        residual : ndarray, shape (m,)
            Whitened.

        Returns
        -------
        ndarray, shape (p, p), ndarray, shape (p,)
        """
        own, other = self._pull(vectors), self._pull(residual)
        solved = np.asarray(cho_solve(self._factor, own, check_finite=False))
        weighed = np.concatenate([weight * vectors[rows] for weight, rows in zip(self.weights, self.rows, strict=True)])
        return weighed.T @ vectors - own.T @ solved, weighed.T @ residual - solved.T @ other

    def moved(self, unknown: Array) -> Array:
        """Return what unknowns, shapes (k,) or (k, p), do to all records, whitened, shapes (m,) or (m, p)."""
        return np.concatenate([part @ unknown for part in self.factors])

    def _pull(self, residual: Array) -> Array:
        return np.tensordot(self.weights, self.pulls(residual), axes=1)


def marginal(columns: tuple[Array, ...]) -> Marginal:
    """Return the linear unknowns of whitened records, every record at its full weight.

    Parameters
    ----------
    columns : tuple of ndarray, shapes (m_r, k)
        Whitened columns of each record, times the prior standard deviations.
    """
    few = [np.count_nonzero(part) <= SPARSE * part.size for part in columns]
    return Marginal(
        columns=columns,
        products=tuple(_product(part) if sparse else np.asarray(part.T @ part) for part, sparse in zip(columns, few, strict=True)),
        factors=tuple(csr_array(part) if sparse else part for part, sparse in zip(columns, few, strict=True)),
        weights=np.ones(len(columns)),
    )


def _product(columns: Array) -> Array:
    """Return A'A of columns A, shape (k, k), without the zeros of the teeth out of contact."""
    total = np.zeros((columns.shape[1], columns.shape[1]))
    for start in range(0, len(columns), RUN):
        rows = columns[start : start + RUN]
        used = np.flatnonzero(rows.any(axis=0))
        part = rows[:, used]
        total[np.ix_(used, used)] += part.T @ part
    return total


def profile(square: Array, rows: Array, floor: Array, memory: Array) -> tuple[Array, Array]:
    """Return the cost of whitened squares when a model is not exact, and the weights that belong to it.

    Parameters
    ----------
    square : ndarray, shape (r,)
        Sum of the squared whitened rows of each record.
    rows : ndarray, shape (r,)
        Number of its rows.
    floor : ndarray, shape (r,)
        Least mean square that can be expected of each record, at least 1: noise, and the errors of a model of finite accuracy.
    memory : ndarray, shape (r,)
        Rows over which errors of the model stay alike, at least 1; noise is whitened and has none.

    Returns
    -------
    cost, weights : ndarray, shape (r,)

    Notes
    -----
    Of a mean square q >= floor, 1/q is noise and the rest is error of the model, of which only one row in `memory` tells something new.
    With -2 ln L = square/s^2 + m ln s^2 of a variance s^2 = q at its likeliest, d cost/dq = m/q (1/q + (1 - 1/q)/memory), which is m where
    noise alone is left and m/(memory q) far above it: the cost of a record that no model meets grows by the logarithm of its
    misfit, and as slowly as if it had m/memory rows. Below the floor the slope stays what it is there.
    """
    mean = square / rows
    level = np.maximum(mean, floor)
    below, slope = ((1.0 / q + (1.0 - 1.0 / q) / memory) / q for q in (floor, level))
    above = (1.0 - 1.0 / memory) * (1.0 / floor - 1.0 / level) + np.log(level / floor) / memory
    return rows * (below * np.minimum(mean, floor) + above), slope


def memory_of(white: Array) -> float:
    """Return over how many rows what is left of a record stays alike, at least 1.

    Parameters
    ----------
    white : ndarray, shape (m,)
        Whitened rows of one record as a fit leaves them.

    Notes
    -----
    1 + 2 sum rho_k^2, Bartlett's number of rows for one independent square, over lags up to a quarter of the record, less what chance adds;
    rho is that of what is left above the noise.
    """
    count = len(white)
    spectrum = np.abs(np.fft.rfft(white - white.mean(), 2 * count)) ** 2
    covariance = np.fft.irfft(spectrum)[: max(count // 4, 2)]
    level = float(np.mean(white**2))
    if covariance[0] <= 0.0 or level <= 1.0:
        return 1.0
    square = (covariance[1:] / covariance[0]) ** 2
    # Chance adds to each square the memory itself over the number of rows.
    memory = (1.0 + 2.0 * float(square.sum())) / (1.0 + 2.0 * len(square) / count)
    return 1.0 + max(memory - 1.0, 0.0) / (1.0 - 1.0 / max(level, 2.0)) ** 2
