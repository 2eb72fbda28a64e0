"""Draws of gear pairs, of their owners' models, of the truth behind them, and of the records to take."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from .gear import Pair, make_pair
from .observe import Spec, measure, natural_speed
from .system import Scatter, Sensor, System
from .tooth import ContactLaw

Model = dict[str, Any]
MODULES = (1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 3.0, 3.25, 3.5, 4.0, 4.5, 5.0, 6.0)


def draw_pair(rng: np.random.Generator) -> Pair:
    """A sound pair: no undercut, tips thick enough, transverse contact ratio from 1.2 to 1.85, path inside the involutes."""
    for _ in range(1000):
        teeth = (int(rng.integers(17, 34)), int(rng.integers(22, 68)))
        module = float(rng.choice(MODULES)) * 1e-3
        shifts = tuple(round(float(x), 2) + 0.0 for x in rng.choice([0.0, 1.0], 1) * rng.uniform([-0.05, -0.3], [0.6, 0.5]))
        width = round(float(rng.uniform(6.0, 13.0)) * module * 1e3) * 1e-3
        bores = tuple(round(float(x), 3) for x in rng.uniform(0.3, 0.62, 2))
        backlash = round(float(rng.uniform(0.02, 0.06)) * module, 6)
        pair = make_pair(teeth, module, (shifts[0], shifts[1]), width, (bores[0], bores[1]), backlash)
        thick = all(2 * g.tip_radius * float(g.half_angle(g.tip_radius)) > 0.25 * module for g in pair.gears)
        clear = all(g.form_roll > 0.0 and pair.lowest_roll(k) > 1.02 * g.form_roll for k, g in enumerate(pair.gears))
        if thick and clear and 1.2 < pair.contact_ratio < 1.85 and abs(teeth[1] / teeth[0] - 1.0) > 0.08:
            return pair
    raise RuntimeError("no sound pair in a thousand draws")


def draw_model(pair: Pair, rng: np.random.Generator) -> Model:
    """The model file's tables as its owner believes them."""
    line = rng.uniform(55e3, 160e3) * pair.pinion.module / 2.5e-3
    torque = float(f"{line * pair.width * pair.pinion.base_radius:.3g}")
    inertias = [float(f"{g.disc_inertia(pair.width) * rng.uniform(1.0, 3.0):.4g}") for g in pair.gears]
    m1, m2 = (j / g.base_radius**2 for j, g in zip(inertias, pair.gears, strict=True))
    resonance = math.sqrt(16e9 * pair.width * (1 / m1 + 1 / m2)) / pair.pinion.teeth
    gears = [{"teeth": g.teeth, "profile_shift": g.shift, "bore_radius_mm": round(g.bore_radius * 1e3, 4)} for g in pair.gears]
    return {
        "name": f"pair {pair.pinion.teeth}/{pair.wheel.teeth}",
        "pair": {
            "module_mm": round(pair.pinion.module * 1e3, 4),
            "pressure_angle_deg": 20.0,
            "centre_distance_mm": round(pair.centre * 1e3, 6),
            "face_width_mm": round(pair.width * 1e3, 3),
            "normal_backlash_mm": round(pair.backlash * 1e3, 6),
        },
        "pinion": gears[0],
        "wheel": gears[1],
        "material": {"youngs_modulus_MPa": 206000.0, "poissons_ratio": 0.3, "density_kg_per_m3": 7850.0},
        "operation": {
            "pinion_torque_Nm": torque,
            "pinion_speed_rpm": round(0.6 * resonance * 30 / math.pi, 1),
            "pinion_inertia_kg_m2": inertias[0],
            "wheel_inertia_kg_m2": inertias[1],
            "friction_coefficient": round(float(rng.choice([0.0, rng.uniform(0.02, 0.07)])), 3),
            "damping_ratio": round(float(rng.uniform(0.04, 0.1)), 3),
        },
    }


def nominal_system(pair: Pair, model: Model) -> System:
    """This simulator's pair with the model file's values."""
    work = model["operation"]
    return System(
        pair=pair,
        scatter=Scatter.none(pair),
        torque=work["pinion_torque_Nm"],
        damping=work["damping_ratio"],
        inertias=(work["pinion_inertia_kg_m2"], work["wheel_inertia_kg_m2"]),
        friction=work["friction_coefficient"],
        backlash=pair.backlash,
    )


def draw_truth(system: System, known_zero: bool, rng: np.random.Generator) -> tuple[System, dict[str, Any]]:
    """Move every nuisance off its believed value, within the stated priors, and choose the contact law."""

    def off(sigma: float) -> float:
        return float(1.0 + sigma * np.clip(rng.normal(), -2.2, 2.2))

    values: dict[str, Any] = {
        "youngs_scale": off(0.01),
        "stiffness_scale": off(0.05),
        "torque_gain": off(0.01),
        "damping_scale": off(0.3) if rng.random() < 0.5 else float(math.exp(0.25 * np.clip(rng.normal(), -2, 2))),
        "inertia_scale": [off(0.02), off(0.02)],
        "sensor_gain": off(0.02),
        "angle_offset_rad": 0.0 if known_zero else float(rng.uniform(-0.48, 0.48)) * system.pair.pitch,
        "friction_shift": float(rng.uniform(-0.3, 0.3)) * system.friction,
    }
    law = ContactLaw(None, float(rng.uniform(0.5, 0.9))) if rng.random() < 0.4 else ContactLaw(float(rng.uniform(0.88, 0.93)))
    values["contact_law"] = {"power": law.power, "depth_modules": law.depth}
    true = replace(
        system,
        youngs=system.youngs * values["youngs_scale"],
        compliance_scale=1.0 / values["stiffness_scale"],
        torque_gain=values["torque_gain"],
        damping=system.damping * max(values["damping_scale"], 0.4),
        inertias=(system.inertias[0] * values["inertia_scale"][0], system.inertias[1] * values["inertia_scale"][1]),
        sensor=Sensor(gain=values["sensor_gain"]),
        angle_offset=values["angle_offset_rad"],
        friction=system.friction + values["friction_shift"],
        contact=law,
        coupling=float(rng.uniform(0.28, 0.42)),
    )
    return true, values


def draw_specs(system: System, rng: np.random.Generator, dynamic: bool = True, rich: bool = True) -> list[Spec]:
    """Usually four slow records and two to four at speed, one of each held out, and now and then other quantities."""
    rated = system.torque
    levels = [rng.uniform(0.05, 0.15), rng.uniform(0.28, 0.45), rng.uniform(0.55, 0.8), rng.uniform(0.95, 1.15)]
    if rng.random() < 0.2:
        levels = sorted([*levels, rng.uniform(0.18, 0.25)])
    out = int(rng.integers(1, len(levels)))
    slow_noise, fast_noise = rng.uniform(0.08, 0.3), rng.uniform(0.15, 0.5)
    turns = rng.uniform(1.5, 4.2)
    samples = int(rng.integers(44, 61))
    specs = []

    def add(quantity: str, torque: float = 0.0, **more: Any) -> None:
        start = float(rng.choice([0.0, 0.0, rng.uniform(0.0, 1.0)])) if "gear" not in more else 0.0
        kind = {"static_transmission_error": "te", "dynamic_transmission_error": "dte"}.get(quantity, quantity)
        tail = f"{torque:.4g}Nm".replace(".", "p") if torque else ("pinion", "wheel")[more.get("gear", 0)]
        name = f"{kind}_{tail}" + (f"_{more['speed'] * 30 / math.pi:.0f}rpm" if more.get("speed") else "")
        specs.append(Spec(f"{name}.csv", quantity, torque, start=start, **{"turns": turns, "samples": samples, **more}))

    def load(level: float) -> float:
        return float(f"{rated * level:.4g}")

    def own(span: float) -> float:
        return float(np.clip(turns + rng.uniform(-span, span), 1.5, 4.2))

    for k, level in enumerate(levels):
        role = "holdout" if k == out else "fit"
        add("static_transmission_error", load(level), role=role, noise=slow_noise * rng.uniform(0.8, 1.25), turns=own(0.7))
    critical = natural_speed(system, 16e9 * system.pair.width)
    if dynamic:
        spots = [rng.uniform(0.35, 0.6), rng.uniform(0.68, 0.88), rng.uniform(1.12, 1.4), rng.uniform(1.45, 1.8)]
        spots = [spots[i] for i in sorted(rng.permutation(4)[: int(rng.integers(2, 5))])]
        out = int(rng.integers(len(spots)))
        heavy = load(rng.uniform(0.6, 1.0))
        for k, spot in enumerate(spots):
            torque = heavy if rng.random() < 0.6 else load(rng.uniform(0.4, 1.0))
            role = "holdout" if k == out else "fit"
            speed = round(spot * critical * 30 / math.pi, 1) * math.pi / 30
            add("dynamic_transmission_error", torque, speed=speed, role=role, noise=fast_noise * rng.uniform(0.8, 1.25), turns=own(0.7))
        if rng.random() < 0.3:
            speed = round(rng.uniform(0.5, 1.5) * critical * 30 / math.pi, 1) * math.pi / 30
            add("pinion_angular_acceleration", heavy, speed=speed)
        if rng.random() < 0.15:
            course = tuple(round(x * critical * 30 / math.pi, 1) * math.pi / 30 for x in np.linspace(0.4, 1.6, 11))
            add("dynamic_factor", heavy, speeds=course, noise=0.01)
    if rich:
        for quantity, chance in (("mesh_stiffness", 0.25), ("flank_profile", 0.25), ("radial_runout", 0.2), ("pitch_deviation", 0.25)):
            if rng.random() >= chance:
                continue
            if quantity == "mesh_stiffness":
                add(quantity, load(rng.uniform(0.4, 1.0)), turns=float(rng.uniform(0.3, 1.5)))
                continue
            g = int(rng.integers(2))
            count = system.pair.gears[g].teeth
            lost = quantity != "flank_profile" and rng.random() < 0.4
            more = {"tooth_zero_unknown": True, "first_tooth": int(rng.integers(count))} if lost else {}
            noise = {"flank_profile": 0.4, "radial_runout": 1.0, "pitch_deviation": 0.4}[quantity] * rng.uniform(0.6, 1.4)
            turn = float(rng.choice([1.0, 2.0]))
            add(quantity, gear=g, tooth=int(rng.integers(count)), turns=turn, noise=noise, **more)
    return [with_noise(system, s) for s in specs]


def with_noise(system: System, spec: Spec) -> Spec:
    """Set the noise of those quantities whose size is only known from the healthy pair."""
    if spec.noise:
        return spec
    short = replace(spec, turns=2.0 / system.pair.pinion.teeth)
    level = measure(system, short)
    return replace(spec, noise=0.01 * float(level.mean()) if spec.quantity == "mesh_stiffness" else 0.05 * float(np.std(level)) + 1e-3)
