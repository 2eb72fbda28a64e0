"""Compiled inner loops of the engagement over many turns; imported when the first angle is solved, never with gearfem.

Tables are stacked: `knots` (t, c + 1) and `bins` (t, b) place an angle, `shape` (t, c, 7, 4) and `law` (t, c, l, 2, 4) are cubics
over it (highest power first). A `desk` is the scratch space of one angle, see `lay`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

QUANTITIES, COLUMNS = 7, 18
GAP, ARM1, ARM2, FRICTION1, FRICTION2, SLIDING, ON_FLANK = range(QUANTITIES)
CELL, PLACE, TABLE, FORCE, STIFFNESS, MISS, LEVER, MOMENT, DUAL, GAP_RATE, SLIDING_RATE = range(QUANTITIES, COLUMNS)
MOST_PAIRS = 10
ROUNDS = 40
# Newton's method converges quadratically: a load met to 1e-11 has its last digits.
TOLERANCE = 1e-11
FAR = 1.0
# Pitches from one angle to the next within which its loads are a place to start from.
NEAR = 0.1
BUILD = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:8]


def compiled(function: Kernel) -> Kernel:
    """Return the function compiled at its first call, the machine code kept on disk beside its file; it leaves other threads free.

    The code on disk goes by the function's name and notices changes of its own file alone; the digest of this one, whose functions
    are compiled into those of others, therefore becomes part of the name.
    """
    function.__qualname__ = f"{function.__qualname__}_{BUILD}"
    return cast(Kernel, numba.njit(cache=True, error_model="numpy", nogil=True)(function))


def inlined(function: Kernel) -> Kernel:
    """Return the function compiled into its callers."""
    return cast(Kernel, numba.njit(cache=True, error_model="numpy", nogil=True, forceinline=True)(function))


@inlined
def find(knots: Any, bins: Any, table: int, x: float) -> int:
    """Return the cell of a table that holds x, or -1 outside it."""
    low, high = knots[table, 0], knots[table, -1]
    if not low <= x < high:
        return -1
    cell = bins[table, int((x - low) / (high - low) * bins.shape[1])]
    while knots[table, cell + 1] <= x:
        cell += 1
    return int(cell)


@inlined
def cubic(c: Any, d: float) -> float:
    """Return a cubic, highest power first."""
    return float(((c[0] * d + c[1]) * d + c[2]) * d + c[3])


@inlined
def lay(
    q: float,
    common: float,
    tables: Any,
    late1: Any,
    late2: Any,
    knots: Any,
    bins: Any,
    shape: Any,
    base1: float,
    base2: float,
    turn: float,
    early: float,
    count: int,
    desk: Any,
) -> int:
    """Lay out the pairs in reach of the pinion angle q, rows of `desk`; return the number of the first. Angles are in pitches.

    `turn` is 1/(r_b1 pitch), `early` the least local angle of any table.
    Columns: gap with index errors and the common gap, arms, friction arms and sliding, cell and place in it (-1 out of reach), table,
    slopes of gap and sliding.
    """
    first = int(np.floor(q - early)) - count + 1
    for slot in range(count):
        pair = first + slot
        table = tables[pair % tables.size]
        # A late pinion tooth stands behind by e/r_b1: its pair is at an earlier place of its way, and both lags add to the gap.
        late = late1[pair % late1.size]
        x = q - pair - late * turn
        cell = find(knots, bins, table, x)
        desk[slot, CELL], desk[slot, TABLE], desk[slot, GAP] = cell, table, FAR
        desk[slot, ARM1], desk[slot, ARM2], desk[slot, LEVER] = base1, base2, 1.0
        if cell < 0:
            continue
        d = x - knots[table, cell]
        own = shape[table, cell]
        for quantity in range(QUANTITIES):
            desk[slot, quantity] = cubic(own[quantity], d)
        desk[slot, PLACE] = d
        # Corners count as if their gap stood still: as in the elastic model, the damper sees what happens on the flanks.
        desk[slot, GAP_RATE] = desk[slot, ON_FLANK] * ((3.0 * own[0, 0] * d + 2.0 * own[0, 1]) * d + own[0, 2])
        turned = own[SLIDING]
        desk[slot, SLIDING_RATE] = (3.0 * turned[0] * d + 2.0 * turned[1]) * d + turned[2]
        lever = desk[slot, ARM2] / base2
        desk[slot, LEVER] = lever
        desk[slot, GAP] += common + late + late2[pair % late2.size]
    return first


@inlined
def keep(passed: int, count: int, desk: Any, right: Any) -> None:
    """Leave loads with their pairs once the desk is laid so many pairs on; pairs out of reach bear none."""
    if passed != 0:
        for slot in range(count):
            right[slot] = desk[slot, FORCE]
        for slot in range(count):
            before = slot + passed
            desk[slot, FORCE] = right[before] if 0 <= before < count else 0.0
    for slot in range(count):
        if desk[slot, CELL] < 0.0:
            desk[slot, FORCE] = 0.0


@inlined
def couple(
    q: float,
    first: int,
    count: int,
    partners: Any,
    cknots: Any,
    cbins: Any,
    coupling: Any,
    yielding: float,
    desk: Any,
    matrix: Any,
) -> None:
    """Fill the compliances between the pairs in reach [m per N/m]: coupling through the bodies, and the common yield of the supports."""
    for j in range(count):
        for k in range(count):
            matrix[j, k] = yielding * desk[j, LEVER] * desk[k, LEVER]
    for j in range(count):
        for apart in range(1, count - j):
            k = j + apart
            if apart > partners.shape[0] or desk[j, CELL] < 0.0 or desk[k, CELL] < 0.0:
                continue
            table = partners[apart - 1, (first + j) % partners.shape[1]]
            x = q - (first + j)
            cell = find(cknots, cbins, table, x)
            if cell >= 0:
                value = cubic(coupling[table, cell], x - cknots[table, cell])
                matrix[j, k] += value
                matrix[k, j] += value


@inlined
def carry(law: Any, desk: Any, slot: int, available: float, lowest: float, step: float) -> None:
    """Set line load and its slope of one pair at an available approach: a K(ln a), K a cubic between levels; constant below them."""
    desk[slot, STIFFNESS], desk[slot, MISS] = 0.0, 0.0
    if available <= 0.0 or desk[slot, CELL] < 0.0:
        return
    last = law.shape[2] - 2
    place = (np.log(available) - lowest) / step
    level = min(max(int(place), 0), last)
    s = min(max(place - level, 0.0), 1.0)
    own, d = law[int(desk[slot, TABLE]), int(desk[slot, CELL])], desk[slot, PLACE]
    low, high = cubic(own[level, 0], d), cubic(own[level + 1, 0], d)
    rise0, rise1 = cubic(own[level, 1], d) * step, cubic(own[level + 1, 1], d) * step
    bend = high - low - rise0
    twist = rise0 + rise1 - 2.0 * (high - low)
    value = low + s * (rise0 + s * (bend - twist + s * twist))
    slope = (rise0 + s * (2.0 * (bend - twist) + 3.0 * s * twist)) / step
    if place != level + s:
        slope = 0.0
    desk[slot, MISS], desk[slot, STIFFNESS] = available * value, value + slope


@inlined
def eliminate(system: Any, right: Any, count: int) -> None:
    """Solve a small system in place; its diagonal is at least 1 and compliances are positive definite: no pivots needed."""
    for j in range(count):
        for k in range(j + 1, count):
            ratio = system[k, j] / system[j, j]
            if ratio != 0.0:
                for i in range(j + 1, count):
                    system[k, i] -= ratio * system[j, i]
                right[k] -= ratio * right[j]
    for j in range(count - 1, -1, -1):
        for k in range(j + 1, count):
            right[j] -= system[j, k] * right[k]
        right[j] /= system[j, j]


@inlined
def dual(desk: Any, matrix: Any, count: int, work: Any, right: Any) -> None:
    """Set column DUAL to z with (I + D C)' z = moments, D the slopes of the loads: the torque that a missing load makes."""
    for j in range(count):
        right[j] = desk[j, MOMENT]
        for k in range(count):
            work[j, k] = desk[k, STIFFNESS] * matrix[k, j]
        work[j, j] += 1.0
    eliminate(work, right, count)
    for j in range(count):
        desk[j, DUAL] = right[j]


@inlined
def respond(e: float, law: Any, lowest: float, step: float, count: int, desk: Any, matrix: Any) -> float:
    """Set slopes and residuals of all line loads at a transmission error; return the largest residual over the largest load."""
    worst, largest = 0.0, 0.0
    for j in range(count):
        if desk[j, CELL] < 0.0:
            desk[j, MISS], desk[j, STIFFNESS] = 0.0, 0.0
            continue
        available = (e - desk[j, GAP]) * desk[j, LEVER]
        for k in range(count):
            available -= matrix[j, k] * desk[k, FORCE]
        # The yield of the supports under the pair's own load belongs to the matrix; its own compliance to the law.
        carry(law, desk, j, available, lowest, step)
        largest = max(largest, desk[j, MISS], desk[j, FORCE])
        desk[j, MISS] -= desk[j, FORCE]
        worst = max(worst, abs(desk[j, MISS]))
    return worst / largest if largest > 0.0 else 0.0


@inlined
def shift(de: float, count: int, desk: Any, matrix: Any, work: Any, right: Any) -> None:
    """Move the loads by one Newton step, the transmission error by `de`; loads that would pull become 0."""
    for j in range(count):
        right[j] = desk[j, MISS] + desk[j, STIFFNESS] * desk[j, LEVER] * de
        for k in range(count):
            work[j, k] = desk[j, STIFFNESS] * matrix[j, k]
        work[j, j] += 1.0
    eliminate(work, right, count)
    for j in range(count):
        desk[j, FORCE] = max(desk[j, FORCE] + right[j], 0.0)


@inlined
def start(torque: float, law: Any, lowest: float, step: float, count: int, desk: Any, matrix: Any) -> float:
    """Load the pair that carries the whole torque alone at the least transmission error; return that error."""
    best, least = -1, np.inf
    for j in range(count):
        desk[j, FORCE] = 0.0
        if desk[j, CELL] < 0.0 or desk[j, MOMENT] <= 0.0:
            continue
        load, approach = torque / desk[j, MOMENT], np.exp(lowest + 0.5 * step * law.shape[2])
        for _ in range(3):
            carry(law, desk, j, approach, lowest, step)
            approach *= load / desk[j, MISS]
        alone = desk[j, GAP] + (approach + matrix[j, j] * load) / desk[j, LEVER]
        if alone < least:
            best, least = j, alone
    if best >= 0:
        desk[best, FORCE] = torque / desk[best, MOMENT]
    return least


@inlined
def settle(
    torque: float, base: float, law: Any, lowest: float, step: float, count: int, desk: Any, matrix: Any, work: Any, right: Any
) -> tuple[float, float]:
    """Bring loads to their torque from those of `desk` on; return the transmission error less `base`, and its slope's reciprocal or 0.

    Gaps count from `base`, so that small deflections keep their digits beside large ones; they stand as they were in the end.
    """
    for j in range(count):
        desk[j, GAP] -= base
    e, found = 0.0, 0.0
    for _ in range(ROUNDS):
        miss = respond(e, law, lowest, step, count, desk, matrix)
        dual(desk, matrix, count, work, right)
        missing, gain = torque, 0.0
        for j in range(count):
            missing -= desk[j, MOMENT] * desk[j, FORCE]
            gain += desk[j, DUAL] * desk[j, STIFFNESS] * desk[j, LEVER]
        if gain <= 0.0:
            break
        if miss < TOLERANCE and abs(missing) < TOLERANCE * torque:
            found = gain
            break
        for j in range(count):
            missing -= desk[j, DUAL] * desk[j, MISS]
        shift(missing / gain, count, desk, matrix, work, right)
        e += missing / gain
    for j in range(count):
        desk[j, GAP] += base
    return e, found


@compiled
def share(
    q: Any,
    torque: Any,
    common: Any,
    friction: float,
    yielding: float,
    width: float,
    base1: float,
    base2: float,
    turn: float,
    early: float,
    tables: Any,
    late1: Any,
    late2: Any,
    knots: Any,
    bins: Any,
    shape: Any,
    law: Any,
    lowest: float,
    step: float,
    partners: Any,
    cknots: Any,
    cbins: Any,
    coupling: Any,
    error: Any,
    slope: Any,
    first: Any,
    force: Any,
    moment2: Any,
    weight1: Any,
    weight2: Any,
) -> int:
    """Solve every angle; return -1, or the number of the first that did not converge or left the law's levels.

    Outputs: transmission error (n,) [m], its slope over the torque (n,), first pair (n,), loads (n, p) [N], their moment on the
    wheel without friction (n,) [N m], weights of the index errors of both teeth of each pair (n, p).
    """
    count = force.shape[1]
    desk = np.zeros((count, COLUMNS))
    matrix, work, right = np.zeros((count, count)), np.zeros((count, count)), np.zeros(count)
    top = np.exp(lowest + step * (law.shape[2] - 1))
    for row in range(q.size):
        first[row] = lay(q[row], common[row], tables, late1, late2, knots, bins, shape, base1, base2, turn, early, count, desk)
        couple(q[row], first[row], count, partners, cknots, cbins, coupling, yielding * width, desk, matrix)
        for j in range(count):
            desk[j, MOMENT] = (desk[j, ARM1] + friction * np.sign(desk[j, SLIDING]) * desk[j, FRICTION1]) * width
        e, base, gain = 0.0, 0.0, 0.0
        # Angles mostly come in order, each so near the last that its loads are those to begin with.
        if row > 0 and abs(q[row] - q[row - 1]) < NEAR:
            keep(first[row] - first[row - 1], count, desk, right)
            base = error[row - 1]
            e, gain = settle(torque[row], base, law, lowest, step, count, desk, matrix, work, right)
        if gain <= 0.0:
            base = start(torque[row], law, lowest, step, count, desk, matrix)
            if not base < FAR:
                return row
            e, gain = settle(torque[row], base, law, lowest, step, count, desk, matrix, work, right)
        if gain <= 0.0:
            return row
        error[row], slope[row], moment2[row] = e + base, 1.0 / gain, 0.0
        for j in range(count):
            if (e + base - desk[j, GAP]) * desk[j, LEVER] > top:
                return row
            force[row, j] = desk[j, FORCE] * width
            moment2[row] += force[row, j] * desk[j, ARM2]
            weight2[row, j] = desk[j, DUAL] * desk[j, STIFFNESS] * desk[j, LEVER] / gain
            weight1[row, j] = weight2[row, j] * desk[j, ARM1] / base1 / desk[j, LEVER]
    return -1


@compiled
def resample(known: Any, values: Any, slopes: Any, wanted: Any, out: Any) -> None:
    """Fill out (r, m) with the cubics through (known, values) (r, k) of given slopes at `wanted` (m,), increasing; linear outside."""
    for row in range(known.shape[0]):
        cell, last = 0, known.shape[1] - 2
        for column in range(wanted.size):
            x = wanted[column]
            while cell < last and known[row, cell + 1] < x:
                cell += 1
            h = known[row, cell + 1] - known[row, cell]
            s = (x - known[row, cell]) / h
            inside = min(max(s, 0.0), 1.0)
            y0, y1 = values[row, cell], values[row, cell + 1]
            m0, m1 = slopes[row, cell] * h, slopes[row, cell + 1] * h
            rise = y1 - y0
            value = y0 + inside * (m0 + inside * (3.0 * rise - 2.0 * m0 - m1 + inside * (m0 + m1 - 2.0 * rise)))
            out[row, column] = value + (s - inside) * (m0 if s < 0.0 else m1)
