"""What the gears do under the instruments, slowly and at speed, at the angles of a record."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline

from gearfem.dynamics.turns import kw_places, march_turns
from gearfem.dynamics.turns_plan import STRIDE
from gearfem.dynamics.waves import slow_torque
from gearfem.engagement.turns import StaticTurns, Turns, static
from gearfem.foundation import Array
from gearfem.sensing.system import System

Channel = Literal["transmission_error", "pinion_acceleration"]

# Angles to the pitch at which a resonance follows a motion, which is stepped 64 times to the pitch or more.
RINGING_ANGLES = 128
# Slower resonances are excited from these pitches before the record on.
MOST_PITCHES = 2000


def slowly(system: System, angle: Array, stated_torque: float) -> StaticTurns:
    """Return the slow engagement at the angles of a record.

    Parameters
    ----------
    system : System
        The gears.
    angle : ndarray, shape (n,)
        Pinion angles of the record [rad].
    stated_torque : float
        Torque that the record states [N m].

    Returns
    -------
    StaticTurns

    Notes
    -----
    A ripple of the wheel's braking torque reaches the pinion times z1/z2. The gears turn forward, so that friction acts.
    """
    turned = angle + system.setup.calibration.angle_offset
    torque = slow_torque(system.drive, system.torque(stated_torque), turned, system.setup.pair.ratio)
    return static(Turns(mesh=system.mesh), turned, torque, system.drive.friction_coefficient)


def slope(system: System, angle: Array, stated_torque: float) -> Array:
    """Return the slope of the normal force over the deflection on the line of action at the angles of a record [N/m], shape (n,).

    Arguments as for `slowly`. Friction changes the normal force that a torque needs, by steps where sliding reverses, but not how the teeth
    yield to it.
    """
    held = slowly(system, angle, stated_torque)
    pressed = held.force.sum(axis=1) * system.setup.pair.pinion.base_radius
    return static(Turns(mesh=system.mesh), held.pinion_angle, pressed).mesh_stiffness


def at_speed(
    system: System,
    channel: Channel,
    angle: Array,
    stated_torque: float,
    speed: float,
    stride: float = STRIDE,
    kick: tuple[float, float] = (0.0, 0.0),
) -> Array:
    """Return the reading of a motion at speed at the angles of a record.

    Parameters
    ----------
    system : System
        The gears, their drive and the instrument.
    channel : {"transmission_error", "pinion_acceleration"}
        What is read.
    angle : ndarray, shape (n,)
        Pinion angles of the record [rad], which come from an encoder without delay.
    stated_torque, speed : float
        As the record states them [N m], [rad/s].
    stride : float
        Longest step of the motion by 1/omega_n.
    kick : (float, float)
        How it begins, see `march_turns`.

    Returns
    -------
    ndarray, shape (n,)
        [m] or [rad/s2].

    Notes
    -----
    A reading that comes late by tau shows at the angle phi what happened at phi - omega tau. What resonances add is followed on
    equal steps from their settling time before the record on, and read off by a cubic spline.
    """
    turns, instrument = Turns(mesh=system.mesh), system.instrument
    torque = system.torque(stated_torque)
    turned = _turned(system, angle, speed)

    pitch, grid = system.setup.pair.pinion.pitch_angle, np.zeros(0)
    if instrument.resonances:
        before = min(math.ceil(speed * instrument.settling / pitch), MOST_PITCHES) + 1
        first, last = math.floor(turned.min() / pitch) - before, math.ceil(turned.max() / pitch) + 1
        grid = np.arange(first * RINGING_ANGLES, last * RINGING_ANGLES) / RINGING_ANGLES * pitch
    angles, loads = np.concatenate([turned, grid]), channel == "pinion_acceleration"
    motion = march_turns(turns, system.drive, angles, speed=speed, torque=torque, stride=stride, kick=kick, loads=loads)
    value, whole = np.split(getattr(motion, channel), [turned.size])
    if instrument.resonances:
        value = value + CubicSpline(grid, instrument.ringing(whole, pitch / RINGING_ANGLES / speed))(turned)
    return np.asarray(instrument.gain * value)


def least_acceleration(system: System, stated_torque: float, speed: float, stride: float = STRIDE) -> float:
    """Return the least reading of the pinion's acceleration over its first turn [rad/s2].

    Arguments as for `at_speed`. It is that of the steps of the motion; with resonances of the instrument, that of 96 angles to the pitch.
    """
    pinion, instrument = system.setup.pair.pinion, system.instrument
    if instrument.resonances:
        angle = kw_places(pinion.teeth) * pinion.pitch_angle
        return float(at_speed(system, "pinion_acceleration", angle, stated_torque, speed, stride).min())
    turn = _turned(system, np.array([0.0, math.tau]), speed)
    torque = system.torque(stated_torque)
    motion = march_turns(Turns(mesh=system.mesh), system.drive, turn, speed=speed, torque=torque, stride=stride, loads=False)
    return instrument.gain * motion.least_acceleration


def _turned(system: System, angle: Array, speed: float) -> Array:
    """Return how far the pinion had turned when what is read at recorded angles happened [rad]."""
    return np.asarray(angle + system.setup.calibration.angle_offset - speed * system.instrument.delay)
