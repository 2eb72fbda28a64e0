"""Motion at speed: relative motion of both inertias along the line of action, exponential time stepping.

The linear part (mean stiffness, damping) is advanced exactly by its matrix exponential; what is left of the tooth force
enters by the second-order scheme of Cox & Matthews (J. Comput. Phys. 176, 2002).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm

from .gear import Array
from .mesh import reach, share
from .system import System

LEVELS = np.array([0.0, 0.06, 0.2, 0.45, 0.75, 1.0, 1.3, 1.8, 2.6, 4.0])


@dataclass(frozen=True)
class Table:
    """Lag over (angle, force level) with the moments that sliding adds; `mean` is the mean slope of the mesh."""

    angle: Array
    lag: Array
    force: Array
    extra1: Array
    extra2: Array
    mean: float


@dataclass(frozen=True)
class Motion:
    lag: Array
    acceleration: Array  # of the pinion
    factor: Array  # 1 - J psi''/T


def masses(system: System) -> tuple[float, float, float]:
    """Inertias on the base circles and their relative mass."""
    m1, m2 = (j / gear.base_radius**2 for j, gear in zip(system.inertias, system.pair.gears, strict=True))
    return m1, m2, m1 * m2 / (m1 + m2)


def tabulate(system: System, angle: Array, torque: float, speed: float = 0.0) -> Table:
    """Solve load sharing at several levels of total normal force; friction's arms are taken at the mean load."""
    step = float(angle[1] - angle[0])
    per = round(system.pair.pitch / step)
    slow = system.uneven or abs(system.pair.pitch / step - per) > 1e-6
    short = angle if slow or len(angle) <= per else angle[:per]
    at = reach(system, short, torque)
    mean_load = torque * system.torque_gain / system.pair.pinion.base_radius
    count, levels = len(short), LEVELS[1:]
    stacked = at.repeated(len(levels))
    solved = share(system, stacked, np.repeat(levels * mean_load, count), friction=False, speed=speed)
    columns = [at.gap.min(1), *solved.lag.reshape(len(levels), count)]
    middle = slice(count * list(levels).index(1.0), count * (list(levels).index(1.0) + 1))
    mean = float(solved.slope[middle].mean())
    portion = solved.force[middle] / solved.force[middle].sum(1, keepdims=True)
    extra1, extra2 = (portion * at.arm1).sum(1), (portion * at.arm2).sum(1)
    lag = np.stack(columns, axis=1)
    take = np.arange(len(angle)) % len(short)
    return Table(angle, lag[take], LEVELS * mean_load, extra1[take], extra2[take], mean)


def settle(system: System, torque_mean: float, speed: float, stiffness: float) -> int:
    """Mesh cycles until a start from rest has died away."""
    ratio = mesh_ratio(system, speed, stiffness)
    return int(min(max(6, math.ceil(5.0 / (2.0 * math.pi * max(system.damping, 0.02)) * ratio)), 45))


def mesh_ratio(system: System, speed: float, stiffness: float) -> float:
    """Mesh frequency over natural frequency."""
    return system.pair.pinion.teeth * speed / math.sqrt(stiffness / masses(system)[2])


def run(system: System, table: Table, torque: float, speed: float) -> Motion:
    """Integrate over the table's angles at a mean speed (rad/s), from the quasi-static state."""
    m1, m2, mass = masses(system)
    pair = system.pair
    r1, r2 = pair.pinion.base_radius, pair.wheel.base_radius
    gain = torque * system.torque_gain
    damper = 2.0 * system.damping * math.sqrt(table.mean * mass)
    dt = float(table.angle[1] - table.angle[0]) / speed
    parts = max(1, math.ceil(dt * math.sqrt(table.mean / mass) / 0.22))
    h = dt / parts
    # normal-force factors of both gears, with sliding; the brake balances the mean
    q1, q2 = 1.0 + table.extra1, 1.0 + table.extra2
    brake = gain / r1 * float(np.mean(q2 / q1))
    weight = mass * (q1 / m1 + q2 / m2)
    own1 = [replace_gear(system, 0), replace_gear(system, 1)]
    ratio = pair.pinion.teeth / pair.wheel.teeth
    drive1 = gain / r1 + own1[0].wobble(table.angle) / r1
    drive2 = brake + own1[1].wobble(table.angle) / ratio / r2
    drive = mass * (drive1 / m1 + drive2 / m2)
    matrix = np.array([[0.0, 1.0], [-table.mean / mass, -damper / mass]])
    whole = np.zeros((4, 4))
    whole[:2, :2] = matrix * h
    whole[0, 2] = 0.0
    whole[:2, 2] = [0.0, h / mass]
    whole[2, 3] = 1.0
    power = expm(whole)
    (a00, a01, b0, c0), (a10, a11, b1, c1) = power[0], power[1]
    free = np.gradient(table.lag[:, 0], dt)
    state = _march(table, drive, weight, free, system.backlash, damper, parts, (a00, a01, b0, c0, a10, a11, b1, c1))
    lag, force = state
    acceleration = (drive1 - q1 * force) / m1 / r1
    return Motion(lag, acceleration, 1.0 - system.inertias[0] * acceleration / gain)


def replace_gear(system: System, gear: int) -> System:
    return replace(system, ripples=tuple(r for r in system.ripples if r.gear == gear))


def _march(
    table: Table, drive: Array, weight: Array, free: Array, backlash: float, damper: float, parts: int, flow: tuple[float, ...]
) -> tuple[Array, Array]:
    """Step the relative lag; plain floats because each step needs the one before."""
    a00, a01, b0, c0, a10, a11, b1, c1 = flow
    mean, force = table.mean, table.force.tolist()
    rows, drive_, weight_, free_ = table.lag.tolist(), drive.tolist(), weight.tolist(), free.tolist()
    top = len(force) - 2
    spot = 4

    def tooth(e: float, v: float, i: int, w: float) -> float:
        nonlocal spot
        low, high = rows[i], rows[i + 1]
        u = 1.0 - w
        first = u * low[0] + w * high[0]
        rub = damper * (v - (u * free_[i] + w * free_[i + 1]))
        if e <= first:
            back = e - first + backlash
            return min(mean * back + rub, 0.0) if back < 0.0 else 0.0
        k = spot
        left = u * low[k] + w * high[k]
        while k > 0 and e < left:
            k -= 1
            left = u * low[k] + w * high[k]
        right = u * low[k + 1] + w * high[k + 1]
        while k < top and e > right:
            k += 1
            left, right = right, u * low[k + 1] + w * high[k + 1]
        spot = k
        value = force[k] + (force[k + 1] - force[k]) * (e - left) / (right - left) + rub
        return value if value > 0.0 else 0.0

    e, v = float(np.interp(force[5], force, rows[0])), free_[0]
    lags, forces = [e], [tooth(e, v, 0, 0.0)]
    share_ = 1.0 / parts
    for i in range(len(rows) - 1):
        d0, d1, w0, w1 = drive_[i], drive_[i + 1], weight_[i], weight_[i + 1]
        for j in range(parts):
            s, t = j * share_, (j + 1) * share_
            g = d0 + s * (d1 - d0) - (w0 + s * (w1 - w0)) * tooth(e, v, i, s) + mean * e + damper * v
            ee = a00 * e + a01 * v + b0 * g
            vv = a10 * e + a11 * v + b1 * g
            new = d0 + t * (d1 - d0) - (w0 + t * (w1 - w0)) * tooth(ee, vv, i, t) + mean * ee + damper * vv
            e = ee + c0 * (new - g)
            v = vv + c1 * (new - g)
        lags.append(e)
        forces.append(tooth(e, v, i + 1, 0.0) if i + 2 < len(rows) else tooth(e, v, i, 1.0))
    return np.array(lags), np.array(forces)
