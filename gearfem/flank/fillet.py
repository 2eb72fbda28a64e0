"""The fillet that the rack's tip round leaves between root circle and flank."""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property

import numpy as np
from scipy.optimize import brentq
from scipy.special import hyp2f1

from gearfem.definition.setup import Gear
from gearfem.foundation import Array, Record

# Absolute step at which a root search ends [rad]: none, so that small roots keep all digits.
FINEST = 1e-300


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Fillet(Record):
    """Trochoid of the rack's rounded tip, up to where the involute begins.

    Parameters
    ----------
    gear : Gear
        The gear whose fillet this is.

    Notes
    -----
    In the frame that rolls, the round of radius rho has its centre (zeta_c, eta_c) from the pitch line and the
    middle of the space; its point with the normal d = (-cos b, sin b) generates the fillet when the normal passes
    through the pitch point: r psi = -zeta_c tan b - eta_c. b runs from 0 (root circle) to pi/2 - alpha (flank of the
    rack), where the fillet meets the involute unless it undercuts it; then both end where they cross. Derived here.
    """

    gear: Gear

    @cached_property
    def rack_tip_radius(self) -> float:
        """Radius of the rack's tip round [m]."""
        return self.gear.rack.tip_radius * self.gear.module

    @cached_property
    def round_height(self) -> float:
        """Centre of the rack's tip round above the pitch line, zeta_c [m]."""
        return self.gear.root_radius - self.gear.reference_radius + self.rack_tip_radius

    @cached_property
    def round_tangential(self) -> float:
        """Centre of the rack's tip round from the middle of the space, eta_c [m]."""
        gear = self.gear
        alpha, shift = gear.pressure_angle, gear.profile_shift * gear.module
        half_datum = math.pi * gear.module / 4.0 + gear.flank_thinning / math.cos(alpha)
        depth = shift - self.round_height
        return half_datum - depth * math.tan(alpha) - self.rack_tip_radius / math.cos(alpha)

    @property
    def largest_rack_tip_radius(self) -> float:
        """Largest tip round of the rack, in modules, that fits its tooth."""
        alpha = self.gear.pressure_angle
        slope = (1.0 - math.sin(alpha)) / math.cos(alpha)
        return (self.round_tangential + self.rack_tip_radius * slope) / slope / self.gear.module

    def place(self, direction: Array) -> tuple[Array, Array]:
        """Return radius [m] and polar angle [rad] (..., 2) and the rolling angle [rad], for normal directions b [rad]."""
        gear = self.gear
        rolled = (-self.round_height * np.tan(direction) - self.round_tangential) / gear.reference_radius
        x = gear.reference_radius + self.round_height - self.rack_tip_radius * np.cos(direction)
        y = -self.round_height * np.tan(direction) + self.rack_tip_radius * np.sin(direction)
        # Turn from the rack's frame into that of the space, then mirror into that of the tooth.
        polar = np.pi / gear.teeth - (np.arctan2(y, x) - rolled)
        return np.stack([np.hypot(x, y), polar], axis=-1), rolled

    def speed(self, direction: Array) -> Array:
        """Return the arc [m] towards the flank per normal direction b [rad]: the centre of the round turns about the pitch point."""
        turning = -self.round_height / (self.gear.reference_radius * np.cos(direction) ** 2)
        arc: Array = self.rack_tip_radius * (1.0 + turning) - self.round_height / np.cos(direction) * turning
        return arc

    @cached_property
    def end(self) -> tuple[float, float]:
        """Last normal direction b of the fillet [rad] and the roll length of the involute there [m].

        Where the undercut is slight, both curves leave the base circle almost along the same line: the crossing is sought as a
        turn away from the end of the rack's round, in differences written out so that no digits cancel.
        """
        last = math.pi / 2.0 - self.gear.pressure_angle
        roll = -self._past_base(0.0)[0]
        if roll > 0.0:
            return last, roll

        def above_base(turn: float) -> float:
            return self._past_base(turn)[1]

        # Undercut: on the base circle the trochoid lies inside the involute, at its end outside; between, they cross.
        first = float(brentq(above_base, 0.0, last, xtol=FINEST))
        cross = float(brentq(self._outside_involute, 0.0, first, xtol=FINEST)) if self._outside_involute(first) < 0.0 else first
        return last - cross, math.sqrt(max(above_base(cross), 0.0))

    def _past_base(self, turn: float) -> tuple[float, float]:
        """Return the fillet's way past the foot of its normal on the base tangent [m] and the square of its roll length [m^2].

        The turn [rad] leads from the direction of the rack's flank towards the root, b = pi/2 - alpha - turn.
        """
        reference, alpha = self.gear.reference_radius, self.gear.pressure_angle
        sine, turned = math.sin(alpha), math.sin(alpha + turn)
        at_end = self.rack_tip_radius - self.round_height / sine - reference * sine
        rise = 2.0 * math.cos(alpha + turn / 2.0) * math.sin(turn / 2.0)
        past = at_end + rise * (self.round_height / (sine * turned) - reference)
        return past, past**2 - reference**2 * math.sin(turn) * math.sin(2.0 * alpha + turn)

    def _outside_involute(self, turn: float) -> float:
        """Return the angle by which the fillet stands outside the involute of its radius [rad]; negative where it cuts into it."""
        reference, alpha, base = self.gear.reference_radius, self.gear.pressure_angle, self.gear.base_radius
        at_end = self._past_base(0.0)[0]
        past, square = self._past_base(turn)
        rolled = self.round_height * math.sin(turn) / (reference * math.sin(alpha) * math.sin(alpha + turn))
        widened = 2.0 * math.sin(alpha + turn / 2.0) * math.sin(turn / 2.0) / math.cos(alpha + turn)
        lag = _arctan_lag(past / (reference * math.cos(alpha + turn))) + _arctan_lag(math.sqrt(max(square, 0.0)) / base)
        return rolled - turn + (at_end - past * (1.0 + widened)) / base + lag

    @property
    def undercut(self) -> bool:
        """Whether the fillet cuts into the involute."""
        return self.end[0] < math.pi / 2.0 - self.gear.pressure_angle


def _arctan_lag(ratio: float) -> float:
    """Return t - arctan(t), which starts as t^3/3, without loss of digits."""
    return float(ratio**3 / 3.0 * hyp2f1(1.0, 1.5, 2.5, -(ratio**2)))
