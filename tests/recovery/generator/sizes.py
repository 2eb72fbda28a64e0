"""Draws of each named effect: parameters as a function of one size, and the plain range of that size."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .effects import GEARS, Params
from .motion import masses
from .observe import Spec
from .system import System
from .tooth import tooth_table

Sized = tuple[Callable[[float], Params], float, float]
SINGLE = (
    "profile_wear",
    "tip_relief",
    "profile_slope",
    "pitch_error",
    "runout",
    "root_crack",
    "pitting",
    "lead_misalignment",
    "crowning",
    "end_relief",
    "body_compliance",
    "support_compliance",
    "contact_compliance",
    "centre_distance",
    "friction",
    "damping",
    "torque_ripple",
    "sensor_gain",
    "sensor_lag",
    "sensor_resonance",
)
AT_SPEED = ("support_compliance", "damping", "sensor_lag", "sensor_resonance", "backlash")


def _met(system: System, specs: list[Spec], gear: int, rng: np.random.Generator) -> int:
    """A tooth that every record meets well inside its range."""
    turning = [s for s in specs if s.quantity.endswith("transmission_error")]
    pitch, count = system.pair.pitch, system.pair.gears[gear].teeth
    first = math.ceil(max((s.start for s in turning), default=0.0) / pitch) + 2
    turns = min([2.0, *(s.turns for s in turning)])
    last = min(count, int(turns * system.pair.pinion.teeth) - 3)
    return int(rng.integers(first, last))


def draw(name: str, system: System, specs: list[Spec], rng: np.random.Generator) -> Sized:
    """Return (parameters of a size, smallest, largest size) for one draw of the named effect."""
    g = int(rng.integers(2))
    gear, pair = GEARS[g], system.pair
    tip, low = pair.gears[g].tip_roll, pair.lowest_roll(g)
    active, module = tip - low, pair.pinion.module
    tooth = _met(system, specs, g, rng)
    angle = float(rng.uniform(0, 2 * math.pi))

    def r(value: float) -> float:
        return float(f"{value:.5g}")

    if name == "profile_wear":
        root, pitch = rng.uniform(0.4, 1.8), rng.uniform(0.02, 0.2)
        return lambda s: {"gear": gear, "tip_um": r(s), "root_um": r(s * root), "pitch_um": r(s * pitch)}, 0.5, 60.0
    if name == "tip_relief":
        length = active * rng.uniform(0.2, 0.42)
        return lambda s: {"gear": gear, "amount_um": r(s), "length_mm": r(length * 1e3)}, 0.5, 60.0
    if name == "profile_slope":
        sign = rng.choice([-1.0, 1.0])
        return lambda s: {"gear": gear, "amount_um": r(sign * s)}, 0.5, 40.0
    if name == "pitch_error":
        sign = rng.choice([-1.0, 1.0])
        return lambda s: {"gear": gear, "tooth": tooth, "amount_um": r(sign * s)}, 0.5, 40.0
    if name == "runout":
        return lambda s: {"gear": gear, "eccentricity_um": r(s), "angle_rad": r(angle)}, 0.5, 80.0
    if name == "root_crack":
        section = tooth_table(pair.gears[g]).section * 1e3
        return lambda s: {"gear": gear, "tooth": tooth, "depth_mm": r(s * section)}, 0.03, 0.5
    if name == "pitting":
        width = active * rng.uniform(0.18, 0.4)
        centre = low + active * rng.uniform(0.3, 0.7)
        place = {"gear": gear, "tooth": tooth}
        return lambda s: {**place, "depth_um": r(s), "centre_mm": r(centre * 1e3), "width_mm": r(width * 1e3)}, 1.0, 80.0
    if name == "lead_misalignment":
        return lambda s: {"slope_um": r(s)}, 1.0, 80.0
    if name == "crowning":
        return lambda s: {"gear": gear, "amount_um": r(s)}, 1.0, 60.0
    if name == "end_relief":
        length = pair.width * rng.uniform(0.12, 0.3)
        return lambda s: {"gear": gear, "amount_um": r(s), "length_mm": r(length * 1e3)}, 2.0, 80.0
    if name in ("body_compliance", "contact_compliance"):
        return lambda s: {"scale": r(1.0 + s)}, 0.05, 3.0
    if name == "support_compliance":
        part = rng.uniform(0.3, 0.7)
        return lambda s: {"pinion_um_per_kN": r(s * part), "wheel_um_per_kN": r(s * (1 - part))}, 0.05, 6.0
    if name == "centre_distance":
        most = 0.06 * module * 1e6
        return lambda s: {"amount_um": r(s)}, 2.0, most
    if name == "friction":
        return lambda s: {"coefficient": r(system.friction + s)}, 0.005, 0.22
    if name == "damping":
        return lambda s: {"ratio": r(system.damping * (1.0 + s))}, 0.1, 4.0
    if name == "torque_ripple":
        order, share = int(rng.integers(2, 7)), pair.wheel.teeth / pair.pinion.teeth if g else 1.0
        base = min(s.torque for s in specs if s.torque > 0.0) * share
        return lambda s: {"gear": gear, "order": order, "amplitude_Nm": r(s * base), "phase_rad": r(angle)}, 0.005, 0.6
    if name == "sensor_gain":
        return lambda s: {"scale": r(1.0 + s)}, 0.03, 0.6
    if name == "sensor_lag":
        natural = math.sqrt(16e9 * pair.width / masses(system)[2])
        return lambda s: {"delay_s": r(s / natural)}, 0.02, 2.0
    if name == "sensor_resonance":
        frequency = math.sqrt(16e9 * pair.width / masses(system)[2]) / (2 * math.pi) * rng.uniform(1.3, 3.0)
        ratio = rng.uniform(0.03, 0.15)
        return lambda s: {"frequency_Hz": r(frequency / s), "ratio": r(ratio)}, 0.4, 1.6
    raise ValueError(f"no draw of {name}")


def equivalent(name: str, system: System, params: Params, depth: Any) -> Params:
    """Return the parameters of the catalogue's own shape that come closest to a drawn profile (least squares on the active flank)."""
    from scipy.optimize import least_squares

    g = GEARS.index(params["gear"])
    pair = system.pair
    tip, low, pitch = pair.gears[g].tip_roll, pair.lowest_roll(g), pair.pitch_roll(g)
    s = np.linspace(low, tip, 241)
    true = depth(s) * 1e6
    if name == "profile_slope":
        t = (s - low) / (tip - low)
        return {**params, "amount_um": float((t @ (true - true.mean()) - 0.0) / (t @ (t - t.mean())))}
    if name == "profile_wear":
        up = np.where(s > pitch, ((s - pitch) / (tip - pitch)) ** 2, 0.0)
        down = np.where(s <= pitch, ((pitch - s) / (pitch - low)) ** 2, 0.0)
        a, b, c = np.linalg.lstsq(np.stack([up, down, 1 - up - down], 1), true, rcond=None)[0]
        return {**params, "tip_um": float(a), "root_um": float(b), "pitch_um": float(c)}

    def model(x: Any) -> Any:
        if name == "tip_relief":
            return x[0] * np.maximum(1 - (tip - s) * 1e3 / x[1], 0.0) ** 2
        t = (s * 1e3 - x[1]) * 2.0 / x[2]
        return x[0] * np.where(np.abs(t) < 1.0, 0.5 + 0.5 * np.cos(np.pi * np.clip(t, -1, 1)), 0.0)

    keys = ("amount_um", "length_mm") if name == "tip_relief" else ("depth_um", "centre_mm", "width_mm")
    fit = least_squares(lambda x: model(x) - true, [params[k] for k in keys], x_scale=[abs(params[k]) for k in keys])
    return {**params, **{k: float(v) for k, v in zip(keys, fit.x, strict=True)}}
