"""A curve in fragments: polynomials in Legendre's basis, joined in value and slope, chosen by cross-validation."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import legder, legval, legvander
from numpy.typing import ArrayLike
from scipy.linalg import null_space

from gearfem.foundation import Array, Record

# Degrees of Wojnarowski & Onishchenko (2003); a fragment has twice as many points as a quartic has coefficients.
DEGREES = (4, 5, 6)
FEWEST_IN_FRAGMENT = 10
MOST_FRAGMENTS = 8
# Places tried for a further breakpoint, at equal numbers of points, then between the neighbours of the best one.
PLACES, FINER = 32, 9
# A breakpoint is the best of many places, so it must gain more than chance gives one model: this many standard errors.
GAIN = 2.0
# Less than a nanometre is below every instrument and the rounding of files: no breakpoint and no outlier is sought there.
NEGLIGIBLE = 1e-9


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Fragments(Record):
    """Polynomials on neighbouring intervals, equal in value and slope where they meet.

    Parameters
    ----------
    ends : ndarray, shape (k + 1,)
        Start, breakpoints and end [m].
    coefficients : tuple of ndarray
        Of Legendre's polynomials on each interval [m].
    """

    ends: Array
    coefficients: tuple[Array, ...]

    @property
    def degrees(self) -> tuple[int, ...]:
        """Degree of each fragment."""
        return tuple(len(values) - 1 for values in self.coefficients)

    @property
    def breakpoints(self) -> Array:
        """Where fragments meet [m]."""
        inner: Array = self.ends[1:-1]
        return inner

    def at(self, x: ArrayLike, order: int = 0) -> Array:
        """Return the curve or a derivative of it; beyond its ends the outer polynomials go on."""
        x = np.asarray(x, float)
        result = np.empty(x.shape)
        place = np.searchsorted(self.breakpoints, x, side="right")
        for number, values in enumerate(self.coefficients):
            low, high = self.ends[number : number + 2]
            inside = place == number
            scale = 2.0 / (high - low)
            slopes = legder(values, order) * scale**order if order else values
            result[inside] = legval(scale * (x[inside] - low) - 1.0, slopes)
        return result


class Fit(NamedTuple):
    """A least-squares fit: its curve, residuals, leverages, the number of quantities fitted (free breakpoints included), its spread.

    The rows of Legendre's polynomials at further places, times the spread, have the leverages there as their squared lengths.
    """

    curve: Fragments
    residual: Array
    leverage: Array
    fitted: int
    spread: Array

    @property
    def left_out(self) -> Array:
        """Error of each point against the curve that is fitted without it; exact for linear least squares."""
        return self.residual / (1.0 - self.leverage)

    def leverage_at(self, x: Array) -> Array:
        """Return the variance of the curve at other places, over that of one point."""
        leverage: Array = ((_design(x, self.curve.ends, self.curve.degrees) @ self.spread) ** 2).sum(axis=1)
        return leverage

    @property
    def std(self) -> float:
        """Standard deviation of the residuals, with the degrees of freedom that are left [m]."""
        free = max(self.residual.size - self.fitted, 1)
        return float(np.sqrt(self.residual @ self.residual / free))


def choose(x: Array, y: Array) -> Fit:
    """Return the fit with no more fragments and no higher degrees than cross-validation asks for.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Places, increasing, and values of at least 8 points [m].

    Returns
    -------
    Fit

    Notes
    -----
    The score is the mean square of the errors with each point left out, e/(1 - h). Degrees 4 to 6: the lowest whose score
    lies within one standard error of the best (the rule of Breiman et al. 1984, with the error of the paired differences).
    A breakpoint is added, at the best of 32 places and then finer, while it lowers the score by more than two standard errors.
    """
    ends = np.array([x[0], x[-1]])
    best = _with_degrees(x, y, ends, ())
    while len(best.curve.coefficients) < MOST_FRAGMENTS and best.std > NEGLIGIBLE:
        further = _split(x, y, best)
        if further is None or not _gains(best, further):
            break
        best = further
    return best


def fit(x: Array, y: Array, ends: Array, degrees: tuple[int, ...]) -> Fit | None:
    """Return the least-squares fit of given fragments; None where the points do not determine it."""
    design = _design(x, ends, degrees)
    free = null_space(_joins(ends, degrees)) if len(degrees) > 1 else np.eye(design.shape[1])
    q, r = np.linalg.qr(design @ free)
    leverage = (q**2).sum(axis=1)
    if np.abs(np.diag(r)).min() < 1e-9 * np.abs(np.diag(r)).max() or leverage.max() > 1.0 - 1e-6:
        return None
    values = free @ np.linalg.solve(r, q.T @ y)
    parts = tuple(np.split(values, np.cumsum([degree + 1 for degree in degrees])[:-1]))
    curve = Fragments(ends=ends, coefficients=parts)
    return Fit(curve, y - design @ values, leverage, free.shape[1] + len(degrees) - 1, np.linalg.solve(r.T, free.T).T)


def _design(x: Array, ends: Array, degrees: tuple[int, ...]) -> Array:
    place = np.searchsorted(ends[1:-1], x, side="right")
    blocks = []
    for number, degree in enumerate(degrees):
        block = legvander(2.0 * (x - ends[number]) / (ends[number + 1] - ends[number]) - 1.0, degree)
        blocks.append(np.where((place == number)[:, None], block, 0.0))
    return np.hstack(blocks)


def _joins(ends: Array, degrees: tuple[int, ...]) -> Array:
    """Return the rows that are zero where neighbours agree in value and slope; P_n(1) = 1 and P_n'(1) = n(n+1)/2."""
    starts = np.concatenate([[0], np.cumsum(np.array(degrees) + 1)])
    rows = np.zeros((2 * (len(degrees) - 1), starts[-1]))
    for number in range(len(degrees) - 1):
        for side, sign in ((number, 1.0), (number + 1, -1.0)):
            order = np.arange(degrees[side] + 1)
            turn = np.ones(len(order)) if side == number else (-1.0) ** order
            part = slice(starts[side], starts[side + 1])
            rows[2 * number, part] = sign * turn
            slope = order * (order + 1) / 2.0 * (turn if side == number else -turn)
            rows[2 * number + 1, part] = sign * slope * (ends[-1] - ends[0]) / (ends[side + 1] - ends[side])
    return rows


def _score(found: Fit) -> float:
    return float(np.mean(found.left_out**2))


def _gains(old: Fit, new: Fit, errors: float = GAIN) -> bool:
    """Say whether a fit predicts points left out better by more than so many standard errors of the difference."""
    better = old.left_out**2 - new.left_out**2
    return bool(better.mean() > errors * better.std(ddof=1) / np.sqrt(better.size))


def _with_degrees(x: Array, y: Array, ends: Array, start: tuple[int, ...]) -> Fit:
    """Return the fit of given fragments with the lowest degrees within one standard error of the best."""
    counts = np.histogram(x, ends)[0]
    most = [min(DEGREES[-1], int(count) - 3) for count in counts]
    degrees = list(start) if start else [min(DEGREES[0], limit) for limit in most]
    found = fit(x, y, ends, tuple(degrees))
    for number, limit in enumerate(most):
        tried = [fit(x, y, ends, (*degrees[:number], degree, *degrees[number + 1 :])) for degree in DEGREES if degree <= limit]
        rated = [one for one in tried if one is not None]
        if rated:
            best = min(rated, key=_score)
            found = next(one for one in rated if one is best or not _gains(one, best, 1.0))
            degrees[number] = found.curve.degrees[number]
    if found is None:
        raise FloatingPointError("the points do not determine a polynomial of degree 4")
    return found


def _split(x: Array, y: Array, old: Fit) -> Fit | None:
    """Return the best fit with one breakpoint more; None where no fragment has points enough."""
    order = np.unique(np.linspace(0, x.size - 1, PLACES + 2).astype(int)[1:-1])
    places = 0.5 * (x[order] + x[np.minimum(order + 1, x.size - 1)])
    best = _best_place(x, y, old.curve, places)
    if best is None:
        return None
    place = float(np.setdiff1d(best.curve.ends, old.curve.ends)[0])
    near = places[np.abs(places - place) <= 1.5 * np.ptp(x) / PLACES]
    best = _best_place(x, y, old.curve, np.linspace(near.min(), near.max(), FINER)) or best
    return _with_degrees(x, y, best.curve.ends, best.curve.degrees)


def _best_place(x: Array, y: Array, old: Fragments, places: Array) -> Fit | None:
    found = []
    for place in places:
        ends = np.sort(np.append(old.ends, place))
        if np.histogram(x, ends)[0].min() < FEWEST_IN_FRAGMENT:
            continue
        number = int(np.searchsorted(old.breakpoints, place))
        degrees = (*old.degrees[: number + 1], *old.degrees[number:])
        one = fit(x, y, ends, degrees)
        if one is not None:
            found.append(one)
    return min(found, key=_score) if found else None
