"""The true gear pair of a case: everything that is unlike the model its owner believes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .gear import Array, Pair
from .tooth import ContactLaw

Depth = Callable[[Array], Array]


@dataclass(frozen=True)
class Profile:
    """Metal missing along the normal over the roll length of one tooth, or of all teeth of a gear."""

    gear: int
    tooth: int | None
    depth: Depth


@dataclass(frozen=True)
class Crack:
    gear: int
    tooth: int
    depth: float


@dataclass(frozen=True)
class Ripple:
    gear: int
    order: float
    amplitude: float
    phase: float


@dataclass(frozen=True)
class Scatter:
    """What manufacture leaves on every tooth: index errors (late, m) and waviness (two cosines per flank)."""

    late: tuple[Array, Array]
    wave: tuple[Array, Array]

    @classmethod
    def none(cls, pair: Pair) -> Scatter:
        counts = [gear.teeth for gear in pair.gears]
        return cls((np.zeros(counts[0]), np.zeros(counts[1])), (np.zeros((counts[0], 6)), np.zeros((counts[1], 6))))

    @classmethod
    def draw(cls, pair: Pair, rng: np.random.Generator, wave_rms: float = 0.2e-6) -> Scatter:
        late, wave = [], []
        for gear in pair.gears:
            late.append(rng.normal(0.0, rng.uniform(0.5e-6, 1.0e-6), gear.teeth))
            amplitude = np.abs(rng.normal(wave_rms, 0.25 * wave_rms, (gear.teeth, 2)))
            cycles = rng.uniform([0.8, 2.0], [2.0, 4.0], (gear.teeth, 2))
            wave.append(np.concatenate([amplitude, cycles, rng.uniform(0.0, 2.0 * np.pi, (gear.teeth, 2))], axis=1))
        return cls((late[0], late[1]), (wave[0], wave[1]))


@dataclass(frozen=True)
class Sensor:
    gain: float = 1.0
    delay: float = 0.0
    resonance: tuple[float, float] | None = None
    once: tuple[tuple[float, float, float], ...] = ()  # encoder errors: order, amplitude, phase


@dataclass(frozen=True)
class System:
    """SI throughout. `lag` adds to every gap, `body_wave` scales the wheel body, both over the pinion's angle."""

    pair: Pair
    scatter: Scatter
    torque: float
    damping: float
    inertias: tuple[float, float]
    youngs: float = 206e9
    compliance_scale: float = 1.0
    body_scale: tuple[float, float] = (1.0, 1.0)
    beam_scale: float = 1.0
    contact_scale: float = 1.0
    contact: ContactLaw = field(default_factory=ContactLaw)
    coupling: float = 0.35
    profiles: tuple[Profile, ...] = ()
    cracks: tuple[Crack, ...] = ()
    late: tuple[Array | None, Array | None] = (None, None)
    runout: tuple[complex, complex] = (0j, 0j)
    centre_shift: float = 0.0
    support: float = 0.0
    support_power: float = 1.0
    lead: Array | None = None  # gaps of slices across the width
    lead_weight: Array | None = None
    friction: float = 0.0
    friction_blend: float = 0.02
    backlash: float = 1e-4
    ripples: tuple[Ripple, ...] = ()
    torque_gain: float = 1.0
    sensor: Sensor = field(default_factory=Sensor)
    angle_offset: float = 0.0
    lag: tuple[Callable[[Array, float], Array], ...] = ()
    body_wave: Callable[[Array], Array] | None = None
    drift: Callable[[Array], Array] | None = None
    film: Callable[[float], float] | None = None

    def wobble(self, angle: Array) -> Array:
        """Torque ripple of slow turning, seen on the pinion."""
        ratio = self.pair.pinion.teeth / self.pair.wheel.teeth
        total = np.zeros_like(angle)
        for item in self.ripples:
            turn, seen = (angle, 1.0) if item.gear == 0 else (angle * ratio, ratio)
            total = total + seen * item.amplitude * np.cos(item.order * turn + item.phase)
        return total

    @property
    def uneven(self) -> bool:
        """Whether anything repeats more slowly than the mesh."""
        loose: list[Any] = [self.cracks, self.lag, self.ripples, self.body_wave, self.drift, any(map(abs, self.runout))]
        teeth = any(p.tooth is not None for p in self.profiles) or any(x is not None for x in self.late)
        scatter = any(np.any(x) for x in (*self.scatter.late, *self.scatter.wave))
        return bool(teeth or scatter or any(bool(x) for x in loose))
