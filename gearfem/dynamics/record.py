"""What the dynamics stage takes and hands on: the drive train and its motions."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from numpy.typing import NDArray

from gearfem.foundation import Array, InputError, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class DriveTrain(Record):
    """Two inertias, their torques and the losses between them.

    Parameters
    ----------
    pinion_inertia, wheel_inertia : float
        Moments of inertia reduced to the two shafts [kg m2].
    pinion_torque, wheel_torque : float
        Driving torque and braking torque, both positive [N m]. Each model scales the wheel's to its own balance.
    efficiency : float
        Efficiency of the drive, used by the rigid model alone.
    pinion_speed : float
        Mean angular velocity of the pinion [rad/s].
    friction_coefficient, damping_ratio : float
        Coefficient of tooth friction; zeta of D = 2 zeta sqrt(C M).
    """

    pinion_inertia: float
    wheel_inertia: float
    pinion_torque: float
    wheel_torque: float
    efficiency: float
    pinion_speed: float
    friction_coefficient: float
    damping_ratio: float

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("pinion_inertia", "wheel_inertia", "pinion_torque", "wheel_torque", "pinion_speed"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(name, getattr(self, name), "a positive number")
        for name in ("friction_coefficient", "damping_ratio"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise InputError(name, getattr(self, name), "zero or a positive number")
        if not 0.0 < self.efficiency <= 1.0:
            raise InputError("efficiency", self.efficiency, "above 0, up to 1")


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class RigidMotion(Record):
    """Periodic motion of the rigid model over one period of the gear ratio; arrays have shape (n,).

    Parameters
    ----------
    period : float
        Pinion angle after which the motion repeats [rad]; the samples leave out its end.
    pinion_angle, wheel_angle, time : ndarray
        [rad], [rad], [s]; wheel angle and time count from the first sample.
    pinion_speed, pinion_acceleration, wheel_acceleration : ndarray
        [rad/s], [rad/s2], [rad/s2].
    dynamic_factor : ndarray
        Kw = 1 - J1 phi1''/T1.
    wheel_torque : float
        Braking torque at which the work over one period balances [N m].
    step_error : float
        Largest change of Kw when every second sample is left out: a bound on the error of the angle step, beside kinks too.
    """

    period: float
    pinion_angle: Array
    wheel_angle: Array
    time: Array
    pinion_speed: Array
    pinion_acceleration: Array
    wheel_acceleration: Array
    dynamic_factor: Array
    wheel_torque: float
    step_error: float


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class ElasticMotion(Record):
    """Steady motion of the elastic model; arrays have shape (n,) unless stated.

    Parameters
    ----------
    time, pinion_angle : ndarray
        [s] and [rad], whole mesh cycles.
    mesh_force : ndarray
        Normal force along the line of action [N], positive on the working flank.
    transmission_error : ndarray
        Lag of the wheel, along the line of action [m].
    pinion_speed, pinion_acceleration : ndarray
        Absolute motion of the pinion, psi1' and psi1'' [rad/s], [rad/s2].
    dynamic_factor : ndarray
        Kw = 1 - J1 psi1''/T1.
    wheel_torque : float
        Braking torque at which the mean power of the orbit balances [N m].
    multipliers : ndarray of complex, shape (2,)
        Floquet multipliers of the relative motion; empty where no periodic orbit was found. The common rotation has
        two more, both 1 (angle and, since no torque depends on the speed, speed), which the mean speed settles.
    periodic : bool
        Whether the motion is a stable periodic orbit; if not, it is a transient's tail, statistics only.
    contact_loss : float
        Fraction of the time without contact on the working flank.
    closure : float
        Largest mismatch of the relative state, and of the pinion's speed, over one cycle, in units of the mean
        deflection and that times the natural frequency; of the last cycle where the motion is not periodic.
    """

    time: Array
    pinion_angle: Array
    mesh_force: Array
    transmission_error: Array
    pinion_speed: Array
    pinion_acceleration: Array
    dynamic_factor: Array
    wheel_torque: float
    multipliers: NDArray[Any]
    periodic: bool
    contact_loss: float
    closure: float

    @property
    def largest_dynamic_factor(self) -> float:
        """Largest Kw of the motion."""
        return float(self.dynamic_factor.max())
