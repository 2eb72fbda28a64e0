"""Linear nuisances with Gaussian priors, eliminated once so that every candidate afterwards costs a projection."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.linalg import qr, solve_triangular

from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Elimination(Record):
    """Whitened data freed from nuisances.

    Parameters
    ----------
    columns : ndarray, shape (m, k)
        Whitened columns of the nuisances, each times its prior standard deviation.
    basis : ndarray, shape (m, k)
        The data's part of the orthogonal factor of the columns above the identity.
    triangle : ndarray, shape (k, k)
        The triangular factor.

    Notes
    -----
    For residuals r and nuisances n in prior deviations: min over n of |r - A n|^2 + |n|^2 = |r|^2 - |Q' r|^2, with (A; 1) = Q R. It is r'
    (1 + A A')^-1 r, the square of r in the noise that holds the nuisances as well.
    """

    columns: Array
    basis: Array
    triangle: Array

    def gram(self, one: Array, two: Array) -> Array:
        """Return the scalar products of whitened vectors, shapes (m,) or (m, p), in the metric freed from nuisances."""
        return np.asarray(one.T @ two - (self.basis.T @ one).T @ (self.basis.T @ two))

    def solve(self, residual: Array, pull: Array | None = None) -> Array:
        """Return the nuisances in prior deviations that leave least.

        Parameters
        ----------
        residual : ndarray, shape (m,)
            Whitened.
        pull : ndarray, shape (k,), optional
            Prior mean of each nuisance, in its deviations; 0 by default.
        """
        right = self.basis.T @ residual
        if pull is not None:
            # The prior's rows of Q are those of the inverse triangle.
            right = right + solve_triangular(self.triangle, pull, trans="T", check_finite=False)
        return np.asarray(solve_triangular(self.triangle, right, check_finite=False))

    def left(self, residual: Array) -> Array:
        """Return the whitened residual without the nuisances that fit it best, shape (m,)."""
        return np.asarray(residual - self.columns @ self.solve(residual))

    def deviations(self) -> Array:
        """Return the standard deviations of the nuisances after the fit, in prior ones, shape (k,)."""
        inverse = solve_triangular(self.triangle, np.eye(len(self.triangle)), check_finite=False)
        return np.asarray(np.sqrt((inverse**2).sum(axis=1)))


def eliminate(columns: Array) -> Elimination:
    """Return the elimination of nuisances.

    Parameters
    ----------
    columns : ndarray, shape (m, k)
        Whitened columns, each times the prior standard deviation of its nuisance.
    """
    count = columns.shape[1]
    whole = np.concatenate([columns, np.eye(count)])
    basis, triangle = qr(whole, mode="economic", overwrite_a=True, check_finite=False)
    return Elimination(columns=columns, basis=basis[: len(columns)], triangle=triangle)
