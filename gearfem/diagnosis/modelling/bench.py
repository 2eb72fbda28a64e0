"""What the diagnosis asks of the model: predictions of records, and how single teeth weigh in them."""

from __future__ import annotations

import dataclasses
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.dynamics.linear_train import LinearTrain
from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Settings(Record):
    """What is never exactly as the model's owner believes; all neutral by default.

    Parameters
    ----------
    pinion_late, wheel_late : ndarray, shapes (z1,), (z2,)
        Index errors that come on top of the model's [m], positive where a tooth comes into contact late.
    angle_offset : float
        True pinion angle less the recorded one [rad].
    torque_scale, stiffness_scale, inertia_scale, damping_scale : float
        True value over the model's, or the record's: torque, stiffness of everything that yields, inertias, damping ratio.
    gain : float
        Reading over true value of angle series, accelerations and stiffness.
    series_compliance : float
        Compliance along the line of action that the model misses, in series with all pairs [m/N]; negative where it has too much.
    coupling_scale, tip_edge_scale : float
        What neighbour teeth feel through the bodies, and the radius of the tip edges, true over the model's.
    evenness : float
        How far contact over tip edges yields as on the flanks, from 0 to 1; on top of what the model says of it.
    errors : tuple of float
        How far the model is wrong in each way of `gearfem.variants`, in standard deviations; empty: in none.
    """

    pinion_late: Array
    wheel_late: Array
    angle_offset: float = 0.0
    torque_scale: float = 1.0
    stiffness_scale: float = 1.0
    inertia_scale: float = 1.0
    damping_scale: float = 1.0
    gain: float = 1.0
    series_compliance: float = 0.0
    coupling_scale: float = 1.0
    tip_edge_scale: float = 1.0
    evenness: float = 0.0
    errors: tuple[float, ...] = ()

    def with_teeth_of(self, other: Settings) -> Settings:
        """Return the same settings with the index errors of others."""
        return dataclasses.replace(self, pinion_late=other.pinion_late, wheel_late=other.wheel_late)


def neutral(pair: GearPair) -> Settings:
    """Return the settings of a model that is exactly right."""
    return Settings(pinion_late=np.zeros(pair.pinion.teeth), wheel_late=np.zeros(pair.wheel.teeth))


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Weights(Record):
    """Derivatives of the slow transmission error over the index errors of the teeth in reach, at n angles.

    Parameters
    ----------
    pairs : ndarray of int, shape (n, p)
        Numbers of the pairs.
    pinion, wheel : ndarray, shape (n, p)
        Derivatives over the lateness of either tooth of each pair; 0 where the pair bears no load.
    """

    pairs: NDArray[Any]
    pinion: Array
    wheel: Array


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Oscillator(Record):
    """The gears on their mean mesh stiffness: how errors of the teeth come through at speed.

    Parameters
    ----------
    frequency : float
        Natural angular frequency [rad/s].
    ratio : float
        Damping ratio.
    fastest, slowest : float
        Largest natural frequency [rad/s] and least decay [1/s] of all that moves, supports and shafts included.
    acceleration : float
        Angular acceleration of the pinion per second derivative of the transmission error [rad/m].
    """

    frequency: float
    ratio: float
    fastest: float
    slowest: float
    acceleration: float


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Swing(Record):
    """A motion at n angles, and how small errors of the teeth change it.

    Parameters
    ----------
    weights : Weights
        Of the teeth under the load that the motion puts on them.
    shares : Weights
        Shares of the pairs in that load, with which the damper sees their gaps.
    stiffness : ndarray, shape (n,)
        Slope of the force of the mesh over its deflection [N/m].
    damping : float
        Of the mesh [N s/m].
    train : LinearTrain
        What moves, without the teeth.
    base1, base2 : float
        Base radii [m].
    """

    weights: Weights
    shares: Weights
    stiffness: Array
    damping: float
    train: LinearTrain
    base1: float
    base2: float


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Peaks(Record):
    """The largest Kw of a turn of the pinion.

    Parameters
    ----------
    angle : float
        Recorded angle where it is [rad].
    share : float
        What Kw gains there by a reading of the pinion's acceleration [s2/rad].
    factors : ndarray, shape (z1,)
        Largest reading of each pitch.
    """

    angle: float
    share: float
    factors: Array


class Bench(Protocol):
    """A model on the bench."""

    @property
    def pair(self) -> GearPair:
        """The gears."""

    @property
    def gain(self) -> float:
        """Reading of the instrument over the true value."""

    @property
    def delay(self) -> float:
        """Time by which the instrument reads late [s]."""

    def turned(self, axis: Array, settings: Settings) -> Array:
        """Return true pinion angles [rad] from recorded ones."""

    def predict(self, record: Measurement, settings: Settings) -> Array:
        """Return what the record would read [SI], shape (n,): its axis in true angles plus no constant, instrument included."""

    def weights(self, angle: Array, torque: float, settings: Settings) -> Weights:
        """Return the weights of the teeth in the slow transmission error at true pinion angles [rad] and a stated torque [N m]."""

    def unloaded(self, angle: Array, torque: float, settings: Settings) -> Array:
        """Return the transmission error [m] at true pinion angles [rad] under a hundredth of a stated torque [N m], without ripple."""

    def oscillator(self, torque: float, settings: Settings) -> Oscillator:
        """Return the oscillator of the mesh at a stated torque [N m]."""

    def swing(self, angle: Array, torque: float, speed: float, settings: Settings, kick: tuple[float, float] = (0.0, 0.0)) -> Swing:
        """Return the motion at true pinion angles [rad], a stated torque [N m] and a speed [rad/s], begun with a kick (`march_turns`)."""

    def peaks(self, torque: float, speed: float, settings: Settings) -> Peaks:
        """Return the largest Kw of a turn and of each of its pitches at a stated torque [N m] and a speed [rad/s]."""

    def read(self, motion: Array, step: float) -> Array:
        """Return what the instrument's resonances make of motions at equal steps of time [s], shape (n, k)."""
