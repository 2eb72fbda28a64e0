"""Centre distance: axes that stand closer together or further apart than the model says."""

from __future__ import annotations

import dataclasses

from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, modules, parameter
from gearfem.placement import Placement, mounted


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class CentreDistance(Effect):
    """A change of the working centre distance."""

    name = "centre_distance"
    stage = "placement"
    repeats = "every tooth"
    history = "mounted"
    sentence = "Centre distance larger by {amount_um} um"
    reverse = "Centre distance smaller by {amount_um} um"
    source = "ISO 21771, working centre distance"

    amount: float = parameter(
        "change, positive further apart", "um", low=modules(-0.2), high=modules(0.5), typical=modules(0.02), neutral=0.0
    )

    def act(self, placement: Placement, setup: Setup) -> Placement:
        """Mount the pair at the changed distance; play grows with it."""
        return mounted(placement, placement.centre_distance + self.amount)
