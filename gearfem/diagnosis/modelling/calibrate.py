"""A model with fitted nuisances in its calibration, and what it leaves of a record once it stands."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, TypeAlias

import numpy as np

from gearfem.assembly import assemble
from gearfem.definition.calibration import COUPLING_SCALE, TIP_EDGE_SCALE, Calibration
from gearfem.definition.setup import Setup
from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.effects.effect import Effect
from gearfem.foundation import Array
from gearfem.sensing import System, observe
from gearfem.variants import VARIANTS

# What a model leaves of a record, shape (n,), the constant that was fitted [SI], and the first tooth.
Left: TypeAlias = tuple[Array, float, int]


def calibrated(setup: Setup, settings: Settings, effects: tuple[Effect, ...] = ()) -> System:
    """Return a model with nuisances in its calibration: from here on nothing knows that they were fitted.

    Parameters
    ----------
    setup : Setup
        The model as its owner believes it.
    settings : Settings
        What was fitted; on top of a calibration that the model has.
    effects : tuple of Effect
        Named effects.
    """
    return assemble(dataclasses.replace(setup, calibration=calibration_of(setup.calibration, settings)), effects)


def calibration_of(known: Calibration, settings: Settings) -> Calibration:
    """Return a calibration with settings on top of it: scales multiplied, angles and index errors added, constants as they were.

    Contact evened out twice keeps the share of its edges that both leave.
    """
    moved = zip(VARIANTS, settings.errors, strict=False)
    errors: dict[str, Any] = {variant.name: variant.both(getattr(known, variant.name), variant.value(far)) for variant, far in moved}
    return dataclasses.replace(
        known,
        **errors,
        stiffness_scale=known.stiffness_scale * settings.stiffness_scale,
        torque_scale=known.torque_scale * settings.torque_scale,
        inertia_scale=known.inertia_scale * settings.inertia_scale,
        damping_scale=known.damping_scale * settings.damping_scale,
        gain=known.gain * settings.gain,
        series_compliance=known.series_compliance + settings.series_compliance,
        coupling_scale=float(np.clip(known.coupling_scale * settings.coupling_scale, *COUPLING_SCALE)),
        tip_edge_scale=float(np.clip(known.tip_edge_scale * settings.tip_edge_scale, *TIP_EDGE_SCALE)),
        evenness=known.evenness + settings.evenness - known.evenness * settings.evenness,
        angle_offset=known.angle_offset + settings.angle_offset,
        pinion_late=known.pinion_late + settings.pinion_late if known.pinion_late.size else settings.pinion_late,
        wheel_late=known.wheel_late + settings.wheel_late if known.wheel_late.size else settings.wheel_late,
    )


def left_of(record: Measurement, system: System) -> Left:
    """Return what a frozen model leaves of a record, the constant that was fitted, and the first tooth."""
    firsts = [0] if record.tooth_known else list(range(system.setup.pair.gear(record.gear).teeth))
    best: Left | None = None
    least = math.inf
    for first in firsts:
        gap = record.value - observe(system, record.request(first))
        offset = float(gap[record.keep].mean()) if record.quantity.free_constant else 0.0
        size = float(np.sum((gap[record.keep] - offset) ** 2))
        if size < least:
            best, least = (gap - offset, offset, first), size
    assert best is not None
    return best
