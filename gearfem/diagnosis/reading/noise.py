"""The noise of a record: what does not come back with the turns of either gear."""

from __future__ import annotations

import dataclasses
import math
from typing import Literal

import numpy as np
from scipy.signal import lfilter

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.periods import hunting_period, shifted
from gearfem.diagnosis.reading.spikes import MAD
from gearfem.diagnosis.reading.whitening import Whitening, make_whitener
from gearfem.foundation import Array, Record

Basis = Literal["repeats", "remainder", "roughness", "stated", "assumed"]
# Instruments colour their noise by a filter or two; more lags than that describe something else.
LAGS = 4
# Differences of turns that are fewer say less than the roughness of the whole record.
FEWEST = 120
BLOCK = 24
# Parts of a pitch over which all pitches count as alike, and pitches from which on their mean is theirs.
BINS, PITCHES = 24, 6
TRIALS = 16
# Rows from which on third differences tell noise.
ROUGH = 24
# What is assumed where nothing can be measured: Kw is read to 1 % at best, indicators to 1 um, all else to this part of its deviation.
ASSUMED = {"dynamic_factor": 0.01, "radial_runout": 1e-6, "pitch_deviation": 1e-6, "flank_profile": 1e-6}
READ = 0.02
WHERE = {
    "repeats": "what does not repeat",
    "remainder": "what the fitted model leaves, since the record covers too few turns to repeat",
    "roughness": "roughness, since the record covers too few turns to repeat",
}
NOT_ROUGH = ("dynamic_factor", "radial_runout", "pitch_deviation")


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Noise(Record):
    """Noise of one record.

    Parameters
    ----------
    basis : {"repeats", "remainder", "roughness", "stated", "assumed"}
        Where it comes from: what does not repeat, what a fit leaves, what is rougher than any signal, the campaign, or nowhere.
    covariance : ndarray, shape (p + 1,)
        Covariance over lags of 0 to p samples, the square of the quantity's SI unit.
    freedom : float
        Degrees of freedom of the estimate; infinite for a stated one (given as 1e9).
    measured_std : float
        Standard deviation as measured [SI unit]; 0 where it could not be.
    whitener : Whitening
        Makes it white.
    sentence : str
        Where it comes from, and whether it agrees with what the campaign states.
    """

    basis: Basis
    covariance: Array
    freedom: float
    measured_std: float
    whitener: Whitening
    sentence: str

    @property
    def std(self) -> float:
        """Standard deviation [SI unit]."""
        return math.sqrt(float(self.covariance[0]))

    def over(self, record: Measurement) -> Noise:
        """Return the noise of a record over other rows of the same instrument."""
        return dataclasses.replace(self, whitener=make_whitener(self.covariance, record.keep))


def measure_noise(record: Measurement, pair: GearPair, explained: Array | None = None) -> Noise:
    """Return the noise of a record, its colour included.

    Parameters
    ----------
    record : Measurement
        Any record.
    pair : GearPair
        The gears, for the periods of what repeats.
    explained : ndarray, shape (n,), optional
        What a fitted model makes of the record, taken off first: the errors of teeth that share a load act on each other, and such a
        combination of teeth does not come back with either gear.

    Returns
    -------
    Noise

    Notes
    -----
    With y = P + W + noise, P of the pinion's turns and W of the wheel's (the mesh belongs to both), the double difference
    y(x + a + b) - y(x + a) - y(x + b) + y(x) over one turn a of the pinion and one turn b of the wheel holds noise alone, and its
    covariance at lags short against a turn is four times the noise's. Records over a hunting period are differenced over it
    once. Only the quieter half of the differences counts. Shorter records than 1 + z2/z1 turns have no repeats. What a model that was
    fitted to them leaves, less what all pitches have of it, stands in: it holds what no tooth and no error of the model does. Without
    such a fit it is third differences of the samples, taken as white. A stated deviation is a floor. Where more than it does not repeat,
    the rest is taken for teeth that act on each other; where third differences of what a fit leaves show less, noise is smoother than
    white noise. The colour is then that of a process of first order that is as rough.
    """
    if explained is not None:
        record = dataclasses.replace(record, value=record.value - explained)
    rest = _rest(record, pair)
    basis: Basis = "assumed"
    covariance, freedom = np.zeros(1), 1e9
    if rest is not None:
        covariance, freedom = _covariance(*rest)
        basis = "repeats"
    elif explained is not None and record.noise_std is None and _has_pitches(record, pair):
        covariance, freedom = _covariance(_unlike(record, pair), 1)
        basis = "remainder"
    elif record.quantity.name not in NOT_ROUGH and record.keep.sum() >= ROUGH:
        covariance, freedom = _roughness(record.value[record.keep])
        basis = "roughness"
    measured = math.sqrt(float(covariance[0]))
    sentence = _words(basis, measured, freedom, record)
    covariance, basis = _reconciled(covariance, basis, freedom, record, explained is not None)
    return Noise(
        basis=basis,
        covariance=covariance,
        freedom=freedom,
        measured_std=measured,
        whitener=make_whitener(covariance, record.keep),
        sentence=sentence,
    )


def _reconciled(covariance: Array, basis: Basis, freedom: float, record: Measurement, fitted: bool) -> tuple[Array, Basis]:
    """Return the measured covariance, or one of the stated deviation where that is larger, or where the record holds more than noise.

    What is rough is noise only where a fitted model has been taken off.
    """
    measured, stated = math.sqrt(float(covariance[0])), record.noise_std
    if measured == 0.0:
        return np.array([(stated or _assumed(record)) ** 2]), "stated" if stated else "assumed"
    if stated is None:
        return covariance, basis
    if measured > (1.0 + 4.0 / math.sqrt(2.0 * freedom)) * stated:
        return _first_order(stated, roughness(record)), "stated"
    if basis == "roughness" and fitted and measured < stated:
        return _first_order(stated, measured), basis
    return covariance * max(1.0, stated / measured) ** 2, basis


def _assumed(record: Measurement) -> float:
    """Return the deviation of noise that nothing shows [SI]: digits that are lost, or what instruments of its kind do."""
    if record.quantity.name in ASSUMED:
        return ASSUMED[record.quantity.name]
    value = record.value[record.keep]
    steps = np.diff(np.unique(value))
    return max(float(steps.min(initial=np.ptp(value))) / math.sqrt(12.0), READ * float(np.std(value)))


def _first_order(std: float, rough: float) -> Array:
    """Return the covariance of white noise, or of noise of first order whose third differences are smoother than white noise's."""
    smoothness = (rough / std) ** 2
    if smoothness > 0.8:
        return np.array([std**2])
    roots = np.roots([-2.0, 12.0, -30.0, 20.0 * (1.0 - smoothness)])
    memory = float(roots[np.argmin(np.abs(roots.imag))].real)
    return std**2 * np.array([1.0, min(max(memory, 0.0), 0.98)])


def _words(basis: Basis, measured: float, freedom: float, record: Measurement) -> str:
    stated = record.noise_std

    def shown(size: float) -> str:
        return f"{size * record.to_file:.3g} {record.quantity.unit}".rstrip()

    if basis == "assumed":
        return f"noise of {shown(stated or _assumed(record))} {'as stated' if stated else 'assumed: nothing in the record shows it'}"
    text = f"noise of {shown(measured)} from {WHERE[basis]} ({freedom:.0f} degrees of freedom)"
    if stated is None:
        return text
    spread = 1.0 + 4.0 / math.sqrt(2.0 * freedom)
    if measured > spread * stated:
        return f"{text}, {measured / stated:.2g} times the stated {shown(stated)}: teeth act on each other, or something drifts"
    if measured < stated / spread:
        return f"{text}, below the stated {shown(stated)}, which is taken"
    return f"{text}, as stated"


# ---- what does not repeat -----------------------------------------------------------------------------


def _rest(record: Measurement, pair: GearPair) -> tuple[Array, int] | None:
    """Return differences that hold noise alone, and how many samples of it each holds; None where turns are too few."""
    turn = 2.0 * math.pi
    hunting = hunting_period(pair)
    periods: tuple[float, ...] = (hunting,) if np.ptp(record.axis) > 1.2 * hunting else (turn, turn * pair.ratio)
    if record.quantity.axis == "tooth":
        periods = (float(pair.gear(record.gear).teeth),)
    elif record.quantity.axis != "angle":
        return None
    axis, value = record.axis[record.keep], record.value[record.keep]
    for period in periods:
        later, valid = shifted(axis, value, period)
        axis, value = axis[valid], later - value[valid]
    return (value, 2 ** len(periods)) if len(value) >= FEWEST else None


def _has_pitches(record: Measurement, pair: GearPair) -> bool:
    """Return whether a record covers enough pitches to tell what they do not share."""
    rows = record.keep.sum()
    return record.quantity.axis == "angle" and rows >= FEWEST and np.ptp(record.axis[record.keep]) > PITCHES * pair.pinion.pitch_angle


def _unlike(record: Measurement, pair: GearPair) -> Array:
    """Return the kept rows of a record less what all pitches have, which is what a model misses of all teeth; of its variance if white."""
    value = record.value[record.keep]
    place = np.floor(record.axis[record.keep] / pair.pinion.pitch_angle * BINS).astype(int) % BINS
    count = np.bincount(place, minlength=BINS)
    mean = np.bincount(place, value, BINS) / np.maximum(count, 1)
    return np.asarray((value - mean[place]) * math.sqrt(value.size / (value.size - np.count_nonzero(count))))


def _covariance(difference: Array, copies: int) -> tuple[Array, float]:
    """Return the covariance of the noise over the lags that matter, and its degrees of freedom, from the quieter half of the record.

    Where teeth act on each other, at the changes of pairs of a lightly loaded mesh above all, the double difference holds more than
    noise. What choosing the quieter half takes from pure noise is found by doing the same to noise of the colour found.
    """
    raw = _quiet_half(difference)
    if raw[0] <= 0.0:
        return np.zeros(1), float(len(difference))
    rng = np.random.default_rng(1)
    white = rng.standard_normal((TRIALS, len(difference) + 8 * LAGS))
    covariance = raw[: 1 + _order(raw, len(difference))] / copies
    raw = raw[: len(covariance)]
    for _ in range(3):
        model = make_whitener(covariance, np.ones(1, bool))
        taps = np.concatenate([[1.0], -model.predictor[-1]])
        noise = model.deviation[-1] * lfilter([1.0], taps, white, axis=1)[:, 8 * LAGS :]
        seen = np.mean([_quiet_half(one)[: len(raw)] for one in noise], axis=0)
        better = covariance * raw / (copies * seen)
        if not _possible(better):
            break
        covariance = better
    return covariance, 0.5 * len(difference)


def _quiet_half(series: Array) -> Array:
    """Return the covariance over all lags in the half of the blocks that has the least power."""
    count = (len(series) - LAGS) // BLOCK
    size = count * BLOCK
    products = np.stack([(series[:size] * series[lag : lag + size]).reshape(count, BLOCK).mean(axis=1) for lag in range(LAGS + 1)])
    quiet = np.argsort(products[0])[: (count + 1) // 2]
    return np.asarray(products[:, quiet].mean(axis=1))


def _order(covariance: Array, count: int) -> int:
    """Return the order of the autoregression that describes a covariance, by Schwarz' criterion."""
    orders = [k for k in range(len(covariance)) if _possible(covariance[: k + 1])]
    # Half of the differences count, and each holds samples that others hold too.
    return min(orders, key=lambda k: 0.5 * count * _innovation(covariance[: k + 1]) + k * math.log(count))


def _innovation(covariance: Array) -> float:
    """Return the logarithm of the standard deviation of the innovation."""
    return math.log(float(make_whitener(covariance, np.ones(1, bool)).deviation[-1]))


def _possible(covariance: Array) -> bool:
    """Whether there is a process of this covariance."""
    order = len(covariance)
    matrix = covariance[np.abs(np.subtract.outer(np.arange(order), np.arange(order)))]
    return bool(np.linalg.eigvalsh(matrix)[0] > 1e-3 * covariance[0])


def roughness(record: Measurement) -> float:
    """Return the standard deviation of white noise that is as rough as a record [SI]; 0 where that cannot be told."""
    return math.sqrt(float(_roughness(record.value[record.keep])[0][0])) if record.keep.sum() >= ROUGH else 0.0


def _roughness(value: Array) -> tuple[Array, float]:
    """Return the variance of white noise from third differences, by their median, which steps and bends of the signal do not move."""
    rough = np.diff(value, 3) / math.sqrt(20.0)
    return np.array([(MAD * float(np.median(np.abs(rough)))) ** 2]), len(rough) / 3.0
