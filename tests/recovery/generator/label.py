"""What the scorer is told: names that count as right, floors of every record, parameters in the catalogue's terms."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .effects import Effect
from .gear import Array
from .observe import Spec, measure
from .rivals import RIVALS, brief, signed
from .sizes import draw, equivalent
from .strength import Scale
from .system import Scatter, System
from .twins import Twin

APART = 2.3
SPREAD = np.array([0.03, 0.12, 0.5])


def described(effect: Effect, healthy: System) -> dict[str, Any]:
    params = effect.params
    near = params
    if effect.name in ("tip_relief", "profile_wear", "profile_slope", "pitting"):
        depth = effect.apply(healthy).profiles[-1].depth
        near = equivalent(effect.name, healthy, params, depth)
    return {"name": effect.name, "parameters": params, "nearest_catalogue": near, "shape_seed": effect.shape}


def acceptable(effects: list[Effect], healthy: System, specs: list[Spec], scale: Scale | None) -> list[list[dict[str, Any]]]:
    """Sets of names that count as right: the truth first, then those that leave less than `APART` of it unexplained."""
    sets: list[list[dict[str, Any]]] = [[]]
    for effect in effects:
        options = [brief(effect)]
        if scale is not None:
            own = scale.whiten(effect.apply(healthy))
            for name, forced in RIVALS.get(effect.name, lambda e: [])(effect):
                if scale.apart(own, imitations(effect, name, forced, healthy, specs)) < APART:
                    options.append({"name": name, **{k: v for k, v in forced.items() if k in ("gear", "tooth")}})
        sets = [[*s, o] for s in sets for o in options]
    return sets


def imitations(effect: Effect, name: str, forced: dict[str, Any], healthy: System, specs: list[Spec]) -> list[System]:
    """The rival at several sizes, so that a free mix of them covers what does not grow in proportion."""
    params, least, most = draw(name, healthy, specs, np.random.default_rng(3))
    out = []
    for size in np.maximum(SPREAD * most, least):
        wanted = {**params(float(size)), **forced, **signed(effect, name, forced, float(size))}
        out.append(Effect(name, wanted, 1).apply(healthy))
    return out


def twin_strengths(twin: Twin, healthy: System, known_zero: bool) -> list[float]:
    """Strength of a twin's cause, what the rivals leave of it, and what they leave once the deciding records are there."""
    effect, out = twin.effects[0], []
    for specs in (twin.specs, [*twin.specs, *twin.deciding]):
        scale = Scale(healthy, specs, angle_known=known_zero)
        own = scale.whiten(effect.apply(healthy))
        if not out:
            out.append(scale.of(effect.apply(healthy)))
        rest = []
        for option in twin.accept[1:]:
            forced = {k: v for k, v in option[0].items() if k != "name"}
            rest.append(scale.apart(own, imitations(effect, option[0]["name"], forced, healthy, specs)))
        out.append(max(rest) if len(out) == 1 else min(rest))
    return out


def verdicts(kind: str, accept: list[list[dict[str, Any]]]) -> list[str]:
    if kind == "none":
        return ["no_discrepancy"]
    if kind == "hidden":
        return ["unexplained"]
    if kind == "twins":
        return ["ambiguous"]
    if kind == "weak":
        return ["no_discrepancy", "ambiguous", "explained"]
    return ["explained"] if len(accept) == 1 else ["explained", "ambiguous"]


def floor(stage: System, system: System, healthy: System, spec: Spec, clean: Array) -> dict[str, Any]:
    """RMS of the sensor, of what scatter leaves, of what waviness leaves, and of the cause itself, in the record's unit."""
    waved = stage.scatter
    index = replace(stage, scatter=Scatter(waved.late, Scatter.none(stage.pair).wave))
    plain = measure(system, spec)

    def rms(values: Array) -> float:
        centred = values - values.mean() if spec.constant else values
        return float(np.sqrt(np.mean(centred**2)))

    return {
        "file": spec.file,
        "quantity": spec.quantity,
        "role": spec.role,
        "noise_rms": spec.noise,
        "floor_rms": float(np.hypot(rms(clean - plain), spec.noise)),
        "floor_index_rms": float(np.hypot(rms(clean - measure(index, spec)), spec.noise)),
        "signature_rms": rms(plain - measure(healthy, spec)),
    }
