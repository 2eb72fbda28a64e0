"""Noise as an autoregressive process, and the filter that makes it white."""

from __future__ import annotations

import dataclasses
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gearfem.foundation import Array, Record


class Whitening(Protocol):
    """Makes rows of variance 1 of the noise of one record."""

    def apply(self, values: Array) -> Array:
        """Return whitened residuals, shape (m,) of (n,), or whitened columns, (m, k) of (n, k)."""
        ...


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Whitener(Record):
    """Turns residuals of one record into independent ones of variance 1, if they are its noise.

    Parameters
    ----------
    predictor : ndarray, shape (p + 1, p)
        Row k: coefficients by which a sample is predicted from the k before it.
    deviation : ndarray, shape (p + 1,)
        Standard deviation of what is left with k samples before it; the last one is the innovation's.
    start : ndarray of int, shape (r,)
        First kept row of each unbroken run.
    stop : ndarray of int, shape (r,)
        Row behind each run.

    Notes
    -----
    Each run starts with the predictors of lower order, so that its whitened samples are exactly independent; what the noise
    remembers across a masked sample is left out, which costs the order of the process in samples.
    """

    predictor: Array
    deviation: Array
    start: NDArray[Any]
    stop: NDArray[Any]

    def apply(self, values: Array) -> Array:
        """Return whitened residuals, or whitened columns of a Jacobian.

        Parameters
        ----------
        values : ndarray, shape (n,) or (n, k)
            In the rows of the record, masked ones included.

        Returns
        -------
        ndarray, shape (m,) or (m, k)
            In the m rows kept.
        """
        return np.concatenate([self._run(values[i:j]) for i, j in zip(self.start, self.stop, strict=True)])

    def _run(self, values: Array) -> Array:
        if not values.size:
            return values
        order = len(self.deviation) - 1
        white: Array = values / self.deviation[order]
        for k, share in enumerate(self.predictor[order] / self.deviation[order], 1):
            white[k:] -= share * values[:-k]
        for k in range(min(order, len(values))):
            white[k] = (values[k] - np.tensordot(self.predictor[k, :k], values[:k][::-1], axes=1)) / self.deviation[k]
        return white


def make_whitener(covariance: Array, keep: NDArray[Any]) -> Whitener:
    """Return the filter for noise of a known covariance over the first lags.

    Parameters
    ----------
    covariance : ndarray, shape (p + 1,)
        Covariance at lags 0 to p, positive definite; only the first makes white noise.
    keep : ndarray of bool, shape (n,)
        Rows of the record that are used.

    Returns
    -------
    Whitener

    Notes
    -----
    Levinson and Durbin's recursion; a reflection beyond 1 means that the covariance belongs to no process.
    """
    order = len(covariance) - 1
    predictor = np.zeros((order + 1, order))
    variance = np.empty(order + 1)
    variance[0] = covariance[0]
    for k in range(1, order + 1):
        before = predictor[k - 1, : k - 1]
        reflection = (covariance[k] - before @ covariance[k - 1 : 0 : -1]) / variance[k - 1]
        predictor[k, : k - 1] = before - reflection * before[::-1]
        predictor[k, k - 1] = reflection
        variance[k] = variance[k - 1] * (1.0 - reflection**2)
        if not variance[k] > 0.0:
            raise ValueError("the covariance is not positive definite")
    edges = np.diff(np.concatenate([[0], keep.astype(int), [0]]))
    return Whitener(
        predictor=predictor,
        deviation=np.sqrt(variance),
        start=np.flatnonzero(edges == 1),
        stop=np.flatnonzero(edges == -1),
    )
