"""Body compliance: rims and webs that yield more or less than the solid disc of the model."""

from __future__ import annotations

import dataclasses

from gearfem.compliance import scale_body
from gearfem.compliance.record import Compliance
from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, parameter


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class BodyCompliance(Effect):
    """Compliance of both gear bodies as a multiple of the computed one."""

    name = "body_compliance"
    stage = "compliance"
    repeats = "every tooth"
    sentence = "Bodies of both gears yield {scale} times as much as computed"
    source = "Whole gear by finite elements less its tooth held at the root"

    scale: float = parameter("of the bodies' share of the compliance", low=0.05, high=20.0, typical=1.5, neutral=1.0)

    def act(self, compliance: Compliance, setup: Setup) -> Compliance:
        """Scale the bodies' share and the coupling, which is all theirs."""
        return scale_body(compliance, self.scale)
