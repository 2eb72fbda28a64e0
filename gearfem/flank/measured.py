"""From measured points of a flank to a smooth deviation: outliers named, fragments fitted, one cubic spline."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from gearfem.definition.measured_flank import MeasuredFlank
from gearfem.definition.measured_points import FEWEST
from gearfem.definition.setup import Gear, Setup
from gearfem.flank.deviation import Deviation
from gearfem.flank.fragments import DEGREES, Fit, Fragments, choose
from gearfem.flank.outline import Outline
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.cache import remembered
from gearfem.foundation.units import MM, UM

# Clean points of one flank are to hold no outlier in 99 of 100 flanks.
FALSE_ALARM = 0.01
# Residuals of the first, robust fit beyond so many of its standard deviations are left out until they prove themselves.
GROSS = 6.0
MOST_KEPT = 0.75
# Less than the roughness of a ground flank and the repeatability of the finest machines is no outlier.
SMALLEST_OUTLIER = 1e-6
ROUNDS = 20
# A point that stands out of its neighbours by less than this share of its residual belongs to a feature that the curve misses.
ALIKE = 0.25
# Beyond the points the slope of the fit runs out over this share of their length.
RUN_OUT = 0.05
NORMAL_MAD = 1.4826


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class FittedFlank(Record):
    """What measured points say of a flank.

    Parameters
    ----------
    points : MeasuredFlank
        As measured.
    curve : Fragments
        Polynomials through the points on the flank, metal missing over roll length [m].
    deviation : Deviation
        The same as one cubic spline from the base circle to the tip, run out to constants beyond the points.
    row : ndarray of int, shape (n,)
        Rows in the file of the points on the flank, in the order of their roll lengths.
    roll, depth, residual : ndarray, shape (n,)
        Those points and what they stand deeper than the curve [m], outliers included.
    kept : ndarray of bool, shape (n,)
        False for outliers.
    aside : ndarray of int, shape (k,)
        Rows on fillet, root and tip round, which stay as they are.
    residual_std : float
        Standard deviation of the kept points about the curve, fitted quantities counted [m].
    cross_validation : float
        Root mean square error of the kept points, each against the curve fitted without it [m].
    spline_error : float
        Largest distance of the spline from the polynomials between its nodes [m].
    """

    points: MeasuredFlank
    curve: Fragments
    deviation: Deviation
    row: NDArray[np.int_]
    roll: Array
    depth: Array
    residual: Array
    kept: NDArray[np.bool_]
    aside: NDArray[np.int_]
    residual_std: float
    cross_validation: float
    spline_error: float

    @property
    def outliers(self) -> tuple[int, ...]:
        """Rows in the file of the points that the curve does not follow."""
        return tuple(sorted(self.row[~self.kept].tolist()))

    @property
    def largest_gap(self) -> float:
        """Longest stretch between kept points, where the curve is a guess [m]."""
        return float(np.diff(self.roll[self.kept]).max())

    @property
    def sentence(self) -> str:
        """All of it in one line."""
        breaks = ", ".join(f"{place / MM:.2f}" for place in self.curve.breakpoints)
        outliers = ", ".join(map(str, self.outliers))
        return (
            f"Flank of the {self.points.name}: {self.roll.size} points from {self.roll[0] / MM:.2f} to {self.roll[-1] / MM:.2f} mm of roll "
            f"length, {len(self.curve.coefficients)} fragment(s) of degree {', '.join(map(str, self.curve.degrees))}"
            + (f" joined at {breaks} mm" if breaks else "")
            + f"; residual standard deviation {self.residual_std / UM:.3g} um, cross-validation {self.cross_validation / UM:.3g} um; "
            + (f"outliers in rows {outliers}" if outliers else "no outliers")
            + f"; {self.aside.size} points on fillet or tip left aside; longest gap {self.largest_gap / MM:.2f} mm."
        )


@remembered
def fit_flank(points: MeasuredFlank, gear: Gear) -> FittedFlank:
    """Return the smooth deviation that measured points of a flank support.

    Parameters
    ----------
    points : MeasuredFlank
        At least 8 of them between form circle and tip form circle.
    gear : Gear
        Nominal gear.

    Returns
    -------
    FittedFlank

    Raises
    ------
    InputError
        If fewer than 8 points lie on the flank, or are left by the outliers.

    Notes
    -----
    Fragments, degrees 4 to 6 and breakpoints: `gearfem.flank.fragments.choose`. Outliers: a robust fit (one fragment of
    degree 6, Huber's weights, scale from the median) leaves out gross ones; then every point is tested against the curve
    fitted without it, t = e/(s sqrt(1 - h)) for a point left in and e/(s sqrt(1 + h)) for one left out, at 1 % per flank
    (Student's t, Bonferroni), and the fit is repeated until the same points stay in. A point that strays as its neighbours
    do shows what the curve misses and is no outlier: one that stands out of the middle two of its four neighbours by less
    than half that limit, or than a quarter of its residual; so is one within 1 um. A feature of one or two points cannot be
    told from outliers and is named as such.

    The noise may be of any size: it is estimated from the points and assumed equal and independent. Where neighbours err
    alike (digitised pictures), the curve follows their common error, and the standard deviation holds only what is left.
    Beyond the points the end slope m runs out parabolically over a twentieth of their length L, m (x - x^2/(0.1 L)), then the
    deviation is constant.
    """
    outline = Outline(gear=gear)
    order = np.argsort(points.roll, kind="stable")
    # s - d is the roll length of the involute at the point's radius: form and tip form circle stay where they are.
    inner = points.roll[order] - points.depth[order]
    on_flank = order[(inner >= outline.flank_start) & (inner <= outline.flank_end)]
    _refuse_few(points, on_flank.size, "on the flank", outline)
    roll, depth = points.roll[on_flank], points.depth[on_flank]
    kept, found = _kept(points, outline, roll, depth)
    deviation, error = _spline(found.curve, gear)
    return FittedFlank(
        points=points,
        curve=found.curve,
        deviation=deviation,
        row=points.row[on_flank],
        roll=roll,
        depth=depth,
        residual=depth - found.curve.at(roll),
        kept=kept,
        aside=np.sort(np.concatenate([np.setdiff1d(points.row, points.row[on_flank]), points.below])),
        residual_std=found.std,
        cross_validation=float(np.sqrt(np.mean(found.left_out**2))),
        spline_error=error,
    )


def fitted_flanks(setup: Setup) -> tuple[FittedFlank, ...]:
    """Return the fits of all flanks that a model gives as measured, in its order."""
    return tuple(fit_flank(points, setup.pair.gear(points.member)) for points in setup.flanks_given)


def _refuse_few(points: MeasuredFlank, number: int, where: str, outline: Outline) -> None:
    if number < FEWEST:
        ends = f"from {outline.flank_start / MM:.3f} to {outline.flank_end / MM:.3f} mm of roll length"
        raise InputError(f"flank of the {points.name}", f"{number} points {where}", f"at least {FEWEST} on the flank, {ends}")


def _kept(points: MeasuredFlank, outline: Outline, roll: Array, depth: Array) -> tuple[NDArray[np.bool_], Fit]:
    """Return which points are no outliers, and the fit to them."""
    kept = _without_gross(roll, depth)
    for _ in range(ROUNDS):
        found = choose(roll[kept], depth[kept])
        wanted = _follows(found, roll, depth, kept)
        _refuse_few(points, int(wanted.sum()), "left by outliers", outline)
        if (wanted == kept).all():
            return kept, found
        kept = wanted
    # The last two rounds disagree about a point at the limit: it counts as an outlier.
    kept = kept & _follows(found, roll, depth, kept)
    _refuse_few(points, int(kept.sum()), "left by outliers", outline)
    return kept, choose(roll[kept], depth[kept])


def _without_gross(roll: Array, depth: Array) -> NDArray[np.bool_]:
    """Return the points near a robust polynomial, which may be too stiff: its misfit widens the scale."""
    ends, weight = roll[[0, -1]], np.ones(roll.size)
    degree = min(DEGREES[-1], roll.size // 3)
    for _ in range(50):
        found = np.polynomial.Legendre.fit(roll, depth, degree, domain=ends.tolist(), w=np.sqrt(weight))
        away = np.abs(depth - found(roll))
        spread = float(np.median(away)) * np.sqrt(roll.size / (roll.size - degree - 1))
        scale = max(NORMAL_MAD * spread, SMALLEST_OUTLIER / GROSS)
        weight = np.minimum(1.0, 1.345 * scale / np.maximum(away, scale))
    near = away <= GROSS * scale
    # Where this polynomial leaves out so many, it is the polynomial that is wrong.
    return np.asarray(near if near.mean() > MOST_KEPT and near.sum() >= FEWEST else np.ones_like(near))


def _follows(found: Fit, roll: Array, depth: Array, kept: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Say which points agree with the curve fitted without them, or stray from it together with their neighbours."""
    away = depth - found.curve.at(roll)
    leverage = np.where(kept, np.minimum(found.leverage_at(roll), 1.0 - 1e-6), found.leverage_at(roll))
    free = max(int(kept.sum()) - found.fitted - 1, 1)
    limit = student.isf(0.5 * FALSE_ALARM / roll.size, free)
    square = found.std**2 * (free + 1)
    # Deletion residuals: without point i the sum of squares falls by e_i^2/(1 - h_i).
    left = np.where(kept, (square - away**2 / (1.0 - np.where(kept, leverage, 0.0))) / free, found.std**2)
    width = np.where(kept, 1.0 - leverage, 1.0 + leverage)
    farthest = np.maximum(limit * np.sqrt(np.maximum(left, 0.0) * width), SMALLEST_OUTLIER)
    return np.asarray((np.abs(away) <= farthest) | (_apart(away) <= np.maximum(0.5 * farthest, ALIKE * np.abs(away))))


def _apart(values: Array) -> Array:
    """Return how far each value stands out of the middle two of the four around it, or nearest to it at an end."""
    around = np.arange(values.size)[:, None] + np.array([-2, -1, 1, 2])
    around = np.where(around < 0, around + 5, np.where(around >= values.size, around - 5, around))
    low, high = np.sort(values[around], axis=1)[:, 1:3].T
    return np.asarray(np.maximum(np.maximum(values - high, low - values), 0.0))


def _spline(curve: Fragments, gear: Gear) -> tuple[Deviation, float]:
    """Return the deviation over the whole flank, and its largest distance from the curve where there are points."""
    nodes = Deviation.none(gear).roll
    deviation = Deviation(roll=nodes, depth=extended(curve, nodes))
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    return deviation, float(np.abs(deviation.at(middle) - extended(curve, middle)).max())


def extended(curve: Fragments, roll: Array) -> Array:
    """Return the curve between its ends; beyond them its end slopes run out and it stays constant [m]."""
    low, high = curve.ends[0], curve.ends[-1]
    length = RUN_OUT * (high - low)
    inside = np.clip(roll, low, high)
    beyond = np.clip(roll - inside, -length, length)
    return np.asarray(curve.at(inside) + curve.at(inside, 1) * (beyond - beyond * np.abs(beyond) / (2.0 * length)))
