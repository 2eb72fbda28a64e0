"""What varies with the turns of the gears as sums of waves: torques of both shafts, and the gaps of eccentric gears."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import ArrayLike

from gearfem.definition.setup import Member
from gearfem.dynamics.record import DriveTrain
from gearfem.foundation import Array
from gearfem.placement import Placement, runout_gap


def torque_ripple(drive: DriveTrain, member: Member, pinion_angle: ArrayLike, ratio: float) -> Array:
    """Return how the torque of one gear's shaft varies at pinion angles [rad] [N m]; `ratio` is z2/z1."""
    value: Array = np.zeros_like(np.asarray(pinion_angle, float))
    for amplitude, order, phase in torque_waves(drive, member, ratio):
        value = value + amplitude * np.cos(order * np.asarray(pinion_angle) + phase)
    return value


def slow_torque(drive: DriveTrain, pinion_torque: float, pinion_angle: ArrayLike, ratio: float) -> Array:
    """Return the torque on the pinion of slowly turning gears.

    Parameters
    ----------
    drive : DriveTrain
        With its ripples.
    pinion_torque : float
        Mean torque [N m].
    pinion_angle : array_like, shape (n,)
        [rad].
    ratio : float
        z2/z1.

    Returns
    -------
    ndarray, shape (n,)
        [N m]. Without inertia, a torque on the wheel is seen on the pinion times z1/z2.
    """
    own = torque_ripple(drive, "pinion", pinion_angle, ratio)
    return pinion_torque + own + torque_ripple(drive, "wheel", pinion_angle, ratio) / ratio


def torque_waves(drive: DriveTrain, member: Member, ratio: float) -> Array:
    """Return amplitude [N m], order over the pinion's angle and phase of the ripples of one shaft, shape (m, 3)."""
    turn = 1.0 if member == "pinion" else 1.0 / ratio
    rows = [(ripple.amplitude, ripple.order * turn, ripple.phase) for ripple in drive.ripples if ripple.member == member]
    return np.array(rows, float).reshape(-1, 3)


def gap_waves(placement: Placement) -> Array:
    """Return the common gap of the runouts as waves: amplitude [m], order over the pinion's angle, phase, shape (2, 3)."""
    ratio = placement.pair.ratio
    waves = []
    for alone, quarter, order in (
        (dataclasses.replace(placement, wheel_runout=(0.0, 0.0)), math.pi / 2.0, 1.0),
        (dataclasses.replace(placement, pinion_runout=(0.0, 0.0)), ratio * math.pi / 2.0, 1.0 / ratio),
    ):
        cosine, sine = runout_gap(alone, np.array([0.0, quarter]))[0]
        waves.append([math.hypot(cosine, sine), order, math.atan2(-sine, cosine)])
    return np.array(waves)
