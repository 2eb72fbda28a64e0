"""Support compliance: shafts and bearings that yield under the gears."""

from __future__ import annotations

import dataclasses

from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, parameter
from gearfem.placement import Placement


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SupportCompliance(Effect):
    """Yield of the supports of both gears along the line of action, on which the gears move with their masses.

    Notes
    -----
    Encoders sit on the gears: as the gears move apart by what the supports yield, the wheel lags by as much. Under a steady force that is a
    constant. At speed each gear is a mass between its support and the teeth (`gearfem.dynamics.supports`): that of a solid disc
    between bore and reference circle, since a stated inertia may hold all that is on the shaft; the mass of a support that the model
    states under the same gear comes before it. The support loses 0.5 % of critical, since the model's damping ratio is that of the teeth.
    """

    name = "support_compliance"
    stage = "placement"
    repeats = "not periodic"
    history = "mounted"
    sentence = "Supports yield by {pinion_um_per_kN} um/kN under the pinion and {wheel_um_per_kN} um/kN under the wheel"
    source = "Each gear a mass between two springs, its support and the teeth"

    pinion: float = parameter("yield under the pinion", "um_per_kN", low=0.0, high=1e-6, typical=2e-9, neutral=0.0)
    wheel: float = parameter("yield under the wheel", "um_per_kN", low=0.0, high=1e-6, typical=2e-9, neutral=0.0)

    def act(self, placement: Placement, setup: Setup) -> Placement:
        """Add the yield to that of each gear's support."""
        return dataclasses.replace(
            placement,
            pinion_support=placement.pinion_support + self.pinion,
            wheel_support=placement.wheel_support + self.wheel,
        )
