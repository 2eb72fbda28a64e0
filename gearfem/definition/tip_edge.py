"""The tip edge whose contact pressure under the whole load of one pair equals what the surface bears."""

from __future__ import annotations

import dataclasses
import math

from scipy.optimize import brentq

from gearfem.definition.schema import Model
from gearfem.definition.setup import Gear, GearPair, Member
from gearfem.foundation import InputError
from gearfem.foundation.units import MM, MPA

# "Two to three" widths of the Hertz contact (Wojnarowski & Onishchenko 2003): the middle.
RUN_OUT_WIDTHS = 2.5


def with_tip_edges(model: Model, pair: GearPair, notes: list[str]) -> GearPair:
    """Return the pair with the tip edges that the surface yield pressures ask for, where they are given and the radii are not.

    Parameters
    ----------
    model : Model
        Validated tables.
    pair : GearPair
        With default tip edges.
    notes : list of str
        Takes one sentence for each tip edge.

    Raises
    ------
    InputError
        Naming the surface yield pressure, if the radius it asks for does not fit the tooth.

    Notes
    -----
    One pair carries the whole normal load F per face width at the tip edge of one gear, which touches its mate's flank at
    the roll length a sin(alpha_w) - s_tip, the radius of curvature there. With 1/R = 1/rho_tip + 1/rho_flank the
    largest pressure is p = sqrt(F E*/(pi R)) (Johnson, Contact Mechanics, eq. 4.45), so R = F E*/(pi p^2). The run-out
    is so many times the width 4 F/(pi p) of the contact. Evaluated once, at the operation torque, on the nominal flanks.
    """
    gears: dict[Member, Gear] = {}
    sides: tuple[tuple[Member, Gear, Gear], ...] = (("pinion", pair.pinion, pair.wheel), ("wheel", pair.wheel, pair.pinion))
    for member, gear, mate in sides:
        limit = gear.material.surface_yield_pressure
        given = getattr(model, member).given("tip_edge_radius_mm")
        if limit is None or given:
            gears[member] = gear
            if given and limit is not None:
                notes.append(f"Surface yield pressure of the {member} not used: its tip edge radius is given.")
            continue
        gears[member] = _with_edge(model, member, gear, mate, pair, limit, notes)
    return dataclasses.replace(pair, pinion=gears["pinion"], wheel=gears["wheel"])


def _with_edge(model: Model, member: Member, gear: Gear, mate: Gear, pair: GearPair, limit: float, notes: list[str]) -> Gear:
    load = model.operation.pinion_torque_Nm / (pair.pinion.base_radius * pair.face_width)
    modulus = 1.0 / (1.0 / gear.material.plane_strain_modulus + 1.0 / mate.material.plane_strain_modulus)
    needed = load * modulus / (math.pi * limit**2)
    flank = pair.centre_distance * math.sin(pair.working_pressure_angle) - math.sqrt(gear.tip_radius**2 - gear.base_radius**2)
    most = _largest_edge(gear)
    least = math.sqrt(load * modulus / math.pi * (1.0 / most + (1.0 / flank if flank > 0.0 else 0.0)))
    key = "surface_yield_pressure_MPa"
    where = f"{member}.material.{key}" if getattr(model, member).material.given(key) else f"material.{key}"
    allowed = (
        f"above {least / MPA:.0f} MPa, at which the largest round of the tip ({most / MM:.3f} mm) is used up: meant is the pressure that "
        "a hardened surface bears under confined contact, several times its tensile yield strength"
    )
    if flank <= 0.0 or needed >= flank or limit <= least:
        asked = f"{1.0 / (1.0 / needed - 1.0 / flank) / MM:.3g} mm" if 0.0 < needed < flank else "more than any radius gives"
        raise InputError(where, f"{limit / MPA:g} MPa, which asks for a tip edge radius of {asked} on the {member}", allowed)
    radius = 1.0 / (1.0 / needed - 1.0 / flank)
    run_out = RUN_OUT_WIDTHS * 4.0 * load / (math.pi * limit)
    notes.append(
        f"Tip edge radius of the {member}: {radius / MM:.4g} mm, at which the whole load presses with {limit / MPA:g} MPa; its curvature "
        f"runs out parabolically over {run_out / MM:.3g} mm of the flank, {RUN_OUT_WIDTHS:g} widths of that contact."
    )
    return dataclasses.replace(gear, tip_edge_radius=radius, tip_run_out=run_out)


def _largest_edge(gear: Gear) -> float:
    """Return the radius [m] of the round that takes up the whole tip land, or reaches the base circle."""

    def land(radius: float) -> float:
        return gear.half_angle(gear.tip_radius - radius) - radius / gear.base_radius

    deepest = (gear.tip_radius - gear.base_radius) * (1.0 - 1e-9)
    return deepest if land(deepest) > 0.0 else float(brentq(land, 0.0, deepest, xtol=1e-12 * gear.module))
