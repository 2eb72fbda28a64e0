"""Pitting: a hollow over part of one flank."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.definition.setup import Member, Setup
from gearfem.effects.effect import Effect, modules, parameter
from gearfem.effects.on_flank import without
from gearfem.effects.roll import of_flank, up_flank
from gearfem.flank import Flanks
from gearfem.foundation import Array

# Of a hollow with a flat bottom and steep ends the best bell, 1.7 times as wide, leaves 9 % of the squares.
FORM = 0.3


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Pitting(Effect):
    """A hollow over the whole face width of one flank: a cosine bell in roll length."""

    name = "pitting"
    stage = "flank"
    repeats = "one tooth"
    history = "worn"
    form = FORM
    sentence = "Pitting on tooth {tooth} of the {gear}: {depth_um} um deep over {width_mm} mm of roll length around {centre_mm} mm"
    source = "ISO 10825, pitting; the bell is an idealisation"

    gear: Member
    tooth: int
    depth: float = parameter("depth in the middle", "um", low=0.0, high=modules(0.1), typical=modules(0.005), neutral=0.0)
    centre: float = parameter(
        "middle of the hollow, as roll length from the base circle",
        "mm",
        low=up_flank(0.0),
        high=up_flank(1.0),
        typical=up_flank(0.4),
        place=True,
    )
    width: float = parameter("roll length from end to end", "mm", low=of_flank(0.05), high=of_flank(1.0), typical=of_flank(0.3))

    def act(self, flanks: Flanks, setup: Setup) -> Flanks:
        """Take the hollow from the one tooth."""

        def depth(roll: Array) -> Array:
            part = np.clip((roll - self.centre) / self.width, -0.5, 0.5)
            return self.depth * 0.5 * (1.0 + np.cos(2.0 * np.pi * part))

        return without(flanks, self.gear, depth, self.tooth)
