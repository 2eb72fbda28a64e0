"""The stage that turns a definition into the flanks of both gears."""

from __future__ import annotations

import dataclasses
import math

from gearfem.definition.setup import Gear, GearPair, Member, Setup
from gearfem.flank.outline import Outline
from gearfem.foundation import InputError, Record
from gearfem.foundation.units import MM


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Flanks(Record):
    """Outlines of the teeth of both gears.

    Parameters
    ----------
    pinion, wheel : Outline
        One side of a tooth of each gear; all teeth and both sides are equal.
    """

    pinion: Outline
    wheel: Outline


def make_flanks(setup: Setup) -> Flanks:
    """Return the flanks of a gear pair, and refuse a pair whose flanks interfere.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.

    Returns
    -------
    Flanks

    Raises
    ------
    InputError
        If an outline is impossible, or a tip reaches below the form circle of its mate.

    Notes
    -----
    The tip of the mate reaches down to the roll length a sin(alpha_w) - s_tip on a flank (ISO 21771); below
    the flank's start there is fillet, which is not conjugate.
    """
    pair = setup.pair
    flanks = Flanks(pinion=_outline("pinion", pair.pinion), wheel=_outline("wheel", pair.wheel))
    _refuse_interference("pinion", flanks.pinion, flanks.wheel, pair)
    _refuse_interference("wheel", flanks.wheel, flanks.pinion, pair)
    return flanks


def _outline(member: Member, gear: Gear) -> Outline:
    try:
        return Outline(gear=gear)
    except InputError as error:
        where = error.where if error.where.startswith("rack") else f"{member}.{error.where}"
        raise InputError(where, error.found, error.allowed) from None


def _refuse_interference(member: Member, outline: Outline, mate: Outline, pair: GearPair) -> None:
    lowest = pair.centre_distance * math.sin(pair.working_pressure_angle) - mate.flank_end
    # A reach of a hundred-thousandth of the module into the fillet is below any tolerance of manufacture.
    if lowest < outline.flank_start - 1e-5 * outline.gear.module:
        contact = math.hypot(outline.gear.base_radius, lowest) if lowest > 0.0 else outline.gear.base_radius
        raise InputError(
            f"{member}.profile_shift",
            f"{outline.gear.profile_shift:g}, with which the mate's tip touches the fillet of the {member} (radius {contact / MM:.4f} mm, "
            f"form circle {outline.form_radius / MM:.4f} mm)",
            "a pair without interference: raise this shift, or lower the tip radius of the mate",
        )
