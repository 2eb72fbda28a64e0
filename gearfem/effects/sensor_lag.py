"""Sensor lag: readings that come late."""

from __future__ import annotations

import dataclasses

from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, parameter
from gearfem.sensing import Instrument


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SensorLag(Effect):
    """A constant delay of all series taken at speed."""

    name = "sensor_lag"
    stage = "sensing"
    repeats = "not periodic"
    history = "running"
    sentence = "Readings come {delay_s} s late"
    source = "Filters and buffers of a measuring chain"

    delay: float = parameter("delay between motion and reading", "s", low=0.0, high=0.1, typical=50e-6, neutral=0.0)

    def act(self, instrument: Instrument, setup: Setup) -> Instrument:
        """Add the delay."""
        return dataclasses.replace(instrument, delay=instrument.delay + self.delay)
