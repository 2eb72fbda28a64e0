"""One point of a fit: effects, nuisances, and what they leave."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.effects.effect import Effect
from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Point(Record):
    """Effects and nuisances at one point, and what they leave.

    Parameters
    ----------
    effects : tuple of Effect
        With the parameters of this point.
    unknown : ndarray, shape (k,)
        Nuisances in prior deviations: settings, offsets, teeth, model form.
    predicted : tuple of ndarray
        Of each record [SI], offsets, waviness and forms common to all teeth left out.
    rise : tuple of ndarray, shapes (n,)
        What the largest Kw of a turn was taken to gain by waviness, see `Problem`.
    residual : ndarray, shape (m,)
        Measured less predicted, whitened, what the prediction holds of inner unknowns put back to 0.
    held : ndarray
        What the prediction holds among the inner unknowns: index errors, and errors of the model.
    given, weights : ndarray, shape (r,)
        What a squared whitened row of each record counts where it was solved, and what it deserves here, see `profile`.
    objective : float
        Cost of all records and squares of all nuisances in prior deviations, summed, as if all that is linear nearby were.
    """

    effects: tuple[Effect, ...]
    unknown: Array
    predicted: tuple[Array, ...]
    rise: tuple[Array, ...]
    residual: Array
    held: Array
    given: Array
    weights: Array
    objective: float

    @property
    def stood(self) -> Array:
        """The unknowns of the prediction: those that it holds as they were before they were solved for here, else nothing linear."""
        return np.concatenate([self.unknown[: len(self.unknown) - len(self.held)], self.held])
