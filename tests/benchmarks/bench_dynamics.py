"""How fast the sweeps are: compiled steps against C of the same method and against BDF, schemes beside each other, a sweep.

Run it by itself: ``python tests/benchmarks/bench_dynamics.py``. Ratios within one run count, times depend on the machine.
"""

from __future__ import annotations

import ctypes
import dataclasses
import math
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np

from gearfem.dynamics import make_drive, sweep, uniform_transport
from gearfem.dynamics.cycle import integrate_cycle
from gearfem.dynamics.fast import kernels, march
from gearfem.dynamics.kernels import law
from gearfem.dynamics.relative import RelativeMotion
from gearfem.dynamics.track import default_steps, make_track, scales
from gearfem.engagement.engage import mesh_force
from gearfem.foundation import SolveError
from gearfem.foundation.units import RPM
from gearfem.model import load_model
from gearfem.pipeline import run

HERE = Path(__file__).parent
MODEL = HERE.parents[1] / "studies" / "coal_combine" / "model.toml"
CYCLES, ROUNDS, ALLOWED = 2000, 7, 2.0


@numba.njit(error_model="numpy")
def exponential(steps, first, motion, table, knots, damp, brake, x, v, cycles):
    """Step with stiffness and damping frozen at the middle of each step, whose linear equation is then solved exactly.

    Second order (midpoint), stable at any step; contact on the working flank throughout.
    """
    cell = 0
    for _ in range(cycles):
        for step in range(steps.size):
            h, point = steps[step], first[step] + 1
            depth = x + 0.5 * h * v + motion[point, 0]
            force, both, _, cell = law(table, knots, point, depth, 1, cell)
            c, s = table[point, cell], min(max(depth, 0.0), knots[-1]) - knots[cell]
            slope = (3.0 * c[3] * s + 2.0 * c[2]) * s + c[1]
            stiff, half = slope * both, 0.5 * damp * both
            rest = (motion[point, 2] + brake - (force + damp * motion[point, 1]) * both) / stiff + x + 0.5 * h * v
            wave = math.sqrt(stiff - half * half)
            decay, angle = math.exp(-half * h), wave * h
            away, sine, cosine = x - rest, math.sin(angle), math.cos(angle)
            x, v = (
                rest + decay * (away * cosine + (v + half * away) / wave * sine),
                decay * (v * cosine - (half * v + stiff * away) / wave * sine),
            )
    return np.array([x, v])


def best(work: Callable[[], object]) -> float:
    """Return the shortest time of several rounds [s]."""
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def c_library(folder: str) -> ctypes.CDLL | None:
    """Compile the C loop, or return None where no compiler is found."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        return None
    target = Path(folder) / "march.so"
    subprocess.run([compiler, "-O3", "-march=native", "-shared", "-fPIC", str(HERE / "march.c"), "-o", str(target)], check=True)
    library = ctypes.CDLL(str(target))
    library.march.restype = ctypes.c_ssize_t
    return library


def c_march(library, track, brake, state, cycles, side=1):
    """Run the C loop on the arrays of a track; return its count of steps."""
    real, whole = ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_ssize_t)
    view = [array.ctypes.data_as(real) for array in (track.steps, track.motion, track.table, track.knots, state)]
    count, cells = ctypes.c_ssize_t(track.steps.size), ctypes.c_ssize_t(track.knots.size - 1)
    numbers = [ctypes.c_double(value) for value in (track.damping, brake, track.backlash)]
    return library.march(
        view[0], track.first.ctypes.data_as(whole), count, *view[1:4], cells, *numbers, view[4], side, ctypes.c_ssize_t(cycles)
    )


def against_c(track) -> bool:
    """Print the cost of a cycle here and in C; return whether it is within the allowed ratio."""
    start, brake = np.array([1.1, 0.0, 0.0]), track.load
    rows, law_of = np.empty((0, 5)), (track.motion, track.table, track.knots, track.damping, brake, track.backlash)

    def ours():
        state = start.copy()
        kernels().march(track.steps, track.first, *law_of, state, CYCLES, rows, np.zeros(3))
        return state

    here = ours()
    ours_time = best(ours) / CYCLES
    with tempfile.TemporaryDirectory() as folder:
        library = c_library(folder)
        if library is None:
            print(f"cycle of {track.steps.size} steps: {ours_time * 1e6:.1f} us; no C compiler found, so nothing to compare with")
            return True
        there = start.copy()
        done = c_march(library, track, brake, there, CYCLES)
        assert done == CYCLES * track.steps.size, "the C loop met a contact event"
        assert np.allclose(here[:2], there[:2], atol=1e-9), (here, there)

        def c_loop():
            c_march(library, track, brake, start.copy(), CYCLES)

        c_time = best(c_loop) / CYCLES
    ratio = ours_time / c_time
    print(
        f"cycle of {track.steps.size} steps: {ours_time * 1e6:.1f} us, C -O3 {c_time * 1e6:.1f} us, ratio {ratio:.2f} (allowed {ALLOWED:g})"
    )
    return ratio <= ALLOWED


def schemes(mesh, drive) -> None:
    """Print cost and error of Runge-Kutta and exponential steps against BDF at 1e-12, over one cycle in contact."""
    print(f"{'rpm':>6} {'steps':>6} {'RK4 error':>10} {'us':>7} {'exp. error':>10} {'us':>7}   (error of x, x' in mean deflections)")
    for rpm in (50.0, 500.0, 1500.0):
        slow = dataclasses.replace(drive, pinion_speed=rpm * RPM)
        system = RelativeMotion(mesh, slow, uniform_transport(mesh, slow))
        reference = integrate_cycle(system, np.array([1.1, 0.0, 0.0, 0.0]), 1.0, 1e-11).end[:2]
        for count in (50, 100, 200, 400, 800, default_steps(scales(mesh, slow).length)):
            track = make_track(mesh, slow, count)
            frozen = (track.steps, track.first, track.motion, track.table, track.knots, track.damping, track.load)
            classical = time_and_error(lambda cycles, track=track: march(track, np.array([1.1, 0.0, 1.0]), cycles)[0][:2], reference)
            exact = time_and_error(lambda cycles, frozen=frozen: exponential(*frozen, 1.1, 0.0, cycles), reference)
            print(f"{rpm:6.0f} {count:6d} {classical} {exact}")


def time_and_error(run_cycles: Callable[[int], np.ndarray], reference: np.ndarray) -> str:
    """Return error after one cycle and time of one, or the word unstable."""
    try:
        error = np.abs(run_cycles(1) - reference).max()
        spent = best(lambda: run_cycles(20)) / 20
    except SolveError:
        return f"{'unstable':>10} {'':7}"
    return f"{error:10.1e} {spent * 1e6:7.1f}"


def main() -> int:
    """Print the table; return 1 if a cycle costs more than the allowed multiple of C's."""
    setup = load_model(str(MODEL))
    results = run(setup, "engagement")
    mesh, drive = mesh_force(results.mesh, setup.operation.pinion_torque), make_drive(setup)
    start = time.perf_counter()
    sweep(mesh, drive, [53.0])
    print(f"first motion, compiling or reading compiled code: {time.perf_counter() - start:.1f} s")
    good = against_c(make_track(mesh, drive, 400))
    system = RelativeMotion(mesh, drive, uniform_transport(mesh, drive))
    bdf = best(lambda: integrate_cycle(system, np.array([1.1, 0.0, 0.0, 0.0]), 1.0, 1e-8))
    print(f"cycle by BDF at 1e-8: {bdf * 1e3:.0f} ms")
    schemes(mesh, drive)
    for both_ways in (False, True):
        for workers in (1, 2):
            start = time.perf_counter()
            found = sweep(mesh, drive, np.linspace(50.0, 6000.0, 200) * RPM, both_ways=both_ways, workers=workers)
            word = "up and down" if both_ways else "from rest"
            spent = time.perf_counter() - start
            print(f"200 speeds {word}, {len(found.points)} steady motions, {workers} process{'es' * (workers > 1)}: {spent:.1f} s")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
