"""Wear of the working flanks of a gear: least at the pitch point, where nothing slides."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from gearfem.definition.setup import Member, Setup
from gearfem.effects.effect import Effect, modules, parameter
from gearfem.effects.on_flank import without
from gearfem.effects.roll import active_flank
from gearfem.flank import Flanks
from gearfem.foundation import Array
from gearfem.foundation.units import UM

# How much deeper than at the tip or the root wear at the pitch point may be found, in parts of the largest depth.
SLACK = 0.1
# One standard deviation of the depth at the pitch point: a part of what tip and root lose together (root of squares), and at least [m].
# An even depth hardly shows: it turns the gear.
SHARE, LEAST = 0.1, 0.1 * UM


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class ProfileWear(Effect):
    """Wear of all teeth of one gear: a parabola in roll length on each side of the pitch point, with its foot there."""

    name = "profile_wear"
    stage = "flank"
    repeats = "every tooth"
    history = "worn"
    sentence = "Wear of the {gear}: {tip_um} um at the tip, {root_um} um at the lowest contact point, {pitch_um} um at the pitch point"
    source = "Archard's law with the sliding of spur gears, which vanishes at the pitch point; Wojnarowski & Onishchenko (2003), section 1"

    gear: Member
    tip: float = parameter("depth at the tip", "um", low=0.0, high=modules(0.1), typical=modules(0.003), neutral=0.0)
    root: float = parameter(
        "depth at the lowest contact point and below it", "um", low=0.0, high=modules(0.1), typical=modules(0.004), neutral=0.0
    )
    pitch: float = parameter("depth at the pitch point", "um", low=0.0, high=modules(0.1), typical=modules(0.0005), neutral=0.0)

    def contradicts(self) -> str:
        """Return that the pitch point wears more than the tip or the root; by less than a tenth of the largest depth it may."""
        deeper = self.pitch > min(self.tip, self.root) + SLACK * max(self.tip, self.root)
        return "flanks wear least at the pitch point, where nothing slides" if deeper else ""

    def unlikely(self) -> tuple[float, ...]:
        """Return the depth at the pitch point, where nothing slides, over what tip and root make likely."""
        return (self.pitch / math.hypot(SHARE * self.tip, SHARE * self.root, LEAST),)

    def act(self, flanks: Flanks, setup: Setup) -> Flanks:
        """Take the worn metal from all teeth."""
        lowest, middle, tip = active_flank(setup, self.gear)

        def depth(roll: Array) -> Array:
            above = (np.maximum(roll, middle) - middle) / (tip - middle)
            below = (middle - np.clip(roll, lowest, middle)) / (middle - lowest)
            return self.pitch + (self.tip - self.pitch) * above**2 + (self.root - self.pitch) * below**2

        return without(flanks, self.gear, depth)
