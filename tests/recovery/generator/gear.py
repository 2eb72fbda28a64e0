"""Involute geometry of a pair: radii, tooth thickness, path of contact, contact of tip corners outside it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from scipy.optimize import brentq

Array = np.ndarray[Any, Any]
ALPHA = math.radians(20.0)
ADDENDUM, DEDENDUM, RACK_TIP = 1.0, 1.25, 0.3


def inv(angle: Any) -> Any:
    """Involute function tan a - a."""
    return np.tan(angle) - angle


@dataclass(frozen=True)
class Gear:
    """One spur gear; lengths in metres."""

    teeth: int
    module: float
    shift: float
    tip_radius: float
    bore_radius: float
    thinning: float

    @property
    def reference_radius(self) -> float:
        return self.module * self.teeth / 2.0

    @property
    def base_radius(self) -> float:
        return self.reference_radius * math.cos(ALPHA)

    @property
    def root_radius(self) -> float:
        return self.reference_radius + (self.shift - DEDENDUM) * self.module

    @property
    def tip_roll(self) -> float:
        return math.sqrt(self.tip_radius**2 - self.base_radius**2)

    @property
    def form_roll(self) -> float:
        """Roll length at which the rack's rounded tip leaves the involute; 0 where it would undercut."""
        height = (DEDENDUM - RACK_TIP * (1.0 - math.sin(ALPHA)) - self.shift) * self.module
        return max(self.reference_radius * math.sin(ALPHA) - height / math.sin(ALPHA), 0.0)

    def half_angle(self, radius: Any) -> Any:
        """Half the angle that the tooth takes at a radius."""
        start = math.pi / (2 * self.teeth) + 2.0 * self.shift * math.tan(ALPHA) / self.teeth + inv(ALPHA)
        return start - inv(np.arccos(np.minimum(self.base_radius / radius, 1.0))) - self.thinning / self.base_radius

    def disc_inertia(self, width: float, density: float = 7850.0) -> float:
        return 0.5 * math.pi * density * width * (self.reference_radius**4 - self.bore_radius**4)


@dataclass(frozen=True)
class Pair:
    """Two gears at a distance. Pair k touches at the pitch point where the pinion has turned k pitches."""

    pinion: Gear
    wheel: Gear
    centre: float
    width: float
    backlash: float

    @property
    def gears(self) -> tuple[Gear, Gear]:
        return self.pinion, self.wheel

    @property
    def base_sum(self) -> float:
        return self.pinion.base_radius + self.wheel.base_radius

    @property
    def alpha(self) -> float:
        """Working pressure angle."""
        return math.acos(self.base_sum / self.centre)

    @property
    def pitch(self) -> float:
        return 2.0 * math.pi / self.pinion.teeth

    @property
    def base_pitch(self) -> float:
        return self.pitch * self.pinion.base_radius

    @property
    def path(self) -> float:
        """Distance between the two base tangent points."""
        return self.base_sum * math.tan(self.alpha)

    @property
    def contact_ratio(self) -> float:
        return (self.pinion.tip_roll + self.wheel.tip_roll - self.path) / self.base_pitch

    def pitch_roll(self, gear: int) -> float:
        return self.gears[gear].base_radius * math.tan(self.alpha)

    def lowest_roll(self, gear: int) -> float:
        """Roll length of the lowest contact point: where the other gear's tip ends."""
        return self.path - self.gears[1 - gear].tip_roll

    @cached_property
    def corners(self) -> tuple[tuple[Array, Array, Array], tuple[Array, Array, Array]]:
        return _corners(self)


def make_pair(
    teeth: tuple[int, int], module: float, shifts: tuple[float, float], width: float, bores: tuple[float, float], backlash: float
) -> Pair:
    """Return a pair at its distance without backlash, tips shortened to keep the clearance, flanks then moved in."""
    total = sum(teeth)
    target = inv(ALPHA) + 2.0 * sum(shifts) / total * math.tan(ALPHA)
    alpha = brentq(lambda a: math.tan(a) - a - target, 0.05, 1.0)
    reference = module * total / 2.0
    centre = reference * math.cos(ALPHA) / math.cos(alpha)
    short = sum(shifts) * module - (centre - reference)
    gears = []
    for count, shift, bore in zip(teeth, shifts, bores, strict=True):
        tip = module * (count / 2.0 + ADDENDUM + shift) - short
        root = module * (count / 2.0 + shift - DEDENDUM)
        gears.append(Gear(count, module, shift, tip, bore * root, backlash / 4.0))
    return Pair(gears[0], gears[1], centre, width, backlash)


@lru_cache(maxsize=64)
def _corners(pair: Pair) -> tuple[tuple[Array, Array, Array], tuple[Array, Array, Array]]:
    """Tables (way beyond the path's end, lag at touch, roll on the mate) of the pinion's and of the wheel's tip corner.

    The corner's circle is cut with the mate's involute; the lag is how far the wheel trails the conjugate motion there.
    """
    alpha, centre = pair.alpha, pair.centre
    rb1, rb2 = pair.pinion.base_radius, pair.wheel.base_radius
    turn = np.linspace(0.0, 1.6, 400) ** 2 / 1.6
    # pinion corner on the wheel's flank, after the path's end
    s_tip = pair.pinion.tip_roll
    eta = -alpha + math.atan(s_tip / rb1) + turn * pair.pitch
    phi = s_tip / rb1 - math.tan(alpha) + turn * pair.pitch
    x, y = centre - pair.pinion.tip_radius * np.cos(eta), pair.pinion.tip_radius * np.sin(eta)
    roll = np.sqrt(np.maximum(np.hypot(x, y) ** 2 - rb2**2, 1e-12))
    meet = (pair.path - roll) / rb1 - math.tan(alpha)
    phi2 = meet * rb1 / rb2 + np.arctan2(y, x) - alpha + np.arctan(roll / rb2)
    first = (rb1 * (phi - phi[0]), np.maximum.accumulate(rb1 * phi - rb2 * phi2), roll)
    # wheel corner on the pinion's flank, before the path's start
    s_tip = pair.wheel.tip_roll
    back = turn * 2.0 * math.pi / pair.wheel.teeth
    gamma = alpha - math.atan(s_tip / rb2) - back
    start = (pair.path - s_tip) / rb1 - math.tan(alpha)
    phi2 = start * rb1 / rb2 - back
    x, y = centre - pair.wheel.tip_radius * np.cos(gamma), pair.wheel.tip_radius * np.sin(gamma)
    radius = np.hypot(x, y)
    roll = np.sqrt(np.maximum(radius**2 - rb1**2, 1e-12))
    phi = np.arctan2(y, x) + alpha - np.arctan(roll / rb1) + roll / rb1 - math.tan(alpha)
    good = (radius > rb1) & (np.diff(phi, prepend=phi[0] + 1.0) < 0)
    last = len(good) if good.all() else int(np.argmin(good))
    cut = slice(0, max(last, 2))
    second = (-rb1 * (phi[cut] - start), np.maximum.accumulate((rb1 * phi - rb2 * phi2)[cut]), roll[cut])
    return first, second
