"""Castigliano's theorem on a tooth replaced by a trapezoid."""

from __future__ import annotations

import dataclasses
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import hyp2f1

from gearfem.compliance.record import ComplianceCurve
from gearfem.compliance.section_mesh import unworn
from gearfem.definition.setup import Material
from gearfem.flank.outline import FILLET, FLANK, TIP, Outline
from gearfem.foundation import Array, InputError, Record

# Timoshenko, Strength of Materials I: energy of the parabolic shear stress of a rectangle over that of its mean.
SHEAR_FACTOR = 6.0 / 5.0
# Bound of the relative error of the closed integrals; see the notes of `trapezoid_compliance`.
ROUNDING = 1e-14
# Points between which the idle side of a worn tooth is taken straight: off by 1e-7 of the module.
IDLE = 8001


class TrapezoidBase(Protocol):
    """Where the trapezoid's large base lies."""

    def parameter(self, outline: Outline) -> float:
        """Return the parameter u of the end of the base chord on the outline."""


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class FilletMiddle(Record):
    """Base at the fillet point whose height along the tooth's axis is midway between the fillet's ends.

    Notes
    -----
    Wojnarowski & Onishchenko (2003), section 2: "the chord of the tooth thickness in mid-range of the
    transient curve". That the range is one of height, and not of arc length, is our reading.
    """

    def parameter(self, outline: Outline) -> float:
        """Return u of that point, between 1 and 2."""
        low, high = outline.point([FILLET, FLANK])[:, 0]

        def above(u: float) -> float:
            return float(outline.point(u)[0] - 0.5 * (low + high))

        return float(brentq(above, FILLET, FLANK, xtol=1e-15))


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class RootEnd(Record):
    """Base where the fillet meets the root circle."""

    def parameter(self, outline: Outline) -> float:
        """Return u = 1."""
        return FILLET


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class FormCircle(Record):
    """Base where the fillet meets the involute."""

    def parameter(self, outline: Outline) -> float:
        """Return u = 2."""
        return FLANK


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Castigliano(Record):
    """Deflection of a tooth from the strain energy of a trapezoid between its root and the load.

    Parameters
    ----------
    base : TrapezoidBase
        Where the large base lies: `FilletMiddle` (the paper's), `RootEnd` or `FormCircle`.

    Notes
    -----
    The small base is the chord at the load point, the sides are straight. The body below the large base is
    rigid, so that the support is called ``root``. Modulus and shear modulus are the textbook's uniaxial ones;
    plane strain would divide the bending and compression parts by 1/(1 - nu^2), 1.10 for steel.

    The deflection is that of the load point, with the energy counted up to its height. A load at the crossing
    of its line with the centreline would leave the piece above the crossing unstrained: on the pinion of the
    paper that piece holds 14 % of the deflection at the end of the flank, 44 % at its middle, and nearly all of
    it where the crossing nears the base. Low on the flank, compare with other methods with care.

    Source: J. Wojnarowski, V. Onishchenko, Mechanism and Machine Theory 38 (2003), section 2, which gives no
    formulas; those of `trapezoid_compliance` are derived here. They find it within 10 % of finite elements.
    """

    base: TrapezoidBase = dataclasses.field(default_factory=FilletMiddle)

    def curve(self, outline: Outline, u: ArrayLike) -> ComplianceCurve:
        """Return the deflection per line load over the load's position.

        Parameters
        ----------
        outline : Outline
            One side of the tooth, with its gear.
        u : array_like, shape (n,)
            Load positions, increasing, on flank or tip round (2 <= u <= 4).

        Returns
        -------
        ComplianceCurve
            Without the rows whose load point, or whose crossing of load line and centreline, is not above the
            base; compare the lengths to see how many.

        Raises
        ------
        InputError
            If u is not an increasing row of positions on flank or tip round.
        """
        u = _positions(u)
        points, normals = outline.point(u), outline.normal(u)
        base = outline.point(self.base.parameter(outline))
        base_height = base[0]
        transverse, axial = normals[:, 1], normals[:, 0]
        # On the tip's end the load runs along the axis and crosses the centreline at the gear's centre.
        crosses = transverse > 1e-12
        depth = points[crosses, 1] / transverse[crosses]
        crossing = points[crosses, 0] - depth * axial[crosses]
        keep = np.flatnonzero(crosses)[(crossing > base_height) & (points[crosses, 0] > base_height)]
        parts = trapezoid_compliance(
            length=points[keep, 0] - base_height,
            load_chord=chord(outline, points[keep]),
            base_chord=chord(outline, base),
            angle=np.arctan2(axial[keep], transverse[keep]),
            material=outline.gear.material,
        )
        return ComplianceCurve(
            method="castigliano",
            support="root",
            u=u[keep],
            radius=np.hypot(points[keep, 0], points[keep, 1]),
            deflection=sum(parts, np.zeros(len(keep))),
            depth=points[keep, 1] / transverse[keep],
        )

    def error(self, outline: Outline, u: ArrayLike) -> Array:
        """Return the relative error of `curve` at each position it keeps: rounding, since the integrals are exact.

        Parameters
        ----------
        outline, u
            As for `curve`.

        Returns
        -------
        ndarray, shape (n,)
            The bound 1e-14 of `trapezoid_compliance`. What the trapezoid itself is wrong by is many powers of ten larger; it
            shows beside the other methods, not here.
        """
        return np.full(len(self.curve(outline, u).u), ROUNDING)


def chord(outline: Outline, place: Array) -> Array:
    """Return the thickness of a tooth across its axis [m] at points of its described side, shape (..., 2) -> (...)."""
    if not outline.worn:
        return np.asarray(2.0 * place[..., 1])
    x, y = unworn(outline).point(np.linspace(1.0, 5.0, IDLE)).T
    return np.asarray(place[..., 1] + np.interp(place[..., 0], x, y))


def trapezoid_compliance(
    *, length: ArrayLike, load_chord: ArrayLike, base_chord: ArrayLike, angle: ArrayLike, material: Material
) -> tuple[Array, Array, Array]:
    """Return the deflection of a clamped trapezoid of unit width along a load on the edge of its free end.

    Parameters
    ----------
    length : array_like, shape (n,)
        Distance of the loaded end from the clamped one [m].
    load_chord, base_chord : array_like, shape (n,)
        Chords at the loaded and at the clamped end [m]; equal chords are no special case.
    angle : array_like, shape (n,)
        Angle of the load from the transverse direction, positive towards the clamped end [rad].
    material : Material
        Gives E and G.

    Returns
    -------
    bending, shear, compression : ndarray, shape (n,)
        Parts of the deflection of the load point along the load, per line load [m per N/m].

    Notes
    -----
    With t from the loaded end, h the chord there and y half the load chord, a load F at the angle a gives
    N = -F sin a, Q = F cos a and M = F (t cos a - y sin a): pressing towards the clamped end on the near edge
    bends the tooth back. dU/dF of U = int M^2/(2 E I) + 6 Q^2/(10 G h) + N^2/(2 E h) dt, I = h^3/12, needs
    int_0^1 s^n (1 + k s)^-m ds = 2F1(m, n + 1; n + 2; -k)/(n + 1), k the relative taper: logarithms and
    rational functions for k != 0, written so that k = 0 loses no digits (error below 1e-14 of the value for
    -0.95 <= k <= 9). The model is Bernoulli's beam with a shear term, for a tooth no longer than it is thick.

    Examples
    --------
    >>> bending, shear, compression = trapezoid_compliance(
    ...     length=3.0, load_chord=1.0, base_chord=1.0, angle=0.0, material=Material(youngs_modulus=1.0))
    >>> round(float(bending), 9), round(float(shear), 9), float(compression)
    (108.0, 9.36, 0.0)
    """
    length, chord, angle = (np.asarray(value, float) for value in (length, load_chord, angle))
    taper = np.asarray(base_chord, float) / chord - 1.0
    cosine, sine = np.cos(angle), np.sin(angle)
    lever, offset = length * cosine, 0.5 * chord * sine
    squares = lever**2 * _moment(2, 3, taper) - 2.0 * lever * offset * _moment(1, 3, taper) + offset**2 * _moment(0, 3, taper)
    slenderness = length / chord
    bending = 12.0 * slenderness * squares / (material.youngs_modulus * chord**2)
    shear = SHEAR_FACTOR * cosine**2 * slenderness * _moment(0, 1, taper) / material.shear_modulus
    compression = sine**2 * slenderness * _moment(0, 1, taper) / material.youngs_modulus
    return bending, shear, compression


def _moment(power: int, order: int, taper: Array) -> Array:
    """Return the integral of s^power (1 + taper s)^-order over s from 0 to 1."""
    value: Array = hyp2f1(order, power + 1, power + 2, -taper) / (power + 1)
    return value


def _positions(u: ArrayLike) -> Array:
    u = np.asarray(u, float)
    allowed = "an increasing row of positions from 2 (start of the flank) to 4 (end of the tip round)"
    if u.ndim != 1 or not np.isfinite(u).all():
        raise InputError("u", f"shape {u.shape} or values that are not finite", allowed)
    if u.size and (u.min() < FLANK or u.max() > TIP or (np.diff(u) <= 0.0).any()):
        raise InputError("u", f"{u.size} values between {u.min():g} and {u.max():g}", allowed)
    return u
