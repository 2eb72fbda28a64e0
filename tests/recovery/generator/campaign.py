"""One blind case: a pair, the truth behind it, its records, and the label that only the scorer reads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from . import twins
from .design import draw_model, draw_pair, draw_specs, draw_truth, nominal_system
from .effects import Effect
from .gear import Array
from .hidden import HIDDEN
from .label import acceptable, described, floor, twin_strengths, verdicts
from .observe import Spec, axis, measure
from .sizes import AT_SPEED, SINGLE, draw
from .strength import Scale
from .system import Scatter, System

LEVELS = {"easy": (6.0, 40.0), "medium": (2.3, 4.8), "weak": (0.15, 0.7), "hidden": (6.0, 18.0)}
KINDS = ("single", "double", "none", "hidden", "twins", "weak")
LEAD = ("lead_misalignment", "crowning", "end_relief")


@dataclass(frozen=True)
class Case:
    """What is measured (`model`, `specs`, `series`) and what is true (`truth`, `label`); `measure_more` takes further records."""

    name: str
    kind: str
    model: dict[str, Any]
    angle_zero: str
    specs: list[Spec]
    series: list[tuple[Array, Array]]
    truth: System
    label: dict[str, Any]
    seed: tuple[int, ...] = ()
    coloured: bool = False
    deciding: list[Spec] = field(default_factory=list)

    def measure_more(self, spec: Spec) -> tuple[Array, Array]:
        """Take one more record of the same true pair, with noise of its own, reproducibly."""
        rng = np.random.default_rng([*self.seed, 77, sum(map(ord, spec.file))])
        return read(self.truth, spec, self.coloured, rng)


def read(truth: System, spec: Spec, coloured: bool, rng: np.random.Generator, clean: Array | None = None) -> tuple[Array, Array]:
    """Columns of one record: the clean reading, its unknown constant, and noise (coloured noise keeps its size)."""
    values = measure(truth, spec) if clean is None else clean
    noise = rng.normal(0.0, 1.0, len(values))
    if coloured and len(values) > 300:
        rho = rng.uniform(0.6, 0.9)
        for i in range(1, len(noise)):
            noise[i] = rho * noise[i - 1] + np.sqrt(1 - rho**2) * noise[i]
    constant = rng.uniform(-20.0, 20.0) if spec.constant else 0.0
    return axis(truth, spec), values + constant + spec.noise * noise


def make_case(seed: int | tuple[int, ...], kind: str = "single", effect: str | None = None, level: str | None = None) -> Case:
    """Return the case of a seed and kind; `effect` (or hidden cause, or twin) and `level` may be fixed for singles.

    Raises
    ------
    RuntimeError
        When twenty-five campaigns in a row cannot show the wanted cause at the wanted strength.
    """
    key = (seed,) if isinstance(seed, int) else tuple(seed)
    for attempt in range(25):
        rng = np.random.default_rng([*key, KINDS.index(kind), attempt])
        case = _attempt(key, kind, effect, level, rng)
        if case is not None:
            return case
    raise RuntimeError(f"no campaign shows {effect or kind} at the wanted strength (seed {key})")


def _attempt(key: tuple[int, ...], kind: str, effect: str | None, level: str | None, rng: np.random.Generator) -> Case | None:
    pair = draw_pair(rng)
    model = draw_model(pair, rng)
    known_zero = bool(rng.random() < 0.3)
    healthy, nuisances = draw_truth(nominal_system(pair, model), known_zero, rng)
    names = _names(kind, effect, rng)
    fast = rng.random() < 0.85 or any(n in (*AT_SPEED, "oil_film") for n in names)
    if kind == "twins":
        twin = twins.draw(names[0], healthy, rng)
        specs, effects, accept, deciding = twin.specs, twin.effects, twin.accept, twin.deciding
        causes: list[Callable[[System], System]] = [e.apply for e in effects]
        strengths = twin_strengths(twin, healthy, known_zero)
        if strengths[0] < 3.0 or strengths[1] > min(2.5, 0.5 * strengths[0]) or strengths[2] < 3.5:
            return None
        level = "twins"
    else:
        specs = draw_specs(healthy, rng, dynamic=fast)
        level = level or {"single": str(rng.choice(["easy", "medium"])), "double": "easy"}.get(kind, kind)
        scale = Scale(healthy, specs, angle_known=known_zero) if names else None
        sized = ([], [], []) if scale is None else _sized(kind, names, level, healthy, specs, scale, rng)
        if sized is None:
            return None
        effects, causes, strengths = sized
        accept, deciding = acceptable(effects, healthy, specs, scale), []
    system = healthy
    for cause in causes:
        system = cause(system)
    stage = replace(system, scatter=Scatter.draw(pair, rng))
    coloured = bool(rng.random() < 0.4)
    hide_roles, stated = bool(rng.random() < 0.15), bool(rng.random() < 0.85)
    series, floors = [], []
    for spec in specs:
        clean = measure(stage, spec)
        columns = read(stage, spec, coloured, rng, clean)
        series.append(columns)
        floors.append(floor(stage, system, healthy, spec, clean))
    if any(row["floor_index_rms"] > 1.1 * row["floor_rms"] for row in floors):
        return None  # teeth part so wildly that no model could follow them
    written = [replace(s, role=None if hide_roles else s.role, stated=stated) for s in specs]
    label = {
        "kind": kind,
        "level": level,
        "seed": list(key),
        "effects": [described(e, healthy) for e in effects],
        "hidden": names[0] if kind == "hidden" else None,
        "strengths": strengths,
        "verdicts": verdicts(kind, accept),
        "accept": accept,
        "records": floors,
        "nuisances": {**nuisances, "coloured_noise": coloured, "roles_given": not hide_roles},
        "index_error_um": [list(map(float, late * 1e6)) for late in stage.scatter.late],
        "angle_zero": "pitch_point" if known_zero else "unknown",
        "deciding": [s.file for s in deciding],
    }
    zero = "pitch_point" if known_zero else "unknown"
    return Case("-".join(map(str, key)), kind, model, zero, written, series, stage, label, key, coloured, deciding)


def _names(kind: str, effect: str | None, rng: np.random.Generator) -> list[str]:
    if kind == "none":
        return []
    if kind == "hidden":
        return [effect or str(rng.choice(list(HIDDEN)))]
    if kind == "twins":
        return [effect or str(rng.choice(list(twins.TWINS)))]
    if kind == "double":
        first, second = (str(x) for x in rng.choice(SINGLE, 2, replace=False))
        while first in LEAD and second in LEAD:
            second = str(rng.choice(SINGLE))
        return [first, second]
    return [effect or str(rng.choice(SINGLE))]


def _sized(
    kind: str, names: list[str], level: str, healthy: System, specs: list[Spec], scale: Scale, rng: np.random.Generator
) -> tuple[list[Effect], list[Callable[[System], System]], list[float]] | None:
    """Size every cause so that its strength lies in the level's range; None where its plain range does not reach it."""
    effects: list[Effect] = []
    causes: list[Callable[[System], System]] = []
    strengths: list[float] = []
    low, high = LEVELS[level]
    fine = 0.03 if level == "weak" else 1.0
    for name in names:
        target = float(np.exp(rng.uniform(np.log(low * 1.05), np.log(high / 1.05))))
        if kind == "hidden":
            make, least, most = HIDDEN[name](healthy, rng)
            size, strength = _solve(lambda s, make=make: scale.of(make(s)), target, least, most, (low, high))
            if size is None:
                return None
            causes.append(lambda _, make=make, size=size: make(size))
        else:
            shape = int(rng.integers(2**31))
            params, least, most = draw(name, healthy, specs, rng)
            least *= fine
            size, strength = _solve(
                lambda s, name=name, params=params, shape=shape: scale.of(Effect(name, params(s), shape).apply(healthy)),
                target,
                least,
                most,
                (low, high),
            )
            if size is None:
                return None
            effects.append(Effect(name, params(size), shape))
            causes.append(effects[-1].apply)
        strengths.append(strength)
    return effects, causes, strengths


def _solve(
    strength: Callable[[float], float], target: float, least: float, most: float, band: tuple[float, float]
) -> tuple[float | None, float]:
    """Find a size whose strength meets the target, by secants in logarithms; any strength inside the band will do after that."""
    size = float(np.sqrt(least * most)) if most < 50 * least else 4.0 * least
    lower, upper = least, most
    value = strength(size)
    for _ in range(7):
        if abs(np.log(max(value, 1e-9) / target)) < 0.08:
            break
        if value < target:
            lower = size
        else:
            upper = size
        guess = size * float(np.clip(target / max(value, 1e-9), 0.05, 20.0))
        size = guess if lower < guess < upper else float(np.sqrt(lower * upper)) if upper < most or guess < upper else most
        value = strength(size)
        if size >= most and value < band[0]:
            return None, value
    return (size, value) if band[0] <= value <= band[1] else (None, value)
