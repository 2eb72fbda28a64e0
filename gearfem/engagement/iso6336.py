"""Tooth stiffness by ISO 6336-1, method B: a regression to set beside our own."""

from __future__ import annotations

import dataclasses
import math

from gearfem.definition.setup import Gear, GearPair
from gearfem.foundation import InputError, Record
from gearfem.foundation.units import DEG, GPA, N_PER_MM, N_PER_MM_UM

# ISO 6336-1, table of C1 to C9 for the flexibility q' [mm um/N].
COEFFICIENTS = (0.04723, 0.15551, 0.25791, -0.00635, -0.11654, -0.00193, -0.24188, 0.00529, 0.00182)
# C_M: measured on solid discs against the regression.
CORRECTION_FACTOR = 0.8
STEEL_MODULUS = 206.0 * GPA
# Line load F_t K_A/b below which teeth are softer, and above which the standard states no accuracy.
LOW_LINE_LOAD, HIGH_LINE_LOAD = 100.0 * N_PER_MM, 1600.0 * N_PER_MM


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class IsoStiffness(Record):
    """Stiffness of a pair of teeth by ISO 6336-1, method B, with the factors that made it.

    Parameters
    ----------
    theoretical_stiffness : float
        c'_th = 1/q' [N/m per m, that is Pa].
    correction_factor, blank_factor, rack_factor, helix_factor : float
        C_M, C_R, C_B and cos(beta).
    load_factor, material_factor : float
        (F_t K_A/(100 b))^0.25 where the line load is below 100 N/mm, else 1; E/E_st.
    contact_ratio : float
        Transverse contact ratio.
    warnings : tuple of str
        One sentence for each range of validity in which the pair does not lie.
    """

    theoretical_stiffness: float
    correction_factor: float
    blank_factor: float
    rack_factor: float
    helix_factor: float
    load_factor: float
    material_factor: float
    contact_ratio: float
    warnings: tuple[str, ...] = ()

    @property
    def single_stiffness(self) -> float:
        """Largest stiffness c' of a single pair of teeth per face width [Pa]."""
        factors = self.correction_factor * self.blank_factor * self.rack_factor * self.helix_factor
        return self.theoretical_stiffness * factors * self.load_factor * self.material_factor

    @property
    def mesh_stiffness(self) -> float:
        """Mean mesh stiffness c_gamma_alpha = c' (0.75 eps_alpha + 0.25) per face width [Pa]."""
        return self.single_stiffness * (0.75 * self.contact_ratio + 0.25)

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What was assumed, the warnings included."""
        common = f"ISO 6336-1 stiffness: K_A = 1, and gear bodies as discs, C_R = {self.blank_factor:g} (ours are discs held at the bore)."
        return (common, *self.warnings)


def iso6336_stiffness(pair: GearPair, pinion_torque: float) -> IsoStiffness:
    """Return the stiffness of a spur gear pair by ISO 6336-1, method B.

    Parameters
    ----------
    pair : GearPair
        Spur gears on their axes; the dedendum of the rack follows from each root radius.
    pinion_torque : float
        Torque on the pinion [N m], for the correction at low load.

    Returns
    -------
    IsoStiffness

    Raises
    ------
    InputError
        If the torque is not positive, or the regression has no positive value for the pair.

    Notes
    -----
    Index 1 is the pinion, F_t = T1/r1 acts on the reference circle and K_A = 1. The bodies are discs, C_R = 1:
    the standard's factor for webs knows no bore, and a thin rim held at its bore is stiffer than its disc.
    """
    pinion, wheel = pair.pinion, pair.wheel
    if not (math.isfinite(pinion_torque) and pinion_torque > 0.0):
        raise InputError("pinion_torque", f"{pinion_torque:g} N m", "a positive torque")
    return tooth_stiffness(
        virtual_teeth=(pinion.teeth, wheel.teeth),
        profile_shift=(pinion.profile_shift, wheel.profile_shift),
        dedendum=(_dedendum(pinion), _dedendum(wheel)),
        youngs_modulus=(pinion.material.youngs_modulus, wheel.material.youngs_modulus),
        contact_ratio=pair.contact_ratio,
        line_load=pinion_torque / (pinion.reference_radius * pair.face_width),
        pressure_angle=pinion.pressure_angle,
    )


def virtual_teeth(teeth: int, helix_angle: float, pressure_angle: float = 20.0 * DEG) -> float:
    """Return the number of teeth of the virtual spur gear of a helical gear.

    Parameters
    ----------
    teeth : int
        Number of teeth z.
    helix_angle, pressure_angle : float
        Helix angle beta on the reference circle and normal pressure angle [rad].

    Notes
    -----
    z_n = z/(cos^2(beta_b) cos(beta)), sin(beta_b) = sin(beta) cos(alpha_n); ISO 6336-1. The shorter
    z/cos^3(beta) misses the fourth digit of the published example.

    Examples
    --------
    >>> round(virtual_teeth(17, 15.8 * DEG), 4)
    18.9051
    """
    base_helix_sine = math.sin(helix_angle) * math.cos(pressure_angle)
    return teeth / ((1.0 - base_helix_sine**2) * math.cos(helix_angle))


def tooth_stiffness(
    *,
    virtual_teeth: tuple[float, float],
    profile_shift: tuple[float, float],
    dedendum: tuple[float, float],
    contact_ratio: float,
    line_load: float,
    youngs_modulus: tuple[float, float] = (STEEL_MODULUS, STEEL_MODULUS),
    pressure_angle: float = 20.0 * DEG,
    helix_angle: float = 0.0,
    blank_factor: float = 1.0,
) -> IsoStiffness:
    """Return the stiffness by ISO 6336-1, method B, from the quantities of the standard.

    Parameters
    ----------
    virtual_teeth, profile_shift : (float, float)
        z_n and x of pinion and wheel.
    dedendum : (float, float)
        h_fP of the racks of pinion and wheel [modules]; where they differ C_B is the mean of both, as the standard has it.
    contact_ratio : float
        Transverse contact ratio.
    line_load : float
        F_t K_A/b [N/m].
    youngs_modulus : (float, float)
        Of pinion and wheel [Pa]; E = 2 E1 E2/(E1 + E2).
    pressure_angle, helix_angle : float
        Normal pressure angle of the rack and helix angle [rad].
    blank_factor : float
        C_R; 1 for solid discs, 1 + ln(b_s/b)/(5 exp(s_R/(5 m_n))) for a web b_s under a rim s_R.

    Returns
    -------
    IsoStiffness

    Raises
    ------
    InputError
        If the regression has no positive value there.

    Notes
    -----
    c' = c'_th C_M C_R C_B cos(beta), with q' = 1/c'_th = C1 + C2/z_n1 + C3/z_n2 + C4 x1 + C5 x1/z_n1 + C6 x2
    + C7 x2/z_n2 + C8 x1^2 + C9 x2^2 and C_B = [1 + 0.5 (1.2 - h_fP/m)][1 - 0.02 (20 - alpha_n in degrees)].
    Fitted to the pair's largest stiffness for x1 >= x2 and -0.5 <= x1 + x2 <= 2; between 100 and 1600 N/mm the standard
    expects actual values from 8 % below to 5 % above. Source: ISO 6336-1:2006 and 2019, "Tooth stiffness parameters".
    The coefficients are those with which ISO/TR 6336-30, example 1, comes out to its seven digits.
    """
    flexibility = _flexibility(*virtual_teeth, *profile_shift)
    if flexibility <= 0.0:
        raise InputError("profile_shift", profile_shift, "shifts for which ISO 6336-1 gives a positive flexibility")
    first, second = youngs_modulus
    return IsoStiffness(
        theoretical_stiffness=N_PER_MM_UM / flexibility,
        correction_factor=CORRECTION_FACTOR,
        blank_factor=blank_factor,
        rack_factor=0.5 * sum(_rack_factor(height, pressure_angle) for height in dedendum),
        helix_factor=math.cos(helix_angle),
        load_factor=min(line_load / LOW_LINE_LOAD, 1.0) ** 0.25,
        material_factor=2.0 * first * second / (first + second) / STEEL_MODULUS,
        contact_ratio=contact_ratio,
        warnings=_warnings(profile_shift, dedendum, contact_ratio, line_load, helix_angle),
    )


def _flexibility(teeth1: float, teeth2: float, shift1: float, shift2: float) -> float:
    """Return q' [mm um/N]."""
    terms = (1.0, 1.0 / teeth1, 1.0 / teeth2, shift1, shift1 / teeth1, shift2, shift2 / teeth2, shift1**2, shift2**2)
    return sum(factor * term for factor, term in zip(COEFFICIENTS, terms, strict=True))


def _rack_factor(dedendum: float, pressure_angle: float) -> float:
    return (1.0 + 0.5 * (1.2 - dedendum)) * (1.0 - 0.02 * (20.0 - pressure_angle / DEG))


def _dedendum(gear: Gear) -> float:
    """Return h_fP [modules] from the root radius; thinning of the flanks leaves the root where it was."""
    return (gear.reference_radius - gear.root_radius) / gear.module + gear.profile_shift


def _warnings(
    profile_shift: tuple[float, float], dedendum: tuple[float, float], contact_ratio: float, line_load: float, helix_angle: float
) -> tuple[str, ...]:
    """Return a sentence for each range of validity that is left."""
    (x1, x2), load = profile_shift, line_load / N_PER_MM
    sentences = (
        (x1 < x2, f"is fitted for x1 >= x2; here x1 = {x1:g}, x2 = {x2:g}."),
        (not -0.5 <= x1 + x2 <= 2.0, f"is fitted for -0.5 <= x1 + x2 <= 2; here the sum is {x1 + x2:g}."),
        (
            contact_ratio < 1.2,
            f"may give a c_gamma_alpha up to 10 % too high below a contact ratio of 1.2; here it is {contact_ratio:.4g}.",
        ),
        (contact_ratio >= 2.0, f"is meant for contact ratios below 2; here it is {contact_ratio:.4g}."),
        (line_load < LOW_LINE_LOAD, f"was lowered for a line load below 100 N/mm; here it is {load:.4g} N/mm."),
        (line_load > HIGH_LINE_LOAD, f"states its accuracy up to 1600 N/mm; here the line load is {load:.4g} N/mm."),
        (helix_angle > 30.0 * DEG, f"is meant for helix angles up to 30 deg; here it is {helix_angle / DEG:.4g} deg."),
        (
            abs(dedendum[0] - dedendum[1]) > 1e-6,
            f"takes the mean of C_B for the two racks, whose dedenda differ: {dedendum[0]:.4g} and {dedendum[1]:.4g} modules.",
        ),
    )
    return tuple(f"ISO 6336-1 stiffness {text}" for outside, text in sentences if outside)
