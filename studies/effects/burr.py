"""A burr at the tip of one tooth: metal that a blow has thrown up, so that the tooth comes into contact early."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.definition.setup import Member, Setup
from gearfem.effects import Effect, modules, parameter
from gearfem.effects.on_flank import without
from gearfem.effects.roll import active_flank, of_flank
from gearfem.flank import Flanks
from gearfem.foundation import Array


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Burr(Effect):
    """Metal that stands out near the tip of one tooth, growing with the third power of the roll length."""

    name = "burr"
    stage = "flank"
    repeats = "one tooth"
    history = "worn"
    sentence = "Burr on tooth {tooth} of the {gear}: {height_um} um at the tip, over {length_mm} mm of roll length"
    source = "An example; the shape is assumed"

    gear: Member
    tooth: int
    height: float = parameter("metal that stands out at the tip", "um", low=0.0, high=modules(0.02), typical=modules(0.002), neutral=0.0)
    length: float = parameter("roll length that it covers", "mm", low=of_flank(0.1), high=of_flank(0.8), typical=of_flank(0.3))

    def act(self, flanks: Flanks, setup: Setup) -> Flanks:
        """Put the burr on the one tooth: negative depth is metal that stands out."""
        start = active_flank(setup, self.gear).tip - self.length

        def depth(roll: Array) -> Array:
            return -self.height * (np.maximum(roll - start, 0.0) / self.length) ** 3

        return without(flanks, self.gear, depth, self.tooth)
