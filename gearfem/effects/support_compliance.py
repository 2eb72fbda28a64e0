"""Support compliance: shafts and bearings that yield."""

from __future__ import annotations

import dataclasses

from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, parameter
from gearfem.placement import Placement


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SupportCompliance(Effect):
    """Yield of the supports of both gears along the line of action, without mass."""

    name = "support_compliance"
    stage = "placement"
    repeats = "not periodic"
    history = "mounted"
    sentence = "Supports yield by {pinion_um_per_kN} um/kN under the pinion and {wheel_um_per_kN} um/kN under the wheel"
    source = "Two springs in series with the mesh"

    pinion: float = parameter("yield under the pinion", "um_per_kN", low=0.0, high=1e-6, typical=5e-9, neutral=0.0)
    wheel: float = parameter("yield under the wheel", "um_per_kN", low=0.0, high=1e-6, typical=2e-9, neutral=0.0)

    def act(self, placement: Placement, setup: Setup) -> Placement:
        """Add the yield of both supports, which all pairs share."""
        return dataclasses.replace(placement, support=placement.support + self.pinion + self.wheel)
