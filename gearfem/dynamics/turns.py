"""Motion over many turns, where every tooth may differ: a drive train and the teeth in it, in fixed compiled steps."""

from __future__ import annotations

import dataclasses
import functools
import math
import os
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType
from typing import Any, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from gearfem.definition.setup import Member
from gearfem.dynamics.linear_train import LinearTrain, linear_train
from gearfem.dynamics.record import DriveTrain
from gearfem.engagement.pair_table import levels
from gearfem.engagement.turns import Turns, static
from gearfem.foundation import Array, InputError, Record, SolveError
from gearfem.placement import Placement, runout_gap

MEMBERS: tuple[Member, ...] = get_args(Member)
# Longest step by 1/omega_n and fewest steps to a pitch: see `march_turns` for what they cost in accuracy. Modes of shafts and supports
# that are faster than the teeth's may turn on by so many times as much in a step: the formula stays stable up to 2.8.
STRIDE, FEWEST, SHAFTS = 0.2, 128, 2.5
# The start, the slow engagement, is forgotten to exp(-DECAY) = 1e-4 before the first angle; no run-in is longer than these pitches.
DECAY, LEAST_SETTLING, MOST_SETTLING = 9.0, 4, 2000
SLOPE_ANGLES = 64
KW_ANGLES = 96


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class TurnsMotion(Record):
    """Steady motion at n pinion angles, at one mean speed and torque.

    Parameters
    ----------
    pinion_angle : ndarray, shape (n,)
        Angles [rad], as asked for.
    pinion_speed, pinion_torque, wheel_torque : float
        Mean speed [rad/s] and mean torques [N m], the wheel's as the mean power balances.
    transmission_error : ndarray, shape (n,)
        Lag of the wheel r_b1 psi1 - r_b2 psi2, counted as in the slow engagement [m].
    pinion_acceleration : ndarray, shape (n,)
        psi1'' [rad/s2].
    dynamic_factor : ndarray, shape (n,)
        Kw = 1 - J1 psi1''/T1; where T1 acts beyond a shaft, M1/T1 of the moment M1 of the teeth.
    mesh_force : ndarray, shape (n,)
        Normal force on the working flanks, less that on the back flanks [N].
    contact_loss : float
        Share of the time without contact on the working flank, from the first angle's pitch to the last one's.
    run_in : int
        Pitches stepped before the first angle.
    remains : float
        What is left of a difference between start and steady motion after them.
    steps : int
        Steps to the pitch.
    end : ndarray, shape (2, n)
        Lag and stretches, and their rates, at the end: where the motion at a neighbouring speed may start.
    """

    pinion_angle: Array
    pinion_speed: float
    pinion_torque: float
    wheel_torque: float
    transmission_error: Array
    pinion_acceleration: Array
    dynamic_factor: Array
    mesh_force: Array
    contact_loss: float
    run_in: int
    remains: float
    steps: int
    end: Array


@functools.cache
def kernels() -> ModuleType:
    """Return the compiled loops; the first call of a process loads the compiler (or its cached code)."""
    from gearfem.dynamics import turn_kernels as module

    return module


def torque_ripple(drive: DriveTrain, member: Member, pinion_angle: ArrayLike, ratio: float) -> Array:
    """Return how the torque of one gear's shaft varies at pinion angles [rad] [N m]; `ratio` is z2/z1."""
    value: Array = np.zeros_like(np.asarray(pinion_angle, float))
    for amplitude, order, phase in _torque_waves(drive, member, ratio):
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


def mean_stiffness(turns: Turns, torque: float) -> float:
    """Return the mean slope of the mesh [N/m] over a pitch of evenly spaced teeth at a torque [N m], rigidly supported."""
    angle = np.arange(SLOPE_ANGLES) / SLOPE_ANGLES * turns.mesh.placement.pair.pinion.pitch_angle
    return float(static(turns.plain, angle, torque).mesh_stiffness.mean())


def march_turns(
    turns: Turns,
    drive: DriveTrain,
    pinion_angle: ArrayLike,
    *,
    speed: float | None = None,
    torque: float | None = None,
    stride: float = STRIDE,
    start: Array | None = None,
) -> TurnsMotion:
    """Return the steady motion at pinion angles, over any number of turns.

    Parameters
    ----------
    turns : Turns
        The gears.
    drive : DriveTrain
        Inertias, shafts and supports with their ripples, friction and damping; torque of the wheel and efficiency are not used.
    pinion_angle : array_like, shape (n,)
        Angles [rad], in any order.
    speed, torque : float, optional
        Mean speed [rad/s] and torque [N m] of the pinion; by default the drive's.
    stride : float
        Longest step by 1/omega_n.
    start : ndarray, shape (2, n), optional
        `end` of the motion at a neighbouring speed, on whose branch this one is to be; by default the slow engagement.

    Returns
    -------
    TurnsMotion

    Raises
    ------
    InputError
        If speed or torque is not positive, or the damping cannot settle the motion.
    SolveError
        If the loads of the teeth do not converge, or the motion grows without bound.

    Notes
    -----
    With e = r_b1 psi1 - r_b2 psi2 and J1 psi1'' = T1 - M1, J2 psi2'' = M2 - T2 (Wojnarowski & Onishchenko 2003, eq. 22)

        e'' = r_b1/J1 (T1 - M1) + r_b2/J2 (T2 - M2),

    M1, M2 the moments of the loads that the slow engagement has at the lag e, friction included; longer trains add the stretches of
    their shafts and supports (`linear_train`). No transport motion is split
    off: the gaps of worn, late or eccentric teeth act inside the contact, and e is the lag itself. That is exact for two free
    inertias but for one thing: tables and ripples are read at the mean rotation, not at psi1, which leads or lags it by some
    e m2/((m1 + m2) r_b1), below 1e-3 pitches for stiff gears; torque ripples that make the speed itself vary shift
    the angle axis by as much as they turn the shaft. The inertias share a ripple, however slow, where `slow_torque`, whose gears
    are held to their speed, passes it on whole.

    Damping: P = sum F + D (e' - g'), D = 2 zeta sqrt(C M), g' the rate of the gaps by load, C from `mean_stiffness`; shared among
    the pairs as their loads are, and never pulling. Back flanks touch at the normal backlash with the stiffness C on the base
    circles. Supports of the placement yield in series with the teeth, without mass, inside the damper. T2 follows the ratio of the mean
    moments during the run-in and then stays.

    Classical Runge-Kutta steps, equal parts of a pitch, cut where the sliding of a pair reverses; between them
    quintics. Where a pair comes into contact, and at impacts, their order falls to the second. Against steps ten times finer, Myga's
    rig with late teeth and friction errs by at most 2e-3 in Kw, and in the transmission error by 3e-3 of its standard
    deviation, from a third to three times its speed (tests/convergence/test_turns_steps.py).
    """
    speed = drive.pinion_speed if speed is None else speed
    torque = drive.pinion_torque if torque is None else torque
    if not (0.0 < speed < math.inf and 0.0 < torque < math.inf):
        raise InputError("operation", f"{speed:g} rad/s and {torque:g} N m", "a positive speed and a positive torque")
    pair, angle = turns.mesh.placement.pair, np.atleast_1d(np.asarray(pinion_angle, float))
    plan = _plan(turns, drive, speed, torque, stride)
    order = np.argsort(angle, kind="stable")
    samples = angle[order] / pair.pinion.pitch_angle
    begin = math.floor(samples[0]) - plan.settling
    rows, count = _rows(turns, begin, samples[-1])
    outputs, means = np.empty((4, angle.size)), np.zeros(3)
    if start is None:
        start = plan.train.start(torque, pair.ratio, pair.pinion.base_radius, *_slow_start(turns, drive, torque, begin, speed))
    state = np.array(start)
    wheel_torque = kernels().march(
        begin,
        plan.settling,
        plan.steps,
        samples,
        state,
        torque,
        torque * pair.ratio,
        count,
        _teeth(turns.mesh.placement, drive, plan, speed),
        rows,
        _train(drive, plan.train, pair.ratio),
        *outputs,
        means,
    )
    if not math.isfinite(wheel_torque):
        found = f"motion over turns at {speed:g} rad/s: it grows without bound, or its loads do not converge"
        raise SolveError(f"{found}; raise the damping or take a shorter stride")
    found_at = np.empty_like(outputs)
    found_at[:, order] = outputs
    error, acceleration, force, moment = found_at
    return TurnsMotion(
        pinion_angle=angle,
        pinion_speed=speed,
        pinion_torque=torque,
        wheel_torque=wheel_torque,
        transmission_error=error,
        pinion_acceleration=acceleration,
        dynamic_factor=moment / torque if drive.pinion_chain else 1.0 - drive.pinion_inertia * acceleration / torque,
        mesh_force=force,
        contact_loss=float(means[2]),
        run_in=plan.settling,
        remains=plan.remains,
        steps=plan.steps,
        end=state,
    )


class _Plan(NamedTuple):
    """Linear part, mean stiffness and damper of a motion, its steps to the pitch, pitches of its run-in and what these leave."""

    train: LinearTrain
    stiffness: float
    damper: float
    steps: int
    settling: int
    remains: float


def _plan(turns: Turns, drive: DriveTrain, speed: float, torque: float, stride: float) -> _Plan:
    """Return how a motion is stepped."""
    pair = turns.mesh.placement.pair
    base1, base2, length = pair.pinion.base_radius, pair.wheel.base_radius, pair.pinion.pitch_angle / speed
    stiffness = mean_stiffness(turns, torque)
    natural, damper = mesh_mode(drive, stiffness, base1, base2)
    train = linear_train(drive, base1, base2)
    decay, fastest = train.rates(stiffness, damper, base1, base2)
    steps = max(FEWEST, math.ceil(natural * length / stride), math.ceil(fastest * length / (SHAFTS * stride)))
    return _Plan(train, stiffness, damper, steps, *_run_in(decay * length))


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


def _rows(turns: Turns, begin: int, last: float) -> tuple[Any, int]:
    """Return the tables of the pairs from one pitch to another as the loops take them, and how many are followed at once."""
    stack, placement = turns.stack(np.arange(begin, math.floor(last) + 2, dtype=float)), turns.mesh.placement
    arrays = stack.arrays(float(levels(placement.pair.pinion.module)[0]), (placement.pinion_late, placement.wheel_late))
    return kernels().Rows(*arrays), stack.count


def _teeth(placement: Placement, drive: DriveTrain, plan: _Plan, speed: float) -> Any:
    """Return what all pairs share, as the loops take it."""
    pair = placement.pair
    base1, base2, pitch = pair.pinion.base_radius, pair.wheel.base_radius, pair.pinion.pitch_angle
    return kernels().Teeth(
        pitch=pitch,
        speed=speed / pitch,
        damp=plan.damper,
        friction=drive.friction_coefficient,
        stiffness=plan.stiffness,
        play=placement.normal_backlash,
        gaps=_gap_waves(placement),
        yielding=placement.support,
        width=pair.face_width,
        base1=base1,
        base2=base2,
        turn=1.0 / (base1 * pitch),
    )


def _train(drive: DriveTrain, train: LinearTrain, ratio: float) -> Any:
    """Return the linear part with the ripples, as the loops take it."""
    waves = (_torque_waves(drive, member, ratio) for member in MEMBERS)
    return kernels().Train(*waves, train.by_load, train.by_place, train.by_rate, train.touch)


def dynamic_factors(turns: Turns, drive: DriveTrain, speeds: ArrayLike, torque: float | None = None, workers: int | None = None) -> Array:
    """Return the largest Kw over the first turn of the pinion, from angle 0, at each speed.

    Parameters
    ----------
    turns, drive
        As for `march_turns`.
    speeds : array_like, shape (n,)
        Mean speeds of the pinion [rad/s].
    torque : float, optional
        Mean torque of the pinion [N m]; by default the drive's.
    workers : int, optional
        Threads; by default one for each core.

    Returns
    -------
    ndarray, shape (n,)
        Over 96 angles to the pitch, which misses a peak by at most (pi/96)^2/2 of the height of its wave for every
        wave to the pitch, squared.

    Raises
    ------
    InputError, SolveError
        As `march_turns`.
    """
    values = np.atleast_1d(np.asarray(speeds, float))
    count = turns.teeth[0] * KW_ANGLES
    angle = np.arange(count) / count * math.tau

    def largest(speed: float) -> float:
        return float(march_turns(turns, drive, angle, speed=speed, torque=torque).dynamic_factor.max())

    # Tables first: threads would make them twice.
    found = [largest(float(values[0]))]
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        found += list(pool.map(largest, values[1:].tolist()))
    return np.array(found)


def _run_in(decay: float) -> tuple[int, float]:
    """Return the pitches of the run-in and what remains of the start, for a decay per pitch."""
    least = math.log(10.0) / MOST_SETTLING
    if decay < least:
        raise InputError("operation.damping_ratio", f"a decay by {decay:.2g} to the pitch", f"damping that settles: at least {least:.2g}")
    count = min(max(math.ceil(DECAY / decay), LEAST_SETTLING), MOST_SETTLING)
    return count, math.exp(-decay * count)


def _slow_start(turns: Turns, drive: DriveTrain, torque: float, begin: int, speed: float) -> tuple[float, float]:
    """Return transmission error and its rate of the slow engagement at the start; without friction, which reverses just there."""
    pitch = turns.mesh.placement.pair.pinion.pitch_angle
    small = 1e-3 * pitch
    at = begin * pitch + np.array([0.0, small])
    load = slow_torque(drive, torque, at, turns.mesh.placement.pair.ratio)
    error = static(turns, at, np.maximum(load, 0.05 * torque)).transmission_error
    return float(error[0]), float((error[1] - error[0]) / small * speed)


def _torque_waves(drive: DriveTrain, member: Member, ratio: float) -> Array:
    """Return amplitude [N m], order over the pinion's angle and phase of the ripples of one shaft, shape (m, 3)."""
    turn = 1.0 if member == "pinion" else 1.0 / ratio
    rows = [(ripple.amplitude, ripple.order * turn, ripple.phase) for ripple in drive.ripples if ripple.member == member]
    return np.array(rows, float).reshape(-1, 3)


def _gap_waves(placement: Placement) -> Array:
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
