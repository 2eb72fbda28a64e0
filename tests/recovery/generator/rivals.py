"""Which causes are known to imitate which: asked of every label, so that a twin by chance is not scored as a plain case."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .effects import GEARS, Effect

Rival = tuple[str, dict[str, Any]]


def brief(effect: Effect) -> dict[str, Any]:
    """Name, gear and tooth of an effect."""
    return {"name": effect.name, **{key: effect.params[key] for key in ("gear", "tooth") if key in effect.params}}


def _other(effect: Effect) -> str:
    return GEARS[1 - GEARS.index(effect.params["gear"])]


def _same(effect: Effect) -> dict[str, Any]:
    return {key: effect.params[key] for key in ("gear", "tooth") if key in effect.params}


def signed(effect: Effect, name: str, forced: dict[str, Any], size: float) -> dict[str, Any]:
    """Give a rival that has a sign the one that imitates: a slope mirrored on the mate turns round, a late tooth stays late."""
    if name not in ("profile_slope", "pitch_error"):
        return {}
    sign = -1.0 if effect.params.get("amount_um", 1.0) < 0.0 else 1.0
    if name == effect.name == "profile_slope" and forced["gear"] != effect.params["gear"]:
        sign = -sign
    return {"amount_um": sign * abs(size)}


def _lead(effect: Effect) -> list[Rival]:
    rivals: list[Rival] = [(name, {}) for name in ("lead_misalignment",) if name != effect.name]
    for name in ("crowning", "end_relief"):
        rivals += [(name, {"gear": gear}) for gear in GEARS if (name, gear) != (effect.name, effect.params.get("gear"))]
    return [*rivals, ("contact_compliance", {})]


def _tooth(effect: Effect) -> list[Rival]:
    names = [name for name in ("pitch_error", "root_crack") if name != effect.name]
    across = {"gear": _other(effect), "tooth": effect.params["tooth"]}
    return [*((name, _same(effect)) for name in names), (effect.name, across)]


RIVALS: dict[str, Callable[[Effect], list[Rival]]] = {
    "profile_slope": lambda e: [("profile_slope", {"gear": _other(e)}), ("profile_wear", _same(e)), ("profile_wear", {"gear": _other(e)})],
    "tip_relief": lambda e: [("profile_wear", _same(e)), ("profile_wear", {"gear": _other(e)}), ("profile_slope", _same(e))],
    "profile_wear": lambda e: [
        *((n, {"gear": g}) for n in ("tip_relief", "profile_slope") for g in GEARS),
        ("profile_wear", {"gear": _other(e)}),
    ],
    "pitch_error": _tooth,
    "root_crack": _tooth,
    "pitting": _tooth,
    "lead_misalignment": _lead,
    "crowning": _lead,
    "end_relief": _lead,
    "body_compliance": lambda e: [("contact_compliance", {}), ("support_compliance", {}), ("sensor_gain", {})],
    "contact_compliance": lambda e: [("body_compliance", {}), ("lead_misalignment", {}), ("crowning", {}), ("sensor_gain", {})],
    "support_compliance": lambda e: [("body_compliance", {})],
    "sensor_gain": lambda e: [("body_compliance", {}), ("contact_compliance", {})],
    "runout": lambda e: [("torque_ripple", {"gear": e.params["gear"], "order": 1, "phase_rad": e.params["angle_rad"]})],
    "damping": lambda e: [("friction", {})],
}
