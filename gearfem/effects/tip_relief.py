"""Tip relief: metal taken off towards the tip, so that teeth bent by the load come into contact without a blow."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.definition.setup import Member, Setup
from gearfem.effects.effect import Effect, modules, parameter
from gearfem.effects.on_flank import without
from gearfem.effects.roll import active_flank, of_flank
from gearfem.flank import Flanks
from gearfem.foundation import Array


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class TipRelief(Effect):
    """Parabolic tip relief of all teeth of one gear, from the tip circle down."""

    name = "tip_relief"
    stage = "flank"
    repeats = "every tooth"
    sentence = "Tip relief of the {gear}: {amount_um} um at the tip, over {length_mm} mm of roll length"
    source = "ISO 21771, profile modifications; parabolic form"

    gear: Member
    amount: float = parameter("metal missing at the tip", "um", low=0.0, high=modules(0.05), typical=modules(0.004), neutral=0.0)
    length: float = parameter("roll length that is relieved", "mm", low=of_flank(0.02), high=of_flank(1.0), typical=of_flank(0.35))

    def act(self, flanks: Flanks, setup: Setup) -> Flanks:
        """Take the relief from all teeth."""
        start = active_flank(setup, self.gear).tip - self.length

        def depth(roll: Array) -> Array:
            return self.amount * (np.maximum(roll - start, 0.0) / self.length) ** 2

        return without(flanks, self.gear, depth)
