"""Steady motion over the speed: both branches of jumps, statistics, several processes."""

from __future__ import annotations

import dataclasses
import math
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from multiprocessing import get_context
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.dynamics.fast import PERIODS, TAIL, Steady, march, steady
from gearfem.dynamics.record import DriveTrain
from gearfem.dynamics.rigid import unloaded_transport
from gearfem.dynamics.sweep_record import DIRECTIONS, Direction, Sweep, SweepPoint
from gearfem.dynamics.track import Track, default_steps, make_track, scales
from gearfem.engagement.record import MeshForce
from gearfem.foundation import Array, InputError, SolveError
from gearfem.foundation.progress import Progress, quiet
from gearfem.foundation.units import RPM

HARMONICS = 6
LONGEST = PERIODS[-1]
FEWEST_STEPS, MOST_STEPS = 32, 65536
Finished = Callable[[SweepPoint], None]


@dataclasses.dataclass(frozen=True)
class Case:
    """What all points of a sweep have in common; `steps` 0 leaves their number to each speed."""

    mesh: MeshForce
    drive: DriveTrain
    steps: int = 0


def sweep(
    mesh: MeshForce,
    drive: DriveTrain,
    speeds: Iterable[float],
    *,
    both_ways: bool = False,
    steps: int = 0,
    workers: int = 1,
    known: Sequence[SweepPoint] = (),
    finished: Finished | None = None,
    progress: Progress = quiet,
) -> Sweep:
    """Return the steady motion of the elastic model at every speed, by compiled fixed steps.

    Parameters
    ----------
    mesh : MeshForce
        Forces of the working flanks.
    drive : DriveTrain
        Two inertias, pinion torque, friction and damping; speed, wheel torque and efficiency are not used.
    speeds : iterable of float
        Mean speeds of the pinion, increasing [rad/s].
    both_ways : bool
        Whether each speed starts from the motion at the one before it, upward and downward, so that both branches of a jump appear;
        by default each starts from the mean deflection at rest, independent of the others.
    steps : int
        Steps per mesh cycle; 0 takes `default_steps`, whose error is below 1e-4 of Kw.
    workers : int
        Processes; up and down count as one task each, independent speeds as many. A script that asks for more than one
        needs the usual guard `if __name__ == "__main__"`.
    known : sequence of SweepPoint
        Points of an interrupted sweep, which are not computed again; the rest comes out as if it had not been interrupted.
    finished : callable, optional
        Told each new point as soon as it is there.
    progress : Progress
        Listener.

    Returns
    -------
    Sweep

    Raises
    ------
    InputError
        If speeds, steps or workers cannot be used, or the drive has more than two inertias.
    SolveError
        If a speed fails; it is named.

    Notes
    -----
    Equations of `RelativeMotion`, as `elastic_motion`, whose numbers come out within 1e-4. The transport is the rigid motion
    under the unloaded ratio, uniform for unworn teeth. Steady motion as in `fast.steady`.

    Examples
    --------
    >>> from gearfem.engagement.record import MeshForce
    >>> angle, e = np.linspace(0.0, 0.4, 64, endpoint=False), np.linspace(0.0, 4e-5, 9)
    >>> force = 4e8 * (1.0 + 0.1 * np.cos(5.0 * np.pi * angle))[:, None] * e
    >>> mesh = MeshForce(pinion_angle=angle, period=0.4, deflection=e, normal_force=force, pinion_moment=0.05 * force,
    ...     wheel_moment=0.1 * force, pinion_friction=0.0 * force, wheel_friction=0.0 * force, unloaded_error=0.0 * angle,
    ...     sliding_reversals=np.empty(0), base_radius1=0.05, base_radius2=0.1, normal_backlash=1e-4, mean_stiffness=4e8)
    >>> drive = DriveTrain(pinion_inertia=0.01, wheel_inertia=0.1, pinion_torque=300.0, wheel_torque=600.0,
    ...     efficiency=1.0, pinion_speed=100.0, friction_coefficient=0.0, damping_ratio=0.1)
    >>> result = sweep(mesh, drive, np.linspace(100.0, 1000.0, 4))
    >>> bool(result.column("dynamic_factor_max", "rest").max() > 1.1)
    True
    """
    wanted = _checked(mesh, drive, speeds, steps, workers)
    chains: list[tuple[Direction, list[float]]] = [("rest", [speed]) for speed in wanted]
    if both_ways:
        chains = [("up", wanted), ("down", wanted[::-1])]
    have = {(point.direction, point.pinion_speed): point for point in known}
    points: list[SweepPoint] = []
    total = sum(len(chain) for _, chain in chains)
    with _pool(Case(mesh, drive, steps), min(workers, len(chains))) as pool:
        for point, is_new in _points(pool, chains, have):
            points.append(point)
            if is_new and finished is not None:
                finished(point)
            progress("sweep", len(points), total)
    return Sweep(points=tuple(sorted(points, key=lambda point: (DIRECTIONS.index(point.direction), point.pinion_speed))))


def _checked(mesh: MeshForce, drive: DriveTrain, speeds: Iterable[float], steps: int, workers: int) -> list[float]:
    wanted = [float(speed) for speed in speeds]
    if not wanted or min(wanted) <= 0.0 or not np.isfinite(wanted).all() or (np.diff(wanted) <= 0.0).any():
        raise InputError("sweep, speeds", wanted[:5], "positive, increasing speeds [rad/s]")
    if steps and not FEWEST_STEPS <= steps <= MOST_STEPS:
        raise InputError("sweep, steps", steps, f"0, or {FEWEST_STEPS} to {MOST_STEPS} per mesh cycle")
    if workers < 1:
        raise InputError("sweep, workers", workers, "at least 1")
    if not drive.two_inertias:
        raise InputError("sweep, drive", "further inertias or yielding supports", "two inertias; one speed at a time by `elastic_motion`")
    return wanted


# ---- order of work ----------------------------------------------------------------------------------


class _Here:
    """Does the work at once, in this process."""

    def __init__(self, case: Case) -> None:
        self._case = case

    def __enter__(self) -> _Here:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def submit(self, _: Callable[..., Any], *args: Any) -> Future[SweepPoint]:
        done: Future[SweepPoint] = Future()
        done.set_result(steady_point(self._case, *args))
        return done


def _pool(case: Case, workers: int) -> Executor | _Here:
    """Return where points are computed. New processes are started, not forked: a bar's thread may be running."""
    if workers == 1:
        return _Here(case)
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_begin, initargs=(case,))


_CASE: list[Case] = []


def _begin(case: Case) -> None:
    """Take the case into a worker; Ctrl-C is left to the process that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _CASE[:] = [case]


def _in_worker(*args: Any) -> SweepPoint:
    return steady_point(_CASE[0], *args)


def _points(
    pool: Any, chains: list[tuple[Direction, list[float]]], have: dict[tuple[Direction, float], SweepPoint]
) -> Iterator[tuple[SweepPoint, bool]]:
    """Yield all points, and whether they are new, as they come: one after the other within a chain, chains side by side."""
    waiting: dict[Future[SweepPoint], Iterator[tuple[Direction, float]]] = {}
    ready: list[tuple[Iterator[tuple[Direction, float]], Array | None]] = [
        (iter([(direction, speed) for speed in chain]), None) for direction, chain in reversed(chains)
    ]
    # Twice as many tasks as processes keep them busy, and few are lost by an interrupt.
    room = 2 * getattr(pool, "_max_workers", 1) if isinstance(pool, Executor) else 1
    try:
        while ready or waiting:
            while ready and len(waiting) < room:
                chain, state = ready.pop()
                for key in chain:
                    if key not in have:
                        waiting[pool.submit(_in_worker, *key, state)] = chain
                        break
                    state = have[key].state
                    yield have[key], False
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                point, chain = future.result(), waiting.pop(future)
                yield point, True
                ready.append((chain, point.state))
    finally:
        for future in waiting:
            future.cancel()


# ---- one speed --------------------------------------------------------------------------------------


def steady_point(case: Case, direction: Direction, speed: float, state: Array | None) -> SweepPoint:
    """Return the steady motion at one speed.

    Parameters
    ----------
    case : Case
        Tables and drive.
    direction : {"rest", "up", "down"}
        Written into the point.
    speed : float
        Mean speed of the pinion [rad/s].
    state : ndarray, shape (3,), optional
        `SweepPoint.state` of a neighbouring speed; default: the mean deflection at rest.

    Returns
    -------
    SweepPoint

    Raises
    ------
    SolveError
        With the speed at which it failed.
    """
    drive = dataclasses.replace(case.drive, pinion_speed=speed)
    sizes = scales(case.mesh, drive)
    try:
        transport = unloaded_transport(case.mesh, drive) if case.mesh.unloaded_error.any() else None
        track = make_track(case.mesh, drive, case.steps or default_steps(sizes.length), transport)
        # Deflection d = x + offset, and so its rate.
        offset = np.array([track.motion[0, 0], track.motion[0, 1], 0.0])
        start = (np.array([1.0, 0.0, 1.0]) if state is None else state / sizes.state) - offset
        found = steady(track, start, drive.damping_ratio * sizes.length, state is not None)
        _, held, nodes = march(track, found.state, found.period or TAIL, nodes=True)
    except SolveError as error:
        raise SolveError(f"at {speed / RPM:.6g} rpm: {error}") from error
    return _point(case.mesh, drive, track, found, direction, held, nodes)


def _point(mesh: MeshForce, drive: DriveTrain, track: Track, found: Steady, direction: Direction, held: Array, nodes: Array) -> SweepPoint:
    sizes = scales(mesh, drive)
    length, step = track.times[-1], track.steps
    weights = 0.5 * (step + np.roll(step, 1)) / length
    error = sizes.unit * (nodes[..., 0] + track.motion[track.first, 0] + track.unloaded[:-1])
    mean = float((error * weights).sum() / len(error))
    lines = _lines(error - mean, weights, track.times[:-1] / length)
    # The samples start at the table's first angle, phases count from angle 0.
    turn = 2.0 * math.pi * mesh.pinion_angle[0] / mesh.period
    harmonics = lines[0, LONGEST - 1 :: LONGEST] * np.exp(-1j * turn * np.arange(1, HARMONICS + 1))
    moment = nodes[..., 3] / (sizes.gain1 * drive.pinion_torque)
    force = nodes[..., 2] * mesh.mean_stiffness * sizes.unit
    offset = np.array([track.motion[0, 0], track.motion[0, 1], 0.0])
    return SweepPoint(
        direction=direction,
        pinion_speed=drive.pinion_speed,
        mesh_frequency=drive.pinion_speed / mesh.period,
        natural_frequency=sizes.natural / (2.0 * math.pi),
        dynamic_factor_max=_largest(moment, nodes[..., 4], track),
        dynamic_factor_min=-_largest(-moment, nodes[..., 4], track),
        mesh_force_max=_largest(force, nodes[..., 4], track),
        mesh_force_mean=float((force * weights).sum() / len(force)),
        error_mean=mean,
        error_rms=math.sqrt(float(((error - mean) ** 2 * weights).sum() / len(error))),
        harmonic_amplitude=np.abs(harmonics),
        harmonic_phase=np.angle(harmonics),
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


def _largest(values: Array, side: Array, track: Track) -> float:
    """Return the largest value between the samples (cycles, s), in parabolas through three samples of one contact state.

    They are laid through each sample that tops both neighbours, and on to the reversals of sliding, where friction jumps.
    """
    count, steps = values.size, track.steps.size
    flat, state = values.ravel(), side.ravel()
    row = np.arange(1, count - 1)
    same = (state[row - 1] == state[row]) & (state[row + 1] == state[row])
    joined = track.first[row % steps] - track.first[(row - 1) % steps] == 2
    joined &= track.first[(row + 1) % steps] - track.first[row % steps] == 2
    left, middle, right = flat[:-2], flat[1:-1], flat[2:]
    bend = 2.0 * middle - left - right
    top = same & joined & (middle >= left) & (middle >= right) & (bend > 0.0)
    peaks = middle[top] + (right[top] - left[top]) ** 2 / (8.0 * bend[top])
    last = same & joined & (track.first[(row + 2) % steps] - track.first[(row + 1) % steps] != 2)
    ends = (left - 3.0 * middle + 3.0 * right)[last]
    return float(max(flat.max(), peaks.max(initial=-math.inf), ends.max(initial=-math.inf)))
