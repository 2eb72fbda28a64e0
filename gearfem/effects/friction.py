"""Tooth friction."""

from __future__ import annotations

import dataclasses

from gearfem.definition.setup import Member, Setup
from gearfem.dynamics.record import DriveTrain
from gearfem.effects.effect import Effect, parameter


def of_model(setup: Setup, member: Member) -> float:
    """Return the coefficient of the model."""
    return setup.operation.friction_coefficient


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Friction(Effect):
    """Coefficient of friction that replaces the model's."""

    name = "friction"
    stage = "drive"
    repeats = "every tooth"
    history = "running"
    replaces = True
    sentence = "Coefficient of tooth friction of {coefficient}"
    source = "Coulomb's law; Wojnarowski & Onishchenko (2003), eq. 24"

    coefficient: float = parameter("coefficient of friction, instead of the model's", low=0.0, high=0.5, typical=0.08, neutral=of_model)

    def act(self, drive: DriveTrain, setup: Setup) -> DriveTrain:
        """Replace the coefficient."""
        return dataclasses.replace(drive, friction_coefficient=self.coefficient)
