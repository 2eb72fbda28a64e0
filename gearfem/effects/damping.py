"""Damping of the mesh."""

from __future__ import annotations

import dataclasses

from gearfem.definition.setup import Member, Setup
from gearfem.dynamics.record import DriveTrain
from gearfem.effects.effect import Effect, parameter


def of_model(setup: Setup, member: Member) -> float:
    """Return the damping ratio of the model."""
    return setup.operation.damping_ratio


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Damping(Effect):
    """Damping ratio that replaces the model's."""

    name = "damping"
    stage = "drive"
    repeats = "not periodic"
    history = "running"
    replaces = True
    sentence = "Damping ratio of {ratio}"
    source = "D = 2 zeta sqrt(C M); Wojnarowski & Onishchenko (2003), eq. 25"

    ratio: float = parameter("zeta of D = 2 zeta sqrt(C M), instead of the model's", low=0.0, high=0.9, typical=0.1, neutral=of_model)

    def act(self, drive: DriveTrain, setup: Setup) -> DriveTrain:
        """Replace the damping ratio."""
        return dataclasses.replace(drive, damping_ratio=self.ratio)
