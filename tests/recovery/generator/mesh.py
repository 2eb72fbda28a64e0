"""Load sharing of all pairs in reach, quasi-static, all angles at once."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from .gear import Array, inv
from .system import System
from .tooth import crack_table, tooth_table

NEAR = np.array([-1, 0, 1, 2])


@dataclass(frozen=True)
class Reach:
    """The pairs in reach at each angle: columns are pairs; lags and rolls in metres, compliances in m/N."""

    pair: Array
    gap: Array
    matrix: Array
    radius: Array
    sliding: Array
    arm1: Array
    arm2: Array
    rolls: tuple[Array, Array]

    def repeated(self, times: int) -> Reach:
        """The same angles, several times over."""

        def many(values: Array) -> Array:
            return np.concatenate([values] * times)

        rolls = (many(self.rolls[0]), many(self.rolls[1]))
        rest = [many(getattr(self, name)) for name in ("pair", "gap", "matrix", "radius", "sliding", "arm1", "arm2")]
        return Reach(*rest, rolls)


@dataclass(frozen=True)
class Static:
    lag: Array
    force: Array
    slope: Array  # of total force against lag
    share: Array  # of each pair's gap in the lag


def reach(system: System, angle: Array, torque: float) -> Reach:
    """Place the pairs at true pinion angles: rolls, gaps with every deviation of the teeth, compliances."""
    pair = system.pair
    index = np.floor(angle / pair.pitch).astype(int)[:, None] + NEAR
    teeth = (index % pair.pinion.teeth, index % pair.wheel.teeth)
    alpha0, alpha, tilt = _centres(system, angle)
    roll1 = pair.pinion.base_radius * (angle - tilt + inv(alpha0) + alpha)[:, None] - pair.base_pitch * index
    roll2 = pair.base_sum * np.tan(alpha)[:, None] - roll1
    gap = np.zeros_like(roll1)
    for over, (way, lag, _) in ((roll1 - pair.pinion.tip_roll, pair.corners[0]), (roll2 - pair.wheel.tip_roll, pair.corners[1])):
        gap += np.where(over > 0.0, np.interp(over, way, lag) + 4.0 * np.maximum(over - way[-1], 0.0), 0.0)
    # beyond its end the flank's tip touches the mate at the roll of the corner's circle
    touch1 = np.where(roll2 > pair.wheel.tip_roll, np.interp(roll2 - pair.wheel.tip_roll, pair.corners[1][0], pair.corners[1][2]), roll1)
    touch2 = np.where(roll1 > pair.pinion.tip_roll, np.interp(roll1 - pair.pinion.tip_roll, pair.corners[0][0], pair.corners[0][2]), roll2)
    rolls = (np.clip(touch1, 0.0, pair.pinion.tip_roll), np.clip(touch2, 0.0, pair.wheel.tip_roll))
    for gear in (0, 1):
        gap += deviation(system, gear, teeth[gear], rolls[gear]) + system.scatter.late[gear][teeth[gear]]
        late = system.late[gear]
        if late is not None:
            gap += late[teeth[gear]]
    gap += (pair.base_sum * (inv(alpha) - inv(alpha0) + tilt))[:, None]
    for extra in system.lag:
        gap += extra(angle, torque)[:, None]
    matrix = _compliance(system, angle, teeth, rolls)
    pitch_roll = pair.base_sum * math.tan(pair.alpha) * pair.pinion.base_radius / pair.base_sum
    sliding = np.tanh((roll1 - pitch_roll) / (system.friction_blend * pair.base_pitch)) * system.friction
    rho = np.maximum(rolls[0] * rolls[1] / (rolls[0] + rolls[1]), 0.02 * pair.path)
    return Reach(
        index, gap, matrix, rho, sliding, sliding * roll1 / pair.pinion.base_radius, sliding * roll2 / pair.wheel.base_radius, rolls
    )


def _centres(system: System, angle: Array) -> tuple[float, Array, Array]:
    """Return the pressure angle at rest, and with runout its course and the tilt of the line of centres."""
    pair = system.pair
    centre = pair.centre + system.centre_shift
    alpha0 = math.acos(pair.base_sum / centre)
    if not any(map(abs, system.runout)) and system.drift is None:
        return alpha0, np.full_like(angle, alpha0), np.zeros_like(angle)
    halves = [gear.half_angle(gear.base_radius / math.cos(alpha0)) for gear in pair.gears]
    ratio = pair.pinion.teeth / pair.wheel.teeth
    first = np.conj(system.runout[0]) * np.exp(1j * (angle - halves[0]))
    second = system.runout[1] * np.exp(1j * (math.pi - halves[1] - angle * ratio))
    apart = centre + second - first
    if system.drift is not None:
        apart = apart + system.drift(angle)
    return alpha0, np.arccos(pair.base_sum / np.abs(apart)), np.angle(apart)


def deviation(system: System, gear: int, tooth: Array, roll: Array) -> Array:
    """Metal missing on the flanks of the stated teeth at the stated rolls."""
    wave = system.scatter.wave[gear]
    total = np.zeros_like(roll)
    if np.any(wave):
        turn = 2.0 * np.pi * roll / (system.pair.contact_ratio * system.pair.base_pitch)
        for k in (0, 1):
            total += wave[tooth, k] * np.cos(wave[tooth, 2 + k] * turn + wave[tooth, 4 + k])
    for profile in system.profiles:
        if profile.gear != gear:
            continue
        if profile.tooth is None:
            total += profile.depth(roll)
        else:
            mine = tooth == profile.tooth % system.pair.gears[gear].teeth
            total[mine] += profile.depth(roll[mine])
    return total


def _compliance(system: System, angle: Array, teeth: tuple[Array, Array], rolls: tuple[Array, Array]) -> Array:
    """Matrix of teeth and bodies: beams on the diagonal, foundations coupled to neighbours by powers of the coupling."""
    matrix = np.zeros((len(angle), len(NEAR), len(NEAR)))
    diagonal = np.arange(len(NEAR))
    fade = system.coupling ** np.abs(diagonal[:, None] - diagonal[None, :])
    for g, gear in enumerate(system.pair.gears):
        table = tooth_table(gear)
        beam = np.interp(rolls[g], table.roll, table.beam) * system.beam_scale
        for crack in system.cracks:
            if crack.gear == g:
                beam = beam + (teeth[g] == crack.tooth) * np.interp(rolls[g], table.roll, crack_table(gear, crack.depth))
        body = np.sqrt(np.interp(rolls[g], table.roll, table.body) * system.body_scale[g])
        if g == 1 and system.body_wave is not None:
            body = body * np.sqrt(system.body_wave(angle))[:, None]
        matrix += fade * body[:, :, None] * body[:, None, :]
        matrix[:, diagonal, diagonal] += beam
    return matrix * (system.compliance_scale / (system.youngs * system.pair.width))


def lead_law(system: System, typical: float) -> PchipInterpolator | None:
    """Extra approach (m) over pair force (N) that a lead gap costs: slices of local stiffness, uneven over the width."""
    if system.lead is None:
        return None
    count = len(system.lead)
    weight = np.full(count, 1.0 / count) if system.lead_weight is None else system.lead_weight / system.lead_weight.sum()
    gap = system.lead - system.lead.min()
    local = 2.2 * typical
    reach_ = np.concatenate(
        [np.linspace(0.0, 1.0, 60)[1:] ** 2 * (gap.max() + 1e-6), gap.max() + 1e-6 + np.linspace(0.0, 1.0, 12)[1:] * 4e-4]
    )
    force = (local * weight * np.maximum(reach_[:, None] - gap, 0.0)).sum(1)
    return PchipInterpolator(np.concatenate([[0.0], force]), np.concatenate([[0.0], reach_ - force / local]))


def typical_stiffness(system: System) -> float:
    """Stiffness (N/m) of one pair at the middle of the path, for scaling."""
    total = 0.0
    for g, gear in enumerate(system.pair.gears):
        table = tooth_table(gear)
        at = system.pair.pitch_roll(g)
        total += float(np.interp(at, table.roll, table.beam) + np.interp(at, table.roll, table.body))
    return system.youngs * system.pair.width / (1.25 * total * system.compliance_scale)


def share(system: System, at: Reach, load: Array, friction: bool, speed: float = 0.0, guess: Static | None = None) -> Static:
    """Solve deflection = lag - gap, force >= 0 and force balance at every angle by a semi-smooth Newton iteration.

    `load` is torque over the pinion's base radius (with `friction`: moments of sliding counted) or the total normal force.
    """
    count, pairs = at.gap.shape
    typical = typical_stiffness(system)
    law = lead_law(system, typical)
    arm = 1.0 + (at.arm1 if friction else np.zeros_like(at.arm1))
    scale = system.contact_scale * system.compliance_scale * (1.0 if system.film is None else system.film(speed))
    force = np.where(at.gap - at.gap.min(1, keepdims=True) < 1e-9, load[:, None], 0.0) if guess is None else guess.force.copy()
    lag = at.gap.min(1) + load / typical if guess is None else guess.lag.copy()
    out_force, out_lag = force.copy(), lag.copy()
    slope, part = np.zeros(count), np.zeros((count, pairs))
    todo = np.arange(count)
    eye = np.eye(pairs)
    for turn in range(60):
        f, e, c, g = out_force[todo], out_lag[todo], at.matrix[todo], at.gap[todo]
        up, rate = system.contact.approach(f, at.radius[todo], system.youngs, system.pair.pinion.module, system.pair.width)
        up, rate = up * scale, rate * scale
        if law is not None:
            up, rate = up + law(f), rate + law(f, 1)
        residual = (c @ f[:, :, None])[:, :, 0] + up + g - e[:, None]
        press = f - typical * residual
        active = (press > 0.0) | (press >= press.max(1, keepdims=True))  # something always carries
        slave = active[:, :, None] * (c + rate[:, :, None] * eye) + (~active)[:, :, None] * eye
        # forces for the residuals at fixed lag, and per unit of lag; the balance then gives the lag
        right = np.stack([np.where(active, -residual, -f), active.astype(float)], axis=2)
        both = np.linalg.solve(slave, right)
        lever = arm[todo]
        more = (load[todo] - (lever * (f + both[:, :, 0])).sum(1)) / (lever * both[:, :, 1]).sum(1)
        step = np.concatenate([both[:, :, 0] + more[:, None] * both[:, :, 1], more[:, None]], axis=1)
        damp = 1.0 if turn < 20 else 0.6
        out_force[todo] = np.maximum(f + damp * step[:, :pairs], 0.0) if turn >= 20 else f + step[:, :pairs]
        out_lag[todo] = e + damp * step[:, pairs]
        # the lag counts too: where one pair bears all, its force is right at once, and others may be in reach once it has yielded
        size = np.abs(step * np.append(np.ones(pairs), typical)).max(1) / np.maximum(load[todo], 1e-3)
        done = size < 1e-7
        if done.any() or turn == 59:
            last = todo if turn == 59 else todo[done]
            pick = np.ones(len(todo), bool) if turn == 59 else done
            response = both[pick, :, 1] * active[pick]
            slope[last] = response.sum(1)
            part[last] = response / np.maximum(slope[last], 1e-30)[:, None]
        todo = todo[~done]
        if len(todo) == 0:
            break
    if len(todo):
        raise RuntimeError(f"load sharing did not settle at {len(todo)} of {count} angles")
    support = system.support
    if support:
        total = out_force.sum(1)
        reference = system.torque / system.pair.pinion.base_radius
        out_lag = out_lag + support * total * (total / reference) ** (system.support_power - 1.0)
        slope = 1.0 / (1.0 / np.maximum(slope, 1e-30) + support)
    return Static(out_lag, out_force, slope, part)


def static(system: System, angle: Array, torque: float, guess: Static | None = None) -> Static:
    """Quasi-static lag at the true angle and the nominal torque, with the torque's true gain, ripple and tooth friction."""
    at = reach(system, angle, torque)
    load = (torque * system.torque_gain + system.wobble(angle)) / system.pair.pinion.base_radius
    return share(system, at, np.maximum(load, 1e-6), friction=True, guess=guess)
