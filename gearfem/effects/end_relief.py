"""End relief: metal taken off near both ends of the face width."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.definition.setup import Member, Setup
from gearfem.effects.effect import Effect, modules, of_width, parameter
from gearfem.flank import Flanks
from gearfem.flank.lead import DISPUTED
from gearfem.foundation import Array


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class EndRelief(Effect):
    """Parabolic relief of all teeth of one gear, from each end of the face width."""

    name = "end_relief"
    stage = "flank"
    repeats = "every tooth"
    either_gear = True
    disputed = DISPUTED
    sentence = "End relief of the {gear}: {amount_um} um at the ends of the face width, over {length_mm} mm each"
    source = "ISO 21771, flank line modifications"

    gear: Member
    amount: float = parameter("metal missing at both ends", "um", low=0.0, high=modules(0.05), typical=modules(0.004), neutral=0.0)
    length: float = parameter(
        "face width that is relieved at each end", "mm", low=of_width(0.02), high=of_width(0.5), typical=of_width(0.2)
    )

    def act(self, flanks: Flanks, setup: Setup) -> Flanks:
        """Take the relief from the common gap: both gears leave the same one."""
        share = self.length / setup.pair.face_width

        def gap(place: Array) -> Array:
            return self.amount * (np.maximum(np.abs(place) - 0.5 + share, 0.0) / share) ** 2

        return dataclasses.replace(flanks, lead=flanks.lead.plus(gap))
