"""Causes that no catalogue names: each takes a size and returns the changed system."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .gear import Array
from .system import Profile, System

Make = Callable[[float], System]


def encoder_mount(system: System, rng: np.random.Generator) -> tuple[Make, float, float]:
    """Oval and eccentric seat of the pinion's encoder: twice, once and three times a turn, in every series of angle."""
    shares, phases = (1.0, rng.uniform(0.3, 0.6), rng.uniform(0.3, 0.6)), rng.uniform(0, 2 * np.pi, 3)

    def make(size: float) -> System:
        waves = tuple((o, size * a, float(p)) for o, a, p in zip((2.0, 1.0, 3.0), shares, phases, strict=True))
        return replace(system, sensor=replace(system.sensor, once=waves))

    return make, 0.3e-6, 25e-6


def undulation(system: System, rng: np.random.Generator) -> tuple[Make, float, float]:
    """The grinding worm's feed mark: the same short wave on every flank of one gear."""
    g = int(rng.integers(2))
    cycles, phase = rng.uniform(2.6, 4.8), rng.uniform(0, 2 * np.pi)
    length = system.pair.contact_ratio * system.pair.base_pitch

    def make(size: float) -> System:
        def depth(s: Array) -> Array:
            return size * np.cos(2 * np.pi * cycles * s / length + phase)

        return replace(system, profiles=(*system.profiles, Profile(g, None, depth)))

    return make, 0.1e-6, 6e-6


def bent_shaft(system: System, rng: np.random.Generator) -> tuple[Make, float, float]:
    """A shaft with a bowed, unequally stiff section: once and twice a turn in proportion to the torque."""
    phases, second = rng.uniform(0, 2 * np.pi, 2), rng.uniform(0.4, 0.8)

    def make(size: float) -> System:
        def lag(angle: Array, torque: float) -> Array:
            return torque / system.torque * size * (np.cos(angle + phases[0]) + second * np.cos(2 * angle + phases[1]))

        return replace(system, lag=(*system.lag, lag))

    return make, 0.3e-6, 25e-6


def loose_wheel(system: System, rng: np.random.Generator) -> tuple[Make, float, float]:
    """A wheel with play on its seat tips over twice a turn of its shaft, less so under torque."""
    ratio, phase, duty = system.pair.pinion.teeth / system.pair.wheel.teeth, rng.uniform(0, 2 * np.pi), rng.uniform(-0.4, 0.4)

    def make(size: float) -> System:
        def lag(angle: Array, torque: float) -> Array:
            return 0.5 * size * np.tanh(14.0 * (np.cos(angle * ratio + phase) - duty)) / (1.0 + 0.5 * torque / system.torque)

        return replace(system, lag=(*system.lag, lag))

    return make, 0.3e-6, 25e-6


def thermal_drift(system: System, rng: np.random.Generator) -> tuple[Make, float, float]:
    """The housing warms up while a record is taken: the centres move apart over the turns, quickly at first."""
    pace = rng.uniform(6.0, 14.0)

    def make(size: float) -> System:
        def drift(angle: Array) -> Array:
            return size * (1.0 - np.exp(-np.maximum(angle, -pace) / pace))

        return replace(system, drift=drift)

    return make, 0.5e-6, 120e-6


def oval_gear(system: System, rng: np.random.Generator) -> tuple[Make, float, float]:
    """A gear clamped in three or two jaws while it was cut: its teeth are late in two or three waves a turn."""
    g, waves, phase = int(rng.integers(2)), int(rng.integers(2, 4)), rng.uniform(0, 2 * np.pi)

    def make(size: float) -> System:
        count = system.pair.gears[g].teeth
        late = list(system.late)
        old = late[g]
        late[g] = (np.zeros(count) if old is None else old) + size * np.cos(2 * np.pi * waves * np.arange(count) / count + phase)
        return replace(system, late=(late[0], late[1]))

    return make, 0.3e-6, 25e-6


def split_gear(system: System, rng: np.random.Generator) -> tuple[Make, float, float]:
    """A gear bolted together from two halves that do not meet: half of the teeth step back."""
    g = int(rng.integers(2))
    count = system.pair.gears[g].teeth
    first = int(rng.integers(count))

    def make(size: float) -> System:
        late = list(system.late)
        old = late[g]
        late[g] = (np.zeros(count) if old is None else old) + size * ((np.arange(count) - first) % count < count // 2)
        return replace(system, late=(late[0], late[1]))

    return make, 0.4e-6, 25e-6


def web_holes(system: System, rng: np.random.Generator) -> tuple[Make, float, float]:
    """Lightening holes in the wheel's web: its body yields more over each of them."""
    holes, phase = int(rng.integers(3, 7)), rng.uniform(0, 2 * np.pi)
    ratio = system.pair.pinion.teeth / system.pair.wheel.teeth

    def make(size: float) -> System:
        def wave(angle: Array) -> Array:
            return 1.0 + size * (0.5 + 0.5 * np.cos(holes * angle * ratio + phase)) ** 2

        return replace(system, body_wave=wave)

    return make, 0.05, 2.5


def stick_slip_brake(system: System, rng: np.random.Generator) -> tuple[Make, float, float]:
    """A dry coupling on the pinion's shaft winds up and slips: a saw-tooth of torque, locked to no shaft order."""
    order, phase = rng.uniform(2.3, 6.7), rng.uniform(0, 1)

    def make(size: float) -> System:
        def lag(angle: Array, torque: float) -> Array:
            t = (order * angle / (2 * np.pi) + phase) % 1.0
            saw = np.where(t < 0.9, t / 0.9, (1.0 - t) / 0.1) - 0.5
            return size * saw * (torque / system.torque) ** 0.7

        return replace(system, lag=(*system.lag, lag))

    return make, 0.3e-6, 25e-6


def oil_film(system: System, rng: np.random.Generator) -> tuple[Make, float, float]:
    """A film that carries at speed: the contact softens with the speed, so the resonance moves between the records."""
    power = rng.uniform(0.6, 0.9)
    scale = math.sqrt(16e9 * system.pair.width * sum(g.base_radius**2 / j for g, j in zip(system.pair.gears, system.inertias, strict=True)))
    scale /= system.pair.pinion.teeth

    def make(size: float) -> System:
        return replace(system, film=lambda speed: 1.0 + size * (speed / scale) ** power)

    return make, 0.1, 6.0


HIDDEN: dict[str, Callable[[System, np.random.Generator], tuple[Make, float, float]]] = {
    "encoder_mount": encoder_mount,
    "undulation": undulation,
    "bent_shaft": bent_shaft,
    "loose_wheel": loose_wheel,
    "thermal_drift": thermal_drift,
    "oval_gear": oval_gear,
    "split_gear": split_gear,
    "web_holes": web_holes,
    "stick_slip_brake": stick_slip_brake,
    "oil_film": oil_film,
}
