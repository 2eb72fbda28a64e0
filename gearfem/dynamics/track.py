"""One mesh cycle laid out for fixed steps: everything that depends on time alone, worked out beforehand."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math

import numpy as np
from numpy.typing import NDArray

from gearfem.dynamics.flank_force import flank_force
from gearfem.dynamics.periodic import smooth
from gearfem.dynamics.record import DriveTrain, RigidMotion
from gearfem.dynamics.relative import RelativeMotion
from gearfem.engagement.record import MeshForce
from gearfem.foundation import Array, InputError, Record

# A stride of the explicit steps, and the fewest of a cycle: 1e-5 of Kw (tests/convergence/test_fast_steps.py).
STRIDE = 0.1
FEWEST_STEPS = 256
# Shares of a cycle below which two ends of a span are one.
EDGE = 1e-9


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Track(Record):
    """Steps of one cycle and, at the start, middle and end of each, the law of the force over the deflection alone.

    Scaled as `RelativeMotion`: lengths by X = T1/(r_b1 C), times by 1/omega_n, forces by C X.

    Parameters
    ----------
    times, angle : ndarray, shape (s + 1,)
        Scaled times of the nodes, and pinion angle of the transport there [rad].
    unloaded : ndarray, shape (s + 1,)
        Transmission error of the rigid gears at the nodes.
    steps : ndarray, shape (s,)
        Lengths of the steps; they end on the reversals of the sliding.
    first : ndarray of int, shape (s,)
        Number of each step's first point; its middle and end follow.
    motion : ndarray, shape (p, 4)
        Offset and drift of the transport; pushes on x and on r_b1 q1 other than those of wheel torque and teeth.
    knots : ndarray, shape (m,)
        Deflections between which the force is a cubic.
    table : ndarray, shape (p, m - 1, 20)
        Cubics of force, of its arms on x and on r_b1 q1 on the working flank, and of these on the back flank.
    damping, backlash : float
        2 zeta, and the scaled backlash.
    drive, load : float
        Pushes of the pinion torque on r_b1 q1 and of the balanced wheel torque on x.
    """

    times: Array
    angle: Array
    unloaded: Array
    steps: Array
    first: NDArray[np.int64]
    motion: Array
    knots: Array
    table: Array
    damping: float
    backlash: float
    drive: float
    load: float


def default_steps(length: float) -> int:
    """Return steps enough for a cycle of scaled length: powers of the root of two, so that many speeds share a track."""
    octaves = math.ceil(2.0 * math.log2(max(length / STRIDE / FEWEST_STEPS, 1.0)))
    return math.ceil(FEWEST_STEPS * math.pow(2.0, 0.5 * octaves))


@dataclasses.dataclass(frozen=True)
class Scales:
    """Units of the scaled motion, as in `RelativeMotion`: length [m], 1/time [1/s]; the cycle's scaled length.

    `gain1`, `gain2`: scaled accelerations of r_b1 q1 and r_b2 q2 per torque on pinion and wheel; `braking` the balanced torque.
    """

    unit: float
    natural: float
    length: float
    gain1: float
    gain2: float
    braking: float

    @property
    def state(self) -> Array:
        """Deflection [m], its rate [m/s] and the wheel's torque ratio per scaled one."""
        return np.array([self.unit, self.unit * self.natural, 1.0])


def scales(mesh: MeshForce, drive: DriveTrain) -> Scales:
    """Return the units of the scaled motion of two inertias."""
    r1, r2 = mesh.base_radius1, mesh.base_radius2
    mass1, mass2 = drive.pinion_inertia / r1**2, drive.wheel_inertia / r2**2
    natural = math.sqrt(mesh.mean_stiffness * (mass1 + mass2) / (mass1 * mass2))
    unit = drive.pinion_torque / (r1 * mesh.mean_stiffness)
    speed = unit * natural**2
    return Scales(
        unit=unit,
        natural=natural,
        length=natural * mesh.period / drive.pinion_speed,
        gain1=r1 / (drive.pinion_inertia * speed),
        gain2=r2 / (drive.wheel_inertia * speed),
        braking=drive.pinion_torque * r2 / r1,
    )


def make_track(mesh: MeshForce, drive: DriveTrain, steps: int, transport: RigidMotion | None = None) -> Track:
    """Return the layout of one cycle in about `steps` steps.

    Parameters
    ----------
    mesh : MeshForce
        Tables of the working flanks.
    drive : DriveTrain
        Two inertias, torque, friction, damping and speed.
    steps : int
        Steps of a cycle; each part between two reversals of the sliding is divided equally, and rounded up.
    transport : RigidMotion, optional
        Motion that the elastic one is counted from; default: uniform rotation, of which nothing has to be integrated.

    Returns
    -------
    Track

    Raises
    ------
    InputError
        If the drive has more than two inertias.

    Notes
    -----
    The angle enters through the transport alone, so that the splines over the angle are evaluated here, once, and the
    steps meet cubics over the deflection only: the very values that `RelativeMotion` has, without an error of their own.
    Under uniform rotation they are the same at all speeds, and kept.
    """
    if not drive.two_inertias:
        raise InputError("drive, fixed steps", "further inertias or yielding supports", "two inertias; `elastic_motion` takes all of them")
    sizes = scales(mesh, drive)
    gains = (sizes.gain1 * sizes.unit * mesh.mean_stiffness, sizes.gain2 * sizes.unit * mesh.mean_stiffness)
    own = np.full(1, sizes.gain1 * drive.pinion_torque)
    if transport is None:
        grid = _even(mesh, drive.friction_coefficient > 0.0, steps)
        angle = mesh.pinion_angle[0] + grid.share * mesh.period
        table = _even_law(mesh, steps, sizes.unit, *gains, drive.friction_coefficient)
        curve = smooth(mesh.pinion_angle, mesh.unloaded_error, mesh.period)
        unloaded, drift = curve(angle), -drive.pinion_speed * curve(angle, 1)
        motion = np.stack(np.broadcast_arrays(-unloaded / sizes.unit, drift / (sizes.unit * sizes.natural), own, own), axis=1)
    else:
        system = RelativeMotion(mesh, drive, transport)
        grid = _grid([(start / system.length, end / system.length, middle) for start, end, middle in system.intervals()], steps)
        carried = system.transport(grid.share * system.length)
        angle = np.asarray(carried.angle)
        table = _law(mesh, angle, grid.middle, sizes.unit, *gains, drive.friction_coefficient)
        unloaded = system.unloaded(angle)
        pinion = own - sizes.gain1 * drive.pinion_inertia * carried.pinion_acceleration
        push = pinion + sizes.gain2 * drive.wheel_inertia * carried.wheel_acceleration
        motion = np.stack([carried.offset / sizes.unit, carried.drift / (sizes.unit * sizes.natural), push, pinion], axis=1)
    nodes = np.append(grid.first, grid.share.size - 1)
    return Track(
        times=grid.share[nodes] * sizes.length,
        angle=angle[nodes],
        unloaded=unloaded[nodes] / sizes.unit,
        steps=(grid.share[grid.first + 2] - grid.share[grid.first]) * sizes.length,
        first=grid.first,
        motion=motion,
        knots=flank_force(mesh).deflection / sizes.unit,
        table=table,
        damping=2.0 * drive.damping_ratio,
        backlash=mesh.normal_backlash / sizes.unit,
        drive=sizes.gain1 * drive.pinion_torque,
        load=sizes.gain2 * sizes.braking,
    )


# ---- where the steps lie ----------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class _Grid:
    """Points as shares of the cycle, an angle on their side of the reversals, and the first point of each step."""

    share: Array
    middle: Array
    first: NDArray[np.int64]


def _grid(spans: list[tuple[float, float, float]], steps: int) -> _Grid:
    """Divide the spans (start, end as shares of the cycle; angle in the middle) into steps."""
    share, middles, first, start = [], [], [], 0
    for begin, end, middle in spans:
        count = math.ceil(steps * (end - begin) - 1e-6)
        share.append(np.linspace(begin, end, 2 * count + 1))
        middles.append(np.full(2 * count + 1, middle))
        first.append(start + 2 * np.arange(count, dtype=np.int64))
        start += 2 * count + 1
    return _Grid(np.concatenate(share), np.concatenate(middles), np.concatenate(first))


def _even(mesh: MeshForce, friction: bool, steps: int) -> _Grid:
    places = np.sort((flank_force(mesh).reversals - mesh.pinion_angle[0]) / mesh.period % 1.0) if friction else np.empty(0)
    edges = [0.0, *places[(places > EDGE) & (places < 1.0 - EDGE)], 1.0]
    spans = [(a, b, mesh.pinion_angle[0] + 0.5 * (a + b) * mesh.period) for a, b in itertools.pairwise(edges)]
    return _grid(spans, steps)


# ---- the law at the points --------------------------------------------------------------------------


@functools.lru_cache(maxsize=8)
def _even_law(mesh: MeshForce, steps: int, unit: float, gain1: float, gain2: float, friction: float) -> Array:
    grid = _even(mesh, friction > 0.0, steps)
    angle = mesh.pinion_angle[0] + grid.share * mesh.period
    table = _law(mesh, angle, grid.middle, unit, gain1, gain2, friction)
    table.flags.writeable = False
    return table


def _law(mesh: MeshForce, angle: Array, middle: Array, unit: float, gain1: float, gain2: float, friction: float) -> Array:
    """Return the table of both flanks in powers of the scaled depth above the cell's first knot."""
    force = flank_force(mesh)
    powers = force.sections(angle, middle, friction > 0.0)
    powers = powers / np.diff(force.deflection / unit)[:, None, None] ** np.arange(4)[:, None]
    arms, rubbing = powers[..., 1:3], friction * powers[..., 3:5]
    parts = [powers[..., 0] / (mesh.mean_stiffness * unit)]
    for sign in (1.0, -1.0):
        one, two = np.moveaxis(sign * arms + rubbing, -1, 0)
        parts += [gain1 * one + gain2 * two, gain1 * one]
    return np.concatenate(parts, axis=-1)
