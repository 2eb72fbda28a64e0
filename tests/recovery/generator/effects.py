"""Every named effect acting at its cause, with shapes that are not the catalogue's."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .gear import Array
from .system import Crack, Depth, Profile, Ripple, System

GEARS = ("pinion", "wheel")
Params = dict[str, Any]


@dataclass(frozen=True)
class Effect:
    """A named cause with the parameters of the file formats; `shape` seeds what those parameters leave open."""

    name: str
    params: Params
    shape: int = 0

    def apply(self, system: System) -> System:
        return APPLY[self.name](system, self.params, np.random.default_rng(self.shape))


def _gear(params: Params) -> int:
    return GEARS.index(params["gear"])


def _with(system: System, gear: int, tooth: int | None, depth: Depth) -> System:
    return replace(system, profiles=(*system.profiles, Profile(gear, tooth, depth)))


def _ragged(rng: np.random.Generator, waves: int) -> Callable[[Array], Array]:
    """Smooth noise of unit size on 0..1."""
    cycles, phase, size = rng.uniform(0.7, 4.5, waves), rng.uniform(0, 2 * np.pi, waves), rng.normal(0, 1, waves)
    size = size / math.sqrt((size**2).sum() / 2)
    return lambda t: (size * np.cos(2 * np.pi * cycles * np.asarray(t)[..., None] + phase)).sum(-1)


def tip_relief(system: System, p: Params, rng: np.random.Generator) -> System:
    """Straight relief with a rounded start, or a power other than the parabola's."""
    g = _gear(p)
    tip, length, amount = system.pair.gears[g].tip_roll, p["length_mm"] * 1e-3, p["amount_um"] * 1e-6
    if rng.random() < 0.5:
        r = rng.uniform(0.25, 0.5)
        return _with(system, g, None, lambda s: amount * _bend(1.0 - (tip - s) / length, r))
    power = rng.choice([rng.uniform(1.45, 1.75), rng.uniform(2.3, 2.8)])
    return _with(system, g, None, lambda s: amount * np.maximum(1.0 - (tip - s) / length, 0.0) ** power)


def _bend(t: Array, r: float) -> Array:
    return np.asarray((t + np.sqrt(t * t + r * r)) / (1.0 + math.sqrt(1.0 + r * r)) - 0.0)


def profile_wear(system: System, p: Params, rng: np.random.Generator) -> System:
    """Archard: depth grows with the sliding path, so nearly straight on each side, round at the pitch point, a little rough."""
    g = _gear(p)
    pair = system.pair
    pitch, tip, low = pair.pitch_roll(g), pair.gears[g].tip_roll, pair.lowest_roll(g)
    soft, rough, noise = rng.uniform(0.15, 0.4), rng.uniform(0.02, 0.05), _ragged(rng, 5)
    bottom, top, root = p["pitch_um"] * 1e-6, p["tip_um"] * 1e-6, p["root_um"] * 1e-6

    def depth(s: Array) -> Array:
        t = np.where(s > pitch, (s - pitch) / (tip - pitch), (pitch - np.maximum(s, low)) / (pitch - low))
        grow = (np.sqrt(t * t + soft**2) - soft) / (math.sqrt(1 + soft**2) - soft)
        full = bottom + (np.where(s > pitch, top, root) - bottom) * grow
        return full * (1.0 + rough * noise((np.maximum(s, low) - low) / (tip - low)))

    return _with(system, g, None, depth)


def profile_slope(system: System, p: Params, rng: np.random.Generator) -> System:
    g = _gear(p)
    tip, low, bow = system.pair.gears[g].tip_roll, system.pair.lowest_roll(g), rng.uniform(-0.12, 0.12)
    amount = p["amount_um"] * 1e-6

    def depth(s: Array) -> Array:
        t = (np.maximum(s, low) - low) / (tip - low)
        return amount * (t + 4.0 * bow * t * (1.0 - t))

    return _with(system, g, None, depth)


def pitch_error(system: System, p: Params, rng: np.random.Generator) -> System:
    """One tooth displaced, with a slight tilt of its flank."""
    g, amount = _gear(p), p["amount_um"] * 1e-6
    late = list(system.late)
    teeth = system.pair.gears[g].teeth
    mine = np.zeros(teeth) if late[g] is None else np.array(late[g])
    mine[p["tooth"] % teeth] += amount
    late[g] = mine
    tilt, middle = rng.uniform(-0.08, 0.08), system.pair.pitch_roll(g)
    tilted = _with(system, g, p["tooth"], lambda s: amount * tilt * (s - middle) / system.pair.base_pitch)
    return replace(tilted, late=(late[0], late[1]))


def runout(system: System, p: Params, rng: np.random.Generator) -> System:
    g = _gear(p)
    vectors = list(system.runout)
    vectors[g] += cmath.rect(p["eccentricity_um"] * 1e-6, p["angle_rad"])
    return replace(system, runout=(vectors[0], vectors[1]))


def root_crack(system: System, p: Params, rng: np.random.Generator) -> System:
    g = _gear(p)
    tooth = p["tooth"] % system.pair.gears[g].teeth
    return replace(system, cracks=(*system.cracks, Crack(g, tooth, p["depth_mm"] * 1e-3)))


def pitting(system: System, p: Params, rng: np.random.Generator) -> System:
    """A hollow with steep shoulders and a ragged floor, skewed to one side."""
    centre, half, deep = p["centre_mm"] * 1e-3, p["width_mm"] * 0.5e-3, p["depth_um"] * 1e-6
    power, rough, noise, skew = rng.uniform(0.35, 0.75), rng.uniform(0.15, 0.35), _ragged(rng, 4), rng.uniform(-0.2, 0.2)

    def depth(s: Array) -> Array:
        t = (s - centre) / half
        bell = np.where(np.abs(t) < 1.0, 0.5 + 0.5 * np.cos(np.pi * np.clip(t, -1.0, 1.0)), 0.0) ** power
        return deep * bell * np.clip(1.0 + rough * noise(t) + skew * t, 0.05, None)

    return _with(system, _gear(p), p["tooth"], depth)


def _lead(system: System, gap: Callable[[Array], Array], rng: np.random.Generator) -> System:
    count = 25
    y = (np.arange(count) + 0.5) / count - 0.5
    weight = 1.0 - rng.uniform(0.1, 0.3) * (2 * y) ** 2 + rng.uniform(-0.08, 0.08) * 2 * y
    before = np.zeros(count) if system.lead is None else system.lead
    return replace(system, lead=before + gap(y), lead_weight=weight)


def lead_misalignment(system: System, p: Params, rng: np.random.Generator) -> System:
    bow = rng.uniform(-0.06, 0.06)
    return _lead(system, lambda y: p["slope_um"] * 1e-6 * (y + 0.5 + bow * (1 - 4 * y * y)), rng)


def crowning(system: System, p: Params, rng: np.random.Generator) -> System:
    power = rng.uniform(2.0, 2.6)
    return _lead(system, lambda y: p["amount_um"] * 1e-6 * np.abs(2 * y) ** power, rng)


def end_relief(system: System, p: Params, rng: np.random.Generator) -> System:
    power, skew = rng.uniform(1.4, 1.8), rng.uniform(-0.1, 0.1)
    share = p["length_mm"] * 1e-3 / system.pair.width

    def gap(y: Array) -> Array:
        ends = [np.maximum(1.0 - (0.5 - side * y) / (share * (1 + side * skew)), 0.0) for side in (1, -1)]
        return p["amount_um"] * 1e-6 * (ends[0] ** power + ends[1] ** power)

    return _lead(system, gap, rng)


def body_compliance(system: System, p: Params, rng: np.random.Generator) -> System:
    odd = rng.uniform(-0.05, 0.05)
    first, second = system.body_scale
    return replace(system, body_scale=(first * p["scale"] * (1 + odd), second * p["scale"] * (1 - odd)))


def support_compliance(system: System, p: Params, rng: np.random.Generator) -> System:
    total = (p["pinion_um_per_kN"] + p["wheel_um_per_kN"]) * 1e-9
    return replace(system, support=system.support + total, support_power=rng.uniform(0.93, 1.0))


def contact_compliance(system: System, p: Params, rng: np.random.Generator) -> System:
    return replace(system, contact_scale=system.contact_scale * p["scale"])


def centre_distance(system: System, p: Params, rng: np.random.Generator) -> System:
    more = p["amount_um"] * 1e-6
    return replace(system, centre_shift=system.centre_shift + more, backlash=system.backlash + 2 * more * math.sin(system.pair.alpha))


def friction(system: System, p: Params, rng: np.random.Generator) -> System:
    """Mixed lubrication: the step at the pitch point is rounded over a part of the base pitch."""
    return replace(system, friction=p["coefficient"], friction_blend=rng.uniform(0.03, 0.08))


def torque_ripple(system: System, p: Params, rng: np.random.Generator) -> System:
    item = Ripple(_gear(p), float(p["order"]), p["amplitude_Nm"], p["phase_rad"])
    return replace(system, ripples=(*system.ripples, item))


def _sensor(**changes: Callable[[System, Params], Any]) -> Callable[[System, Params, np.random.Generator], System]:
    def act(system: System, p: Params, rng: np.random.Generator) -> System:
        return replace(system, sensor=replace(system.sensor, **{key: make(system, p) for key, make in changes.items()}))

    return act


APPLY: dict[str, Callable[[System, Params, np.random.Generator], System]] = {
    "tip_relief": tip_relief,
    "profile_wear": profile_wear,
    "profile_slope": profile_slope,
    "pitch_error": pitch_error,
    "runout": runout,
    "root_crack": root_crack,
    "pitting": pitting,
    "lead_misalignment": lead_misalignment,
    "crowning": crowning,
    "end_relief": end_relief,
    "body_compliance": body_compliance,
    "support_compliance": support_compliance,
    "contact_compliance": contact_compliance,
    "centre_distance": centre_distance,
    "backlash": lambda system, p, rng: replace(system, backlash=p["amount_um"] * 1e-6),
    "friction": friction,
    "damping": lambda system, p, rng: replace(system, damping=p["ratio"]),
    "torque_ripple": torque_ripple,
    "sensor_gain": _sensor(gain=lambda s, p: s.sensor.gain * p["scale"]),
    "sensor_lag": _sensor(delay=lambda s, p: s.sensor.delay + p["delay_s"]),
    "sensor_resonance": _sensor(resonance=lambda s, p: (p["frequency_Hz"], p["ratio"])),
}
