"""What a fit leaves of all records, and how that speaks for what is named."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy.signal import correlate

from gearfem.diagnosis.comparing.erratic import said
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.roles import ROLES, Role
from gearfem.foundation import Array, Record
from gearfem.foundation.units import digits

# Part of a record over which what is left may be alike.
BLOCKS = 10
# What a record may be left with, in parts of its floor, before that is said.
WIDE = 2.0


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Gap(Record):
    """What is left of one record; SI.

    Parameters
    ----------
    measurement : Measurement
        The record.
    before : ndarray, shape (n,)
        Measured less the model as its owner believes it, angle zero and constant taken off.
    nuisances_only : ndarray, shape (n,)
        Less the model with the nuisances that fit best without any effect.
    smooth : ndarray, shape (n,) or (0,)
        The same less a free smooth correction; empty where the quantity is not over the pinion angle.
    after : ndarray, shape (n,)
        Less the model with the named effects and their nuisances, index errors included; the waviness of single teeth stays.
    offset : float
        Constant of the record under the last of these.
    first_tooth : int
        Tooth that the record begins with, fitted where it is unknown.
    noise_rms : float
        Standard deviation of the sensor.
    floor_rms : float
        What remains if the effects are exactly right: noise and the waviness of single teeth.
    doubt_rms : float
        What the standard deviations of the parameters of the named effects do to what is foretold; 0 of records that were fitted.
    """

    measurement: Measurement
    before: Array
    nuisances_only: Array
    smooth: Array
    after: Array
    offset: float
    first_tooth: int
    noise_rms: float
    floor_rms: float
    doubt_rms: float

    @property
    def expected_rms(self) -> float:
        """What remains if the effects are right, as well as their parameters are known."""
        return math.hypot(self.floor_rms, self.doubt_rms)

    @property
    def counted_rms(self) -> float:
        """What is left counts by: what is expected, and on a record held out more where more is missing with effects or without."""
        least = min(self.rms(self.nuisances_only), self.rms(self.after)) if self.role == "holdout" else 0.0
        return max(self.expected_rms, least)

    @property
    def role(self) -> Role:
        """What the record was for."""
        return self.measurement.role

    def rms(self, series: Array) -> float:
        """Return the root mean square of one of the series over the rows that are used."""
        return self.measurement.rms(series)

    @property
    def closure(self) -> float:
        """Share of the gap above the floor that is closed; 1 is all of it, and all of it where there is none; below 0 it is wider."""
        before, after, floor = (value**2 for value in (self.rms(self.before), self.rms(self.after), self.floor_rms))
        return 1.0 - max(after - floor, 0.0) / (before - floor) if before > floor else 1.0


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Proof(Record):
    """How a frozen fit stands against all records.

    Parameters
    ----------
    records : tuple of Gap
        In the order of the campaign.
    over_nuisances, over_smooth : float or None
        On hold-out records: what nuisances alone, and the smooth correction, leave over what the named effects leave; each in parts of
        what can be expected, or of what both leave open beyond that, root mean square over the records. None without hold-out records or
        effects.
    over_fitted : float or None
        The first of these on the records that were fitted; None without effects, or without such a record over the angle: a handful of
        numbers is met by nuisances as well, at values that are less likely.
    foretold : float or None
        What the first would be if the named effects were right: as far above 1 as these records can show them.
    stderr : float or None
        Standard error of the first: what a model misses stays alike over many rows.
    stands : bool
        Whether the named effects beat both.
    reasons : tuple of str
        The same in words.
    """

    records: tuple[Gap, ...]
    over_nuisances: float | None = None
    over_smooth: float | None = None
    over_fitted: float | None = None
    foretold: float | None = None
    stderr: float | None = None
    stands: bool = False
    reasons: tuple[str, ...]

    def of(self, role: Role) -> tuple[Gap, ...]:
        """Return the records of one role."""
        return tuple(gap for gap in self.records if gap.role == role)


def judged(gaps: tuple[Gap, ...], named: bool) -> Proof:
    """Return how what is left of all records speaks for what is named, if anything is."""
    held = [gap for gap in gaps if gap.measurement.proves]
    fitted = [gap for gap in gaps if gap.role == "fit" and not gap.measurement.erratic]
    over_fitted = _over(fitted) if named and any(gap.measurement.quantity.axis == "angle" for gap in fitted) else None
    still = tuple(_wide(gap) for gap in gaps if gap.rms(gap.after) > WIDE * gap.floor_rms)
    bare = named and all(gap.role == "fit" for gap in gaps)
    words = ("No record is held out: nothing but the fit itself speaks for the name.",) if bare else ()
    still = (*still, *said([gap.measurement for gap in gaps]))
    if not held or not named:
        return Proof(records=gaps, over_fitted=over_fitted, reasons=(*words, *still))
    after, over_nuisances = _pooled([(gap, gap.after) for gap in held]), _over(held)
    corrected = [gap for gap in held if gap.smooth.size]
    over_smooth = _pooled([(g, g.smooth) for g in corrected]) / _pooled([(g, g.after) for g in corrected]) if corrected else None
    foretold = math.hypot(1.0, _pooled([(gap, gap.nuisances_only - gap.after) for gap in held]) / after)
    stderr = _doubt(held) / (2.0 * after**2 * over_nuisances)
    stands = over_nuisances > 1.0 and (over_smooth is None or over_smooth > 1.0)
    compared = [f"{_words('nuisances alone', over_nuisances)} The standard error of this ratio is {stderr:.2g}."]
    if over_smooth is not None:
        compared.append(_words("a free smooth correction", over_smooth))
    return Proof(
        records=gaps,
        over_nuisances=over_nuisances,
        over_smooth=over_smooth,
        over_fitted=over_fitted,
        foretold=foretold,
        stderr=stderr,
        stands=stands,
        reasons=(*compared, *still),
    )


def _wide(gap: Gap) -> str:
    """Return what stays open of a record."""
    scale, unit = gap.measurement.to_file, gap.measurement.quantity.unit
    before, after, floor = (digits(size * scale) for size in (gap.rms(gap.before), gap.rms(gap.after), gap.floor_rms))
    left = f"{after} {unit}".rstrip() + f" are left, {gap.rms(gap.after) / gap.floor_rms:.1f} times the floor of {floor}"
    return f"{gap.measurement.file}, {ROLES[gap.role]}: {left}, {'more than' if gap.closure < 0.0 else 'for'} {before} before."


def _over(gaps: list[Gap]) -> float:
    """Return what nuisances alone leave of records over what the named effects leave."""
    return _pooled([(gap, gap.nuisances_only) for gap in gaps]) / _pooled([(gap, gap.after) for gap in gaps])


def _pooled(gaps: list[tuple[Gap, Array]]) -> float:
    """Return the root mean square over records of what is left, in parts of what that of each counts by."""
    return math.sqrt(sum((gap.rms(series) / gap.counted_rms) ** 2 for gap, series in gaps) / len(gaps))


def _doubt(gaps: list[Gap]) -> float:
    """Return the standard error of the pooled square that nuisances alone leave beyond what the named effects leave.

    That is (2 r + d) d of what these leave, r, and what they do, d, so that r alone is by chance: counted as a stationary series, alike
    over a tenth of its rows at most. A single tooth tells as much as its response stands out, however few rows it has.
    """
    errors = []
    for gap in gaps:
        keep = gap.measurement.keep
        left, does = (series[keep] / gap.counted_rms for series in (gap.after, gap.nuisances_only - gap.after))
        lags = np.arange(1 + left.size // BLOCKS)
        alike, reach = (correlate(series, series)[series.size - 1 :][: lags.size] for series in (left, does))
        taper = np.where(lags > 0, 2.0, 1.0) * (1.0 - lags / lags.size)
        errors.append(2.0 * math.sqrt(max(float(taper @ (alike * reach)), 0.0) / left.size) / left.size)
    return math.hypot(*errors) / len(gaps)


def _words(other: str, ratio: float) -> str:
    if ratio > 1.0:
        return f"On records held out, {other} leave{'s' if other.startswith('a ') else ''} {ratio:.2f} times what the named effects leave."
    return f"On records held out, the named effects do not beat {other}: they leave {1.0 / ratio:.2f} times as much."
