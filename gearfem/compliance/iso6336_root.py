"""Nominal tooth root stress by ISO 6336-3, method B, with the load at any radius of the flank."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import ArrayLike

from gearfem.flank import Outline
from gearfem.flank.outline import FLANK, ROUND
from gearfem.foundation import Array, InputError, Record, SolveError

# Angle between the tooth's axis and the tangent at the critical section of an external gear.
TANGENT = math.pi / 6.0
# Range of q_s for which the standard gives Y_S.
NOTCH_LOW, NOTCH_HIGH = 1.0, 8.0


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class RootSection(Record):
    """The critical section of a tooth root, where the tangents stand at 30 degrees to the tooth's axis.

    Parameters
    ----------
    chord : float
        Root normal chord s_Fn [m].
    height : float
        Distance of the chord from the gear's centre [m].
    fillet_radius : float
        Radius of the fillet at its ends rho_F [m].
    """

    chord: float
    height: float
    fillet_radius: float


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class RootFactors(Record):
    """Form factor and stress correction factor over the load's position.

    Parameters
    ----------
    section : RootSection
        The critical section.
    u, radius : ndarray, shape (n,)
        Load positions as parameters of the `Outline`, and their radii [m].
    bending_arm : ndarray, shape (n,)
        h_F: from the section to where the load line crosses the tooth's axis [m].
    load_angle : ndarray, shape (n,)
        alpha_Fn: from the load line to the normal of the tooth's axis [rad].
    form_factor, stress_correction : ndarray, shape (n,)
        Y_F and Y_S.
    stress : ndarray, shape (n,)
        Nominal stress per line load, Y_F Y_S cos(alpha)/m [Pa per N/m].
    """

    section: RootSection
    u: Array
    radius: Array
    bending_arm: Array
    load_angle: Array
    form_factor: Array
    stress_correction: Array
    stress: Array

    @property
    def notch(self) -> float:
        """Notch parameter q_s = s_Fn/(2 rho_F); the standard gives Y_S for 1 <= q_s < 8."""
        return self.section.chord / (2.0 * self.section.fillet_radius)

    @property
    def in_range(self) -> bool:
        """Whether the notch parameter lies where the standard gives Y_S."""
        return NOTCH_LOW <= self.notch < NOTCH_HIGH


def root_section(outline: Outline) -> RootSection:
    """Return the critical section of an external spur gear.

    Parameters
    ----------
    outline : Outline
        Outline of the tooth; its rack's dedendum follows from the root radius.

    Returns
    -------
    RootSection

    Raises
    ------
    SolveError
        If the section's angle is not found.
    InputError
        If the 30 degree tangent does not touch the fillet.

    Notes
    -----
    E = pi m/4 - h_fP tan(alpha) - (1 - sin(alpha)) rho_fP/cos(alpha), G = rho_fP/m - h_fP/m + x,
    H = 2/z (pi/2 - E/m) - pi/3, theta = 2 G/z tan(theta) - H,
    s_Fn/m = z sin(pi/3 - theta) + sqrt(3) (G/cos(theta) - rho_fP/m),
    rho_F/m = rho_fP/m + 2 G^2/(cos(theta) (z cos(theta)^2 - 2 G)).
    A flank moved in by s_n along its normal widens the rack's tooth and adds s_n/cos(alpha) to E. The section is that of the
    generated fillet exactly. Source: ISO 6336-3:2006, clause 6 (spur, external); checked against the outline.

    Examples
    --------
    >>> from gearfem.definition.setup import Gear, Material, Rack
    >>> gear = Gear(teeth=20, module=1e-3, pressure_angle=math.radians(20), profile_shift=0.0, flank_thinning=0.0,
    ...             root_radius=8.75e-3, tip_radius=11e-3, tip_edge_radius=2e-5, bore_radius=4e-3, rack=Rack(),
    ...             material=Material())
    >>> round(root_section(Outline(gear=gear)).chord * 1e3, 3)
    1.933
    """
    gear = outline.gear
    module, teeth, alpha = gear.module, gear.teeth, gear.pressure_angle
    rounding = gear.rack.tip_radius
    dedendum = teeth / 2.0 + gear.profile_shift - gear.root_radius / module
    e = math.pi / 4.0 - dedendum * math.tan(alpha) - (1.0 - math.sin(alpha)) * rounding / math.cos(alpha)
    e += gear.flank_thinning / (module * math.cos(alpha))
    g = rounding - dedendum + gear.profile_shift
    h = 2.0 / teeth * (math.pi / 2.0 - e) - math.pi / 3.0
    theta = _section_angle(g, h, teeth)
    # theta is the angle of the rack's normal from the middle of its round; the round runs from 0 to pi/2 - alpha.
    if not 0.0 < theta < math.pi / 2.0 - alpha:
        raise InputError("gear", f"a section angle of {math.degrees(theta):.3g} degrees", "a gear whose fillet has a 30 degree tangent")
    across = g / math.cos(theta) - rounding
    chord = teeth * math.sin(math.pi / 3.0 - theta) + math.sqrt(3.0) * across
    height = 0.5 * (teeth * math.cos(math.pi / 3.0 - theta) + across)
    radius = rounding + 2.0 * g**2 / (math.cos(theta) * (teeth * math.cos(theta) ** 2 - 2.0 * g))
    return RootSection(chord=chord * module, height=height * module, fillet_radius=radius * module)


def _section_angle(g: float, h: float, teeth: int) -> float:
    """Return theta of theta = 2 G/z tan(theta) - H by Newton's method from pi/6, where the standard starts."""
    theta = TANGENT
    for _ in range(50):
        step = (theta - 2.0 * g / teeth * math.tan(theta) + h) / (1.0 - 2.0 * g / teeth / math.cos(theta) ** 2)
        theta -= step
        if abs(step) < 1e-14:
            return theta
    raise SolveError(f"the angle of the critical section was not found for {teeth} teeth, G = {g:.4g}; check rack and profile shift")


def root_factors(outline: Outline, u: ArrayLike) -> RootFactors:
    """Return Y_F, Y_S and the nominal root stress over load positions on the flank.

    Parameters
    ----------
    outline : Outline
        Outline of the tooth.
    u : array_like, shape (n,)
        Load positions, increasing, in [2, 3].

    Returns
    -------
    RootFactors
        Without the positions whose load line crosses the tooth's axis at or below the critical section: they have no
        bending arm, and the standard no factor.

    Raises
    ------
    InputError
        If a position is not on the flank.
    SolveError
        As `root_section` does.

    Notes
    -----
    Y_F = 6 (h_F/m) cos(alpha_Fn)/((s_Fn/m)^2 cos(alpha)), Y_S = (1.2 + 0.13 L) q_s^(1/(1.21 + 2.3/L)), L = s_Fn/h_F,
    q_s = s_Fn/(2 rho_F); sigma = F_t/(b m) Y_F Y_S with F_t = F_n cos(alpha), Y_B = Y_DT = 1. The standard puts the load at the
    outer point of single pair contact; h_F and alpha_Fn are those of that point and hold for any other in the same way:
    alpha_Fn = arccos(r_b/r) - gamma, gamma the half angle of the tooth at r, and the load line crosses the axis at
    r_b/cos(alpha_Fn). Y_S was fitted to loads high on the flank.

    Source: ISO 6336-3:2006, clauses 6 and 7.
    """
    at = np.array(u, dtype=float, ndmin=1)
    if at.ndim != 1 or not (at.size and at.min() >= FLANK and at.max() <= ROUND and (np.diff(at) > 0.0).all()):
        raise InputError("load positions u", at, "increasing numbers from 2 (start of the involute) to 3 (its end)")
    gear, section = outline.gear, root_section(outline)
    radius = np.hypot(*outline.point(at).T)
    half = np.array([gear.half_angle(float(r)) for r in radius])
    angle = np.arccos(gear.base_radius / radius) - half
    arm = gear.base_radius / np.cos(angle) - section.height
    kept = arm > 0.0
    at, radius, angle, arm = at[kept], radius[kept], angle[kept], arm[kept]
    form = 6.0 * arm * gear.module * np.cos(angle) / (section.chord**2 * math.cos(gear.pressure_angle))
    slender = section.chord / arm
    notch = section.chord / (2.0 * section.fillet_radius)
    correction = (1.2 + 0.13 * slender) * notch ** (1.0 / (1.21 + 2.3 / slender))
    return RootFactors(
        section=section,
        u=at,
        radius=radius,
        bending_arm=arm,
        load_angle=angle,
        form_factor=form,
        stress_correction=correction,
        stress=form * correction * math.cos(gear.pressure_angle) / gear.module,
    )
