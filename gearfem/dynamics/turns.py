"""Motion over many turns, where every tooth may differ: a drive train and the teeth in it, in fixed compiled steps."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import ArrayLike

from gearfem.dynamics.record import DriveTrain
from gearfem.dynamics.turns_plan import STRIDE, Plan, kernels, make_plan, rows_of, teeth_of, train_of
from gearfem.dynamics.waves import slow_torque
from gearfem.engagement.turns import Turns, static
from gearfem.foundation import Array, InputError, Record, SolveError

# Angles to the pitch at which extremes of Kw are looked for.
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
    least_acceleration : float
        Least psi1'' between the first angle and the last one [rad/s2], by parabolas through the steps, which err by up to an eighth of a
        jump of friction; 0 if no step lies there.
    mesh_force : ndarray, shape (n,)
        Normal force on the working flanks, less that on the back flanks [N].
    elastic_force : ndarray, shape (n,)
        Normal force of the working flanks without their damper [N].
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
    least_acceleration: float
    mesh_force: Array
    elastic_force: Array
    contact_loss: float
    run_in: int
    remains: float
    steps: int
    end: Array


def march_turns(
    turns: Turns,
    drive: DriveTrain,
    pinion_angle: ArrayLike,
    *,
    speed: float | None = None,
    torque: float | None = None,
    stride: float = STRIDE,
    start: Array | None = None,
    kick: tuple[float, float] = (0.0, 0.0),
    loads: bool = True,
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
        Longest step by 1/omega_n; the fewest steps to a pitch, 128 with the default, go with it.
    start : ndarray, shape (2, n), optional
        `end` of the motion at a neighbouring speed, on whose branch this one is to be; by default the slow engagement.
    kick : (float, float)
        Without such a start, the lag at the beginning of the run-in beside that of the slow engagement, in mean deflections of the mesh,
        and its rate, in these times the mesh's angular frequency: of several steady motions the one that this leads to.
    loads : bool
        Whether accelerations, factors and forces are wanted at the angles too, which cost up to as much as the steps; empty where not.

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
    rig with late teeth and friction errs by at most 8e-4 in Kw, and in the transmission error by 8e-4 of its standard
    deviation, from a third to three times its speed; with a stride of 0.5 by 4e-3 and 6e-3, with 0.7 by
    1.6e-2 and 2.4e-2 (tests/convergence/test_turns_steps.py).
    """
    speed = drive.pinion_speed if speed is None else speed
    torque = drive.pinion_torque if torque is None else torque
    if not (0.0 < speed < math.inf and 0.0 < torque < math.inf):
        raise InputError("operation", f"{speed:g} rad/s and {torque:g} N m", "a positive speed and a positive torque")
    pair, angle = turns.mesh.placement.pair, np.atleast_1d(np.asarray(pinion_angle, float))
    plan = make_plan(turns, drive, speed, torque, stride)
    order = np.argsort(angle, kind="stable")
    samples = angle[order] / pair.pinion.pitch_angle
    begin = math.floor(samples[0]) - plan.settling
    rows, count = rows_of(turns, begin, samples[-1])
    error, at_angles, means = np.empty(angle.size), np.empty((4, angle.size if loads else 0)), np.zeros(4)
    state = np.array(_slow_start(turns, drive, plan, speed, torque, begin, kick) if start is None else start)
    wheel_torque = kernels().march(
        begin,
        plan.settling,
        plan.steps,
        samples,
        state,
        torque,
        torque * pair.ratio,
        count,
        teeth_of(plan, speed),
        rows,
        train_of(plan),
        error,
        *at_angles,
        means,
    )
    if not math.isfinite(wheel_torque):
        found = f"motion over turns at {speed:g} rad/s: it grows without bound, or its loads do not converge"
        raise SolveError(f"{found}; raise the damping or take a shorter stride")
    asked = np.argsort(order)
    acceleration, force, moment, pressed = at_angles[:, asked] if loads else at_angles
    return TurnsMotion(
        pinion_angle=angle,
        pinion_speed=speed,
        pinion_torque=torque,
        wheel_torque=wheel_torque,
        transmission_error=error[asked],
        pinion_acceleration=acceleration,
        dynamic_factor=moment / torque if drive.pinion_chain else 1.0 - drive.pinion_inertia * acceleration / torque,
        least_acceleration=float(means[3]) if math.isfinite(means[3]) else 0.0,
        mesh_force=force,
        elastic_force=pressed,
        contact_loss=float(means[2]),
        run_in=plan.settling,
        remains=plan.remains,
        steps=plan.steps,
        end=state,
    )


def kw_places(pitches: int) -> Array:
    """Return places [pitches] over so many pitches, 96 to each, at which extremes of Kw are looked for."""
    return np.arange(pitches * KW_ANGLES) / KW_ANGLES


def _slow_start(turns: Turns, drive: DriveTrain, plan: Plan, speed: float, torque: float, begin: int, kick: tuple[float, float]) -> Array:
    """Return coordinates and rates (2, n) of the slow engagement at a pitch, and the kick besides.

    The slow engagement goes without friction, which reverses just there.
    """
    pair = turns.mesh.placement.pair
    pitch, radius = pair.pinion.pitch_angle, pair.pinion.base_radius
    small = 1e-3 * pitch
    at = begin * pitch + np.array([0.0, small])
    load = slow_torque(drive, torque, at, pair.ratio)
    error = static(turns, at, np.maximum(load, 0.05 * torque)).transmission_error
    lag, rate = float(error[0]), float((error[1] - error[0]) / small * speed)
    deflection = torque / radius / plan.stiffness
    lag, rate = lag + kick[0] * deflection, rate + kick[1] * deflection * speed * pair.pinion.teeth
    moved = (turns.mesh.placement.support - plan.placement.support) * torque / radius
    return plan.train.start(torque, pair.ratio, radius, lag - moved, rate)
