"""Sensor gain: an instrument that reads too much or too little."""

from __future__ import annotations

import dataclasses

from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, parameter
from gearfem.sensing import Instrument


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SensorGain(Effect):
    """Readings multiplied by a constant."""

    name = "sensor_gain"
    stage = "sensing"
    repeats = "not periodic"
    history = "running"
    sentence = "The instrument reads {scale} times the true value"
    source = "Calibration error of a sensor"

    scale: float = parameter("reading over true value", low=0.1, high=10.0, typical=1.05, neutral=1.0)

    def act(self, instrument: Instrument, setup: Setup) -> Instrument:
        """Multiply the gain."""
        return dataclasses.replace(instrument, gain=instrument.gain * self.scale)
