"""Body compliance: rims and webs that yield more or less than the solid disc of the model."""

from __future__ import annotations

import dataclasses

from gearfem.compliance import scale_body
from gearfem.compliance.record import Compliance
from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, parameter

# Of what a body held at half of its root circle yields, a hub that is rigid up to eight tenths of it leaves 0.53 to 0.79, and up to nine
# tenths 0.34 to 0.65 (23 to 60 teeth).
LEAST = 0.5
# Bodies that yield five times as much leave 0.28 to 0.35 of the mean mesh stiffness (16 to 66 teeth); the most yielding gear blank of
# ISO 6336-1, a web a fifth as wide as the face and a rim one module thick, leaves 0.74 of it (its C_R). Others may yield more than this.
MOST = 5.0


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class BodyCompliance(Effect):
    """Compliance of both gear bodies as a multiple of the computed one."""

    name = "body_compliance"
    stage = "compliance"
    repeats = "every tooth"
    sentence = "Bodies of both gears yield {scale} times as much as computed"
    source = "Whole gear by finite elements less its tooth held at the root"

    scale: float = parameter("factor of the bodies' share of the compliance", low=0.05, high=20.0, typical=1.5, neutral=1.0)

    def contradicts(self) -> str:
        """Return that no blank does this: most of a body yields right under the tooth, whatever its hub, web or rim."""
        if self.scale < LEAST:
            return "bodies yield less than half as much only on a hub beyond eight tenths of their root circle"
        return "bodies that yield more than five times as much leave a third of the mesh stiffness" if self.scale > MOST else ""

    def act(self, compliance: Compliance, setup: Setup) -> Compliance:
        """Scale the bodies' share and the coupling, which is all theirs."""
        return scale_body(compliance, self.scale)
