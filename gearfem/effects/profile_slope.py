"""Profile slope: flanks that stand at a wrong pressure angle."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.definition.setup import Member, Setup
from gearfem.effects.effect import Effect, modules, parameter
from gearfem.effects.on_flank import without
from gearfem.effects.roll import active_flank
from gearfem.flank import Flanks
from gearfem.foundation import Array


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class ProfileSlope(Effect):
    """Slope of all flanks of one gear, linear in roll length from the lowest contact point (0) to the tip."""

    name = "profile_slope"
    stage = "flank"
    repeats = "every tooth"
    sentence = "Profile slope of the {gear}: {amount_um} um of metal missing at the tip, none at the lowest contact point"
    reverse = "Profile slope of the {gear}: {amount_um} um of metal too much at the tip, none at the lowest contact point"
    source = "ISO 1328-1, profile slope deviation"

    gear: Member
    amount: float = parameter("metal missing at the tip", "um", low=modules(-0.05), high=modules(0.05), typical=modules(0.003), neutral=0.0)

    def act(self, flanks: Flanks, setup: Setup) -> Flanks:
        """Tilt the flanks of all teeth."""
        lowest, _, tip = active_flank(setup, self.gear)

        def depth(roll: Array) -> Array:
            return self.amount * np.maximum(roll - lowest, 0.0) / (tip - lowest)

        return without(flanks, self.gear, depth)
