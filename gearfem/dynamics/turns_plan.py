"""How a motion over turns is stepped: steps, run-in, and the arguments of the compiled loops."""

from __future__ import annotations

import dataclasses
import functools
import math
from types import ModuleType
from typing import Any, NamedTuple, get_args

import numpy as np

from gearfem.definition.setup import Member
from gearfem.dynamics.linear_train import LinearTrain, linear_train
from gearfem.dynamics.record import DriveTrain
from gearfem.dynamics.supports import on_supports
from gearfem.dynamics.waves import gap_waves, torque_waves
from gearfem.engagement.engage import Mesh
from gearfem.engagement.turns import Turns, static
from gearfem.foundation import InputError
from gearfem.placement import Placement

MEMBERS: tuple[Member, ...] = get_args(Member)
# Longest step by 1/omega_n and with it the fewest steps to a pitch: see `march_turns` for their accuracy. Modes of shafts and supports
# that are faster than the teeth's may turn on by so many times as much in a step, up to 0.8 rad, which damps them by 0.2 % of critical.
STRIDE, FEWEST, SHAFTS, LONGEST = 0.2, 128, 2.5, 0.8
# The start, the slow engagement, is forgotten to exp(-DECAY) = 1e-4 before the first angle, or to as much more as longer steps err more, by
# their square; no run-in is longer than these pitches.
DECAY, LEAST_SETTLING, MOST_SETTLING = 9.0, 4, 2000
SLOPE_ANGLES = 64


@functools.cache
def kernels() -> ModuleType:
    """Return the compiled loops; the first call of a process loads the compiler (or its cached code)."""
    from gearfem.dynamics import turn_kernels as module

    return module


def mean_stiffness(turns: Turns, torque: float) -> float:
    """Return the mean slope of the mesh [N/m] over a pitch of evenly spaced teeth at a torque [N m], rigidly supported."""
    angle = np.arange(SLOPE_ANGLES) / SLOPE_ANGLES * turns.mesh.placement.pair.pinion.pitch_angle
    return float(static(turns.plain, angle, torque).mesh_stiffness.mean())


class Plan(NamedTuple):
    """What moves, mean stiffness and damper of its teeth, steps to the pitch, pitches of the run-in and what these leave of the start."""

    placement: Placement
    drive: DriveTrain
    train: LinearTrain
    stiffness: float
    damper: float
    steps: int
    settling: int
    remains: float

    def rates(self) -> tuple[float, float]:
        """Return slowest decay and fastest rate [1/s] of all that moves, its teeth on their mean stiffness."""
        pair = self.placement.pair
        return self.train.rates(self.stiffness, self.damper, pair.pinion.base_radius, pair.wheel.base_radius)


def make_plan(turns: Turns, drive: DriveTrain, speed: float, torque: float, stride: float = STRIDE) -> Plan:
    """Return how a motion is stepped.

    Of a rate at which the gears approach, supports without mass leave the teeth the share s = 1/(1 + c C): their damper acts as D s^2.
    """
    pair = turns.mesh.placement.pair
    base1, base2, length = pair.pinion.base_radius, pair.wheel.base_radius, pair.pinion.pitch_angle / speed
    stiffness = mean_stiffness(turns, torque)
    natural, damper = mesh_mode(drive, stiffness, base1, base2)
    placement, drive = on_supports(turns.mesh.placement, drive, natural)
    damper *= _teeth_share(turns.mesh.placement, placement, stiffness) ** 2
    train = linear_train(drive, base1, base2)
    decay, fastest = train.rates(stiffness, damper, base1, base2)
    turn = min(SHAFTS * stride, LONGEST)
    steps = max(math.ceil(FEWEST * STRIDE / stride), math.ceil(natural * length / stride), math.ceil(fastest * length / turn))
    return Plan(placement, drive, train, stiffness, damper, steps, *_run_in(decay * length, DECAY + 2.0 * math.log(STRIDE / stride)))


def mesh_mode(drive: DriveTrain, stiffness: float, base1: float, base2: float) -> tuple[float, float]:
    """Return the natural frequency of the two gears alone on a mean mesh stiffness [rad/s], and their damper [N s/m].

    Parameters
    ----------
    drive : DriveTrain
        Inertias and damping ratio.
    stiffness : float
        [N/m].
    base1, base2 : float
        Base radii [m].

    Returns
    -------
    tuple of float
    """
    masses = drive.pinion_inertia / base1**2, drive.wheel_inertia / base2**2
    mass = masses[0] * masses[1] / (masses[0] + masses[1])
    return math.sqrt(stiffness / mass), 2.0 * drive.damping_ratio * math.sqrt(stiffness * mass)


def _teeth_share(before: Placement, after: Placement, stiffness: float) -> float:
    """Return the share of the teeth in what gears approach on supports that lost their mass."""
    return 1.0 / (1.0 + (after.series - before.series) * stiffness)


def moving(mesh: Mesh, drive: DriveTrain) -> tuple[Mesh, DriveTrain]:
    """Return mesh and drive of a motion under the drive's torque, the gears with their masses on what they yield: see `on_supports`.

    Parameters
    ----------
    mesh : Mesh
        With the supports of its placement.
    drive : DriveTrain
        With the masses of the gears.

    Returns
    -------
    Mesh, DriveTrain
        Both as they were where the placement gives the gears no supports.
    """
    pair = mesh.placement.pair
    if mesh.placement.pinion_support == mesh.placement.wheel_support == 0.0:
        return mesh, drive
    stiffness = mean_stiffness(Turns(mesh=mesh), drive.pinion_torque)
    natural, _ = mesh_mode(drive, stiffness, pair.pinion.base_radius, pair.wheel.base_radius)
    placement, held = on_supports(mesh.placement, drive, natural)
    # D = 2 zeta sqrt(C M) of a mesh that supports without mass soften: see `make_plan`.
    ratio = drive.damping_ratio * _teeth_share(mesh.placement, placement, stiffness) ** 1.5
    return dataclasses.replace(mesh, placement=placement), dataclasses.replace(held, damping_ratio=ratio)


def rows_of(turns: Turns, begin: int, last: float) -> tuple[Any, int]:
    """Return the tables of the pairs from one pitch to another as the loops take them, and how many are followed at once."""
    stack, placement = turns.stack(np.arange(begin, math.floor(last) + 2, dtype=float)), turns.mesh.placement
    arrays = stack.arrays(placement.pair.pinion.module, (placement.pinion_late, placement.wheel_late))
    return kernels().Rows(*arrays), stack.count


def teeth_of(plan: Plan, speed: float) -> Any:
    """Return what all pairs share, as the loops take it."""
    placement, pair = plan.placement, plan.placement.pair
    base1, base2, pitch = pair.pinion.base_radius, pair.wheel.base_radius, pair.pinion.pitch_angle
    return kernels().Teeth(
        pitch=pitch,
        speed=speed / pitch,
        damp=plan.damper,
        friction=plan.drive.friction_coefficient,
        stiffness=plan.stiffness,
        play=placement.normal_backlash,
        gaps=gap_waves(placement),
        yielding=placement.support,
        width=pair.face_width,
        base1=base1,
        base2=base2,
        turn=1.0 / (base1 * pitch),
    )


def train_of(plan: Plan) -> Any:
    """Return the linear part with the ripples, as the loops take it."""
    train = plan.train
    waves = (torque_waves(plan.drive, member, plan.placement.pair.ratio) for member in MEMBERS)
    return kernels().Train(*waves, train.by_load, train.by_place, train.by_rate, train.touch)


def _run_in(decay: float, wanted: float) -> tuple[int, float]:
    """Return the pitches of the run-in and what remains of the start, for a decay per pitch and one that is wanted in all."""
    least = math.log(10.0) / MOST_SETTLING
    if decay < least:
        raise InputError("operation.damping_ratio", f"a decay by {decay:.2g} to the pitch", f"damping that settles: at least {least:.2g}")
    count = min(max(math.ceil(wanted / decay), LEAST_SETTLING), MOST_SETTLING)
    return count, math.exp(-decay * count)
