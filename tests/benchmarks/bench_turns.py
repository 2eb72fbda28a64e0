"""What the engagement and the motion over many turns cost, part by part: python tests/benchmarks/bench_turns.py [MODEL].

All times are of the processor, in one run on one machine, best of some repeats; the ratios are what carries over to another.
Goals: 3 us an angle from tables already made, and 100 ms for three turns at one speed on Myga's rig.
"""

from __future__ import annotations

import dataclasses
import math
import sys
import time
from collections.abc import Callable

import numpy as np

from gearfem.dynamics import make_drive
from gearfem.dynamics.turns import march_turns
from gearfem.dynamics.turns_plan import mean_stiffness
from gearfem.engagement import engage
from gearfem.engagement.pair_table import coupling_table, pair_table
from gearfem.engagement.turns import Turns, static
from gearfem.model import load_model
from gearfem.pipeline import run

ANGLES = 100_000


def best(work: Callable[[], object], repeats: int = 5) -> float:
    """Return the shortest time of some calls [s]."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def main(model: str) -> None:
    """Print the times."""
    setup = load_model(model)
    mesh = run(setup, until="compliance").mesh
    assert mesh is not None
    torque, pitch, teeth = setup.operation.pinion_torque, setup.pair.pinion.pitch_angle, setup.pair.pinion.teeth
    rng = np.random.default_rng(1)
    late = [rng.normal(0.0, 1e-6, gear.teeth) for gear in (setup.pair.pinion, setup.pair.wheel)]
    placement = dataclasses.replace(mesh.placement, pinion_late=late[0], wheel_late=late[1])
    turns = Turns(mesh=dataclasses.replace(mesh, placement=placement))
    drive = make_drive(setup)
    angle = np.arange(3 * teeth * 64) / 64 * pitch
    start = time.process_time()
    static(turns, angle[:1], torque)
    march_turns(turns, drive, angle[:1])
    print(f"{model}: compiler or its cached code, and first tables: {time.process_time() - start:.2f} s")

    table = pair_table(turns.bare, 0)
    print(
        f"table of one pair ({len(table.law)} cells, {table.law.shape[1]} levels): {1e3 * best(lambda: pair_table(turns.bare, 0)):.1f} ms"
    )
    coupled = best(lambda: coupling_table(turns.bare, 0, 1, (table, table)))
    print(f"coupling with the next pair: {1e3 * coupled:.1f} ms")
    again = best(lambda: Turns(mesh=turns.mesh).stack(angle / pitch))
    print(f"other index errors, tables kept: {1e3 * again:.2f} ms")

    random = rng.uniform(0.0, 3.0 * math.tau, ANGLES)
    slow = best(lambda: static(turns, random, torque)) / ANGLES
    exact = best(lambda: engage(mesh, standard(pitch), torque), 2) / 400
    print(f"slow engagement: {1e6 * slow:.2f} us an angle; `engage` takes {exact / slow:.0f} times as long")

    whole = best(lambda: march_turns(turns, drive, angle))
    bare = best(lambda: march_turns(turns, drive, angle, loads=False))
    few = best(lambda: march_turns(turns, drive, angle[[0, -1]]))
    motion = march_turns(turns, drive, angle)
    slope = best(lambda: mean_stiffness(turns, torque))
    run_in = best(lambda: march_turns(turns, drive, angle[:1]))
    print(f"three turns at {drive.pinion_speed * 30.0 / math.pi:.0f} rpm, {angle.size} angles: {1e3 * whole:.1f} ms, of which")
    print(f"  mean stiffness {1e3 * slope:.1f} ms, start and run-in of {motion.run_in} pitches {1e3 * (run_in - slope):.1f} ms,")
    print(
        f"  steps {1e3 * (few - run_in):.1f} ms, reading {1e3 * (whole - few):.1f} ms ({1e6 * (whole - few) / angle.size:.2f} us an angle)"
    )
    print(f"  without loads at the angles {bare / whole:.2f} of the time")


def standard(pitch: float) -> np.ndarray:
    """Return 400 angles over a pitch."""
    return np.arange(400) / 400 * pitch


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "studies/myga_rig/model.toml")
