"""The elastic model with two degrees of freedom, and Bosch's classical one: steady motion and dynamic factor."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from gearfem.dynamics.cycle import Cycle
from gearfem.dynamics.orbit import LOOSE, Orbit, settle, shoot
from gearfem.dynamics.record import DriveTrain, ElasticMotion, RigidMotion
from gearfem.dynamics.relative import RelativeMotion
from gearfem.dynamics.rigid import uniform_transport
from gearfem.engagement.record import MeshForce
from gearfem.foundation import Array, InputError, SolveError
from gearfem.foundation.progress import Progress, quiet
from gearfem.foundation.threads import one_thread

TAIL = 20
DECAY = 7.0
FEWEST_CYCLES, MOST_CYCLES = 20, 200


def elastic_motion(
    mesh: MeshForce,
    drive: DriveTrain,
    transport: RigidMotion,
    *,
    cycles: int = 3,
    samples: int = 400,
    tolerance: float = 1e-8,
    start: tuple[float, float] | None = None,
    progress: Progress = quiet,
) -> ElasticMotion:
    """Return the steady motion of two inertias, or of a longer drive train, joined by elastic teeth.

    Shooting finds the periodic orbit and the wheel torque that balances its mean power; where there is no stable one,
    the tail of a transient stands for it and `periodic` is false.

    Parameters
    ----------
    mesh : MeshForce
        Forces of the working flanks over angle and transmission error.
    drive : DriveTrain
        Inertias, torques, friction and damping; efficiency and wheel torque are not used.
    transport : RigidMotion
        Motion of the rigid gears with the unloaded ratio (`unloaded_transport`), from which the elastic one counts.
    cycles, samples : int
        Periods of `mesh` that are handed out, and samples in each; a tail hands out all its cycles.
    tolerance : float
        Relative tolerance per step of the integration, of states scaled by the mean deflection; 1e-4 or less.
    start : tuple of float, optional
        Deflection [m] and its rate [m/s] at the first angle from which the search starts: chooses among
        coexisting motions. Default: the mean deflection at rest.
    progress : Progress
        Listener.

    Returns
    -------
    ElasticMotion

    Raises
    ------
    InputError
        If counts or tolerance are out of range, or the tables cannot be used.
    SolveError
        If even the transient cannot be integrated.

    Notes
    -----
    Equations, and what they leave out, are in `RelativeMotion`. Integration by Gear's method (BDF). The pinion's
    speed has the nominal mean. Kw = M1/T1, M1 the moment of the teeth on the pinion; for two inertias 1 - J1 psi1''/T1.
    Lightly damped shafts are no trouble for shooting, but a transient that stands in for an orbit has hardly settled.

    References
    ----------
    Wojnarowski & Onishchenko 2003, eqs. (21)-(29).
    """
    if cycles < 1 or samples < 4:
        raise InputError("elastic_motion, cycles and samples", f"{cycles} and {samples}", "at least 1 cycle and 4 samples")
    if not 1e-12 <= tolerance <= 1e-4:
        raise InputError("elastic_motion, tolerance", tolerance, "1e-12 to 1e-4")
    system = RelativeMotion(mesh, drive, transport)
    first = system.transport(0.0)
    depth, rate = (system.unit, 0.0) if start is None else start
    z = system.shafting.static_stretches(drive.pinion_torque, system.balanced_torque, drive.pinion_torque / mesh.base_radius1)
    z = z / system.stretch_unit
    x = (depth - first.offset) / system.unit + system.yielding @ z
    guess = np.concatenate([[x, (rate - first.drift) / (system.unit * system.natural)], z, np.zeros_like(z), [1.0]])
    # Threads of dense algebra, started for matrices of four rows, took nine tenths of the time.
    with one_thread():
        orbit, periodic = _steady(system, guess, tolerance, progress)
    return _motion(system, orbit, periodic, cycles, samples)


def classical_motion(
    mesh: MeshForce,
    drive: DriveTrain,
    pinion_inertia: float,
    wheel_inertia: float,
    *,
    cycles: int = 3,
    samples: int = 400,
    tolerance: float = 1e-8,
    progress: Progress = quiet,
) -> ElasticMotion:
    """Return the motion by Bosch's classical model: constant ratio, and the inertias of the mating gears alone.

    Parameters
    ----------
    mesh : MeshForce
        The same excitation as in `elastic_motion`.
    drive : DriveTrain
        Torques, friction, damping and speed; its inertias, shafts and supports are not used.
    pinion_inertia, wheel_inertia : float
        Inertias of the two gears [kg m2].
    cycles, samples, tolerance, progress
        As in `elastic_motion`.

    Returns
    -------
    ElasticMotion

    Notes
    -----
    The transport rotates uniformly. For unworn teeth this differs from `elastic_motion` in the inertias alone. For worn
    teeth the flanks' deviations still act through the tables, as a displacement of the teeth and not as a ratio.
    """
    gears = dataclasses.replace(
        drive,
        pinion_inertia=pinion_inertia,
        wheel_inertia=wheel_inertia,
        pinion_chain=(),
        wheel_chain=(),
        pinion_support=None,
        wheel_support=None,
    )
    transport = uniform_transport(mesh, gears)
    return elastic_motion(mesh, gears, transport, cycles=cycles, samples=samples, tolerance=tolerance, progress=progress)


def _steady(system: RelativeMotion, guess: Array, tolerance: float, progress: Progress) -> tuple[Orbit, bool]:
    """Return the stable orbit from the guess, or from where a transient settles, or the transient's tail."""
    try:
        orbit = shoot(system, guess, tolerance, progress)
        if orbit.stable:
            return orbit, True
    except SolveError:
        pass
    decay = DECAY / max(system.drive.damping_ratio * system.length, DECAY / MOST_CYCLES)
    count = max(FEWEST_CYCLES, math.ceil(decay))
    _, settled = settle(system, guess, count, 0, max(LOOSE, tolerance), progress)
    try:
        orbit = shoot(system, settled, tolerance, progress)
        if orbit.stable:
            return orbit, True
    except SolveError:
        pass
    return settle(system, settled, 0, TAIL, tolerance, progress)[0], False


def _motion(system: RelativeMotion, orbit: Orbit, periodic: bool, cycles: int, samples: int) -> ElasticMotion:
    drive = system.drive
    sampled = [_sample(system, cycle, samples, turn) for cycle, turn in zip(orbit.cycles, _turns(system, orbit), strict=True)]
    count = cycles if periodic else len(sampled)
    angle, speed, error, force, moment, *stretches = np.concatenate(sampled * cycles if periodic else sampled, axis=1)
    number = np.repeat(np.arange(count), samples)
    time = (np.arange(count * samples) / samples) * system.length / system.natural
    train, loads = system.shafting, np.array(stretches).reshape(-1, count * samples)
    driving = loads[0] if drive.pinion_chain else drive.pinion_torque
    pieces = [piece for cycle in orbit.cycles for piece in cycle.pieces]
    lost = sum(piece.duration for piece in pieces if piece.side != 1)
    return ElasticMotion(
        time=time,
        pinion_angle=angle + number * system.mesh.period,
        mesh_force=force,
        transmission_error=error,
        pinion_speed=speed,
        pinion_acceleration=(driving - moment) / drive.pinion_inertia,
        dynamic_factor=moment / drive.pinion_torque,
        wheel_torque=orbit.cycles[-1].torque * system.balanced_torque,
        multipliers=orbit.multipliers,
        periodic=periodic,
        contact_loss=lost / (len(orbit.cycles) * system.length),
        closure=orbit.closure,
        stretch_load=loads,
        stretch_names=train.stretch_names,
    )


def _turns(system: RelativeMotion, orbit: Orbit) -> list[tuple[float, float]]:
    """Return scaled r_b1 q1 and its rate to be added to each cycle, whose own count starts at 0.

    q1 starts at 0 and its mean speed is 0: a uniform rotation, which no force feels, is free for that.
    """
    turns, turn, rate = [], 0.0, 0.0
    for cycle in orbit.cycles:
        turns.append((turn, rate))
        turn, rate = turn + rate * system.length + cycle.end[2], rate + cycle.end[3]
    drift = turn / (len(turns) * system.length)
    return [(turn - drift * number * system.length, rate - drift) for number, (turn, rate) in enumerate(turns)]


def _sample(system: RelativeMotion, cycle: Cycle, samples: int, turn: tuple[float, float]) -> Array:
    """Return angle, speed, transmission error, normal force, moment of the pinion and loads of shafts and supports at equal times."""
    times = system.length * np.arange(samples) / samples
    r1, scale = system.mesh.base_radius1, system.unit
    values = np.empty((5 + system.count, samples))
    starts = np.array([piece.steps[0] for piece in cycle.pieces])
    which = np.searchsorted(starts, times, side="right") - 1
    for number in np.unique(which):
        piece, chosen = cycle.pieces[number], which == number
        state = piece.solution(times[chosen])
        x, own, own_rate = state[0], state[2], state[3]
        carried = system.transport(times[chosen])
        force, moment = np.zeros_like(x), np.zeros_like(x)
        if piece.side:
            touch = system.contact(carried, *system.approach(state), piece.side, piece.middle)
            force, moment = piece.side * touch.force, touch.force * touch.arms[:, 0]
        angle = carried.angle + scale / r1 * (own + turn[0] + turn[1] * times[chosen])
        speed = carried.speed + scale * system.natural / r1 * (own_rate + turn[1])
        error = scale * x + carried.offset + system.unloaded(carried.angle)
        values[:5, chosen] = angle, speed, error, force, moment
        values[5:, chosen] = system.stretch_loads(state)
    return values
