"""Line contact that runs over a tip edge: the band lies on flank and round at one time."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gearfem.contact.arguments import finite, not_negative, positive
from gearfem.contact.band import edge_band
from gearfem.contact.hertz import SMALLEST_LINE_LOAD, HertzLine
from gearfem.definition.setup import Material
from gearfem.foundation import Array, Record


class Line(NamedTuple):
    """Geometry of many line contacts; arrays broadcast against each other and the loads.

    Parameters
    ----------
    radius : ndarray, shape (...)
        Equivalent radius of the two flanks, as if they went on past the edge [m], positive.
    depth1, depth2 : ndarray, shape (...)
        Depths below the contact in the pinion and in the wheel [m], not negative.
    edge : ndarray, shape (...)
        Arc from the rigid contact point to the beginning of the nearest tip round [m]: positive on the
        flank, negative on the round.
    edge_radius : ndarray, shape (...)
        Radius of that round [m], positive.
    """

    radius: Array
    depth1: Array
    depth2: Array
    edge: Array
    edge_radius: Array


class _Effective(NamedTuple):
    """Hertz contact of the same approach; all arrays have the shape of the loads and lines together."""

    radius: Array
    growth: Array
    centre: Array


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class EdgedLine(Record):
    """Line contact of two elastic bodies near a rounded edge of one of them.

    On the flank, with the edge outside the band, and on the round, with the flank outside it, this is the
    law of Hertz. Between them the band is cut off by the round: the law of Hertz then holds with the radius
    that gives the same approach. All loads are per face width [N/m].

    Parameters
    ----------
    pinion, wheel : Material
        Materials of the two bodies; Poisson's ratio below 1/2.

    Notes
    -----
    Solution: `gearfem.contact.band.edge_band`. It holds for elastic half planes without friction, small slopes
    and prescribed rotation. Sizes of its errors:

    - The circle of the round is taken as a parabola, as Hertz does: ln(a_e), about 5 below ln(2 d), is too large
      by 2e-5 with the rigid contact at the edge and by (a/(3.3 rho))^2 on the round (a: half width there), 0.2 %
      at F/(E* rho) = 0.02 and 1 % at 0.1. The tip arc beyond the round is not reached: the band ends 0.3 rho
      past the edge at 0.02 and 0.7 rho at 0.1, rounds end after 0.8 rho or more.
    - On the round the equivalent curvature is 1/rho + 1/R, where 1/rho + 1/R2 is exact (R2 of the other body):
      less than rho/R in the radius, 0.1 % of the approach at R = 180 rho.
    - Depths count along the normal at the rigid contact point. Each square bracket in `HertzLine` is then too small by
      (2 - nu)/(2 (1 - nu)) (mean x^2 - a_e^2/4)/d^2, x^2 weighted by the pressure: below 0.3 % of the
      approach at d = 5 a, 0.1 % at 10 a.
    - A tooth ends beside its tip edge, where a half plane goes on. In a wedge of 125 degrees, loaded square to one face near
      its apex, the strain along the load is 1.3 times as large (Michell's radial field): estimated, the approach
      is too small by up to an eighth at the edge, and by less and less farther from it.

    The approach is continuous in edge and load, grows with the load and is concave in it. Over `edge` it has a
    kink at 0, as it should: on the round the arc passes R/rho + 1 times slower. Over the distance at which the
    flanks would touch if they went on, edge (1 + R/rho) beyond the edge, its slope is continuous; over the angle
    of two gears, whose round departs from these proportions by rho/R, to about 1 % of the slope.

    Examples
    --------
    >>> steel = EdgedLine(pinion=Material(), wheel=Material())
    >>> line = Line(*map(np.array, (0.029, 3e-3, 3e-3, [1e-3, 1e-4, 0.0, -1e-5, -1e-4], 0.16e-3)))
    >>> [f"{1e3 * float(radius):.3f}" for radius in steel.effective_radius(3.56e5, line)]
    ['29.000', '17.537', '10.203', '0.235', '0.159']
    """

    pinion: Material
    wheel: Material

    @property
    def hertz(self) -> HertzLine:
        """The law of Hertz for the same materials."""
        return HertzLine(pinion=self.pinion, wheel=self.wheel)

    def effective_radius(self, force_per_width: ArrayLike, line: Line) -> Array:
        """Return the radius [m] with which the law of Hertz gives the approach; arguments and errors as `approach`."""
        return self._effective(force_per_width, line).radius

    def centre(self, force_per_width: ArrayLike, line: Line) -> Array:
        """Return how far [m] the centre of pressure lies from the rigid contact point, positive towards the tip.

        Arguments and errors as `approach`.
        """
        return self._effective(force_per_width, line).centre

    def approach(self, force_per_width: ArrayLike, line: Line) -> Array:
        """Return by how much the points at the two depths come closer.

        Parameters
        ----------
        force_per_width : array_like, shape (...)
            Normal line load F [N/m], not negative.
        line : Line
            Geometry of the contacts.

        Returns
        -------
        ndarray, shape (...)
            Approach [m]: 0 without load, growing with it, less than in proportion.

        Raises
        ------
        InputError
            If a load or depth is negative, a radius is not positive, or one is not finite.
        SolveError
            If the band of contact does not converge.
        """
        radius = self._effective(force_per_width, line).radius
        return self.hertz.approach(force_per_width, radius, line.depth1, line.depth2)

    def compliance(self, force_per_width: ArrayLike, line: Line) -> Array:
        """Return the derivative of `approach` with respect to the line load.

        Parameters
        ----------
        force_per_width, line
            As in `approach`; loads below `SMALLEST_LINE_LOAD` count as that load.

        Returns
        -------
        ndarray, shape (...)
            d(approach)/dF [m per N/m], positive, falling with the load.

        Raises
        ------
        InputError, SolveError
            As in `approach`.
        """
        return self.respond(force_per_width, line)[1]

    def respond(self, force_per_width: ArrayLike, line: Line) -> tuple[Array, Array]:
        """Return `approach` and `compliance` together: the band over an edge is found once; arguments, units and errors as there.

        Loads below `SMALLEST_LINE_LOAD` have its band, and so an approach in proportion to them.
        """
        force = not_negative("force_per_width", force_per_width)
        loaded = np.maximum(force, SMALLEST_LINE_LOAD)
        effective = self._effective(loaded, line)
        approach, slope = self.hertz.respond(force, effective.radius, line.depth1, line.depth2)
        over = effective.growth != 0.5
        if not over.any():
            return approach, slope
        loaded, depth1, depth2 = (np.broadcast_to(values, over.shape)[over] for values in (loaded, line.depth1, line.depth2))
        further = np.zeros(over.shape)
        further[over] = (0.5 - effective.growth[over]) * self.hertz.narrowing(loaded, effective.radius[over], depth1, depth2)
        return approach, slope + further

    def beside(self, force_per_width: ArrayLike, distance: ArrayLike, line: Line) -> Array:
        """Return the approach at a distance [m] beside a contact on the flanks, per load on it [m per N/m]; as `HertzLine.beside`."""
        return self.hertz.beside(force_per_width, distance, line.radius, line.depth1, line.depth2)

    def _effective(self, force_per_width: ArrayLike, line: Line) -> _Effective:
        flank, edge_radius = positive("radius", line.radius), positive("edge_radius", line.edge_radius)
        half_width = self.hertz.half_width(force_per_width, flank)
        flank, rho, edge, half_width = np.broadcast_arrays(flank, edge_radius, finite("edge", line.edge), half_width)
        if (edge >= half_width).all():
            return _Effective(flank.copy(), np.full(flank.shape, 0.5), np.zeros(flank.shape))
        sharpness = flank / rho
        over = (edge < half_width) & (edge > -half_width / np.sqrt(1.0 + sharpness))
        radius = np.where(edge >= 0.0, flank, flank / (1.0 + sharpness))
        growth, centre = np.full_like(radius, 0.5), np.zeros_like(radius)
        if over.any():
            band = edge_band(edge[over] / half_width[over], sharpness[over])
            radius[over], growth[over] = flank[over] * band.radius, band.growth
            centre[over] = band.centre * half_width[over]
        return _Effective(radius, growth, centre)
