"""Dynamic factor by ISO 6336-1, method B: a regression to set beside our own."""

from __future__ import annotations

import dataclasses
import math
from typing import Literal

from gearfem.definition.setup import Gear, GearPair
from gearfem.engagement.iso6336 import iso6336_stiffness
from gearfem.foundation import InputError, Record
from gearfem.foundation.units import MM, N_PER_MM, UM

Range = Literal["subcritical", "main resonance", "intermediate", "supercritical"]
# Ends of the main resonance and start of the supercritical range, in N.
RESONANCE_END, SUPERCRITICAL = 1.15, 1.5
LOW_LINE_LOAD = 100.0 * N_PER_MM
# Running-in of case-hardened gears: a part of the base pitch deviation, up to 3 um.
RUN_IN, RUN_IN_MOST = 0.075, 3.0 * UM
COARSE_GRADE = 6


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class IsoDynamicFactor(Record):
    """Dynamic factor by ISO 6336-1, method B, with the numbers that made it.

    Parameters
    ----------
    resonance_ratio, lower_limit : float
        N = n1/n_E1, and N_S below which the pair runs subcritically.
    reduced_mass : float
        Mass per face width on the line of action [kg/m].
    pitch_parameter, form_parameter, relief_parameter : float
        B_p, B_f and B_k.
    range : str
        "subcritical", "main resonance", "intermediate" or "supercritical".
    dynamic_factor : float
        K_v.
    """

    resonance_ratio: float
    lower_limit: float
    reduced_mass: float
    pitch_parameter: float
    form_parameter: float
    relief_parameter: float
    range: Range
    dynamic_factor: float


def pitch_deviation(gear: Gear, grade: int) -> float:
    """Return the limit of the single pitch deviation f_pt of an accuracy grade [m].

    Parameters
    ----------
    gear : Gear
        Module and reference circle.
    grade : int
        ISO accuracy grade, 0 to 12.

    Notes
    -----
    0.3 (m + 0.4 sqrt(d)) + 4 in um for grade 5, times sqrt(2) per grade; ISO 1328-1:1995, of the gear's own module and
    diameter rather than the means of their ranges, and not rounded: up to some 20 % from the printed tables.
    """
    module, diameter = gear.module / MM, 2.0 * gear.reference_radius / MM
    return (0.3 * (module + 0.4 * math.sqrt(diameter)) + 4.0) * _step(grade) * UM


def form_deviation(gear: Gear, grade: int) -> float:
    """Return the limit of the profile form deviation f_fa of an accuracy grade [m].

    Parameters
    ----------
    gear : Gear
        Module and reference circle.
    grade : int
        ISO accuracy grade, 0 to 12.

    Notes
    -----
    2.5 sqrt(m) + 0.17 sqrt(d) + 0.5 in um for grade 5; otherwise as `pitch_deviation`.
    """
    module, diameter = gear.module / MM, 2.0 * gear.reference_radius / MM
    return (2.5 * math.sqrt(module) + 0.17 * math.sqrt(diameter) + 0.5) * _step(grade) * UM


def _step(grade: int) -> float:
    if not 0 <= grade <= 12:
        raise InputError("accuracy grade", grade, "0 to 12")
    return math.sqrt(2.0) ** (grade - 5)


def iso6336_dynamic_factor(
    pair: GearPair,
    pinion_torque: float,
    pinion_speed: float,
    grade: int,
    *,
    inertias: tuple[float, float] | None = None,
    tip_relief: float = 0.0,
) -> IsoDynamicFactor:
    """Return the dynamic factor of a spur gear pair by ISO 6336-1, method B.

    Parameters
    ----------
    pair : GearPair
        Geometry and materials.
    pinion_torque, pinion_speed : float
        [N m] and [rad/s]; K_A is 1.
    grade : int
        ISO accuracy grade of both gears, 0 to 12.
    inertias : tuple of float, optional
        Moments of inertia of both gears [kg m2]; by default solid discs between bore and reference circle.
    tip_relief : float
        Tip relief C_a [m]; it counts in grades finer than 6 only.

    Returns
    -------
    IsoDynamicFactor

    Raises
    ------
    InputError
        If the grade is out of range, torque or speed are not positive, or the contact ratio is not above 1.

    Notes
    -----
    N = omega1 z1 sqrt(m_red/c_gamma_alpha), the mesh frequency over the natural one of the two gears alone; N_S = 0.85, and
    0.5 + 0.35 sqrt(F_t/(100 b)) below 100 N/mm. With the deviations of the wheel or pinion, whichever are larger, after
    running in of case-hardened gears (y = 0.075 f, up to 3 um): B_p = c' f_pb/(F_t/b), B_f = c' f_fa/(F_t/b),
    B_k = |1 - c' C_a/(F_t/b)|, and 1 for grade 6 and coarser.

    References
    ----------
    ISO 6336-1:2006, 6.5. Formulas and coefficients written from memory; the branches join as they should at contact ratio 1.5
    and 2.5, and within a few percent at 2, where two columns of the table meet. Not compared with a published example.
    """
    if not (pinion_torque > 0.0 and pinion_speed > 0.0):
        raise InputError("ISO 6336-1, torque and speed", f"{pinion_torque:g} and {pinion_speed:g}", "positive numbers")
    stiffness = iso6336_stiffness(pair, pinion_torque)
    mass = _reduced_mass(pair, inertias)
    ratio = pinion_speed * pair.pinion.teeth * math.sqrt(mass / stiffness.mesh_stiffness)
    load = pinion_torque / pair.pinion.reference_radius / pair.face_width
    limit = 0.85 if load >= LOW_LINE_LOAD else 0.5 + 0.35 * math.sqrt(load / LOW_LINE_LOAD)
    parameters = _parameters(pair, grade, stiffness.single_stiffness / load, tip_relief)
    where, factor = dynamic_factor(ratio, limit, pair.contact_ratio, parameters)
    return IsoDynamicFactor(
        resonance_ratio=ratio,
        lower_limit=limit,
        reduced_mass=mass,
        pitch_parameter=parameters[0],
        form_parameter=parameters[1],
        relief_parameter=parameters[2],
        range=where,
        dynamic_factor=factor,
    )


def _parameters(pair: GearPair, grade: int, per_length: float, tip_relief: float) -> tuple[float, float, float]:
    """Return B_p, B_f and B_k; c'/(F_t/b) per length of a deviation [1/m]."""
    gears = (pair.pinion, pair.wheel)
    pitch = max(pitch_deviation(gear, grade) for gear in gears) * math.cos(pair.pinion.pressure_angle)
    form = max(form_deviation(gear, grade) for gear in gears)
    return (
        per_length * (pitch - min(RUN_IN * pitch, RUN_IN_MOST)),
        per_length * (form - min(RUN_IN * form, RUN_IN_MOST)),
        1.0 if grade >= COARSE_GRADE else abs(1.0 - per_length * tip_relief),
    )


def dynamic_factor(ratio: float, limit: float, contact_ratio: float, parameters: tuple[float, float, float]) -> tuple[Range, float]:
    """Return the speed range and K_v of a resonance ratio, by the formulas of that range.

    Parameters
    ----------
    ratio, limit : float
        N and N_S.
    contact_ratio : float
        Total contact ratio, above 1.
    parameters : tuple of float
        B_p, B_f and B_k.

    Examples
    --------
    >>> dynamic_factor(0.5, 0.85, 1.6, (1.0, 1.0, 1.0))
    ('subcritical', 1.445)
    """
    c = coefficients(contact_ratio)
    pitch, form, relief = parameters
    resonance = c[0] * pitch + c[1] * form + c[3] * relief + 1.0
    beyond = c[4] * pitch + c[5] * form + c[6]
    if ratio <= limit:
        return "subcritical", ratio * (c[0] * pitch + c[1] * form + c[2] * relief) + 1.0
    if ratio <= RESONANCE_END:
        return "main resonance", resonance
    if ratio >= SUPERCRITICAL:
        return "supercritical", beyond
    return "intermediate", beyond + (resonance - beyond) * (SUPERCRITICAL - ratio) / (SUPERCRITICAL - RESONANCE_END)


def coefficients(contact_ratio: float) -> tuple[float, ...]:
    """Return C_v1 to C_v7 of a total contact ratio above 1."""
    e = contact_ratio
    if e <= 1.0:
        raise InputError("ISO 6336-1, contact ratio", f"{e:.4g}", "above 1")
    seventh = 0.75 if e <= 1.5 else 0.125 * math.sin(math.pi * (e - 2.0)) + 0.875 if e <= 2.5 else 1.0
    if e <= 2.0:
        return 0.32, 0.34, 0.23, 0.90, 0.47, 0.47, seventh
    return 0.32, 0.57 / (e - 0.3), 0.096 / (e - 1.56), (0.57 - 0.05 * e) / (e - 1.44), 0.47, 0.12 / (e - 1.74), seventh


def _reduced_mass(pair: GearPair, inertias: tuple[float, float] | None) -> float:
    one, two = inertias or (pair.pinion.disc_inertia(pair.face_width), pair.wheel.disc_inertia(pair.face_width))
    mass1, mass2 = one / pair.pinion.base_radius**2, two / pair.wheel.base_radius**2
    return mass1 * mass2 / (mass1 + mass2) / pair.face_width
