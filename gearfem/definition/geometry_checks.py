"""Refusals of pairs that cannot exist, each with the key that decides it; flanks that interfere are the flank stage's."""

from __future__ import annotations

import dataclasses
import math

from gearfem.definition.schema import GearTable, Model
from gearfem.definition.setup import Gear, GearPair, Member, zero_backlash_centre_distance
from gearfem.foundation import InputError
from gearfem.foundation.units import MM

# Shifts are written with three or four digits: the distance at which they mesh without play is as uncertain.
ROUNDING_MODULES = 1e-3
THINNEST_RIM_MODULES = 0.5
SHARPEST_EDGE_MODULES = 1e-3
SMALLEST_BORE = 0.02
SMALLEST_INERTIA = 1e-4


def zero_backlash(pinion: Gear, wheel: Gear, backlash: float = 0.0) -> float:
    """Return the centre distance [m] at which thinned gears mesh without play, or refuse their shifts.

    Parameters
    ----------
    pinion, wheel : Gear
        Only teeth, module, pressure angle and profile shift are used.
    backlash : float
        Normal backlash by thinning [m]; 0 gives the zero-backlash distance of the shifts.

    Notes
    -----
    Thinning by j_n in all acts on the tooth thickness as a change of the shifts by -j_n/(2 m sin(alpha)).
    """
    less = backlash / (2.0 * pinion.module * math.sin(pinion.pressure_angle))
    try:
        return zero_backlash_centre_distance(dataclasses.replace(pinion, profile_shift=pinion.profile_shift - less), wheel)
    except ValueError:
        if backlash > 0.0:
            return pinion.base_radius + wheel.base_radius
        found = f"{pinion.profile_shift:g}, {pinion.profile_shift + wheel.profile_shift:g} with the wheel's"
        allowed = "a larger sum of the two shifts: with this one no centre distance lets the gears mesh"
        raise InputError("pinion.profile_shift", found, allowed) from None


def check_rack(model: Model) -> None:
    """Refuse a rack whose dedendum leaves no tip clearance."""
    if model.rack.dedendum < model.rack.addendum:
        found = f"{model.rack.dedendum:g} modules"
        raise InputError(
            "rack.dedendum", found, f"at least the addendum of {model.rack.addendum:g} modules; the tip clearance is negative below"
        )


def check_gear(model: Model, member: Member, gear: Gear) -> None:
    """Refuse a gear without a body: a root circle of no radius, a pointed rack, or a bore that leaves no rim."""
    table = _table(model, member)
    least = THINNEST_RIM_MODULES * gear.module
    _check_depth(table, member, gear)
    if gear.root_radius <= least:
        key = "root_radius_mm" if table.given("root_radius_mm") else "profile_shift"
        found = f"{getattr(table, key):g}, with a root radius of {gear.root_radius / MM:.4f} mm"
        raise InputError(f"{member}.{key}", found, f"a root radius above {THINNEST_RIM_MODULES:g} module ({least / MM:g} mm)")
    if gear.bore_radius > gear.root_radius - least:
        found = f"{gear.bore_radius / MM:g} mm" + _default_mark(table, "bore_radius_mm")
        allowed = (
            f"up to {(gear.root_radius - least) / MM:.4f} mm, half a module inside the root radius of {gear.root_radius / MM:.4f} mm: "
            "a thinner rim is no body that a bore could hold"
        )
        raise InputError(f"{member}.bore_radius_mm", found, allowed)
    if gear.bore_radius < SMALLEST_BORE * gear.root_radius:
        allowed = (
            f"from {SMALLEST_BORE * gear.root_radius / MM:.4f} mm, {100.0 * SMALLEST_BORE:g} % of the root radius: the gear is held on its "
            "bore, and on a pin it turns without limit (as 1/r^2)"
        )
        raise InputError(f"{member}.bore_radius_mm", f"{gear.bore_radius / MM:g} mm", allowed)
    if gear.tip_edge_radius < SHARPEST_EDGE_MODULES * gear.module:
        allowed = (
            f"from {SHARPEST_EDGE_MODULES * gear.module / MM:g} mm, {SHARPEST_EDGE_MODULES:g} module: no cut tooth has a sharper edge, "
            "and the contact on it would have no finite pressure"
        )
        raise InputError(f"{member}.tip_edge_radius_mm", f"{gear.tip_edge_radius / MM:g} mm", allowed)


def check_inertia(given: float, member: Member, gear: Gear, face_width: float) -> None:
    """Refuse an inertia [kg m2] that the gear's own body cannot have.

    Notes
    -----
    The inertia holds everything that turns with the gear, so a lightened blank is far above this part of a solid disc. Below it
    the natural frequency leaves the range in which the teeth act as springs without mass.
    """
    least = SMALLEST_INERTIA * gear.disc_inertia(face_width)
    if given < least:
        allowed = f"from {least:.4g} kg m2, {SMALLEST_INERTIA:g} of a solid disc of this gear, below which nothing that carries teeth comes"
        raise InputError(f"operation.{member}_inertia_kg_m2", f"{given:g} kg m2", allowed)


def _check_thinning(member: Member, gear: Gear, backlash: float) -> None:
    """Refuse a backlash that alone makes a tooth pointed; j_n/4 is taken off each flank."""
    bare = dataclasses.replace(gear, flank_thinning=0.0).half_angle(gear.tip_radius)
    if gear.half_angle(gear.tip_radius) <= 0.0 < bare:
        most = 4.0 * bare * gear.base_radius
        allowed = f"below {most / MM:.4f} mm, at which the thinned teeth of the {member} are pointed at the tip circle"
        raise InputError("pair.normal_backlash_mm", f"{backlash / MM:g} mm", allowed)


def _check_depth(table: GearTable, member: Member, gear: Gear) -> None:
    depth = (gear.reference_radius - gear.root_radius) / gear.module + gear.profile_shift
    # Half the width of the rack's tooth, pi/4 on the datum line, is used up at this depth.
    pointed = math.pi / 4.0 / math.tan(gear.pressure_angle)
    if depth >= pointed:
        own = table.root_radius_mm is not None
        where, found = (f"{member}.root_radius_mm", f"{table.root_radius_mm:g} mm") if own else ("rack.dedendum", f"{depth:g} modules")
        raise InputError(
            where, found, f"a tooth space less than {pointed:.4f} modules deep below the datum line, where the rack is pointed"
        )


def _table(model: Model, member: Member) -> GearTable:
    return model.pinion if member == "pinion" else model.wheel


def _default_mark(table: GearTable, key: str) -> str:
    return "" if table.given(key) else " (the default)"


def check_centre_distance(distance: float, pinion: Gear, wheel: Gear, backlash: float) -> str | None:
    """Refuse a given centre distance at which the teeth jam; return a sentence where rounding alone explains the overlap.

    Parameters
    ----------
    distance, backlash : float
        Given centre distance and normal backlash by thinning [m].
    pinion, wheel : Gear
        The two gears; their tips do not matter.

    Returns
    -------
    str or None
        What was assumed.
    """
    least = zero_backlash(pinion, wheel, backlash)
    if distance >= least:
        return None
    short = f"{(least - distance) / MM:.6f} mm"
    rounding = ROUNDING_MODULES * pinion.module
    if distance > pinion.base_radius + wheel.base_radius and least - distance <= rounding:
        return (
            f"The centre distance is {short} below that of gears without play: taken as rounding of the given figures, no preload computed."
        )
    raise InputError(
        "pair.centre_distance_mm",
        f"{distance / MM:g} mm, at which the teeth jam",
        f"from {least / MM:.4f} mm (two shifts and backlash); add pair.normal_backlash_mm or lower a shift for less",
    )


def check_pair(model: Model, pair: GearPair) -> None:
    """Refuse tips that cannot be, and a contact ratio below 1.

    Raises
    ------
    InputError
        Naming the tip radius of a gear, or the key that decides the contact ratio.
    """
    members: tuple[tuple[Member, Gear, Gear], ...] = (("pinion", pair.pinion, pair.wheel), ("wheel", pair.wheel, pair.pinion))
    for member, gear, mate in members:
        where = f"{member}.tip_radius_mm"
        found = f"{gear.tip_radius / MM:.4f} mm" + _default_mark(_table(model, member), "tip_radius_mm")
        room = pair.centre_distance - mate.root_radius
        if gear.tip_radius > room:
            raise InputError(where, found, f"up to {room / MM:.4f} mm, where the tip touches the root of its mate")
        lowest = max(gear.root_radius, gear.base_radius) + gear.tip_edge_radius
        if gear.tip_radius <= lowest:
            circle = "root" if gear.root_radius >= gear.base_radius else "base"
            raise InputError(where, found, f"above {lowest / MM:.4f} mm, the {circle} circle and the tip edge radius")
        _check_thinning(member, gear, pair.normal_backlash)
    if pair.contact_ratio < 1.0:
        where, found = _decides_contact_ratio(model, pair)
        allowed = "a pair whose transverse contact ratio is at least 1: longer tips, gears closer together or smaller shifts"
        raise InputError(where, f"{found}, with a contact ratio of {pair.contact_ratio:.4f}", allowed)


def _decides_contact_ratio(model: Model, pair: GearPair) -> tuple[str, str]:
    """Return the given key that is most likely to blame, and what it holds."""
    if pair.centre_distance > pair.zero_backlash_centre_distance + ROUNDING_MODULES * pair.pinion.module:
        return "pair.centre_distance_mm", f"{pair.centre_distance / MM:g} mm"
    for owner, table in (("pinion", model.pinion), ("wheel", model.wheel)):
        if table.tip_radius_mm is not None:
            return f"{owner}.tip_radius_mm", f"{table.tip_radius_mm:g} mm"
    for owner, table, gear in (("pinion", model.pinion, pair.pinion), ("wheel", model.wheel, pair.wheel)):
        datum = gear.reference_radius + (gear.profile_shift - gear.rack.dedendum) * gear.module
        if table.root_radius_mm is not None and gear.root_radius > datum:
            return f"{owner}.root_radius_mm", f"{table.root_radius_mm:g} mm, which shortens the tip of its mate"
    if model.rack.addendum < 1.0:
        return "rack.addendum", f"{model.rack.addendum:g} modules"
    member: Member = "pinion" if abs(model.pinion.profile_shift) >= abs(model.wheel.profile_shift) else "wheel"
    return f"{member}.profile_shift", f"{_table(model, member).profile_shift:g}"
