"""The elastic motion of gears whose teeth differ, which repeats only after whole turns."""

from __future__ import annotations

import math

import numpy as np

from gearfem.dynamics.record import DriveTrain, ElasticMotion
from gearfem.dynamics.turns import march_turns
from gearfem.engagement.turns import Turns

# Angles to the pitch that are handed on.
ANGLES = 128


def uneven_motion(turns: Turns, drive: DriveTrain) -> ElasticMotion:
    """Return the steady motion over as many whole turns of the pinion as bring every tooth of both gears into contact.

    Parameters
    ----------
    turns : Turns
        The gears, teeth of any kind.
    drive : DriveTrain
        Two inertias, their torques with ripples, friction and damping.

    Returns
    -------
    ElasticMotion
        At equal steps of the angle; `closure` is what remains of the start after the run-in, and there are no multipliers.

    Raises
    ------
    InputError, SolveError
        As `march_turns`.

    Notes
    -----
    Time runs at the mean speed; the speed is that plus the integral of the acceleration by the trapezoidal rule, without its mean.
    """
    pair = turns.mesh.placement.pair
    count = max(1, math.ceil(pair.ratio)) * pair.pinion.teeth * ANGLES
    angle = np.arange(count) / ANGLES * pair.pinion.pitch_angle
    motion = march_turns(turns, drive, angle)
    step = float(angle[1]) / drive.pinion_speed
    swing = motion.pinion_acceleration - motion.pinion_acceleration.mean()
    gained = np.concatenate([[0.0], np.cumsum(0.5 * (swing[1:] + swing[:-1])) * step])
    return ElasticMotion(
        time=angle / drive.pinion_speed,
        pinion_angle=angle,
        mesh_force=motion.mesh_force,
        transmission_error=motion.transmission_error,
        pinion_speed=drive.pinion_speed + gained - gained.mean(),
        pinion_acceleration=motion.pinion_acceleration,
        dynamic_factor=motion.dynamic_factor,
        wheel_torque=motion.wheel_torque,
        multipliers=np.empty(0),
        periodic=True,
        contact_loss=motion.contact_loss,
        closure=motion.remains,
    )
