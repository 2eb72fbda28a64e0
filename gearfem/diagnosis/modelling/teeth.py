"""Columns of the scatter of single teeth: index errors and waviness, in records of every kind."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Mapping
from types import ModuleType
from typing import Any, Protocol

import numpy as np
from numpy.polynomial import legendre
from scipy.interpolate import BSpline

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.modelling.bench import Bench, Settings, Swing, Weights
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.foundation import Array, Record
from gearfem.foundation.units import UM

# Ring-down to a thousandth before the record begins, at most so many turns of the pinion; steps in parts of 1/omega.
RING_DOWN, LONGEST_LEAD, STEP = math.log(1e3), 4.0, 0.15
# Response, in parts of the errors or of what they change by in a step, that no resonance reaches: about an unstable motion it has no end.
GROWN = 1e4
# Teeth whose response is followed at once.
TOGETHER = 16


class Forms(Protocol):
    """Forms of a flank over the path of contact."""

    def __call__(self, path: Array, *, derivative: int = 0) -> Array:
        """Return s forms on the path of contact [m], or their slopes over the pinion angle; shape (..., s)."""


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Scatter(Record):
    """What is expected of the single teeth of both gears; neither belongs to an effect.

    Parameters
    ----------
    index : float
        Standard deviation of an index error [m].
    waviness : float
        Standard deviation of a flank about its own mean [m].
    terms : int
        Legendre polynomials over the path of contact that describe the waviness of one flank, from the first degree up.
    rest : mapping of str to ndarray, shapes (n, r), optional
        For means over the pitches: what single teeth still do to each record, by its file [SI], at one deviation each. Index errors
        then stand still, and of either gear the mean tooth is described.
    """

    index: float = 1.0 * UM
    waviness: float = 0.2 * UM
    terms: int = 5
    rest: Mapping[str, Array] | None = None

    @property
    def common(self) -> bool:
        """Whether the mean tooth of either gear is described, and no single ones."""
        return self.rest is not None

    @property
    def left(self) -> int:
        """Number of columns that say what single teeth still do to means."""
        return next(iter(self.rest.values())).shape[1] if self.rest else 0

    def counts(self, pair: GearPair) -> tuple[int, int]:
        """Return how many teeth of either gear are described."""
        return (1, 1) if self.common else (pair.pinion.teeth, pair.wheel.teeth)

    def shapes(self) -> Array:
        """Return the share of each polynomial in a form that is equally likely in all of them, shape (terms,)."""
        return np.asarray(np.sqrt((2.0 * np.arange(1, self.terms + 1) + 1.0) / max(self.terms, 1)))

    def deviations(self, pair: GearPair) -> Array:
        """Return the prior standard deviation of every column [m], shape ((z1 + z2) (terms + 1),)."""
        return np.tile(np.concatenate([[self.index], self.waviness * self.shapes()]), sum(self.counts(pair)))


def tooth_columns(record: Measurement, bench: Bench, settings: Settings, scatter: Scatter, ride: Ride | None = None) -> Array:
    """Return the derivatives of a record over the scatter of all teeth.

    Parameters
    ----------
    record : Measurement
        Any record; stiffness and the largest Kw do not feel scatter to first order, and radial runout not at all.
    bench : Bench
        The model.
    settings : Settings
        Where it stands.
    scatter : Scatter
        How many terms describe a flank.
    ride : Ride, optional
        The motion of a record of one, where it is there already.

    Returns
    -------
    ndarray, shape (n, (z1 + z2) (terms + 1))
        Tooth by tooth, the pinion's first; of each tooth the index error, then the terms of its waviness. Of the mean tooth of either gear
        alone where the scatter describes no others.

    Notes
    -----
    Slow transmission error: the weight of each pair times the polynomial where it touches. At speed the motion is linearised about
    itself, with the weights and the stiffness that its forces give the teeth, see `respond`. Of the largest Kw of a turn see `at_peaks`.
    """
    name, pair, counts = record.quantity.name, bench.pair, scatter.counts(bench.pair)
    way = ride or way_of(record, bench, settings)
    if way is not None:
        forms = functools.partial(_polynomials, pair=pair, terms=scatter.terms)
        return _as_read(felt(record, bench, way, forms, counts, range(sum(counts))), settings.gain * bench.gain, scatter)
    out = np.zeros((len(record.axis), sum(counts), scatter.terms + 1))
    first = counts[0] if record.gear == "wheel" else 0
    if name == "flank_profile":
        assert record.tooth is not None
        tooth = 0 if scatter.common else record.tooth
        out[:, first + tooth, 1:] = _polynomials(_path_of_roll(record, pair), pair, scatter.terms)[:, 1:]
    if name == "pitch_deviation":
        teeth = pair.wheel.teeth if record.gear == "wheel" else pair.pinion.teeth
        out[np.arange(len(record.axis)), first + record.axis.astype(int) % teeth, 0] = 1.0
    return out.reshape(len(record.axis), -1)


def _polynomials(path: Array, pair: GearPair, terms: int, derivative: int = 0) -> Array:
    """Return Legendre polynomials of degree 0 to `terms` over the path of contact [m], 0 at the pitch point; shape (..., terms + 1).

    Their derivative is that over the pinion angle.
    """
    reach = 0.5 * (pair.approach_length + pair.recess_length)
    place = (path - 0.5 * (pair.recess_length - pair.approach_length)) / reach
    values = legendre.legvander(np.clip(place, -1.0, 1.0), terms)
    if not derivative:
        return np.asarray(values)
    slopes = legendre.legder(np.eye(terms + 1), axis=0)
    inside = (np.abs(place) < 1.0)[..., None]
    return np.asarray(np.where(inside, values[..., :terms] @ slopes, 0.0) * pair.pinion.base_radius / reach)


def _as_read(columns: Array, gain: float, scatter: Scatter) -> Array:
    """Return columns of true errors as they are read, in place: index errors times the gain.

    Waviness is expected as it is read: if it were not, a gain would be the likelier the larger it is, since less waviness then suffices.
    A trace of the flank off the rig has it as it is, which differs by the gain.
    """
    columns[:, :: scatter.terms + 1] *= gain
    return columns


def _path_of_roll(record: Measurement, pair: GearPair) -> Array:
    gear, sign = (pair.wheel, -1.0) if record.gear == "wheel" else (pair.pinion, 1.0)
    return sign * (record.axis - gear.base_radius * math.tan(pair.working_pressure_angle))


def _spread(weights: Weights, shapes: Array, counts: tuple[int, int], teeth: range) -> Array:
    """Return the weights of some teeth, of so many of either gear, times the shapes (n, p, s) of all pairs; shape (n, t s)."""
    out = np.zeros((len(shapes), len(teeth), shapes.shape[2]))
    _kernels().spread(weights.pairs, weights.pinion, weights.wheel, shapes, *counts, teeth.start, out)
    return out.reshape(len(shapes), -1)


def _path(weights: Weights, angle: Array, pair: GearPair) -> Array:
    """Return where the pairs touch on the path of contact [m], 0 at the pitch point; shape (n, p)."""
    return np.asarray((angle[:, None] / pair.pinion.pitch_angle - weights.pairs) * pair.base_pitch)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Touch(Record):
    """How single teeth weigh in a slow record: their weights (n, p) at the true pinion angles of its rows, (n,) [rad]."""

    angle: Array
    weights: Weights


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Ride(Record):
    """The motion of a record on a grid of equal steps that begins a ring-down before it, and the way back to the record's rows.

    Parameters
    ----------
    angle : ndarray, shape (g,)
        True pinion angles [rad].
    step : float
        Time step [s].
    swing : Swing
        The motion there.
    between : sparse array, shape (n, g)
        Makes rows of the record.
    """

    angle: Array
    step: float
    swing: Swing
    between: Any

    def rows(self, errors: Array, rates: Array, record: Measurement, bench: Bench) -> Array:
        """Return what small errors of the flanks do to the record, read: errors [m] and rates [m/s] shape (g, k), see `respond`.

        Nothing where the motion is not stable: flanks that part and meet bound what then grows, so that no small error foretells it.
        """
        acceleration = record.quantity.name == "pinion_angular_acceleration"
        moving = respond(errors, rates, self.swing, self.step, acceleration)
        most = GROWN * max(np.abs(errors).max(), np.abs(rates).max() * self.step)
        if not np.abs(moving).max() <= most / (bench.pair.pinion.base_radius * self.step**2 if acceleration else 1.0):
            moving = np.zeros_like(moving)
        return np.asarray(self.between @ bench.read(moving, self.step))


def ride_of(record: Measurement, bench: Bench, settings: Settings) -> Ride:
    """Return the motion of a record of a motion, as a model has it."""
    oscillator = bench.oscillator(record.pinion_torque, settings)
    speed = record.pinion_speed
    axis = record.axis - speed * bench.delay
    step = STEP * speed / oscillator.fastest
    if len(axis) > 1:
        # Whole parts of the record's own steps: where these are equal, nothing is read between the grid's.
        apart = float(np.median(np.diff(axis)))
        step = apart / math.ceil(apart / step)
    ring = RING_DOWN * speed / max(oscillator.slowest, 1e-3 * oscillator.frequency)
    before = math.ceil(min(ring, LONGEST_LEAD * 2.0 * math.pi) / step)
    grid = axis[0] + step * np.arange(-before, math.ceil((axis[-1] - axis[0]) / step) + 2)
    angle = bench.turned(grid, settings)
    return Ride(
        angle=angle,
        step=step / speed,
        swing=bench.swing(angle, record.pinion_torque, speed, settings, record.kick),
        between=BSpline.design_matrix(axis, np.pad(grid, 1, mode="edge"), 1),
    )


def way_of(record: Measurement, bench: Bench, settings: Settings) -> Touch | Ride | None:
    """Return the way in which a record over the pinion angle feels single teeth to first order; None for all others."""
    if record.quantity.name == "static_transmission_error":
        angle = bench.turned(record.axis, settings)
        return Touch(angle=angle, weights=bench.weights(angle, record.pinion_torque, settings))
    return ride_of(record, bench, settings) if record.quantity.is_motion else None


def felt(record: Measurement, bench: Bench, way: Touch | Ride, forms: Forms, counts: tuple[int, int], teeth: range) -> Array:
    """Return what small errors of single flanks do to a record.

    Parameters
    ----------
    record, bench : Measurement, Bench
        A record and the model.
    way : Touch or Ride
        From `way_of`.
    forms : callable
        Errors of a flank [m], positive where it touches late, on the path of contact; see `Forms`.
    counts : tuple of int
        Teeth of either gear.
    teeth : range
        Those wanted, the pinion's first.

    Returns
    -------
    ndarray, shape (n, len(teeth) s)
        Tooth by tooth, the gain of the instrument not counted.
    """
    weights = way.weights if isinstance(way, Touch) else way.swing.weights
    path = _path(weights, way.angle, bench.pair)
    if isinstance(way, Touch):
        return _spread(weights, forms(path), counts, teeth)
    shapes, slopes, out = forms(path), forms(path, derivative=1), []
    # A few teeth at a time: what they do at all steps then stays near the processor.
    for first in range(teeth.start, teeth.stop, TOGETHER):
        group = range(first, min(first + TOGETHER, teeth.stop))
        errors, rates = _spread(weights, shapes, counts, group), _spread(way.swing.shares, slopes, counts, group)
        out.append(way.rows(errors, record.pinion_speed * rates, record, bench))
    return np.concatenate(out, axis=1)


def respond(errors: Array, rates: Array, swing: Swing, step: float, acceleration: bool) -> Array:
    """Return the response of a motion to small errors of the teeth.

    Parameters
    ----------
    errors, rates : ndarray, shape (n, k)
        Errors as they weigh in the slow transmission error [m], and their rates by shares of the load [m/s], at equal steps of time.
    swing : Swing
        The motion at the same times.
    step : float
        Time step [s].
    acceleration : bool
        Whether the pinion's angular acceleration is wanted [rad/s2], or the transmission error [m].

    Returns
    -------
    ndarray, shape (n, k)
        From rest at the first errors.

    Notes
    -----
    y'' = A y + B y' + b P of the coordinates of the train, with P = k(t) (t y - u) + d (t y' - u') and its touch t, linear about the
    motion: two inertias have m x'' + d (x' - u') + k(t) (x - u) = 0. By Newmark's mean acceleration, whose waves are
    (omega step)^2/12 of their length too long.
    """
    train, count, damp = swing.train, swing.train.touch.size, swing.damping
    by_force = train.by_load @ np.array([0.0, swing.base1, 0.0, swing.base2, 1.0])
    pushed = np.outer(by_force[:count], train.touch)
    springs = train.by_place[:count] + swing.stiffness[:, None, None] * pushed
    dampers = train.by_rate[:count] + damp * pushed
    solved = np.linalg.inv(np.eye(count) - 0.25 * step**2 * springs - 0.5 * step * dampers)
    out = np.empty_like(errors)
    _kernels().follow(
        errors,
        rates,
        swing.stiffness,
        damp,
        springs,
        dampers,
        solved,
        by_force,
        train.touch,
        train.by_place[count],
        train.by_rate[count],
        step,
        acceleration,
        out,
    )
    return out


@functools.cache
def _kernels() -> ModuleType:
    """Return the compiled loops; the first call of a process loads the compiler (or its cached code)."""
    from gearfem.diagnosis.modelling import response_kernel as module

    return module
