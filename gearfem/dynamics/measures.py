"""What is read off a steady motion: extremes between the steps, means, harmonics and spectral lines."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gearfem.dynamics.fast import PERIODS, Steady
from gearfem.dynamics.flank_force import flank_force
from gearfem.dynamics.record import DriveTrain, ElasticMotion
from gearfem.dynamics.sweep_record import Direction, SweepPoint
from gearfem.dynamics.track import Track, scales
from gearfem.engagement.record import MeshForce
from gearfem.foundation import Array

HARMONICS = 6
LONGEST = PERIODS[-1]
ORDERS = np.arange(1, HARMONICS * LONGEST + 1) / LONGEST
# Tops among the nodes that are looked at closely, and places in a step: corners are missed by a slope over a thirtieth of it.
TOPS, PLACES = 4, 33


def read_off(
    mesh: MeshForce, drive: DriveTrain, track: Track, found: Steady, direction: Direction, held: Array, nodes: Array
) -> SweepPoint:
    """Return what a sweep reports of a steady motion.

    Parameters
    ----------
    mesh, drive, track : MeshForce, DriveTrain, Track
        The model at this speed.
    found : Steady
        Where the motion is at the first angle, and its period.
    direction : {"rest", "up", "down"}
        Handed through.
    held : ndarray, shape (3,)
        Parts of the time, as `march` returns them.
    nodes : ndarray, shape (c, s, 5)
        Its nodes.

    Returns
    -------
    SweepPoint

    Notes
    -----
    Means, rms and harmonics are trapezoidal sums over the nodes. Extremes are looked for between the nodes, where pairs enter or leave
    and friction reverses: Kw and force have corners and jumps there, which samples miss by 1e-3 and more.
    """
    sizes = scales(mesh, drive)
    length, step = track.times[-1], track.steps
    weights = 0.5 * (step + np.roll(step, 1)) / length
    error = sizes.unit * (nodes[..., 0] + track.motion[track.first, 0] + track.unloaded[:-1])
    mean = float((error * weights).sum() / len(error))
    lines = _lines(error - mean, weights, track.times[:-1] / length)
    # The samples start at the table's first angle, phases count from angle 0.
    turn = 2.0 * math.pi * mesh.pinion_angle[0] / mesh.period
    harmonics = lines[0, LONGEST - 1 :: LONGEST] * np.exp(-1j * turn * np.arange(1, HARMONICS + 1))
    force = nodes[..., 2] * mesh.mean_stiffness * sizes.unit
    highest, lowest, pressed = _extremes(mesh, drive, track, nodes, found.period > 0)
    offset = np.array([track.motion[0, 0], track.motion[0, 1], 0.0])
    return SweepPoint(
        direction=direction,
        pinion_speed=drive.pinion_speed,
        mesh_frequency=drive.pinion_speed / mesh.period,
        natural_frequency=sizes.natural / (2.0 * math.pi),
        dynamic_factor_max=highest,
        dynamic_factor_min=lowest,
        mesh_force_max=pressed,
        mesh_force_mean=float((force * weights).sum() / len(force)),
        error_mean=mean,
        error_rms=math.sqrt(float(((error - mean) ** 2 * weights).sum() / len(error))),
        harmonic_amplitude=np.abs(harmonics),
        harmonic_phase=np.angle(harmonics),
        line_order=ORDERS,
        line_amplitude=np.sqrt(np.mean(np.abs(lines) ** 2, axis=0)),
        contact_loss=float(held[0] + held[1]),
        back_contact=float(held[0]),
        period_cycles=found.period,
        growth=found.growth,
        multiplier_magnitude=np.sort(np.abs(found.multipliers))[::-1],
        wheel_torque=float(found.state[2]) * sizes.braking,
        state=(found.state + offset) * sizes.state,
        steps=step.size,
    )


def _lines(values: Array, weights: Array, share: Array) -> NDArray[np.complex128]:
    """Return complex amplitudes at 1/24 to 6 mesh orders, shape (b, 144), for samples (cycles, s) at shares of a cycle.

    A period of fewer than 24 cycles has lines at its own multiples alone; longer stretches are taken in b blocks of 24 cycles.
    """
    cycles = min(len(values), LONGEST)
    blocks = values.reshape(-1, cycles, values.shape[1])
    number = np.arange(1, HARMONICS * cycles + 1)
    over_cycles = np.fft.fft(blocks, axis=1)[:, number % cycles] / cycles
    within = np.exp(-2j * math.pi * number[:, None] / cycles * share) * weights
    lines = np.zeros((len(blocks), HARMONICS * LONGEST), complex)
    lines[:, LONGEST // cycles - 1 :: LONGEST // cycles] = 2.0 * np.einsum("bns,ns->bn", over_cycles, within)
    return lines


def read_off_reference(mesh: MeshForce, drive: DriveTrain, motion: ElasticMotion, direction: Direction) -> SweepPoint:
    """Return what a sweep reports of one periodic cycle by Gear's method, for drives that the fixed steps do not take.

    Parameters
    ----------
    mesh, drive : MeshForce, DriveTrain
        The model at this speed.
    motion : ElasticMotion
        One cycle of a stable periodic motion.
    direction : {"rest", "up", "down"}
        Handed through.

    Returns
    -------
    SweepPoint

    Notes
    -----
    Extremes are those of the samples, `steps` their number. The natural frequency is still that of the two gears alone.
    """
    sizes, error = scales(mesh, drive), motion.transmission_error
    count, mean = error.size, float(error.mean())
    lines = _lines((error - mean)[None], np.full(count, 1.0 / count), np.arange(count) / count)
    turn = 2.0 * math.pi * mesh.pinion_angle[0] / mesh.period
    harmonics = lines[0, LONGEST - 1 :: LONGEST] * np.exp(-1j * turn * np.arange(1, HARMONICS + 1))
    start = float(error[0] - mesh.unloaded_error[0])
    rate = float(error[1] - error[-1]) * count * drive.pinion_speed / (2.0 * mesh.period)
    return SweepPoint(
        direction=direction,
        pinion_speed=drive.pinion_speed,
        mesh_frequency=drive.pinion_speed / mesh.period,
        natural_frequency=sizes.natural / (2.0 * math.pi),
        dynamic_factor_max=motion.largest_dynamic_factor,
        dynamic_factor_min=float(motion.dynamic_factor.min()),
        mesh_force_max=float(motion.mesh_force.max()),
        mesh_force_mean=float(motion.mesh_force.mean()),
        error_mean=mean,
        error_rms=float(error.std()),
        harmonic_amplitude=np.abs(harmonics),
        harmonic_phase=np.angle(harmonics),
        line_order=ORDERS,
        line_amplitude=np.abs(lines[0]),
        contact_loss=motion.contact_loss,
        back_contact=float(np.mean(motion.mesh_force < 0.0)),
        period_cycles=1,
        growth=float(np.abs(motion.multipliers).max()),
        multiplier_magnitude=np.sort(np.abs(motion.multipliers))[::-1],
        wheel_torque=motion.wheel_torque,
        state=np.array([start, rate, motion.wheel_torque / sizes.braking]),
        steps=count,
    )


def _extremes(mesh: MeshForce, drive: DriveTrain, track: Track, nodes: Array, repeats: bool) -> tuple[float, float, float]:
    """Return largest and least Kw and the largest force on the working flank less that on the back."""
    flat = nodes.reshape(-1, 5)
    factor, force = flat[:, 3] / track.drive, flat[:, 2] * mesh.mean_stiffness * scales(mesh, drive).unit
    tops = np.concatenate([_tops(values) for values in (factor, -factor, force)])
    steps = track.steps.size
    reversal = np.flatnonzero(np.diff(track.first) != 2)
    ends = (reversal + steps * np.arange(len(nodes))[:, None]).ravel()
    rows = np.unique(np.concatenate([tops, tops - 1, ends]) % len(flat))
    rows = rows[(rows + 1 < len(flat)) | repeats]
    side = flat[rows, 4]
    rows = rows[(side != 0.0) & (side == flat[(rows + 1) % len(flat), 4])]
    if rows.size:
        closer, pressed = _within(mesh, drive, track, flat, rows)
        factor, force = np.append(factor, closer), np.append(force, pressed)
    return float(factor.max()), float(factor.min()), float(force.max())


def _tops(values: Array) -> NDArray[np.intp]:
    """Return the highest few of the nodes that no neighbour exceeds."""
    level = np.flatnonzero((values >= np.roll(values, 1)) & (values >= np.roll(values, -1)))
    return level[np.argsort(values[level])[-TOPS:]]


def _within(mesh: MeshForce, drive: DriveTrain, track: Track, flat: Array, rows: NDArray[np.intp]) -> tuple[Array, Array]:
    """Return Kw and force at places within steps that start at some nodes, from the law itself.

    x is Hermite's cubic between the nodes (h^4/384 of its fourth derivative).
    """
    sizes, step = scales(mesh, drive), rows % track.steps.size
    s, h = np.linspace(0.0, 1.0, PLACES)[:, None], track.steps[step]
    (x0, v0), (x1, v1) = flat[rows, :2].T, flat[(rows + 1) % len(flat), :2].T
    bend, twist = 3.0 * (x1 - x0) - h * (2.0 * v0 + v1), h * (v0 + v1) - 2.0 * (x1 - x0)
    x = x0 + s * (h * v0 + s * (bend + s * twist))
    v = v0 + s * (2.0 * bend + 3.0 * s * twist) / h
    points = track.motion[track.first[step][:, None] + np.arange(3), :2]
    weights = np.stack([(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)], axis=-1)
    offset, drift = np.moveaxis((weights[..., None] * points).sum(axis=-2), -1, 0)
    side = flat[rows, 4]
    depth = np.where(side > 0.0, x + offset, -(x + offset) - track.backlash)
    speed = side * (v + drift)
    start, end = track.angle[step], track.angle[step + 1]
    friction = drive.friction_coefficient
    values, _ = flank_force(mesh)(start + s * (end - start), depth * sizes.unit, 0.5 * (start + end) + 0.0 * s, friction > 0.0)
    force = values[..., 0] + track.damping * mesh.mean_stiffness * sizes.unit * speed
    arm = side * values[..., 1] + friction * values[..., 3]
    return force * arm / drive.pinion_torque, side * force
