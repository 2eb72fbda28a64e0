"""What a comparison hands on: every record beside the model, and where the nuisances went."""

from __future__ import annotations

import dataclasses

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.noise import Noise
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
        What fitted nuisances leave: offset, scales, index errors and waviness of all teeth, errors of our own model.
    scatter : ndarray, shape (n,)
        The part of the fit that is waviness of single teeth, and errors of our own model.
    offset : float
        Fitted constant.
    """

    measurement: Measurement
    noise: Noise
    before: Array
    after: Array
    scatter: Array
    offset: float

    def rms(self, series: Array) -> float:
        """Return the root mean square of a series over the rows that are used [SI]."""
        return self.measurement.rms(series)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Comparison(Record):
    """A campaign beside its model, nuisances fitted.

    Parameters
    ----------
    problem : Problem
        The records of role "fit" with their noise; it is what all further fits start from.
    alone : Fit
        Of the nuisances alone.
    shifts : tuple of Shift
        Where the nuisances went; the teeth's index errors are in `settings`.
    records : tuple of Compared
        The fitted records, in the order of the campaign; hold-out records are not looked at.
    """

    problem: Problem
    alone: Fit
    shifts: tuple[Shift, ...]
    records: tuple[Compared, ...]

    @property
    def campaign(self) -> Campaign:
        """What was measured."""
        return self.problem.campaign

    @property
    def settings(self) -> Settings:
        """Fitted nuisances, index errors included."""
        return self.alone.settings

    @property
    def chi_square(self) -> float:
        """Square of what is left, in the metric of noise and nuisances, linear about the fit; about the number of rows if all is in."""
        residual = self.problem.effective(self.alone.point)
        left, _ = self.problem.whole.measure(residual[:, None], residual)
        return float(left[0, 0])
