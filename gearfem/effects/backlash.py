"""Backlash: the play between working and idle flanks."""

from __future__ import annotations

import dataclasses

from gearfem.definition.setup import Member, Setup
from gearfem.effects.effect import Effect, modules, parameter
from gearfem.placement import Placement


def of_model(setup: Setup, member: Member) -> float:
    """Return the play of the model at its centre distance [m]."""
    return setup.pair.working_backlash


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Backlash(Effect):
    """Normal backlash that replaces the model's."""

    name = "backlash"
    stage = "placement"
    repeats = "every tooth"
    replaces = True
    sentence = "Normal backlash of {amount_um} um"
    source = "ISO 21771, normal backlash"

    amount: float = parameter(
        "normal backlash, instead of the model's", "um", low=0.0, high=modules(0.5), typical=modules(0.05), neutral=of_model
    )

    def act(self, placement: Placement, setup: Setup) -> Placement:
        """Replace the play; it lies behind the idle flanks, so that working flanks stay where they are."""
        return dataclasses.replace(placement, normal_backlash=self.amount)
