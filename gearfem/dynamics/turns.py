"""Motion over many turns, where every tooth may differ: two inertias and the teeth between them, in fixed compiled steps."""

from __future__ import annotations

import dataclasses
import functools
import math
import os
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike

from gearfem.definition.setup import Member
from gearfem.dynamics.record import DriveTrain
from gearfem.engagement.pair_table import levels
from gearfem.engagement.turns import Turns, static
from gearfem.foundation import Array, InputError, Record, SolveError
from gearfem.placement import Placement, runout_gap

# Longest step by 1/omega_n and fewest steps to a pitch: see `march_turns` for what they cost in accuracy.
STRIDE, FEWEST = 0.2, 128
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
        Kw = 1 - J1 psi1''/T1.
    mesh_force : ndarray, shape (n,)
        Normal force on the working flanks, less that on the back flanks [N].
    contact_loss : float
        Share of the time without contact on the working flank, from the first angle's pitch to the last one's.
    run_in : int
        Pitches stepped before the first angle.
    remains : float
        What is left of a difference between start and steady motion after them.
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
) -> TurnsMotion:
    """Return the steady motion at pinion angles, over any number of turns.

    Parameters
    ----------
    turns : Turns
        The gears.
    drive : DriveTrain
        Two inertias with their ripples, friction and damping; torque of the wheel and efficiency are not used.
    pinion_angle : array_like, shape (n,)
        Angles [rad], in any order.
    speed, torque : float, optional
        Mean speed [rad/s] and torque [N m] of the pinion; by default the drive's.
    stride : float
        Longest step by 1/omega_n.

    Returns
    -------
    TurnsMotion

    Raises
    ------
    InputError
        If speed or torque is not positive, the drive has more than two inertias, or the damping cannot settle it.
    SolveError
        If the loads of the teeth do not converge, or the motion grows without bound.

    Notes
    -----
    With e = r_b1 psi1 - r_b2 psi2 and J1 psi1'' = T1 - M1, J2 psi2'' = M2 - T2 (Wojnarowski & Onishchenko 2003, eq. 22)

        e'' = r_b1/J1 (T1 - M1) + r_b2/J2 (T2 - M2),

    M1, M2 the moments of the loads that the slow engagement has at the lag e, friction included. No transport motion is split
    off: the gaps of worn, late or eccentric teeth act inside the contact, and e is the lag itself. That is exact for two free
    inertias but for one thing: tables and ripples are read at the mean rotation, not at psi1, which leads or lags it by some
    e m2/((m1 + m2) r_b1), below 1e-3 pitches for stiff gears; torque ripples that make the speed itself vary shift
    the angle axis by as much as they turn the shaft. The inertias share a ripple, however slow, where `slow_torque`, whose gears
    are held to their speed, passes it on whole.

    Damping: P = sum F + D (e' - g'), D = 2 zeta sqrt(C M), g' the rate of the gaps by load, C from `mean_stiffness`; shared among
    the pairs as their loads are, and never pulling. Back flanks touch at the normal backlash with the stiffness C on the base
    circles. Supports yield in series with the teeth, without mass, inside the damper. T2 follows the ratio of the mean moments
    during the run-in and then stays.

    Classical Runge-Kutta steps, equal parts of a pitch, so that sliding reverses at their ends on unworn flanks; between them
    quintics. Where a pair comes into contact, and at impacts, their order falls to the second. Against steps ten times finer, Myga's
    rig with late teeth and friction errs by at most 2e-3 in Kw, and in the transmission error by 3e-3 of its standard
    deviation, from a third to three times its speed (tests/convergence/test_turns_steps.py).
    """
    if not drive.two_inertias:
        raise InputError(
            "operation", "shafts or supports with inertia", "two inertias alone: use the elastic model for longer drive trains"
        )
    speed = drive.pinion_speed if speed is None else speed
    torque = drive.pinion_torque if torque is None else torque
    if not (0.0 < speed < math.inf and 0.0 < torque < math.inf):
        raise InputError("operation", f"{speed:g} rad/s and {torque:g} N m", "a positive speed and a positive torque")
    placement, angle = turns.mesh.placement, np.atleast_1d(np.asarray(pinion_angle, float))
    pair = placement.pair
    base1, base2, pitch = pair.pinion.base_radius, pair.wheel.base_radius, pair.pinion.pitch_angle
    stiffness = mean_stiffness(turns, torque)
    masses = drive.pinion_inertia / base1**2, drive.wheel_inertia / base2**2
    mass = masses[0] * masses[1] / (masses[0] + masses[1])
    natural, length = math.sqrt(stiffness / mass), pitch / speed
    settling, remains = _run_in(drive.damping_ratio * natural * length)
    order = np.argsort(angle, kind="stable")
    samples = angle[order] / pitch
    begin = math.floor(samples[0]) - settling
    stack = turns.stack(np.arange(begin, math.floor(samples[-1]) + 2, dtype=float))
    outputs = [np.empty(angle.size) for _ in range(3)]
    means = np.zeros(3)
    wheel_torque = kernels().march(
        begin,
        settling,
        max(FEWEST, math.ceil(natural * length / stride)),
        samples,
        _start(turns, drive, torque, begin * pitch, speed),
        torque,
        torque * pair.ratio,
        _torque_waves(drive, "pinion", pair.ratio),
        _torque_waves(drive, "wheel", pair.ratio),
        drive.pinion_inertia,
        drive.wheel_inertia,
        stack.count,
        pitch,
        1.0 / length,
        2.0 * drive.damping_ratio * math.sqrt(stiffness * mass),
        drive.friction_coefficient,
        stiffness,
        placement.normal_backlash,
        _gap_waves(placement),
        placement.support,
        pair.face_width,
        base1,
        base2,
        1.0 / (base1 * pitch),
        *stack.arrays(float(levels(pair.pinion.module)[0]), (placement.pinion_late, placement.wheel_late)),
        *outputs,
        means,
    )
    if not math.isfinite(wheel_torque):
        found = f"motion over turns at {speed:g} rad/s: it grows without bound, or its loads do not converge"
        raise SolveError(f"{found}; raise the damping or take a shorter stride")
    error, acceleration, force = (np.empty(angle.size) for _ in range(3))
    for out, values in zip((error, acceleration, force), outputs, strict=True):
        out[order] = values
    return TurnsMotion(
        pinion_angle=angle,
        pinion_speed=speed,
        pinion_torque=torque,
        wheel_torque=wheel_torque,
        transmission_error=error,
        pinion_acceleration=acceleration,
        dynamic_factor=1.0 - drive.pinion_inertia * acceleration / torque,
        mesh_force=force,
        contact_loss=float(means[2]),
        run_in=settling,
        remains=remains,
    )


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


def _start(turns: Turns, drive: DriveTrain, torque: float, angle: float, speed: float) -> Array:
    """Return transmission error and its rate of the slow engagement at the start."""
    small = 1e-3 * turns.mesh.placement.pair.pinion.pitch_angle
    at = angle + np.array([0.0, small])
    load = slow_torque(drive, torque, at, turns.mesh.placement.pair.ratio)
    error = static(turns, at, np.maximum(load, 0.05 * torque), drive.friction_coefficient).transmission_error
    return np.array([error[0], (error[1] - error[0]) / small * speed])


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
