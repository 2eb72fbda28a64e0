"""Cost of a full 2D compliance curve against one sparse factorisation of the same matrices and its solves.

Run it as ``python tests/benchmarks/compliance_curve.py`` with OMP_NUM_THREADS=1; it is no test and not collected. Both gears of the
coal combine, 50 load radii each, at the default resolution, whose error is below 0.2 %. The reference is generous: matrices that are
assembled already, the sector with its bore held, factorised and solved for the 50 loads alone, by the fastest installed solver
for each gear; the curve does mesh, assembly, all factors, the ring of sectors, loads and readings. CPU seconds, least of 7 runs
in turns, two busy cores:

===================================================== ======== ======== ========
scipy's SuperLU, s (factors + 50 solves)               pinion   wheel    both
===================================================== ======== ======== ========
minimum degree of A' + A, symmetric mode               0.054    0.079    0.132
column minimum degree                                  0.103    0.172    0.275
minimum degree of A' A                                 0.110    0.174    0.285
the curve                                              0.080    0.132    0.212
curve, coupling of 6 neighbours and local depth        0.126    0.201    0.327
===================================================== ======== ======== ========

The curve was 1.6 times the reference; with the coupling and the local depth, which the contact needs, 2.5 times. Parts of the
curve: mesh 0.016 s, assembly 0.021 s, loads and readings 0.006 s, factors 0.130 s, ring 0.020 s.

Why this solver: scipy's SuperLU comes with every installation. With our own nested dissection, ports and cuts last, the trailing
block of its factors is the Schur complement, so that no solve runs over the inside; the mirror symmetry of the sector makes two
problems of half the size. The same SuperLU with minimum degree and solves for all unknowns of both cuts took 4.2 times
the reference. Solvers that come without wheels (CHOLMOD, PETSc) or in other languages' packages were not tried.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse.linalg import splu

from gearfem import load_model
from gearfem.compliance import FiniteElements, load_positions
from gearfem.compliance import finite_elements as module
from gearfem.compliance.elasticity import stiffness
from gearfem.compliance.load_lines import forces, load_lines, readings
from gearfem.compliance.ring import Ring
from gearfem.flank import Outline, make_flanks
from gearfem.foundation.threads import one_thread

RADII, RUNS = 50, 7
ORDERINGS: dict[str, dict[str, Any]] = {
    "minimum degree of A' + A, symmetric mode": {
        "permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True},
    },
    "column minimum degree": {"permc_spec": "COLAMD"},
    "minimum degree of A' A": {"permc_spec": "MMD_ATA"},
}  # fmt: skip


def seconds(work: Callable[[], object]) -> float:
    """Return the CPU seconds of one call."""
    start = time.process_time()
    work()
    return time.process_time() - start


def curve(outline: Outline, u: np.ndarray) -> None:
    """Compute the curve without what is remembered."""
    module._curve.forget()
    FiniteElements().curve(outline, u)


def tooth(outline: Outline, u: np.ndarray) -> None:
    """Compute the curve, the coupling of six neighbours and the local depth."""
    module._tooth.forget()
    FiniteElements().tooth(outline, u)


def parts(outline: Outline, u: np.ndarray) -> dict[str, float]:
    """Return the CPU seconds of the steps of the curve."""
    method, marks = FiniteElements(), [time.process_time()]
    section = method._mesh(outline)
    marks.append(time.process_time())
    matrix = stiffness(section.mesh, method.plane, outline.gear.material)
    marks.append(time.process_time())
    lines = load_lines(outline, u)
    load, reading = forces(section, lines), readings(section, lines)
    ports = np.flatnonzero((np.abs(load) + np.abs(reading)).sum(axis=1).reshape(2, -1).any(axis=0))
    marks.append(time.process_time())
    ring = Ring(section, matrix, outline.gear.teeth, ports)
    marks.append(time.process_time())
    ring.deflection(load, reading)
    marks.append(time.process_time())
    return dict(zip(("mesh", "assembly", "loads", "factors", "ring"), np.diff(marks), strict=True))


def main() -> None:
    """Print the table of the docstring."""
    flanks = make_flanks(load_model("studies/coal_combine/model.toml"))
    gears = {name: (outline, load_positions(outline, RADII)) for name, outline in (("pinion", flanks.pinion), ("wheel", flanks.wheel))}
    times: dict[tuple[str, str], list[float]] = {}
    steps: list[dict[str, float]] = []
    with one_thread():
        for _ in range(RUNS):
            for name, (outline, u) in gears.items():
                method = FiniteElements()
                section = method._mesh(outline)
                nodes = section.mesh.doflocs.shape[1]
                free = np.setdiff1d(np.arange(2 * nodes), [*section.held, *(section.held + nodes)])
                matrix = stiffness(section.mesh, method.plane, outline.gear.material)[free][:, free]
                load = forces(section, load_lines(outline, u))[free]
                for title, options in ORDERINGS.items():
                    spent = seconds(lambda matrix=matrix, load=load, options=options: splu(matrix, **options).solve(load))
                    times.setdefault((title, name), []).append(spent)
                for title, work in (("the curve", curve), ("curve, coupling and local depth", tooth)):
                    times.setdefault((title, name), []).append(seconds(lambda work=work, o=outline, u=u: work(o, u)))
                steps.append(parts(outline, u))
    least = {key: min(values) for key, values in times.items()}
    for title in [*ORDERINGS, "the curve", "curve, coupling and local depth"]:
        row = [least[title, name] for name in gears]
        print(f"{title:53s} {row[0]:8.3f} {row[1]:8.3f} {sum(row):8.3f}")
    reference = sum(min(least[title, name] for title in ORDERINGS) for name in gears)
    for title in ("the curve", "curve, coupling and local depth"):
        print(f"{title}: {sum(least[title, name] for name in gears) / reference:.2f} times the reference")
    print(", ".join(f"{step} {sum(min(s[step] for s in steps[g::2]) for g in (0, 1)):.3f} s" for step in steps[0]))


if __name__ == "__main__":
    main()
