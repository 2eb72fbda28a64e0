"""What a lead adds to the approach of a pair: a curve over the line load for each pair at each angle."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class LeadApproach(Record):
    """Further approach of pairs whose gap opens along the face width, over the logarithm of their mean line load.

    Parameters
    ----------
    start, step : float
        Logarithm of the first line load of the curves, and of the ratio of neighbours [N/m].
    value, rate : ndarray, shape (..., m)
        Further approach at m line loads, and its derivative with respect to the logarithm [m].

    Notes
    -----
    Cubic between the nodes. Below them a power of the load, as where few slices touch; above them, where the whole face width
    touches, it runs into a constant. Value and slope are continuous at both ends.
    """

    start: float
    step: float
    value: Array
    rate: Array

    def at(self, chosen: NDArray[np.bool_]) -> LeadApproach:
        """Return the curves of some of the pairs."""
        return dataclasses.replace(self, value=self.value[chosen], rate=self.rate[chosen])

    def approach(self, force: Array) -> Array:
        """Return the further approach [m] under mean line loads [N/m], shape (...)."""
        return self._read(force)[0]

    def respond(self, force: Array) -> tuple[Array, Array]:
        """Return the further approach [m] and its slope [m per N/m]; that of the smallest load for none."""
        value, rate = self._read(force)
        return value, rate / np.maximum(force, SMALLEST)

    def _read(self, force: Array) -> tuple[Array, Array]:
        """Return the value and its derivative with respect to the logarithm of the load."""
        along = (np.log(np.maximum(force, SMALLEST)) - self.start) / self.step
        last = self.value.shape[-1] - 1
        left = np.clip(np.floor(along), 0, last - 1).astype(int)
        t = np.clip(along - left, 0.0, 1.0)

        def nodes(values: Array) -> tuple[Array, Array]:
            first, second = (np.take_along_axis(values, (left + k)[..., None], axis=-1)[..., 0] for k in (0, 1))
            return first, second

        (y0, y1), (r0, r1) = nodes(self.value), nodes(self.step * self.rate)
        rise = 3.0 * (y1 - y0) - 2.0 * r0 - r1
        bend = 2.0 * (y0 - y1) + r0 + r1
        value = y0 + t * (r0 + t * (rise + t * bend))
        rate = (r0 + t * (2.0 * rise + 3.0 * t * bend)) / self.step
        return self._beyond(self.step * along, last, value, rate)

    def _beyond(self, along: Array, last: int, value: Array, rate: Array) -> tuple[Array, Array]:
        below, above = np.minimum(along, 0.0), np.maximum(along - self.step * last, 0.0)
        power = rate / np.where(value > 0.0, value, 1.0)
        falling = np.exp(np.maximum(power, 0.0) * below)
        fading = np.exp(-above)
        value = np.where(below < 0.0, value * falling, value + rate * (1.0 - fading))
        rate = np.where(below < 0.0, rate * falling, rate * fading)
        return value, rate


# As for Hertz's law: a load no solver tells from none.
SMALLEST = 1e-6
