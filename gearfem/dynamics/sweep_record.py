"""What a speed sweep hands on: one point for each speed and direction."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Literal

import numpy as np

from gearfem.foundation import Array, InputError, Record

Direction = Literal["rest", "up", "down"]
DIRECTIONS: tuple[Direction, ...] = ("rest", "up", "down")


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SweepPoint(Record):
    """The steady motion at one speed.

    Parameters
    ----------
    direction : {"rest", "up", "down"}
        Where the search started: the mean deflection at rest, or the motion at the speed below or above.
    pinion_speed, mesh_frequency, natural_frequency : float
        [rad/s], [Hz], [Hz]; the natural one is sqrt(C/M)/(2 pi) of the two gears on the mean slope of the mesh.
    dynamic_factor_max, dynamic_factor_min : float
        Largest and least Kw = 1 - J1 psi1''/T1 = M1/T1.
    mesh_force_max, mesh_force_mean : float
        Largest and mean normal force of all pairs together [N]: positive on the working flank, negative on the back flank.
    error_mean, error_rms : float
        Mean of the dynamic transmission error, and root mean square of what it is off its mean [m].
    harmonic_amplitude, harmonic_phase : ndarray, shape (6,)
        Of the dynamic transmission error, A_n cos(n z1 phi1 + phase_n), n = 1 to 6 [m], [rad], phi1 the uniform rotation from angle 0.
    line_order, line_amplitude : ndarray, shape (k,)
        Amplitudes of the dynamic transmission error [m] and their mesh orders: 1/24 to 6 in 144 steps; over turns, where teeth differ,
        those up to 6 that reach a thousandth of the largest.
    contact_loss, back_contact : float
        Parts of the time without contact on the working flank, and in contact on the back flank.
    period_cycles : int
        Mesh cycles after which the motion repeats, 1, 2, 3, 4, 6, 8, 12 or 24; 0: not periodic, statistics of 96 cycles. Where teeth
        differ: those after which the same ones meet again, over which everything here is taken.
    growth : float
        How much neighbouring motions grow per mesh cycle: the largest magnitude of the Floquet multipliers over the period, to the
        power 1/period_cycles; the mean over the cycles of the statistics where the motion is not periodic (above 1: chaotic;
        below: it repeats after some other number of cycles, or has not settled). Where teeth differ: that of the drive train on the
        mean stiffness of the mesh.
    multiplier_magnitude : ndarray, shape (2,) or (0,)
        Magnitudes of the Floquet multipliers over the period; empty where there is none.
    wheel_torque : float
        Braking torque at which the mean power balances [N m].
    state : ndarray, shape (3,) or (2 n,)
        Where the next speed starts: deflection [m] and its rate [m/s] at the table's first angle, wheel torque over the
        frictionless one; where teeth differ, `TurnsMotion.end`.
    steps : int
        Steps per mesh cycle.
    """

    direction: Direction
    pinion_speed: float
    mesh_frequency: float
    natural_frequency: float
    dynamic_factor_max: float
    dynamic_factor_min: float
    mesh_force_max: float
    mesh_force_mean: float
    error_mean: float
    error_rms: float
    harmonic_amplitude: Array
    harmonic_phase: Array
    line_order: Array
    line_amplitude: Array
    contact_loss: float
    back_contact: float
    period_cycles: int
    growth: float
    multiplier_magnitude: Array
    wheel_torque: float
    state: Array
    steps: int

    @property
    def tuning(self) -> float:
        """Mesh frequency over natural frequency: resonances near 1, 1/2, 1/3 and, parametric, 2."""
        return self.mesh_frequency / self.natural_frequency


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Failure(Record):
    """A speed without a motion to report, and why.

    Parameters
    ----------
    direction : {"rest", "up", "down"}
        As `SweepPoint`; the next speed starts from rest.
    pinion_speed : float
        [rad/s].
    reason : str
        One sentence.
    """

    direction: Direction
    pinion_speed: float
    reason: str


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Sweep(Record):
    """Steady motion over the speed.

    Parameters
    ----------
    points : tuple of SweepPoint
        By direction, then by speed.
    failures : tuple of Failure
        Speeds that have no point, in the same order.
    """

    points: tuple[SweepPoint, ...]
    failures: tuple[Failure, ...] = ()

    @classmethod
    def of(cls, found: Iterable[SweepPoint | Failure]) -> Sweep:
        """Return the sweep of points and failures in any order."""
        ordered = sorted(found, key=lambda one: (DIRECTIONS.index(one.direction), one.pinion_speed))
        return cls(
            points=tuple(one for one in ordered if isinstance(one, SweepPoint)),
            failures=tuple(one for one in ordered if isinstance(one, Failure)),
        )

    def branch(self, direction: Direction) -> tuple[SweepPoint, ...]:
        """Return the points of one direction, by increasing speed; none if it was not run."""
        return tuple(point for point in self.points if point.direction == direction)

    @property
    def directions(self) -> tuple[Direction, ...]:
        """Directions that hold points."""
        return tuple(name for name in DIRECTIONS if self.branch(name))

    def column(self, name: str, direction: Direction) -> Array:
        """Return one number of every point of a direction, by increasing speed.

        Parameters
        ----------
        name : str
            A number of `SweepPoint`, such as "dynamic_factor_max".
        direction : {"rest", "up", "down"}
            Which points.

        Returns
        -------
        ndarray, shape (n,) or (n, k)

        Raises
        ------
        InputError
            If there is no such number.
        """
        if not hasattr(SweepPoint, name) and name not in SweepPoint.__dataclass_fields__:
            raise InputError("sweep column", name, ", ".join(SweepPoint.__dataclass_fields__))
        return np.array([getattr(point, name) for point in self.branch(direction)])
