"""Sensor resonance: an instrument on an elastic mount."""

from __future__ import annotations

import dataclasses
import math

from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, parameter
from gearfem.sensing import Instrument, Resonance

# Damping ratio that sensors are likely to have, and its deviation as a factor: piezoelectric ones have 0.01, those with a damper 0.7.
USUAL, FACTOR = 0.084, 2.9


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SensorResonance(Effect):
    """A low-pass of second order on all series taken at speed."""

    name = "sensor_resonance"
    stage = "sensing"
    repeats = "not periodic"
    history = "running"
    sentence = "The instrument resonates at {frequency_Hz} Hz with a damping ratio of {ratio}"
    source = "Seismic sensor, one degree of freedom"

    frequency: float = parameter(
        "natural frequency of the mounted sensor", "Hz", low=1.0, high=math.inf, typical=3000.0, neutral=math.inf, reciprocal=True
    )
    ratio: float = parameter("damping ratio", low=0.001, high=2.0, typical=0.1)

    def unlikely(self) -> tuple[float, ...]:
        """Return the logarithm of the damping ratio, from that of what sensors usually have."""
        return (math.log(self.ratio / USUAL) / math.log(FACTOR),)

    def act(self, instrument: Instrument, setup: Setup) -> Instrument:
        """Put the low-pass behind those that are there; one of infinite frequency passes everything."""
        if math.isinf(self.frequency):
            return instrument
        resonance = Resonance(frequency=self.frequency, ratio=self.ratio)
        return dataclasses.replace(instrument, resonances=(*instrument.resonances, resonance))
