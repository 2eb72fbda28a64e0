"""Steady motion over the speed: both branches of jumps, statistics, several processes."""

from __future__ import annotations

import dataclasses
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from multiprocessing import get_context
from typing import Any

import numpy as np

from gearfem.dynamics.elastic import TAIL as TAIL_CYCLES
from gearfem.dynamics.elastic import elastic_motion
from gearfem.dynamics.fast import TAIL, march, steady
from gearfem.dynamics.measures import read_off, read_off_reference
from gearfem.dynamics.record import DriveTrain
from gearfem.dynamics.rigid import unloaded_transport
from gearfem.dynamics.sweep_record import Direction, Failure, Sweep, SweepPoint
from gearfem.dynamics.track import default_steps, make_track, scales
from gearfem.dynamics.uneven import uneven_point
from gearfem.engagement.record import MeshForce
from gearfem.engagement.turns import Turns
from gearfem.foundation import Array, InputError, SolveError
from gearfem.foundation.progress import Progress, quiet

FEWEST_STEPS, MOST_STEPS = 32, 65536
REFERENCE_SAMPLES = 800
Found = SweepPoint | Failure
Finished = Callable[[Found], None]


@dataclasses.dataclass(frozen=True)
class Case:
    """What all points of a sweep have in common; `steps` 0 leaves their number to each speed."""

    mesh: MeshForce | Turns
    drive: DriveTrain
    steps: int = 0


def sweep(
    mesh: MeshForce | Turns,
    drive: DriveTrain,
    speeds: Iterable[float],
    *,
    both_ways: bool = False,
    steps: int = 0,
    workers: int = 1,
    known: Sequence[Found] = (),
    finished: Finished | None = None,
    progress: Progress = quiet,
) -> Sweep:
    """Return the steady motion of the elastic model at every speed, by compiled fixed steps.

    Parameters
    ----------
    mesh : MeshForce or Turns
        Forces of the working flanks; where teeth differ or torques ripple, the gears themselves, which are stepped over whole turns.
    drive : DriveTrain
        Inertias, pinion torque, friction and damping; speed, wheel torque and efficiency are not used.
    speeds : iterable of float
        Mean speeds of the pinion, increasing [rad/s].
    both_ways : bool
        Whether each speed starts from the motion at the one before it, upward and downward, so that both branches of a jump appear;
        by default each starts from the mean deflection at rest, independent of the others.
    steps : int
        Steps per mesh cycle of equal teeth; 0 takes `default_steps`, whose error is below 1e-4 of Kw.
    workers : int
        Processes; up and down count as one task each, independent speeds as many. A script that asks for more than one
        needs the usual guard `if __name__ == "__main__"`.
    known : sequence of SweepPoint or Failure
        What is there of an interrupted sweep, which are not computed again; the rest comes out as if it had not been interrupted.
    finished : callable, optional
        Told each new point, or failure, as soon as it is there.
    progress : Progress
        Listener.

    Returns
    -------
    Sweep
        Speeds that fail, as where parametric resonance outgrows the damping, are in its `failures`.

    Raises
    ------
    InputError
        If speeds, steps or workers cannot be used.

    Notes
    -----
    Equations of `RelativeMotion`, as `elastic_motion`, whose numbers come out within 1e-4. The transport is the rigid motion
    under the unloaded ratio, uniform for unworn teeth. Steady motion as in `fast.steady`. Drives of more than two inertias go
    through `elastic_motion` instead, a second or so for each speed: extremes are those of 800 samples, and motions that do
    not repeat after one cycle are failures. Over whole turns any drive train goes as in `march_turns`.

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
    wanted = _checked(speeds, steps, workers)
    chains: list[tuple[Direction, list[float]]] = [("rest", [speed]) for speed in wanted]
    if both_ways:
        chains = [("up", wanted), ("down", wanted[::-1])]
    have = {(point.direction, point.pinion_speed): point for point in known}
    points: list[Found] = []
    total = sum(len(chain) for _, chain in chains)
    with _pool(Case(mesh, drive, steps), min(workers, len(chains))) as pool:
        for point, is_new in _points(pool, chains, have):
            points.append(point)
            if is_new and finished is not None:
                finished(point)
            progress("sweep", len(points), total)
    return Sweep.of(points)


def _checked(speeds: Iterable[float], steps: int, workers: int) -> list[float]:
    wanted = [float(speed) for speed in speeds]
    if not wanted or min(wanted) <= 0.0 or not np.isfinite(wanted).all() or (np.diff(wanted) <= 0.0).any():
        raise InputError("sweep, speeds", wanted[:5], "positive, increasing speeds [rad/s]")
    if steps and not FEWEST_STEPS <= steps <= MOST_STEPS:
        raise InputError("sweep, steps", steps, f"0, or {FEWEST_STEPS} to {MOST_STEPS} per mesh cycle")
    if workers < 1:
        raise InputError("sweep, workers", workers, "at least 1")
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

    def submit(self, _: Callable[..., Any], *args: Any) -> Future[Found]:
        done: Future[Found] = Future()
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


def _in_worker(*args: Any) -> Found:
    return steady_point(_CASE[0], *args)


def _points(
    pool: Any, chains: list[tuple[Direction, list[float]]], have: dict[tuple[Direction, float], Found]
) -> Iterator[tuple[Found, bool]]:
    """Yield all points, and whether they are new, as they come: one after the other within a chain, chains side by side."""
    waiting: dict[Future[Found], Iterator[tuple[Direction, float]]] = {}
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
                    state = _end(have[key])
                    yield have[key], False
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                point, chain = future.result(), waiting.pop(future)
                yield point, True
                ready.append((chain, _end(point)))
    finally:
        for future in waiting:
            future.cancel()


def _end(found: Found) -> Array | None:
    return found.state if isinstance(found, SweepPoint) else None


# ---- one speed --------------------------------------------------------------------------------------


def steady_point(case: Case, direction: Direction, speed: float, state: Array | None) -> Found:
    """Return the steady motion at one speed.

    Parameters
    ----------
    case : Case
        Tables and drive.
    direction : {"rest", "up", "down"}
        Written into the point.
    speed : float
        Mean speed of the pinion [rad/s].
    state : ndarray, optional
        `SweepPoint.state` of a neighbouring speed; default: the mean deflection at rest.

    Returns
    -------
    SweepPoint or Failure
    """
    drive = dataclasses.replace(case.drive, pinion_speed=speed)
    try:
        if isinstance(case.mesh, Turns):
            return uneven_point(case.mesh, drive, direction, state)
        if drive.two_inertias:
            return _by_steps(case.mesh, drive, case.steps, direction, state)
        return _by_reference(case.mesh, drive, direction, state)
    except SolveError as error:
        return Failure(direction=direction, pinion_speed=speed, reason=str(error))


def _by_steps(mesh: MeshForce, drive: DriveTrain, steps: int, direction: Direction, state: Array | None) -> SweepPoint:
    sizes = scales(mesh, drive)
    transport = unloaded_transport(mesh, drive) if mesh.unloaded_error.any() else None
    track = make_track(mesh, drive, steps or default_steps(sizes.length), transport)
    # Deflection d = x + offset, and so its rate.
    offset = np.array([track.motion[0, 0], track.motion[0, 1], 0.0])
    start = (np.array([1.0, 0.0, 1.0]) if state is None else state / sizes.state) - offset
    found = steady(track, start, drive.damping_ratio * sizes.length, state is not None)
    _, held, nodes = march(track, found.state, found.period or TAIL, nodes=True)
    return read_off(mesh, drive, track, found, direction, held, nodes)


def _by_reference(mesh: MeshForce, drive: DriveTrain, direction: Direction, state: Array | None) -> SweepPoint:
    start = None if state is None else (float(state[0]), float(state[1]))
    motion = elastic_motion(mesh, drive, unloaded_transport(mesh, drive), cycles=1, samples=REFERENCE_SAMPLES, start=start)
    if not motion.periodic:
        tail = f"largest dynamic factor {motion.largest_dynamic_factor:.3f} over {TAIL_CYCLES} cycles"
        raise SolveError(f"elastic model by Gear's method: no stable motion of one cycle; {tail}")
    return read_off_reference(mesh, drive, motion, direction)
