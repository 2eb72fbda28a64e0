"""Contact compliance: a contact that yields more or less than Hertz's."""

from __future__ import annotations

import dataclasses

from gearfem.contact.scaled import Law, ScaledLaw
from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, parameter


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class ContactCompliance(Effect):
    """Compliance of the contact as a multiple of the computed one."""

    name = "contact_compliance"
    stage = "contact"
    repeats = "every tooth"
    history = "running"
    sentence = "The contact of the flanks yields {scale} times as much as computed"
    source = "Roughness, lubricant films and depths of influence other than assumed"

    scale: float = parameter("factor of the approach, for all loads", low=0.05, high=20.0, typical=1.2, neutral=1.0)

    def act(self, law: Law, setup: Setup) -> Law:
        """Scale the approach and its slope."""
        return ScaledLaw(law=law, scale=self.scale)
