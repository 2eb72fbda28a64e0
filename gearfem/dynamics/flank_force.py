"""Force and arms of the flanks in engagement, smooth between the samples of the engagement stage."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from gearfem.engagement.record import MeshForce
from gearfem.foundation import Array, InputError, Record

SUPPORT = 3
ON_REVERSAL = 1e-6


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class FlankForce(Record):
    """Normal force, arms and friction arms over pinion angle and deflection.

    The deflection d = e - e_u counts from first touch, so that the onset of contact is one column for all angles.

    Parameters
    ----------
    start, step, period : float
        First angle, spacing and period [rad].
    deflection : ndarray, shape (m,)
        Knots, from 0 [m].
    coefficients : ndarray, shape (n, m - 1, 4, 4, 5)
        Powers of the place in the angle cell, then in the deflection cell; of force [N], arms 1 and 2,
        friction arms 1 and 2 [m] with their jumps taken out.
    reversals : ndarray, shape (k,)
        Angles of the jumps [rad].
    jumps : ndarray, shape (k, 3, m - 1, 4, 2)
        Jumps of the two friction arms and of their first two slopes over the angle at each reversal, in powers of the
        place in the deflection cell [m, m/rad, m/rad2].
    """

    start: float
    step: float
    period: float
    deflection: Array
    coefficients: Array
    reversals: Array
    jumps: Array

    def __call__(self, angle: Array, deflection: Array, middle: Array | float, friction: bool) -> tuple[Array, Array]:
        """Return force, arms and friction arms, and their slopes over the deflection.

        Parameters
        ----------
        angle, deflection : ndarray, shape (...)
            Pinion angle [rad] and deflection [m]. The force is continued linearly, the arms constantly, beyond the knots
            on either side: whether a negative force counts is for the caller to say.
        middle : ndarray, shape (...)
            An angle within the same interval between two reversals: tells the side at a reversal itself.
        friction : bool
            Whether the jumps of the friction arms are wanted.

        Returns
        -------
        values, slopes : ndarray, shape (..., 5)
            [N, m, m, m, m] and the same per metre.
        """
        place = (np.asarray(angle) - self.start) / self.step
        whole = np.floor(place)
        row = whole.astype(int) % self.coefficients.shape[0]
        inside = np.minimum(np.maximum(deflection, 0.0), self.deflection[-1])
        column = np.clip(np.searchsorted(self.deflection, inside, side="right") - 1, 0, self.deflection.size - 2)
        width = self.deflection[column + 1] - self.deflection[column]
        u = (place - whole)[..., None, None]
        s = ((inside - self.deflection[column]) / width)[..., None]
        over = self.coefficients[row, column]
        cubic = ((over[..., 3, :, :] * u + over[..., 2, :, :]) * u + over[..., 1, :, :]) * u + over[..., 0, :, :]
        values = ((cubic[..., 3, :] * s + cubic[..., 2, :]) * s + cubic[..., 1, :]) * s + cubic[..., 0, :]
        slopes = ((3.0 * cubic[..., 3, :] * s + 2.0 * cubic[..., 2, :]) * s + cubic[..., 1, :]) / width[..., None]
        if friction:
            for reversal, jump in zip(self.reversals, self.jumps, strict=True):
                teeth = _sawteeth(angle, middle, reversal, self.period)
                c = sum(tooth[..., None, None] * rise[column] for tooth, rise in zip(teeth, jump, strict=True))
                values[..., 3:] += ((c[..., 3, :] * s + c[..., 2, :]) * s + c[..., 1, :]) * s + c[..., 0, :]
                slopes[..., 3:] += ((3.0 * c[..., 3, :] * s + 2.0 * c[..., 2, :]) * s + c[..., 1, :]) / width[..., None]
        beyond = deflection - inside
        values[..., 0] += slopes[..., 0] * beyond
        slopes[..., 1:] *= (beyond == 0.0)[..., None]
        return values, slopes

    def sections(self, angle: Array, middle: Array, friction: bool) -> Array:
        """Return the powers over the place in the deflection cell at given angles, shape (p, m - 1, 4, 5).

        Parameters
        ----------
        angle, middle : ndarray, shape (p,)
            As in a call [rad].
        friction : bool
            As in a call.

        Returns
        -------
        ndarray
            Of what a call evaluates, so that both give the same values to rounding.
        """
        place = (angle - self.start) / self.step
        whole = np.floor(place)
        row = whole.astype(int) % self.coefficients.shape[0]
        u = (place - whole)[:, None, None, None]
        powers = self.coefficients[row, :, 3]
        for order in (2, 1, 0):
            powers = powers * u + self.coefficients[row, :, order]
        if friction:
            for reversal, jump in zip(self.reversals, self.jumps, strict=True):
                for tooth, rise in zip(_sawteeth(angle, middle, reversal, self.period), jump, strict=True):
                    powers[..., 3:] += tooth[:, None, None, None] * rise
        sections: Array = powers
        return sections


@functools.lru_cache(maxsize=8)
def flank_force(mesh: MeshForce) -> FlankForce:
    """Return the interpolant of the forces of a mesh.

    Parameters
    ----------
    mesh : MeshForce
        Tables over angle and transmission error.

    Returns
    -------
    FlankForce

    Raises
    ------
    InputError
        If the tables touch below the unloaded error, never touch, or have too few angles beside a reversal.

    Notes
    -----
    One mesh gets one object. Each row is moved to start at its own unloaded error. Over the angle periodic cubic splines,
    over the deflection cubic pieces with the slopes of parabolas through three knots: h^4 and h^3 for a smooth table, h where
    a pair enters.
    All is linear in the tables, so proportional tables stay proportional. Friction arms jump at the reversals, and so do
    their slopes: the jumps are the differences of the parabolas through three samples on either side (h^3), they are
    taken out as periodic sawteeth (Bernoulli polynomials) and put back exactly at the stated angle; a sample on a
    reversal itself is not used.
    """
    knots = _knots(mesh)
    tables = _moved(mesh, knots)
    offsets = (mesh.sliding_reversals - mesh.pinion_angle[0]) % mesh.period
    reversals = mesh.pinion_angle[0] + np.sort(offsets)
    jumps = _take_out_jumps(mesh, tables, reversals)
    over_angle = np.concatenate([tables, np.gradient(tables, knots, axis=1, edge_order=2)], axis=2)
    ends = np.append(mesh.pinion_angle, mesh.pinion_angle[0] + mesh.period)
    step = mesh.period / mesh.pinion_angle.size
    pieces = CubicSpline(ends, np.concatenate([over_angle, over_angle[:1]]), bc_type="periodic").c[::-1]
    powers = np.moveaxis(pieces * step ** np.arange(4)[:, None, None, None], 0, 1)
    return FlankForce(
        start=float(mesh.pinion_angle[0]),
        step=step,
        period=mesh.period,
        deflection=knots,
        coefficients=np.moveaxis(_hermite(powers[..., :5], powers[..., 5:], knots), 1, 2),
        reversals=reversals,
        jumps=_hermite(jumps, np.gradient(jumps, knots, axis=2, edge_order=2), knots),
    )


def _knots(mesh: MeshForce) -> Array:
    touching = mesh.normal_force.max(axis=0) > 0.0
    if not touching[-1]:
        raise InputError(
            "mesh force, normal_force", "no contact at the largest deflection", "a table that reaches above the operating load"
        )
    first = int(np.argmax(touching))
    origin = mesh.deflection[first - 1] if first > 0 else min(float(mesh.unloaded_error.min()), float(mesh.deflection[0]))
    knots = mesh.deflection[mesh.deflection > origin] - origin
    if knots.size < 3:
        raise InputError("mesh force, deflection", f"{knots.size} columns in contact", "at least 3")
    return np.concatenate([[0.0], knots])


def _moved(mesh: MeshForce, knots: Array) -> Array:
    """Return force, arms and friction arms, shape (n, m, 5), over the deflection from first touch."""
    sources = (mesh.normal_force, mesh.pinion_moment, mesh.wheel_moment, mesh.pinion_friction, mesh.wheel_friction)
    tables = np.empty((mesh.pinion_angle.size, knots.size, 5))
    for row, onset in enumerate(mesh.unloaded_error):
        above = mesh.deflection > onset + 1e-9 * knots[-1]
        if mesh.normal_force[row, ~above].max(initial=0.0) > 1e-6 * mesh.normal_force[row].max():
            raise InputError("mesh force, unloaded_error", f"force below it at row {row}", "tables that are zero up to the unloaded error")
        force = mesh.normal_force[row, above]
        if above.sum() < 2 or force.max() <= 0.0:
            raise InputError("mesh force, normal_force", f"fewer than two columns in contact at row {row}", "a table that reaches higher")
        own = np.concatenate([[0.0], mesh.deflection[above] - onset])
        held = np.maximum.accumulate(np.where(force > 0.0, np.arange(force.size), np.argmax(force > 0.0)))
        tables[row, :, 0] = _along(knots, own, np.concatenate([[0.0], force]))
        for which, source in enumerate(sources[1:], start=1):
            arm = source[row, above][held] / force[held]
            tables[row, :, which] = np.interp(knots, own, np.concatenate([arm[:1], arm]))
    return tables


def _along(knots: Array, own: Array, force: Array) -> Array:
    """Return the force of one row at the common knots: piecewise linear, and so beyond the last column."""
    slope = (force[-1] - force[-2]) / (own[-1] - own[-2])
    values: Array = np.interp(knots, own, force) + slope * np.maximum(knots - own[-1], 0.0)
    return values


def _take_out_jumps(mesh: MeshForce, tables: Array, reversals: Array) -> Array:
    """Remove the jumps of the friction arms and their slopes from `tables` in place and return them, shape (k, 3, m, 2)."""
    count = mesh.pinion_angle.size
    step = mesh.period / count
    places = (reversals - mesh.pinion_angle[0]) / step
    gaps = np.diff(np.append(places, places[:1] + count))
    if places.size and gaps.min() < 2 * SUPPORT + 1:
        raise InputError(
            "mesh force, sliding_reversals", f"{gaps.min():.1f} angle steps apart", f"at least {2 * SUPPORT + 1}: take more angles"
        )
    friction = tables[:, :, 3:]
    jumps = np.empty((places.size, SUPPORT, tables.shape[1], 2))
    for k, place in enumerate(places):
        below = math.ceil(place - ON_REVERSAL) - 1
        above = math.floor(place + ON_REVERSAL) + 1
        before = _extrapolate(friction, below - np.arange(SUPPORT)[::-1], place, step)
        after = _extrapolate(friction, above + np.arange(SUPPORT), place, step)
        jumps[k] = after - before
        if above - below == 2:
            friction[(below + 1) % count] = 0.5 * (before[0] + after[0])
    for reversal, place, jump in zip(reversals, places, jumps, strict=True):
        teeth = _sawteeth(mesh.pinion_angle, mesh.pinion_angle, reversal, mesh.period)
        on = round(place)
        if abs(place - on) <= ON_REVERSAL:
            teeth[0][on % count] = 0.0
        for tooth, rise in zip(teeth, jump, strict=True):
            friction -= tooth[:, None, None] * rise
    return jumps


def _extrapolate(friction: Array, rows: NDArray[np.int_], place: float, step: float) -> Array:
    """Return value, slope and curvature over the angle, shape (3, m, 2), of the parabola through three rows, at a fractional row."""
    basis = np.linalg.inv(np.vander(rows - place, SUPPORT, increasing=True))
    scale = np.array([1.0, 1.0, 2.0]) / step ** np.arange(SUPPORT)
    value: Array = np.tensordot(scale[:, None] * basis, friction[rows % friction.shape[0]], axes=1)
    return value


def _sawteeth(angle: Array, middle: Array | float, reversal: float, period: float) -> tuple[Array, Array, Array]:
    """Return periodic functions whose value, slope or curvature alone rises by 1 at the reversal, on the side of `middle`.

    -period^n B_{n+1}(t)/(n+1)!, B the Bernoulli polynomials, t the place in the period after the reversal.
    """
    t = np.asarray((angle - reversal) / period - np.floor((middle - reversal) / period))
    return 0.5 - t, -period * (t * (t - 1.0) + 1.0 / 6.0) / 2.0, -(period**2) * t * (t - 0.5) * (t - 1.0) / 6.0


def _hermite(values: Array, slopes: Array, knots: Array) -> Array:
    """Return the powers, shape (..., m - 1, 4, t), of the cubics with values and slopes (..., m, t) at the knots."""
    width = np.diff(knots)[:, None]
    left, right = values[..., :-1, :], values[..., 1:, :]
    start, end = slopes[..., :-1, :] * width, slopes[..., 1:, :] * width
    rise = right - left
    return np.stack([left, start, 3.0 * rise - 2.0 * start - end, start + end - 2.0 * rise], axis=-2)
