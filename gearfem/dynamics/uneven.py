"""The three models where teeth differ or torques vary with the turns: motions that repeat only after whole turns."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Hashable, Sequence

import numpy as np

from gearfem.dynamics.measures import HARMONICS
from gearfem.dynamics.periodic import kinked
from gearfem.dynamics.record import DriveTrain, ElasticMotion, RigidMotion
from gearfem.dynamics.rigid import rigid_motion
from gearfem.dynamics.sweep_record import Direction, SweepPoint
from gearfem.dynamics.turns import kw_places, march_turns
from gearfem.dynamics.turns_plan import mean_stiffness, mesh_mode
from gearfem.engagement.turns import Turns, static
from gearfem.foundation import Array
from gearfem.placement import runout_gap

# Angles to the pitch that are handed on.
ANGLES = 128
# Of the rigid model: angles in all, and limits of their number to the pitch.
RIGID_ANGLES, FEWEST, MOST = 40_000, 128, 6400
# A longer period is not followed to its end: whole turns that bring every tooth into contact stand for it.
MOST_PITCHES = 1500
FAINT = 1e-3


def repeats(turns: Turns, drive: DriveTrain) -> int:
    """Return the number of pitches after which the same teeth meet under the same torques.

    Parameters
    ----------
    turns : Turns
        The gears.
    drive : DriveTrain
        With its ripples, whose orders count as whole numbers.

    Returns
    -------
    int
        1 where all teeth are alike; at most 1500, or whole turns of the pinion that bring every tooth into contact.
    """
    placement, (z1, z2) = turns.mesh.placement, turns.teeth
    rippled = {ripple.member for ripple in drive.ripples}

    def differ(kinds: Sequence[Hashable], late: Array, runout: tuple[float, float]) -> bool:
        return len(set(kinds)) > 1 or bool(np.ptp(late) > 0.0) or any(runout)

    one = differ(turns.kinds[0], placement.pinion_late, placement.pinion_runout) or "pinion" in rippled
    two = differ(turns.kinds[1], placement.wheel_late, placement.wheel_runout) or "wheel" in rippled
    whole = math.lcm(z1 if one else 1, z2 if two else 1)
    return whole if whole <= MOST_PITCHES else math.ceil(z2 / z1) * z1


def uneven_motion(turns: Turns, drive: DriveTrain) -> ElasticMotion:
    """Return the steady motion of the elastic model over the whole period of teeth that differ.

    Parameters
    ----------
    turns : Turns
        The gears, teeth of any kind.
    drive : DriveTrain
        Inertias, shafts and supports, torques with ripples, friction and damping.

    Returns
    -------
    ElasticMotion
        At equal steps of the angle; `closure` is what remains of the start after the run-in, and there are no multipliers. Motions
        under ripples of broken orders do not repeat.

    Raises
    ------
    InputError, SolveError
        As `march_turns`.

    Notes
    -----
    Time runs at the mean speed; the speed is that plus the integral of the acceleration by the trapezoidal rule, without its mean.
    """
    angle = np.arange(repeats(turns, drive) * ANGLES) / ANGLES * turns.mesh.placement.pair.pinion.pitch_angle
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
        periodic=all(float(ripple.order).is_integer() for ripple in drive.ripples),
        contact_loss=motion.contact_loss,
        closure=motion.remains,
    )


def uneven_classical(turns: Turns, drive: DriveTrain, pinion_inertia: float, wheel_inertia: float) -> ElasticMotion:
    """Return the motion of the classical model, the inertias of the two gears [kg m2] alone, over the whole period.

    What differs from tooth to tooth acts as a displacement of the teeth, as worn flanks do in `classical_motion`; supports of the
    placement yield without mass.
    """
    gears = dataclasses.replace(drive, pinion_inertia=pinion_inertia, wheel_inertia=wheel_inertia, pinion_chain=(), wheel_chain=())
    return uneven_motion(turns, dataclasses.replace(gears, pinion_support=None, wheel_support=None, pinion_mass=0.0, wheel_mass=0.0))


def uneven_rigid(turns: Turns, drive: DriveTrain) -> RigidMotion:
    """Return the motion of the rigid model over the whole period of teeth that differ.

    Parameters
    ----------
    turns : Turns
        The gears.
    drive : DriveTrain
        Inertias, torques without their ripples, efficiency and mean speed.

    Returns
    -------
    RigidMotion

    Raises
    ------
    InputError, SolveError
        As `static` and `rigid_motion`.

    Notes
    -----
    The ratio is that of the forces under the operation torque, i = sum P l2/(T1 - g' sum P), g' the slope of the common gap of the
    runouts [m/rad], by which eccentric gears move apart along the line of action as they turn: r_b1 dphi1 - r_b2 dphi2 = dg. A late tooth
    changes where pairs hand over, not the ratio in between. Its mean over the wheel's angle is set to z2/z1.
    """
    pair = turns.mesh.placement.pair
    pitches = repeats(turns, dataclasses.replace(drive, ripples=()))
    steps = min(max(RIGID_ANGLES // pitches, FEWEST), MOST)
    angle = np.arange(pitches * steps) / steps * pair.pinion.pitch_angle
    slow = static(turns, angle, drive.pinion_torque)
    slope = runout_gap(turns.mesh.placement, angle)[1]
    ratio = slow.wheel_moment / (drive.pinion_torque - slope * slow.force.sum(axis=1))
    ratio *= float(np.mean(1.0 / ratio)) * pair.ratio
    return rigid_motion(angle, ratio, pitches * pair.pinion.pitch_angle, drive, kinked)


def uneven_point(turns: Turns, drive: DriveTrain, direction: Direction, state: Array | None) -> SweepPoint:
    """Return what a sweep reports of the motion at one speed where teeth differ.

    Parameters
    ----------
    turns, drive : Turns, DriveTrain
        The gears and their drive, at this speed.
    direction : {"rest", "up", "down"}
        Handed through.
    state : ndarray, optional
        `SweepPoint.state` of a neighbouring speed.

    Returns
    -------
    SweepPoint
        Extremes are those of 96 angles to the pitch.
    """
    pair = turns.mesh.placement.pair
    pitches = repeats(turns, drive)
    place = kw_places(pitches)
    motion = march_turns(turns, drive, place * pair.pinion.pitch_angle, start=None if state is None else state.reshape(2, -1))
    error = motion.transmission_error
    lines = 2.0 * np.fft.rfft(error) / error.size
    amplitude = np.abs(lines[1 : HARMONICS * pitches + 1])
    strong = np.flatnonzero(amplitude >= FAINT * amplitude.max())
    harmonics = lines[pitches * np.arange(1, HARMONICS + 1)]
    base = pair.pinion.base_radius, pair.wheel.base_radius
    return SweepPoint(
        direction=direction,
        pinion_speed=drive.pinion_speed,
        mesh_frequency=drive.pinion_speed / pair.pinion.pitch_angle,
        natural_frequency=mesh_mode(drive, mean_stiffness(turns, drive.pinion_torque), *base)[0] / math.tau,
        dynamic_factor_max=float(motion.dynamic_factor.max()),
        dynamic_factor_min=float(motion.dynamic_factor.min()),
        mesh_force_max=float(motion.mesh_force.max()),
        mesh_force_mean=float(motion.mesh_force.mean()),
        error_mean=float(error.mean()),
        error_rms=float(error.std()),
        harmonic_amplitude=np.abs(harmonics),
        harmonic_phase=np.angle(harmonics),
        line_order=(strong + 1) / pitches,
        line_amplitude=amplitude[strong],
        contact_loss=motion.contact_loss,
        back_contact=float(np.mean(motion.mesh_force < 0.0)),
        period_cycles=pitches,
        growth=motion.remains ** (1.0 / motion.run_in),
        multiplier_magnitude=np.empty(0),
        wheel_torque=motion.wheel_torque,
        state=motion.end.ravel(),
        steps=motion.steps,
    )
