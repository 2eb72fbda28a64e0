"""Campaigns whose records cannot tell one cause from another, and the record that would."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .effects import GEARS, Effect
from .observe import Spec
from .system import System


@dataclass(frozen=True)
class Twin:
    specs: list[Spec]
    effects: list[Effect]
    accept: list[list[dict[str, Any]]]
    deciding: list[Spec]


def _slow(system: System, levels: list[float], turns: float, rng: np.random.Generator, role: str = "fit") -> list[Spec]:
    out = []
    for level in levels:
        torque = float(f"{system.torque * level:.4g}")
        noise = float(rng.uniform(0.08, 0.25))
        name = f"te_{torque:.4g}Nm".replace(".", "p") + ".csv"
        out.append(Spec(name, "static_transmission_error", torque, role=role, noise=noise, turns=turns, samples=50))
    return out


def slope_of_either_gear(system: System, rng: np.random.Generator) -> Twin:
    """A profile slope: the mirror on the other gear gives the same transmission error. A flank trace decides."""
    g = int(rng.integers(2))
    amount = float(rng.uniform(3.5, 5.5) * rng.choice([-1, 1]))
    specs = _slow(system, [rng.uniform(0.35, 0.45), 0.6, 1.0], float(rng.uniform(1.5, 3.0)), rng)
    specs += _slow(system, [0.7], float(rng.uniform(1.5, 3.0)), rng, "holdout")
    trace = Spec(f"flank_profile_{GEARS[g]}.csv", "flank_profile", gear=g, tooth=3, noise=0.4)
    accept = [[{"name": "profile_slope", "gear": GEARS[x]}] for x in (g, 1 - g)]
    return Twin(specs, [Effect("profile_slope", {"gear": GEARS[g], "amount_um": amount}, int(rng.integers(2**31)))], accept, [trace])


def tooth_of_either_gear(system: System, rng: np.random.Generator) -> Twin:
    """One late tooth, met once: it may be the pinion's or the wheel's. Its gear's pitch record decides."""
    g = int(rng.integers(2))
    most = min(system.pair.pinion.teeth, system.pair.wheel.teeth)
    tooth = int(rng.integers(4, most - 5))
    turns = (most - 1.5) / system.pair.pinion.teeth
    specs = _slow(system, [rng.uniform(0.06, 0.14), 0.4, 1.0], turns, rng) + _slow(system, [0.7], turns, rng, "holdout")
    amount = float(rng.uniform(6.0, 10.0) * rng.choice([-1, 1]))
    pitch = Spec(f"pitch_deviation_{GEARS[g]}.csv", "pitch_deviation", gear=g, noise=0.4, turns=1.0)
    accept = [[{"name": "pitch_error", "gear": GEARS[x], "tooth": tooth}] for x in (g, 1 - g)]
    params = {"gear": GEARS[g], "tooth": tooth, "amount_um": amount}
    return Twin(specs, [Effect("pitch_error", params, int(rng.integers(2**31)))], accept, [pitch])


def body_or_contact(system: System, rng: np.random.Generator) -> Twin:
    """Softer bodies or softer contacts, seen at one load with its angle-free mean unknown. Stiffness at several loads decides."""
    specs = _slow(system, [1.0], float(rng.uniform(1.5, 3.0)), rng) + _slow(system, [0.95], 1.5, rng, "holdout")
    name = str(rng.choice(["body_compliance", "contact_compliance"]))
    more = []
    for level in (0.04, 0.12, 0.3, 0.6, 0.9, 1.2):
        torque = float(f"{system.torque * level:.4g}")
        file = f"mesh_stiffness_{torque:.4g}Nm".replace(".", "p") + ".csv"
        more.append(Spec(file, "mesh_stiffness", torque, noise=2.0, turns=4.0 / system.pair.pinion.teeth, samples=50))
    scale = float(rng.uniform(1.9, 2.4)) if name == "body_compliance" else float(rng.uniform(2.2, 3.0))
    accept = [[{"name": x}] for x in (name, *({"body_compliance", "contact_compliance"} - {name}))]
    return Twin(specs, [Effect(name, {"scale": scale}, int(rng.integers(2**31)))], accept, more)


def gain_or_softness(system: System, rng: np.random.Generator) -> Twin:
    """An encoder that reads too much, or teeth that yield too much, at one torque. A measured stiffness decides: it goes up or down."""
    specs = _slow(system, [1.0], float(rng.uniform(1.5, 3.0)), rng) + _slow(system, [0.95], 1.5, rng, "holdout")
    torque = float(f"{system.torque * 0.8:.4g}")
    file = f"mesh_stiffness_{torque:.4g}Nm".replace(".", "p") + ".csv"
    more = [Spec(file, "mesh_stiffness", torque, noise=2.0, turns=4.0 / system.pair.pinion.teeth, samples=50)]
    names = ["sensor_gain", "body_compliance", "contact_compliance"]
    true = Effect("sensor_gain", {"scale": float(rng.uniform(1.45, 1.7))})
    return Twin(specs, [true], [[{"name": name}] for name in names], more)


TWINS: dict[str, Callable[[System, np.random.Generator], Twin]] = {
    "slope_of_either_gear": slope_of_either_gear,
    "tooth_of_either_gear": tooth_of_either_gear,
    "body_or_contact": body_or_contact,
    "gain_or_softness": gain_or_softness,
}


def draw(name: str, system: System, rng: np.random.Generator) -> Twin:
    """Return one campaign of the named pair of rivals."""
    return TWINS[name](system, rng)
