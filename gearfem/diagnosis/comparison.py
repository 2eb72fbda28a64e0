"""What a comparison hands on: every record beside the model, and where the nuisances went."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.diagnosis.bench import Settings
from gearfem.diagnosis.campaign import Campaign, Measurement
from gearfem.diagnosis.linear import Elimination
from gearfem.diagnosis.noise import Noise
from gearfem.diagnosis.teeth import Scatter
from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Shift(Record):
    """Where a nuisance went.

    Parameters
    ----------
    name, words : str
        Field of `Settings`, and what it is.
    value, stderr, prior : float
        Fitted value, its standard deviation and that of the prior [rad for the angle, m for index errors, else dimensionless].
    deviations : float
        Distance from the model's value in prior deviations; beyond three it is a finding.
    """

    name: str
    words: str
    value: float
    stderr: float
    prior: float
    deviations: float


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Compared(Record):
    """One record beside the model; arrays in the rows of the record, SI.

    Parameters
    ----------
    measurement : Measurement
        What was measured.
    noise : Noise
        Its noise.
    before : ndarray, shape (n,)
        Measured less the model as its owner believes it, the unknown constant and angle taken off.
    after : ndarray, shape (n,)
        What fitted nuisances leave: offset, scales, index errors and waviness of all teeth.
    scatter : ndarray, shape (n,)
        The part of the fit that is waviness of single teeth.
    offset : float
        Fitted constant.
    rows : (int, int)
        Where its whitened rows stand in `Comparison.residual`.
    """

    measurement: Measurement
    noise: Noise
    before: Array
    after: Array
    scatter: Array
    offset: float
    rows: tuple[int, int]

    @property
    def white(self) -> Array:
        """The whitened residual after the nuisances, shape (m,)."""
        return self.noise.whitener.apply(self.after)

    def rms(self, series: Array) -> float:
        """Return the root mean square of a series over the rows that are used [SI]."""
        return float(np.sqrt(np.mean(series[self.measurement.keep] ** 2)))


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Comparison(Record):
    """A campaign beside its model, nuisances fitted.

    Parameters
    ----------
    campaign : Campaign
        What was measured.
    settings : Settings
        Fitted nuisances, index errors included.
    scatter : Scatter
        Prior of the single teeth.
    shifts : tuple of Shift
        Where the nuisances went; the teeth's index errors are in `settings`.
    records : tuple of Compared
        The fitted records, in the order of the campaign; hold-out records are not looked at.
    residual : ndarray, shape (m,)
        Whitened rows of all records, linearised at the fit: measured less predicted, nuisances put back to their priors, so that
        `elimination` frees it, and any candidate's whitened signature, from all of them.
    elimination : Elimination
        The nuisances, linear about the fit.
    rounds : int
        Rounds of Gauss and Newton's method that were needed.
    """

    campaign: Campaign
    settings: Settings
    scatter: Scatter
    shifts: tuple[Shift, ...]
    records: tuple[Compared, ...]
    residual: Array
    elimination: Elimination
    rounds: int

    @property
    def chi_square(self) -> float:
        """Square of what is left, in the metric of noise and nuisances; about the number of rows if nothing is missing."""
        return float(self.elimination.gram(self.residual, self.residual))

    def whiten(self, series: tuple[Array, ...]) -> Array:
        """Return series in the rows of the records, shapes (n,) or (n, p), whitened and one below the other."""
        pairs = zip(self.records, series, strict=True)
        return np.concatenate([record.noise.whitener.apply(part) for record, part in pairs])
