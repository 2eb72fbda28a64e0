"""Pitch error: one tooth that stands in a wrong place."""

from __future__ import annotations

import dataclasses
from typing import Any

from gearfem.definition.setup import Member, Setup
from gearfem.effects.effect import Effect, modules, parameter
from gearfem.placement import Placement


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class PitchError(Effect):
    """The working flank of one tooth displaced along the line of action."""

    name = "pitch_error"
    stage = "placement"
    repeats = "one tooth"
    sentence = "Pitch error of tooth {tooth} of the {gear}: {amount_um} um late"
    reverse = "Pitch error of tooth {tooth} of the {gear}: {amount_um} um early"
    source = "ISO 1328-1, single pitch deviation"

    gear: Member
    tooth: int
    amount: float = parameter(
        "displacement along the line of action, positive where the tooth comes into contact late",
        "um",
        low=modules(-0.05),
        high=modules(0.05),
        typical=modules(0.003),
        neutral=0.0,
    )

    def act(self, placement: Placement, setup: Setup) -> Placement:
        """Displace the working flank of the tooth."""
        late = (placement.pinion_late if self.gear == "pinion" else placement.wheel_late).copy()
        late[self.tooth] += self.amount
        changes: dict[str, Any] = {f"{self.gear}_late": late}
        return dataclasses.replace(placement, **changes)
