"""Torque ripple: a motor or load whose torque varies with the turns of its shaft."""

from __future__ import annotations

import dataclasses
import math

from gearfem.definition.setup import Member, Setup
from gearfem.dynamics.record import DriveTrain, Ripple
from gearfem.effects.effect import Effect, Size, parameter


def of_torque(share: float) -> Size:
    """Return a share of the operation torque of a gear [N m]."""
    return lambda setup, member: share * (setup.operation.pinion_torque if member == "pinion" else setup.operation.wheel_torque)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class TorqueRipple(Effect):
    """A torque A cos(order x angle + phase) on one gear, over the angle of its own shaft."""

    name = "torque_ripple"
    stage = "drive"
    repeats = "once a turn"
    history = "running"
    sentence = "Torque on the {gear} varies by {amplitude_Nm} N m at order {order} of its shaft, phase {phase_rad} rad"
    source = "Pole and cogging torques of electric machines, combustion orders"

    gear: Member
    order: float = parameter("cycles to a turn of the shaft", low=0.01, high=1000.0, typical=2.0, whole=True)
    amplitude: float = parameter(
        "amplitude of the torque on that gear", "Nm", low=0.0, high=of_torque(1.0), typical=of_torque(0.05), neutral=0.0
    )
    phase: float = parameter("phase at angle 0", "rad", low=-2.0 * math.pi, high=2.0 * math.pi, typical=0.5)

    def act(self, drive: DriveTrain, setup: Setup) -> DriveTrain:
        """Add the ripple to those of the drive train."""
        ripple = Ripple(member=self.gear, order=self.order, amplitude=self.amplitude, phase=self.phase)
        return dataclasses.replace(drive, ripples=(*drive.ripples, ripple))
