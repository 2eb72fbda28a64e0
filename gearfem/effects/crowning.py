"""Crowning: flanks that are thinner towards both ends of the face width."""

from __future__ import annotations

import dataclasses

from gearfem.definition.setup import Member, Setup
from gearfem.effects.effect import Effect, modules, parameter
from gearfem.flank import Flanks
from gearfem.flank.lead import DISPUTED


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Crowning(Effect):
    """Parabolic crowning of all teeth of one gear."""

    name = "crowning"
    stage = "flank"
    repeats = "every tooth"
    either_gear = True
    disputed = DISPUTED
    sentence = "Crowning of the {gear}: {amount_um} um of metal missing at both ends of the face width"
    source = "ISO 21771, flank line modifications"

    gear: Member
    amount: float = parameter("metal missing at both ends", "um", low=0.0, high=modules(0.05), typical=modules(0.003), neutral=0.0)

    def act(self, flanks: Flanks, setup: Setup) -> Flanks:
        """Take the crowning from the common gap: both gears leave the same one."""
        return dataclasses.replace(flanks, lead=flanks.lead.plus(lambda place: self.amount * (2.0 * place) ** 2))
