"""The flank of a tooth over its roll length: an involute, and one from which metal is missing."""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from gearfem.definition.setup import Gear
from gearfem.flank.deviation import Deviation
from gearfem.foundation import Array, InputError, Record, SolveError
from gearfem.foundation.units import MM

# Metal missing or standing out along the normal, in modules: beyond it a tooth has lost its shape.
DEEPEST, HIGHEST = 0.25, 0.05
SAMPLES = 2049
ITERATIONS = 80


class Side(Protocol):
    """A flank as a curve over the roll length of its nominal involute [m]."""

    def start(self, form_roll: float) -> float:
        """Return the roll length at which the flank meets the form circle."""

    def end(self, start: float) -> tuple[float, float]:
        """Return the roll length at which the tip round begins, and the polar angle of the round's centre."""

    def place(self, roll: Array) -> tuple[Array, Array]:
        """Return radius and polar angle of points."""

    def direction(self, roll: Array) -> Array:
        """Return the polar angle of the outward normal."""

    def curvature(self, roll: Array) -> Array:
        """Return the curvature, positive where the metal is convex."""

    def speed(self, roll: Array) -> Array:
        """Return the arc along the flank per roll length."""

    def arc(self, roll: Array, end: float) -> Array:
        """Return the arc along the flank up to the roll length `end`."""

    def roll_at(self, radius: Array) -> Array:
        """Return the roll lengths at radii."""


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Involute(Record):
    """The nominal flank: Wojnarowski & Onishchenko (2003), eq. 1, moved to the gear's centre.

    Parameters
    ----------
    gear : Gear
        The gear whose flank this is.
    """

    gear: Gear

    def start(self, form_roll: float) -> float:
        """Return the roll length at which the flank meets the form circle: `form_roll` itself."""
        return form_roll

    def end(self, start: float) -> tuple[float, float]:
        """Return where the tip round begins: its centre lies on the circle r_a - rho and on the involute moved in by rho."""
        gear = self.gear
        radius = gear.tip_radius - gear.tip_edge_radius
        if radius <= gear.base_radius:
            raise no_round(gear)
        end = math.sqrt(radius**2 - gear.base_radius**2) + gear.tip_edge_radius
        return end, gear.half_angle(radius) - gear.tip_edge_radius / gear.base_radius

    def place(self, roll: Array) -> tuple[Array, Array]:
        """Return radius [m] and polar angle [rad] of points."""
        ratio = roll / self.gear.base_radius
        return np.hypot(self.gear.base_radius, roll), self.gear.base_half_angle - (ratio - np.arctan(ratio))

    def direction(self, roll: ArrayLike) -> Array:
        """Return the polar angle [rad] of the outward normal; it touches the base circle."""
        return self.gear.base_half_angle - np.asarray(roll, float) / self.gear.base_radius + np.pi / 2.0

    def curvature(self, roll: Array) -> Array:
        """Return the curvature [1/m]."""
        with np.errstate(divide="ignore"):
            return 1.0 / roll

    def speed(self, roll: Array) -> Array:
        """Return the arc along the flank per roll length."""
        return roll / self.gear.base_radius

    def arc(self, roll: Array, end: float) -> Array:
        """Return the arc along the flank up to the roll length `end` [m]."""
        return (end**2 - roll**2) / (2.0 * self.gear.base_radius)

    def roll_at(self, radius: Array) -> Array:
        """Return the roll lengths at radii [m] not below the base radius."""
        return np.sqrt(radius**2 - self.gear.base_radius**2)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class WornInvolute(Record):
    """A flank from which metal is missing along the normal of its involute.

    Parameters
    ----------
    gear : Gear
        The gear whose flank this is.
    deviation : Deviation
        What is missing.

    Raises
    ------
    InputError
        If the depth leaves -0.05 to 0.25 modules, or falls back over the height so steeply that the radius does not rise.

    Notes
    -----
    With the nominal normal direction nu(s) = nu(0) - s/r_b, a flank of depth d(s) is, with q = s - d,

        P = r_b e(nu - pi/2) + q e(nu),    P' = -[d' e(nu) + (q/r_b) e(nu + pi/2)],

    so its radius is that of an involute at the roll length q, and its normal stands at nu - atan(t), t = r_b d'/q.
    The curvature is the turn of the normal per arc, derived here:

        kappa = [1/r_b + t'/(1 + t^2)] / [(q/r_b) sqrt(1 + t^2)],    t' = r_b [d'' q - d' (1 - d')]/q^2.

    The flank begins where its radius is that of the form circle. Rounding apart, all is exact for the spline of the
    deviation; arcs are its integral to 1e-10 of their length.
    """

    gear: Gear
    deviation: Deviation

    def __post_init__(self) -> None:
        super().__post_init__()
        gear, depth = self.gear, self._depths
        for bound, worst in ((DEEPEST, float(depth.max())), (-HIGHEST, float(depth.min()))):
            if abs(worst) > abs(bound) * gear.module and worst * bound > 0.0:
                found = f"a depth of {worst / MM:.4g} mm"
                allowed = f"{-HIGHEST * gear.module / MM:.4g} to {DEEPEST * gear.module / MM:.4g} mm (-0.05 to 0.25 modules)"
                raise InputError("deviation", found, allowed)
        slope = self.deviation.slope(self._samples)
        if slope.max() >= 1.0:
            place = float(self._samples[np.argmax(slope)])
            found = f"a depth that grows by {slope.max():.3g} times the roll length at {place / MM:.4g} mm of it"
            raise InputError("deviation", found, "a growth below 1: the flank's radius has to rise from root to tip")

    @cached_property
    def _tip_roll(self) -> float:
        return math.sqrt(self.gear.tip_radius**2 - self.gear.base_radius**2)

    @cached_property
    def _samples(self) -> Array:
        return np.linspace(0.0, self._tip_roll + DEEPEST * self.gear.module, SAMPLES)

    @cached_property
    def _depths(self) -> Array:
        return self.deviation.at(np.concatenate([self._samples[self._samples <= self._tip_roll], self.deviation.roll]))

    @cached_property
    def bounds(self) -> tuple[float, float]:
        """Least and largest s - q up to the tip circle; past the tip's roll length the depth goes on straight."""
        slope, slack = float(self.deviation.slope(self._samples[-1])), 1e-3 * self.gear.module
        straight = float(self.deviation.at(self._tip_roll)) / (1.0 - slope)
        return min(float(self._depths.min()), straight) - slack, max(float(self._depths.max()), straight) + slack

    def _inner(self, roll: ArrayLike) -> Array:
        """Return q = s - d(s) [m], the roll length of an involute of the same radius."""
        return np.asarray(roll, float) - self.deviation.at(roll)

    def _tilt(self, roll: Array, inner: Array) -> Array:
        """Return t = tan of the angle by which the normal leans towards the tip."""
        return self.gear.base_radius * self.deviation.slope(roll) / inner

    def start(self, form_roll: float) -> float:
        """Return the roll length at which the flank meets the form circle: s - d(s) is that of the unworn flank there."""
        return self._solve(form_roll)

    def _solve(self, inner: float) -> float:
        low, high = self.bounds
        return float(brentq(lambda roll: float(self._inner(roll)) - inner, inner + low, inner + high, xtol=1e-17))

    def end(self, start: float) -> tuple[float, float]:
        """Return where the tip round begins: the first point from which its radius inwards one stands r_a - rho from the centre."""
        gear = self.gear
        target = gear.tip_radius - gear.tip_edge_radius
        rolls = np.linspace(start, self._solve(self._tip_roll), SAMPLES)
        over = np.hypot(*self._round_centre(rolls)) >= target
        first = int(np.argmax(over))
        if target <= gear.base_radius or not over.any() or first == 0:
            raise no_round(gear)
        end = float(brentq(lambda roll: float(np.hypot(*self._round_centre(roll))) - target, rolls[first - 1], rolls[first], xtol=1e-17))
        x, y = self._round_centre(end)
        return end, math.atan2(float(y), float(x))

    def _round_centre(self, roll: ArrayLike) -> tuple[Array, Array]:
        radius, polar = self.place(np.asarray(roll, float))
        direction, edge = self.direction(roll), self.gear.tip_edge_radius
        return radius * np.cos(polar) - edge * np.cos(direction), radius * np.sin(polar) - edge * np.sin(direction)

    def place(self, roll: Array) -> tuple[Array, Array]:
        """Return radius [m] and polar angle [rad] of points."""
        base, inner = self.gear.base_radius, self._inner(roll)
        return np.hypot(base, inner), self.gear.base_half_angle - (roll / base - np.arctan(inner / base))

    def direction(self, roll: ArrayLike) -> Array:
        """Return the polar angle [rad] of the outward normal."""
        roll = np.asarray(roll, float)
        nominal = self.gear.base_half_angle - roll / self.gear.base_radius + np.pi / 2.0
        turned: Array = nominal - np.arctan(self._tilt(roll, self._inner(roll)))
        return turned

    def curvature(self, roll: Array) -> Array:
        """Return the curvature [1/m], negative in a hollow."""
        base, inner = self.gear.base_radius, self._inner(roll)
        slope, tilt = self.deviation.slope(roll), self._tilt(roll, inner)
        change = base * (self.deviation.bend(roll) * inner - slope * (1.0 - slope)) / inner**2
        turn: Array = 1.0 / base + change / (1.0 + tilt**2)
        return turn / (inner / base * np.sqrt(1.0 + tilt**2))

    def speed(self, roll: Array) -> Array:
        """Return the arc along the flank per roll length."""
        return np.hypot(self.deviation.slope(roll), self._inner(roll) / self.gear.base_radius)

    @cached_property
    def _arcs(self) -> CubicSpline:
        spline: CubicSpline = CubicSpline(self._samples, self.speed(self._samples)).antiderivative()
        return spline

    def arc(self, roll: Array, end: float) -> Array:
        """Return the arc along the flank up to the roll length `end` [m]."""
        return np.asarray(self._arcs(end) - self._arcs(roll))

    def roll_at(self, radius: Array) -> Array:
        """Return the roll lengths at radii [m] not below that of the form circle."""
        inner = np.sqrt(radius**2 - self.gear.base_radius**2)
        low, high = inner + self.bounds[0], inner + self.bounds[1]
        roll: Array = np.clip(inner + self.deviation.at(inner), low, high)
        for _ in range(ITERATIONS):
            missing = inner - self._inner(roll)
            low, high = np.where(missing > 0.0, roll, low), np.where(missing < 0.0, roll, high)
            newton = roll + missing / (1.0 - self.deviation.slope(roll))
            following = np.where((newton >= low) & (newton <= high), newton, (low + high) / 2.0)
            step, roll = np.abs(following - roll).max(initial=0.0), following
            if step < 1e-15:
                return roll
        raise SolveError("the roll length of a worn flank at a radius did not converge")


def no_round(gear: Gear) -> InputError:
    """Return the refusal of a tip round that leaves no flank."""
    return InputError("tip_edge_radius_mm", f"{gear.tip_edge_radius / MM:g} mm", "a radius that leaves a flank and a tip land")
