"""Runout: a gear that turns about an axis beside the centre of its toothing."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from gearfem.definition.setup import Member, Setup
from gearfem.effects.effect import Effect, modules, parameter
from gearfem.placement import Placement


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Runout(Effect):
    """One gear mounted with an eccentricity."""

    name = "runout"
    stage = "placement"
    repeats = "once a turn"
    history = "mounted"
    sentence = "Runout of the {gear}: eccentricity of {eccentricity_um} um, its largest radius at {angle_rad} rad from tooth 0"
    source = "ISO 1328-2, radial runout"

    gear: Member
    eccentricity: float = parameter(
        "distance between the centre of the toothing and the axis", "um", low=0.0, high=modules(0.5), typical=modules(0.004), neutral=0.0
    )
    angle: float = parameter(
        "angle of the largest radius, on the gear, from the centre of tooth 0 in counting direction",
        "rad",
        low=-2.0 * math.pi,
        high=2.0 * math.pi,
        typical=1.0,
    )

    def act(self, placement: Placement, setup: Setup) -> Placement:
        """Move the centre of the toothing; eccentricities add as vectors."""
        towards, along = placement.pinion_runout if self.gear == "pinion" else placement.wheel_runout
        towards += self.eccentricity * math.cos(self.angle)
        along += self.eccentricity * math.sin(self.angle)
        changes: dict[str, Any] = {f"{self.gear}_runout": (towards, along)}
        return dataclasses.replace(placement, **changes)
