"""The outline of one side of an unworn tooth: root arc, fillet, involute, tip round, tip arc."""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from gearfem.definition.setup import Gear
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.units import MM

ROOT, FILLET, FLANK, ROUND, TIP, END = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0
# Loads act from FLANK to here: past the middle of its tip round a tooth has left its mate by a tenth of the module.
LOADED_END = 3.5


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Outline(Record):
    """One side of a tooth as a curve over a parameter u from the middle of the space to the tip's middle.

    The tooth's axis of symmetry is the x axis, the gear's centre the origin, and the side with y > 0 is
    described; the other side is its mirror image. The parameter runs over five segments of unit length:
    root arc [0, 1], fillet [1, 2], flank [2, 3], tip round [3, 4] and tip arc [4, 5]. On the flank u is
    linear in the roll length, on the fillet in the direction of the rack's normal, on the arcs in the angle.

    Parameters
    ----------
    gear : Gear
        The gear whose tooth this is.

    Raises
    ------
    InputError
        If the rack's tip round is too large for its tooth, the tip is pointed, or the tip round does not fit.

    Notes
    -----
    Involute: Wojnarowski & Onishchenko (2003), eq. 1, moved to the gear's centre. Fillet: envelope of the
    rack's tip round, derived here. In the frame that rolls, the round of radius rho has its centre
    (zeta_c, eta_c) from the pitch line and the middle of the space; its point with the normal d =
    (-cos b, sin b) generates the fillet when the normal passes through the pitch point:
    r psi = -zeta_c tan b - eta_c. b runs from 0 (root circle) to pi/2 - alpha (flank of the rack), where
    the fillet meets the involute unless it undercuts it; then both end where they cross.

    Examples
    --------
    >>> from gearfem.definition.setup import Material, Rack
    >>> gear = Gear(teeth=17, module=1e-3, pressure_angle=math.radians(20), profile_shift=0.0, flank_thinning=0.0,
    ...             root_radius=7.25e-3, tip_radius=9.5e-3, tip_edge_radius=2e-5, bore_radius=4e-3, rack=Rack(),
    ...             material=Material())
    >>> outline = Outline(gear=gear)
    >>> bool(np.hypot(*outline.point(5.0)) == gear.tip_radius)
    True
    """

    gear: Gear

    def __post_init__(self) -> None:
        super().__post_init__()
        gear = self.gear
        if self._round_tangential < -1e-12 * gear.module:
            limit = self._largest_rack_tip_radius()
            found = f"{gear.rack.tip_radius:g} modules"
            raise InputError("rack.tip_radius", found, f"at most {limit:.4f} modules, where the rack's tip has no land left")
        if gear.half_angle(gear.tip_radius) <= 0.0:
            allowed = "a tip circle on which the tooth still has a thickness: the tooth is pointed below it"
            raise InputError("tip_radius_mm", f"{gear.tip_radius / MM:.4f} mm", allowed)
        below = gear.tip_radius - gear.tip_edge_radius <= gear.base_radius
        if below or self.flank_end <= self.flank_start or self._round_angle <= 0.0:
            raise InputError("tip_edge_radius_mm", f"{gear.tip_edge_radius / MM:g} mm", "a radius that leaves a flank and a tip land")

    # ---- rack tip round -------------------------------------------------------------------------

    @cached_property
    def _rack_tip_radius(self) -> float:
        return self.gear.rack.tip_radius * self.gear.module

    @cached_property
    def _round_height(self) -> float:
        """Centre of the rack's tip round above the pitch line (zeta_c)."""
        return self.gear.root_radius - self.gear.reference_radius + self._rack_tip_radius

    @cached_property
    def _round_tangential(self) -> float:
        """Centre of the rack's tip round from the middle of the space (eta_c)."""
        gear = self.gear
        alpha, shift = gear.pressure_angle, gear.profile_shift * gear.module
        half_datum = math.pi * gear.module / 4.0 + gear.flank_thinning / math.cos(alpha)
        depth = shift - self._round_height
        return half_datum - depth * math.tan(alpha) - self._rack_tip_radius / math.cos(alpha)

    def _largest_rack_tip_radius(self) -> float:
        alpha = self.gear.pressure_angle
        slope = (1.0 - math.sin(alpha)) / math.cos(alpha)
        return (self._round_tangential + self._rack_tip_radius * slope) / slope / self.gear.module

    def _trochoid(self, direction: Array) -> tuple[Array, Array]:
        """Return fillet points in the tooth's frame and the rolling angle, for normal directions b [rad]."""
        gear = self.gear
        rolled = (-self._round_height * np.tan(direction) - self._round_tangential) / gear.reference_radius
        x = gear.reference_radius + self._round_height - self._rack_tip_radius * np.cos(direction)
        y = -self._round_height * np.tan(direction) + self._rack_tip_radius * np.sin(direction)
        # Turn from the rack's frame into that of the space, then mirror into that of the tooth.
        polar = np.pi / gear.teeth - (np.arctan2(y, x) - rolled)
        return np.stack([np.hypot(x, y), polar], axis=-1), rolled

    @cached_property
    def _fillet_end(self) -> tuple[float, float]:
        """Last normal direction b of the fillet and the roll length of the involute there."""
        gear = self.gear
        last = math.pi / 2.0 - gear.pressure_angle
        sine = math.sin(gear.pressure_angle)
        roll = gear.reference_radius * sine + self._round_height / sine - self._rack_tip_radius
        if roll > 0.0:
            return last, roll

        def beyond(direction: float) -> float:
            """Angle by which the fillet stands outside the involute; negative where it cuts into it."""
            (radius, polar), _ = self._trochoid(np.array(direction))
            return float(polar - gear.half_angle(max(radius, gear.base_radius)))

        def above_base(direction: float) -> float:
            return float(self._trochoid(np.array(direction))[0][0]) - gear.base_radius

        # Undercut: on the base circle the trochoid lies inside the involute, at its end outside; between, they cross.
        first = float(brentq(above_base, 0.0, last, xtol=1e-15))
        cross = float(brentq(beyond, first, last, xtol=1e-15)) if beyond(first) < 0.0 else first
        radius = float(self._trochoid(np.array(cross))[0][0])
        return cross, math.sqrt(max(radius**2 - gear.base_radius**2, 0.0))

    @property
    def undercut(self) -> bool:
        """Whether the fillet cuts into the involute."""
        return self._fillet_end[0] < math.pi / 2.0 - self.gear.pressure_angle

    @property
    def undercut_turn(self) -> float:
        """Angle [rad] by which the outline turns at the edge between fillet and involute; 0 without undercut."""
        last, roll = self._fillet_end
        rolled = float(self._trochoid(np.array(last))[1])
        return max(math.pi / self.gear.teeth + rolled + last - float(self.normal_direction(roll)), 0.0)

    # ---- flank and tip round --------------------------------------------------------------------

    @property
    def flank_start(self) -> float:
        """Roll length [m] at which the involute begins (form circle)."""
        return self._fillet_end[1]

    @property
    def form_radius(self) -> float:
        """Root form radius [m], where fillet and involute meet."""
        return math.hypot(self.gear.base_radius, self.flank_start)

    @cached_property
    def flank_end(self) -> float:
        """Roll length [m] at which the involute passes into the tip round."""
        gear = self.gear
        return math.sqrt((gear.tip_radius - gear.tip_edge_radius) ** 2 - gear.base_radius**2) + gear.tip_edge_radius

    @property
    def flank_end_radius(self) -> float:
        """Tip form radius [m], where the involute passes into the tip round."""
        return math.hypot(self.gear.base_radius, self.flank_end)

    @cached_property
    def _round_angle(self) -> float:
        """Polar angle of the centre of the tip round: on the circle r_a - rho and on the involute moved in by rho."""
        gear = self.gear
        radius = gear.tip_radius - gear.tip_edge_radius
        return gear.half_angle(radius) - gear.tip_edge_radius / gear.base_radius

    @cached_property
    def _round_start(self) -> Array:
        """Direction of the normal at the junction of flank and tip round."""
        return self.normal_direction(self.flank_end)

    def normal_direction(self, roll: ArrayLike) -> Array:
        """Return the polar angle [rad] of the outward normal at roll lengths [m]; it touches the base circle."""
        return self.gear.base_half_angle - np.asarray(roll, float) / self.gear.base_radius + np.pi / 2.0

    # ---- the curve ------------------------------------------------------------------------------

    def parameter(self, roll: ArrayLike) -> Array:
        """Return u of roll lengths [m] on the flank."""
        return FLANK + (np.asarray(roll, float) - self.flank_start) / (self.flank_end - self.flank_start)

    def round_parameter(self, direction: ArrayLike) -> Array:
        """Return u of the tip round where its normal has a polar angle [rad]; outside [3, 4] it is not on the round."""
        return ROUND + (np.asarray(direction, float) - self._round_start) / (self._round_angle - self._round_start)

    def edge_distance(self, u: ArrayLike) -> Array:
        """Return the arc [m] from points of flank and tip round to where the round begins, negative on the round."""
        u = np.asarray(u, float)
        on_flank = (self.flank_end**2 - self.roll_length(u) ** 2) / (2.0 * self.gear.base_radius)
        on_round = (ROUND - u) * (self._round_start - self._round_angle) * self.gear.tip_edge_radius
        return np.where(u <= ROUND, on_flank, on_round)

    @property
    def round_centre(self) -> tuple[float, float]:
        """Polar angle [rad] and radius [m] of the centre of the tip round."""
        return self._round_angle, self.gear.tip_radius - self.gear.tip_edge_radius

    def roll_length(self, u: ArrayLike) -> Array:
        """Return the roll lengths [m] of parameters u on the flank."""
        return self.flank_start + (np.asarray(u, float) - FLANK) * (self.flank_end - self.flank_start)

    def point(self, u: ArrayLike) -> Array:
        """Return points of the outline.

        Parameters
        ----------
        u : array_like, shape (...)
            Parameters in [0, 5].

        Returns
        -------
        ndarray, shape (..., 2)
            x along the tooth's axis and y towards the described side, from the gear's centre [m].
        """
        return self._evaluate(u)[0]

    def normal(self, u: ArrayLike) -> Array:
        """Return unit normals that point out of the metal, shape (..., 2)."""
        direction = self._evaluate(u)[1]
        return np.stack([np.cos(direction), np.sin(direction)], axis=-1)

    def curvature(self, u: ArrayLike) -> Array:
        """Return the curvature [1/m] of flank and tip round, positive where the metal is convex.

        Parameters
        ----------
        u : array_like, shape (...)
            Parameters in [2, 5]; the fillet carries no contact and is refused.

        Returns
        -------
        ndarray, shape (...)
        """
        u = np.asarray(u, float)
        if u.size and u.min() < FLANK:
            raise ValueError(f"curvature is defined on flank and tip, u >= 2, not at u = {u.min():g}")
        gear = self.gear
        with np.errstate(divide="ignore"):
            flank = 1.0 / self.roll_length(u)
        return np.where(u <= ROUND, flank, np.where(u <= TIP, 1.0 / gear.tip_edge_radius, 1.0 / gear.tip_radius))

    def _evaluate(self, u: ArrayLike) -> tuple[Array, Array]:
        """Return points (..., 2) and directions of the outward normal [rad] (...)."""
        u = np.asarray(u, float)
        if u.size and (u.min() < ROOT or u.max() > END):
            raise ValueError(f"the outline's parameter runs from 0 to 5, not to {u.min():g} or {u.max():g}")
        points = np.empty((*u.shape, 2))
        normals = np.empty(u.shape)
        pieces = (self._root_arc, self._fillet, self._involute, self._tip_round, self._tip_arc)
        segment = np.clip(u.astype(int), 0, 4)
        for number, piece in enumerate(pieces):
            inside = segment == number
            if inside.any():
                points[inside], normals[inside] = piece(u[inside] - number)
        return points, normals

    def _root_arc(self, part: Array) -> tuple[Array, Array]:
        start = np.pi / self.gear.teeth
        polar = start - part * self._round_tangential / self.gear.reference_radius
        return _polar(np.full_like(polar, self.gear.root_radius), polar), polar

    def _fillet(self, part: Array) -> tuple[Array, Array]:
        direction = part * self._fillet_end[0]
        points, rolled = self._trochoid(direction)
        # The rack's normal (-cos b, sin b) points into the gear; outward is its opposite, turned and mirrored as the points are.
        return _polar(points[:, 0], points[:, 1]), np.pi / self.gear.teeth + rolled + direction

    def _involute(self, part: Array) -> tuple[Array, Array]:
        gear = self.gear
        roll = self.roll_length(part + FLANK)
        ratio = roll / gear.base_radius
        polar = gear.base_half_angle - (ratio - np.arctan(ratio))
        return _polar(np.hypot(gear.base_radius, roll), polar), self.normal_direction(roll)

    def _tip_round(self, part: Array) -> tuple[Array, Array]:
        direction = self._round_start + part * (self._round_angle - self._round_start)
        angle, radius = self.round_centre
        centre = radius * np.array([math.cos(angle), math.sin(angle)])
        return centre + _polar(np.full_like(direction, self.gear.tip_edge_radius), direction), direction

    def _tip_arc(self, part: Array) -> tuple[Array, Array]:
        polar = (1.0 - part) * self._round_angle
        return _polar(np.full_like(polar, self.gear.tip_radius), polar), polar


def _polar(radius: Array, angle: Array) -> Array:
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
