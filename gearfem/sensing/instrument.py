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

    @property
    def settling(self) -> float:
        """Time [s] after which the resonances have forgotten how they started, to 1e-4."""
        decays = (2.0 * math.pi * resonance.frequency * min(resonance.ratio, 1.0 / resonance.ratio) for resonance in self.resonances)
        return math.log(1e4) / min(decays) if self.resonances else 0.0

    def ringing(self, value: Array, step: float) -> Array:
        """Return what the resonances add to a series.

        Parameters
        ----------
        value : ndarray, shape (n,)
            True values at equal steps of time; they count as repeating, so that the first `settling` of the result is to be left out.
        step : float
            [s].

        Returns
        -------
        ndarray, shape (n,)
            Reading less true value at the same times, gain and delay left out; exactly 0 for rigid mounts.

        Notes
        -----
        Each line of the spectrum is multiplied by the response less 1, exact for motions without lines above half the sampling
        rate.
        """
        frequency: Array = np.fft.rfftfreq(len(value), step).astype(float)
        response = np.ones(len(frequency), complex)
        for resonance in self.resonances:
            response = response * resonance.response(frequency)
        return np.asarray(np.fft.irfft(np.fft.rfft(value) * (response - 1.0), len(value)))
