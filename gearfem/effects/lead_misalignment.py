"""Misalignment: flanks that meet at an angle along the face width."""

from __future__ import annotations

import dataclasses

from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, modules, parameter
from gearfem.flank import Flanks
from gearfem.flank.lead import DISPUTED


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class LeadMisalignment(Effect):
    """A gap between all flanks that opens evenly along the face width, from none at one end."""

    name = "lead_misalignment"
    stage = "flank"
    repeats = "every tooth"
    history = "mounted"
    disputed = DISPUTED
    sentence = "Misalignment: the gap opens by {slope_um} um over the face width"
    reverse = "Misalignment: the gap opens by {slope_um} um over the face width, from its other end on"
    source = "ISO 6336-1, mesh misalignment"

    slope: float = parameter(
        "gap at the other end of the face width", "um", low=modules(-0.05), high=modules(0.05), typical=modules(0.004), neutral=0.0
    )

    def act(self, flanks: Flanks, setup: Setup) -> Flanks:
        """Open the gap along the face width."""
        return dataclasses.replace(flanks, lead=flanks.lead.plus(lambda place: self.slope * (place + 0.5)))
