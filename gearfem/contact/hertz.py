"""Hertz line contact with its approach to a depth."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from gearfem.contact.arguments import not_negative, positive
from gearfem.definition.setup import Material
from gearfem.foundation import Array, Record

# Slope of the approach at lower loads is that at 1 mN/m, since the true one grows as -ln F; the approach
# there is below 1e-13 m, less than an atom, so a solver sees no difference.
SMALLEST_LINE_LOAD = 1e-3


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class HertzLine(Record):
    """Line contact of two elastic bodies, each compressed between its surface and a depth below the contact.

    All loads are per face width [N/m]; arguments broadcast against each other.

    Parameters
    ----------
    pinion, wheel : Material
        Materials of the two bodies; Poisson's ratio below 1/2.

    Notes
    -----
    Plane strain; the bodies are half spaces down to the depth, which on a tooth is that of the half space
    yielding as the finite tooth does down to its centreline (`ToothCompliance.local_depth`). Dry, smooth, and the
    half width small beside the radius.

    On the axis of load, under p0 sqrt(1 - x^2/a^2), the stresses at depth z are (K. L. Johnson, Contact Mechanics,
    eq. 4.46) s_z = -p0 a/r and s_x = -p0 [(a^2 + 2 z^2)/(a r) - 2 z/a] with r = sqrt(a^2 + z^2). The strain
    (1 - nu^2)/E [s_z - nu/(1 - nu) s_x], integrated from 0 to d (derived here), gives the approach of a body

        delta = 2 F (1 - nu^2)/(pi E) [asinh(d/a) - nu/(1 - nu) d/(d + sqrt(a^2 + d^2))].

    For d >> a it is eq. 5.57 of Johnson and, summed over both bodies, the gear form of C. Weber, K. Banaschek,
    Formänderung und Profilrücknahme (1953): F (1 - nu^2)/(pi E) [2 ln(2 d/a) - nu/(1 - nu)]. That is too
    small by (1/4 + nu/(8 (1 - nu))) (a/d)^2 of the square bracket above (0.1 % of delta at d = 10 a, 0.6 % at 5 a)
    and falls with the load from about d = a on, where the exact one goes on growing.

    Examples
    --------
    >>> steel = HertzLine(pinion=Material(), wheel=Material())
    >>> f"{float(steel.half_width(4e5, 0.01)):.4e} {float(steel.pressure(4e5, 0.01)):.4e}"
    '2.1212e-04 1.2005e+09'
    """

    pinion: Material
    wheel: Material

    @property
    def contact_modulus(self) -> float:
        """E* [Pa], from 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2."""
        return 1.0 / (1.0 / self.pinion.plane_strain_modulus + 1.0 / self.wheel.plane_strain_modulus)

    def half_width(self, force_per_width: ArrayLike, radius: ArrayLike) -> Array:
        """Return the half width a = sqrt(4 F R/(pi E*)) of the contact.

        Parameters
        ----------
        force_per_width : array_like, shape (...)
            Normal line load F [N/m], not negative.
        radius : array_like, shape (...)
            Equivalent radius of curvature R, 1/R = 1/R1 + 1/R2 [m], positive.

        Returns
        -------
        ndarray, shape (...)
            [m]; 0 without load.

        Raises
        ------
        InputError
            If a load is negative, a radius is not positive, or either is not finite.

        Notes
        -----
        Johnson, Contact Mechanics, eq. 4.43.
        """
        force, radius = not_negative("force_per_width", force_per_width), positive("radius", radius)
        return np.sqrt(4.0 * force * radius / (np.pi * self.contact_modulus))

    def pressure(self, force_per_width: ArrayLike, radius: ArrayLike) -> Array:
        """Return the largest pressure p0 = sqrt(F E*/(pi R)) [Pa]; arguments and errors as `half_width`."""
        force, radius = not_negative("force_per_width", force_per_width), positive("radius", radius)
        return np.sqrt(force * self.contact_modulus / (np.pi * radius))

    def approach(self, force_per_width: ArrayLike, radius: ArrayLike, depth1: ArrayLike, depth2: ArrayLike) -> Array:
        """Return by how much the points at the two depths come closer.

        Parameters
        ----------
        force_per_width, radius : array_like, shape (...)
            As in `half_width`.
        depth1, depth2 : array_like, shape (...)
            Depths below the contact in the pinion and in the wheel [m], not negative.

        Returns
        -------
        ndarray, shape (...)
            Approach [m]: 0 without load, growing with it, less than in proportion.

        Raises
        ------
        InputError
            If a load or depth is negative, a radius is not positive, or one is not finite.
        """
        force = not_negative("force_per_width", force_per_width)
        width = self.half_width(force, radius)
        # Any width serves where the load is 0 (or too small for its square root), since the load multiplies the bracket.
        width = np.where(width > 0.0, width, 1.0)
        first, _ = _yield(width, not_negative("depth1", depth1), self.pinion)
        return force * (first + _yield(width, not_negative("depth2", depth2), self.wheel)[0])

    def compliance(self, force_per_width: ArrayLike, radius: ArrayLike, depth1: ArrayLike, depth2: ArrayLike) -> Array:
        """Return the derivative of `approach` with respect to the line load.

        Parameters
        ----------
        force_per_width, radius, depth1, depth2 : array_like, shape (...)
            As in `approach`; loads below `SMALLEST_LINE_LOAD` count as that load.

        Returns
        -------
        ndarray, shape (...)
            d(approach)/dF [m per N/m], positive, falling with the load.

        Raises
        ------
        InputError
            As in `approach`.

        Notes
        -----
        With da/dF = a/(2 F) each body gives 2 (1 - nu^2)/(pi E) [asinh(d/a) - d/(2 (1 - nu) sqrt(a^2 + d^2))]
        (derived here), positive for every load and depth if nu < 1/2.
        """
        return self.respond(force_per_width, radius, depth1, depth2)[1]

    def respond(self, force_per_width: ArrayLike, radius: ArrayLike, depth1: ArrayLike, depth2: ArrayLike) -> tuple[Array, Array]:
        """Return `approach` and `compliance` together, which share their logarithms; arguments, units and errors as there.

        Loads below `SMALLEST_LINE_LOAD` have its half width, and so an approach in proportion to them.
        """
        force = not_negative("force_per_width", force_per_width)
        width = self.half_width(np.maximum(force, SMALLEST_LINE_LOAD), radius)
        first = _yield(width, not_negative("depth1", depth1), self.pinion)
        other = _yield(width, not_negative("depth2", depth2), self.wheel)
        return force * (first[0] + other[0]), first[1] + other[1]

    def narrowing(self, force_per_width: ArrayLike, radius: ArrayLike, depth1: ArrayLike, depth2: ArrayLike) -> Array:
        """Return -d(approach/F)/d(ln a): how the approach per load falls as the half width grows at constant load.

        Parameters
        ----------
        force_per_width, radius, depth1, depth2 : array_like, shape (...)
            As in `compliance`.

        Returns
        -------
        ndarray, shape (...)
            [m per N/m], not negative.

        Raises
        ------
        InputError
            As in `approach`.

        Notes
        -----
        Each body gives 2 (1 - nu^2)/(pi E) d/r [1 - nu/(1 - nu) (r - d)/(r + d)], r = sqrt(a^2 + d^2) (derived here).
        """
        force = np.maximum(not_negative("force_per_width", force_per_width), SMALLEST_LINE_LOAD)
        width = self.half_width(force, radius)
        first = _narrowing(width, not_negative("depth1", depth1), self.pinion)
        return first + _narrowing(width, not_negative("depth2", depth2), self.wheel)

    def beside(self, force_per_width: ArrayLike, distance: ArrayLike, radius: ArrayLike, depth1: ArrayLike, depth2: ArrayLike) -> Array:
        """Return by how much the bodies come closer beside a line contact, per load on it.

        Parameters
        ----------
        force_per_width, radius : array_like, shape (...)
            Line load [N/m] and equivalent radius [m] that give the width of the contact, as in `half_width`.
        distance : array_like, shape (...)
            From the contact, along the surface [m], positive.
        depth1, depth2 : array_like, shape (...)
            Depths of the reference points below that place [m], not negative.

        Returns
        -------
        ndarray, shape (...)
            Approach per line load [m per N/m]; for a given width linear in the load.

        Raises
        ------
        InputError
            If a load or depth is negative, a radius or distance is not positive, or one is not finite.

        Notes
        -----
        Half spaces under a line load (Flamant): with r^2 = s^2 + d^2 each body gives 2 (1 - nu^2)/(pi E) [ln(r/s) - (d/r)^2 /
        (2 (1 - nu))] (derived here). A contact of half width a has s^2 + a^2/4 for s^2, which at its own middle is the slope of its
        approach for d >> a, so that nothing yields more beside a load than under it; the bracket errs by less than (a/s)^2/4.
        """
        aside = np.hypot(positive("distance", distance), 0.5 * self.half_width(force_per_width, radius))
        first = _beside(aside, not_negative("depth1", depth1), self.pinion)
        return first + _beside(aside, not_negative("depth2", depth2), self.wheel)


def _beside(aside: Array, depth: Array, material: Material) -> Array:
    ray = np.hypot(aside, depth)
    bracket = np.log(ray / aside) - (depth / ray) ** 2 / (2.0 * (1.0 - material.poissons_ratio))
    return 2.0 / (np.pi * material.plane_strain_modulus) * bracket


def _yield(width: Array, depth: Array, material: Material) -> tuple[Array, Array]:
    """Return the approach of one body per load, and its slope over the load [m per N/m]."""
    confined = material.poissons_ratio / (1.0 - material.poissons_ratio)
    ray, logarithm = np.hypot(width, depth), np.arcsinh(depth / width)
    scale = 2.0 / (np.pi * material.plane_strain_modulus)
    own = logarithm - confined * depth / (depth + ray)
    return scale * own, scale * (logarithm - depth / (2.0 * (1.0 - material.poissons_ratio) * ray))


def _narrowing(width: Array, depth: Array, material: Material) -> Array:
    confined = material.poissons_ratio / (1.0 - material.poissons_ratio)
    ray = np.hypot(width, depth)
    return 2.0 / (np.pi * material.plane_strain_modulus) * depth / ray * (1.0 - confined * (ray - depth) / (ray + depth))
