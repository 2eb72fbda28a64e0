"""Where on a flank: roll lengths that effects are described by."""

from __future__ import annotations

import math
from typing import NamedTuple

from gearfem.definition.setup import Gear, Member, Setup
from gearfem.effects.effect import Size
from gearfem.flank import Outline


class Active(NamedTuple):
    """Roll lengths [m] of the active flank of a gear: lowest contact point, pitch point and tip circle."""

    lowest: float
    pitch: float
    tip: float


def active_flank(setup: Setup, member: Member) -> Active:
    """Return the roll lengths of the active flank of one gear, as designed.

    Parameters
    ----------
    setup : Setup
        The pair; its stated centre distance counts.
    member : {"pinion", "wheel"}
        The gear.

    Returns
    -------
    Active

    Notes
    -----
    The mate's tip circle reaches down to a sin(alpha_w) - s_tip (ISO 21771); undercut may end the flank before.
    """
    pair = setup.pair
    gear, mate = (pair.pinion, pair.wheel) if member == "pinion" else (pair.wheel, pair.pinion)
    lowest = pair.centre_distance * math.sin(pair.working_pressure_angle) - _tip(mate)
    return Active(max(lowest, Outline(gear=gear).flank_start), gear.base_radius * math.tan(pair.working_pressure_angle), _tip(gear))


def _tip(gear: Gear) -> float:
    return math.sqrt(gear.tip_radius**2 - gear.base_radius**2)


def of_flank(share: float) -> Size:
    """Return a share of the roll length of the active flank, for bounds and typical values."""

    def size(setup: Setup, member: Member) -> float:
        active = active_flank(setup, member)
        return share * (active.tip - active.lowest)

    return size


def up_flank(share: float) -> Size:
    """Return the roll length at a share of the active flank, from its lowest contact point (0) to the tip (1)."""

    def size(setup: Setup, member: Member) -> float:
        active = active_flank(setup, member)
        return active.lowest + share * (active.tip - active.lowest)

    return size
