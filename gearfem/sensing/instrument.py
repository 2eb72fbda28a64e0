"""The instrument between a motion and its record: gain, delay, resonance."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from gearfem.foundation import Array, InputError, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Resonance(Record):
    """A low-pass of second order, as of a sensor on an elastic mount.

    Parameters
    ----------
    frequency : float
        Natural frequency [Hz]; infinite for a rigid mount.
    ratio : float
        Damping ratio, positive.
    """

    frequency: float
    ratio: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (self.frequency > 0.0 and 0.0 < self.ratio < math.inf):
            raise InputError("resonance", f"{self.frequency:g} Hz, damping ratio {self.ratio:g}", "positive numbers")

    def response(self, frequency: Array) -> NDArray[np.complex128]:
        """Return 1/(1 - (f/f0)^2 + 2 i zeta f/f0) at frequencies f [Hz]; complex, the same shape."""
        part = frequency / self.frequency
        return np.asarray(1.0 / (1.0 - part**2 + 2j * self.ratio * part))


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Instrument(Record):
    """What the measuring chain makes of every series over the pinion angle.

    Parameters
    ----------
    gain : float
        Reading over true value.
    delay : float
        Time by which readings come late [s].
    resonances : tuple of Resonance
        Low-passes in series.
    """

    gain: float = 1.0
    delay: float = 0.0
    resonances: tuple[Resonance, ...] = ()

    def read_slow(self, value: Array) -> Array:
        """Return the reading of a series taken slowly, where neither delay nor resonance has time to show."""
        return self.gain * value

    def read_periodic(self, value: Array, period: float) -> Array:
        """Return the reading of a motion that repeats.

        Parameters
        ----------
        value : ndarray, shape (n,)
            Equal steps over one period, its end excluded.
        period : float
            Its length in time [s].

        Returns
        -------
        ndarray, shape (n,)
            The steady reading at the same times.

        Notes
        -----
        Each line of the spectrum is multiplied by gain x response x exp(-2 pi i f delay): exact for a motion without lines
        above half the sampling rate. The line at that rate has no phase and keeps its real part.
        """
        if self.delay == 0.0 and not self.resonances:
            return self.gain * value
        frequency: Array = np.fft.rfftfreq(len(value), period / len(value)).astype(float)
        response = np.exp(-2j * np.pi * frequency * self.delay)
        for resonance in self.resonances:
            response = response * resonance.response(frequency)
        return self.gain * np.fft.irfft(np.fft.rfft(value) * response, len(value))
