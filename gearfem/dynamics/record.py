"""What the dynamics stage takes and hands on: the drive train and its motions."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.drive_parts import ShaftedInertia, Support
from gearfem.definition.setup import Member
from gearfem.foundation import Array, InputError, Record

Part = TypeVar("Part", bound=Record)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Ripple(Record):
    """A torque that varies as amplitude x cos(order x angle + phase) with the angle of its own shaft.

    Parameters
    ----------
    member : {"pinion", "wheel"}
        Whose torque varies: the pinion's driving torque or the wheel's braking torque.
    order, amplitude, phase : float
        Cycles to a turn of that shaft, amplitude [N m] and phase [rad].
    """

    member: Member
    order: float
    amplitude: float
    phase: float


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class DriveTrain(Record):
    """Two inertias, their torques and the losses between them; further inertias and yielding supports where stated.

    Parameters
    ----------
    pinion_inertia, wheel_inertia : float
        Moments of inertia that turn with the two gears: without chains, of all that is on their shafts [kg m2].
    pinion_torque, wheel_torque : float
        Driving torque and braking torque, both positive [N m]. Each model scales the wheel's to its own balance.
    efficiency : float
        Efficiency of the drive, used by the rigid model alone.
    pinion_speed : float
        Mean angular velocity of the pinion [rad/s].
    friction_coefficient, damping_ratio : float
        Coefficient of tooth friction; zeta of D = 2 zeta sqrt(C M), M of the two gears alone.
    pinion_chain, wheel_chain : tuple of ShaftedInertia
        Further inertias on elastic shafts, from the gear outward; the last one carries the side's torque. Those on the
        wheel's side turn as the wheel does.
    pinion_support, wheel_support : Support, optional
        Yielding supports along the line of action; None is rigid.
    pinion_mass, wheel_mass : float
        Masses of the gears, which move where a placement gives them supports [kg]; 0 leaves those without mass.
    ripples : tuple of Ripple
        Torques that vary with the turns of a shaft, added to the two steady ones.
    """

    pinion_inertia: float
    wheel_inertia: float
    pinion_torque: float
    wheel_torque: float
    efficiency: float
    pinion_speed: float
    friction_coefficient: float
    damping_ratio: float
    pinion_chain: tuple[ShaftedInertia, ...] = ()
    wheel_chain: tuple[ShaftedInertia, ...] = ()
    pinion_support: Support | None = None
    wheel_support: Support | None = None
    pinion_mass: float = 0.0
    wheel_mass: float = 0.0
    ripples: tuple[Ripple, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("pinion_inertia", "wheel_inertia", "pinion_torque", "wheel_torque", "pinion_speed"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(name, getattr(self, name), "a positive number")
        for name in ("friction_coefficient", "damping_ratio", "pinion_mass", "wheel_mass"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise InputError(name, getattr(self, name), "zero or a positive number")
        if not 0.0 < self.efficiency <= 1.0:
            raise InputError("efficiency", self.efficiency, "above 0, up to 1")

    @property
    def two_inertias(self) -> bool:
        """Whether nothing is joined to the two gears."""
        return not (self.pinion_chain or self.wheel_chain or self.pinion_support or self.wheel_support)

    def over(self, divisor: float) -> DriveTrain:
        """Return the train with every force divided: inertias, masses, torques, springs and dampers; it moves as before."""

        def less(part: Part, *fields: str) -> Part:
            return dataclasses.replace(part, **{field: getattr(part, field) / divisor for field in fields})

        def held(support: Support | None) -> Support | None:
            return support and less(dataclasses.replace(support, compliance=support.compliance * divisor), "mass", "damping")

        def chain(parts: tuple[ShaftedInertia, ...]) -> tuple[ShaftedInertia, ...]:
            return tuple(less(part, "inertia", "stiffness", "damping") for part in parts)

        own = less(self, "pinion_inertia", "wheel_inertia", "pinion_torque", "wheel_torque", "pinion_mass", "wheel_mass")
        return dataclasses.replace(
            own,
            pinion_chain=chain(self.pinion_chain),
            wheel_chain=chain(self.wheel_chain),
            pinion_support=held(self.pinion_support),
            wheel_support=held(self.wheel_support),
            ripples=tuple(less(ripple, "amplitude") for ripple in self.ripples),
        )

    @property
    def pinion_side_inertia(self) -> float:
        """Inertia of the pinion and everything on its shafts [kg m2]."""
        return self.pinion_inertia + sum(part.inertia for part in self.pinion_chain)

    @property
    def wheel_side_inertia(self) -> float:
        """Inertia of the wheel and everything on its shafts [kg m2]."""
        return self.wheel_inertia + sum(part.inertia for part in self.wheel_chain)


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
        Kw = 1 - J1 phi1''/T1, J1 of the whole side: the load on the teeth.
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
        Kw = M1/T1, M1 the moment of the teeth on the pinion; 1 - J1 psi1''/T1 where T1 acts on the pinion itself.
    wheel_torque : float
        Braking torque at which the mean power of the orbit balances [N m].
    multipliers : ndarray of complex, shape (2 + 2 k,)
        Floquet multipliers of the relative motion, k the shafts and supports that yield; empty where no periodic orbit
        was found. The common rotation has two more, both 1 (angle and, since no torque depends on the speed, speed),
        which the mean speed settles.
    periodic : bool
        Whether the motion is a stable periodic orbit; if not, it is a transient's tail, statistics only.
    contact_loss : float
        Fraction of the time without contact on the working flank.
    closure : float
        Largest mismatch of the relative state, and of the pinion's speed, over one cycle, in units of the mean
        deflection and that times the natural frequency; of the last cycle where the motion is not periodic.
    stretch_load : ndarray, shape (k, n)
        Torque of each shaft [N m], pinion's side first, then force of each support [N], positive as the working load.
    stretch_names : tuple of str
        Names of these.
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
    stretch_load: Array = dataclasses.field(default_factory=lambda: np.empty((0, 0)))
    stretch_names: tuple[str, ...] = ()

    @property
    def largest_dynamic_factor(self) -> float:
        """Largest Kw of the motion."""
        return float(self.dynamic_factor.max())
