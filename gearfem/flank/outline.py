"""The outline of one side of a tooth: root arc, fillet, flank, tip round, tip arc."""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gearfem.definition.setup import Gear
from gearfem.flank.deviation import Deviation
from gearfem.flank.fillet import Fillet
from gearfem.flank.involute import SAMPLES, Involute, Side, WornInvolute, no_round
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.units import MM

ROOT, FILLET, FLANK, ROUND, TIP, END = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0
# Loads act from FLANK to here: past the middle of its tip round a tooth has left its mate by a tenth of the module.
LOADED_END = 3.5
# A turn of the outline between fillet and flank [rad] that is rounding and no edge.
SMALLEST_EDGE = 1e-9


class Curve(NamedTuple):
    """Flank and tip round in plain numbers, for compiled loops; lengths in m.

    The depth that is missing runs over the roll length from `first` on in cells of `step`: cubics `bends` (n, 4), highest power first.
    Roll lengths of points exceed those of an involute of their radius by `least` to `most`.
    """

    base_radius: float
    base_half_angle: float
    flank_start: float
    flank_end: float
    form_radius: float
    flank_end_radius: float
    tip_radius: float
    edge_radius: float
    round_start: float
    round_angle: float
    least: float
    most: float
    first: float
    step: float
    bends: Array


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Outline(Record):
    """One side of a tooth as a curve over a parameter u from the middle of the space to the tip's middle.

    The tooth's axis of symmetry is the x axis, the gear's centre the origin, and the side with y > 0 is
    described; the other side is its mirror image. The parameter runs over five segments of unit length:
    root arc [0, 1], fillet [1, 2], flank [2, 3], tip round [3, 4] and tip arc [4, 5]. On the flank u is
    linear in the roll length of the nominal involute, on the fillet in the direction of the rack's normal, on the arcs
    in the angle.

    Parameters
    ----------
    gear : Gear
        The gear whose tooth this is.
    deviation : Deviation, optional
        Metal missing from the flank; None or depth 0 leaves the involute.

    Raises
    ------
    InputError
        If the rack's tip round is too large for its tooth, the tip is pointed, the tip round does not fit, or the
        deviation is out of its bounds.

    Notes
    -----
    Involute and worn flank: `gearfem.flank.involute`. The tip circle and the radius of the tip round stay; the round is
    fitted anew between worn flank and tip circle. Fillet: `gearfem.flank.fillet`, the trochoid of the rack's rounded tip.
    Under a worn flank it is moved by the displacement of its upper end times 3 p^2 - 2 p^3 over its part p, which
    keeps the outline closed; its tangent meets that of the flank up to the slope of the deviation there. No contact is
    sought on it.

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
    deviation: Deviation | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        gear = self.gear
        if self._cut.round_tangential < -1e-12 * gear.module:
            found = f"{gear.rack.tip_radius:g} modules"
            limit = self._cut.largest_rack_tip_radius
            raise InputError("rack.tip_radius", found, f"at most {limit:.4f} modules, where the rack's tip has no land left")
        if gear.half_angle(gear.tip_radius) <= 0.0:
            allowed = "a tip circle on which the tooth still has a thickness: the tooth is pointed below it"
            raise InputError("tip_radius_mm", f"{gear.tip_radius / MM:.4f} mm", allowed)
        unworn_end, unworn_angle = Involute(gear=gear).end(0.0)
        if unworn_end <= self._cut.end[1] or unworn_angle <= 0.0:
            raise no_round(gear)
        if self.deviation is not None and self.worn and self.deviation.roll[0] > self.flank_start:
            found = f"a deviation from {self.deviation.roll[0] / MM:.4g} mm of roll length on"
            raise InputError("deviation", found, f"one that covers the flank, from {self.flank_start / MM:.4g} mm on")
        if self._round_angle <= 0.0:
            found = f"a depth of {float(self.deviation.at(self.flank_end)) / MM:.4g} mm at the tip" if self.deviation else "a depth"
            raise InputError("deviation", found, "a depth that leaves this side of the tooth a land: the tip gets pointed")

    @cached_property
    def _side(self) -> Side:
        if self.deviation is None or not self.deviation.depth.any():
            return Involute(gear=self.gear)
        return WornInvolute(gear=self.gear, deviation=self.deviation)

    @property
    def worn(self) -> bool:
        """Whether metal is missing from the involute, or stands out."""
        return isinstance(self._side, WornInvolute)

    @cached_property
    def deepest(self) -> float:
        """Largest depth that is missing, or stands out, on the flank [m]; 0 of an involute."""
        if self.deviation is None or not self.worn:
            return 0.0
        return float(np.abs(self.deviation.at(np.linspace(self.flank_start, self.flank_end, SAMPLES))).max())

    # ---- fillet ---------------------------------------------------------------------------------

    @cached_property
    def _cut(self) -> Fillet:
        return Fillet(gear=self.gear)

    @property
    def undercut(self) -> bool:
        """Whether the fillet cuts into the involute."""
        return self._cut.undercut

    @property
    def edged(self) -> bool:
        """Whether fillet and flank meet in an edge: by undercut, or by wear that begins with a slope at the form circle."""
        return self.undercut_turn > SMALLEST_EDGE

    @cached_property
    def undercut_turn(self) -> float:
        """Angle [rad] by which the outline turns at the edge between fillet and flank; 0 without undercut."""
        last, _ = self._cut.end
        rolled = float(self._cut.place(np.array(last))[1])
        return max(math.pi / self.gear.teeth + rolled + last - float(self.flank_direction(self.flank_start)), 0.0)

    # ---- flank and tip round --------------------------------------------------------------------

    @cached_property
    def flank_start(self) -> float:
        """Roll length [m] at which the flank begins (form circle)."""
        return self._side.start(self._cut.end[1])

    @cached_property
    def form_radius(self) -> float:
        """Root form radius [m], where fillet and flank meet; wear leaves it."""
        return math.hypot(self.gear.base_radius, self._cut.end[1])

    @cached_property
    def _end(self) -> tuple[float, float]:
        return self._side.end(self.flank_start)

    @property
    def flank_end(self) -> float:
        """Roll length [m] at which the flank passes into the tip round."""
        return self._end[0]

    @cached_property
    def flank_end_radius(self) -> float:
        """Tip form radius [m], where the flank passes into the tip round."""
        return float(self._side.place(np.array(self.flank_end))[0])

    @property
    def _round_angle(self) -> float:
        """Polar angle of the centre of the tip round."""
        return self._end[1]

    @cached_property
    def _round_start(self) -> Array:
        """Direction of the normal at the junction of flank and tip round."""
        return self.flank_direction(self.flank_end)

    def flank_direction(self, roll: ArrayLike) -> Array:
        """Return the polar angle [rad] of the flank's outward normal at roll lengths [m]."""
        return self._side.direction(np.asarray(roll, float))

    # ---- the curve ------------------------------------------------------------------------------

    @cached_property
    def curve(self) -> Curve:
        """Flank and tip round in plain numbers."""
        gear, side = self.gear, self._side
        least, most, first, step, bends = 0.0, 0.0, 0.0, 1.0, np.zeros((1, 4))
        if isinstance(side, WornInvolute):
            (least, most), (first, step, bends) = side.bounds, side.deviation.cubics
        return Curve(
            base_radius=gear.base_radius,
            base_half_angle=gear.base_half_angle,
            flank_start=float(self.flank_start),
            flank_end=float(self.flank_end),
            form_radius=self.form_radius,
            flank_end_radius=self.flank_end_radius,
            tip_radius=gear.tip_radius,
            edge_radius=gear.tip_edge_radius,
            round_start=float(self._round_start),
            round_angle=float(self._round_angle),
            least=least,
            most=most,
            first=first,
            step=step,
            bends=bends,
        )

    def parameter(self, roll: ArrayLike) -> Array:
        """Return u of roll lengths [m] on the flank."""
        return FLANK + (np.asarray(roll, float) - self.flank_start) / (self.flank_end - self.flank_start)

    def round_parameter(self, direction: ArrayLike) -> Array:
        """Return u of the tip round where its normal has a polar angle [rad]; outside [3, 4] it is not on the round."""
        return ROUND + (np.asarray(direction, float) - self._round_start) / (self._round_angle - self._round_start)

    def edge_distance(self, u: ArrayLike) -> Array:
        """Return the arc [m] from points of flank and tip round to where the round begins, negative on the round."""
        u = np.asarray(u, float)
        on_flank = self._side.arc(self.roll_length(u), self.flank_end)
        on_round = (ROUND - u) * (self._round_start - self._round_angle) * self.gear.tip_edge_radius
        return np.where(u <= ROUND, on_flank, on_round)

    def stretch(self, u: ArrayLike) -> Array:
        """Return the arc [m] towards the tip per parameter, on flank and tip round."""
        u = np.asarray(u, float)
        on_flank = self._side.speed(self.roll_length(u)) * (self.flank_end - self.flank_start)
        return np.where(u <= ROUND, on_flank, (self._round_start - self._round_angle) * self.gear.tip_edge_radius)

    def at_radius(self, radius: ArrayLike) -> Array:
        """Return u of flank and tip round at radii [m], which count as form or tip radius beyond them."""
        bounded: Array = np.clip(np.asarray(radius, float), self.form_radius, self.gear.tip_radius)
        u = np.maximum(self.parameter(self._side.roll_at(np.minimum(bounded, self.flank_end_radius))), FLANK)
        over = bounded > self.flank_end_radius
        if over.any():
            edge, centre = self.gear.tip_edge_radius, self.round_centre[1]
            cosine = (bounded[over] ** 2 - centre**2 - edge**2) / (2.0 * centre * edge)
            u[over] = np.maximum(self.round_parameter(self._round_angle + np.arccos(np.minimum(cosine, 1.0))), ROUND)
        return u

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
        return self.evaluate(u)[0]

    def normal(self, u: ArrayLike) -> Array:
        """Return unit normals that point out of the metal, shape (..., 2)."""
        direction = self.evaluate(u)[1]
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
        flank = self._side.curvature(self.roll_length(u))
        return np.where(u <= ROUND, flank, np.where(u <= TIP, 1.0 / gear.tip_edge_radius, 1.0 / gear.tip_radius))

    def evaluate(self, u: ArrayLike) -> tuple[Array, Array]:
        """Return points (..., 2) [m] and polar angles of the outward normal (...) [rad]."""
        u = np.asarray(u, float)
        if u.size and (u.min() < ROOT or u.max() > END):
            raise ValueError(f"the outline's parameter runs from 0 to 5, not to {u.min():g} or {u.max():g}")
        points = np.empty((*u.shape, 2))
        normals = np.empty(u.shape)
        pieces = (self._root_arc, self._fillet, self._flank, self._tip_round, self._tip_arc)
        segment = np.clip(u.astype(int), 0, 4)
        for number, piece in enumerate(pieces):
            inside = segment == number
            if inside.any():
                points[inside], normals[inside] = piece(u[inside] - number)
        return points, normals

    def _root_arc(self, part: Array) -> tuple[Array, Array]:
        start = np.pi / self.gear.teeth
        polar = start - part * self._cut.round_tangential / self.gear.reference_radius
        return _polar(np.full_like(polar, self.gear.root_radius), polar), polar

    def _fillet(self, part: Array) -> tuple[Array, Array]:
        last = self._cut.end[0]
        places, rolled = self._cut.place(part * last)
        # The rack's normal (-cos b, sin b) points into the gear; outward is its opposite, turned and mirrored as the points are.
        points, normals = _polar(places[:, 0], places[:, 1]), np.pi / self.gear.teeth + rolled + part * last
        if not self.worn:
            return points, normals
        end, _ = self._cut.place(np.array(last))
        moved = self._flank(np.array([0.0]))[0][0] - _polar(end[0], end[1])
        along = self._cut.speed(part * last)[:, None] * last * _polar(np.ones_like(normals), normals - np.pi / 2.0)
        along = along + 6.0 * (part * (1.0 - part))[:, None] * moved
        points = points + (part**2 * (3.0 - 2.0 * part))[:, None] * moved
        return points, np.arctan2(along[:, 1], along[:, 0]) + np.pi / 2.0

    def _flank(self, part: Array) -> tuple[Array, Array]:
        roll = self.roll_length(part + FLANK)
        return _polar(*self._side.place(roll)), self._side.direction(roll)

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
