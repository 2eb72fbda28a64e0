"""Nuisances: what is wrong in every model and every rig without being an effect, with its prior."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from gearfem.diagnosis.modelling.bench import Bench, Settings
from gearfem.diagnosis.modelling.differences import one_sided, two_sided
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.effects.damping import Damping
from gearfem.effects.effect import Effect
from gearfem.effects.sensor_gain import SensorGain
from gearfem.foundation import Array, Record
from gearfem.sensing import System
from gearfem.variants import just


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Nuisance(Record):
    """One number of the settings, with a Gaussian prior about the model's value.

    Parameters
    ----------
    name : str
        Field of `Settings`.
    words : str
        For reports.
    prior : float
        Standard deviation: of the logarithm of a scale, which cannot turn negative; else of the value [SI].
    step : float
        Step of the finite difference, in prior deviations; negative where the other way may be impossible.
    reach : float
        Most prior deviations that a fit may go; farther is no nuisance any more.
    most : float
        The same upwards, where that is less.
    level : float
        Value about which it is expected: that of the model, but where many models have another one.
    is_scale : bool
        Whether it multiplies by more or less and never by nothing.
    cause : callable, optional
        Takes a System and a value of the setting, and returns the effect that would do the same.
    """

    name: str
    words: str
    prior: float
    step: float = 0.1
    reach: float = 5.0
    most: float = math.inf
    level: float = 1.0
    is_scale: bool = True
    cause: Callable[[System, float], Effect] | None = None

    @property
    def room(self) -> tuple[float, float]:
        """The least and the most prior deviations that a fit may go."""
        return -self.reach, min(self.reach, self.most)

    @property
    def unit(self) -> str:
        """Unit in which files give it; empty for a scale."""
        return {"angle_offset": "rad", "series_compliance": "um/N"}.get(self.name, "")

    def value(self, moved: float) -> float:
        """Return the value of the setting so many prior deviations from the model's."""
        return math.exp(moved * self.prior) if self.is_scale else self.level + moved * self.prior

    def deviations(self, value: float) -> float:
        """Return how many prior deviations from the model's value a setting stands."""
        return (math.log(value) if self.is_scale else value - self.level) / self.prior


def _damped(system: System, scale: float) -> Damping:
    return Damping(ratio=system.drive.damping_ratio * scale)


# Torque and stiffness act as their ratio on everything slow; Young's modulus (1 %) is merged with the stiffness scale (5 %).
SCALES = (
    Nuisance(name="stiffness_scale", words="stiffness of teeth and bodies, Young's modulus included", prior=math.hypot(0.05, 0.01)),
    Nuisance(name="torque_scale", words="torque", prior=0.01, step=0.5),
    Nuisance(name="gain", words="sensor gain", prior=0.02, step=0.5, cause=partial(just, SensorGain, "scale")),
)
# Inertias are known to 2 %; what they swing on errs by more than its compliance in series does, some 3 % of natural frequencies squared.
MOVING = (
    Nuisance(name="inertia_scale", words="inertias", prior=math.hypot(0.02, 0.03), step=0.025),
    Nuisance(name="damping_scale", words="damping ratio", prior=0.30, step=0.01, reach=3.0, cause=_damped),
)
# Mean stiffnesses of the models in use differ by some 10 %, however well they agree on its course over the pitch: of that of a usual mesh,
# 20 N/(mm um) by ISO 6336-1 [N/m2].
SERIES, USUAL_STIFFNESS = 0.08, 20e9
# Two pairs together yield about alike in all models, one pair alone does not: some models have no neighbours that feel anything, others a
# body that carries most of a deflection over; edges are sharp, or broken by some hundredths of a module, and contact over them yields more
# than on flanks, by the small radius of their rounds, or as on flanks: many models have sharp tips and one contact for the whole tooth, and
# either is as likely. All act far from linearly on where pairs hand over, so that they are fitted, not taken for small errors.
BUILD = (
    Nuisance(
        name="coupling_scale",
        words="coupling of neighbour teeth through bodies",
        prior=0.5,
        step=0.05,
        reach=1.8,
        # Beyond, a neighbour may yield more than the tooth that bears the load, and no loads be right: with contact and bodies four
        # deviations off three of four pairs had such angles at 1.9 times the coupling and none at 1.6 times, one shifted far at 1.6 times.
        most=1.2,
        is_scale=False,
    ),
    Nuisance(
        name="tip_edge_scale",
        words="radius of the tip edges",
        prior=0.55,
        step=-0.02,
        reach=0.97,
        level=0.55,
        is_scale=False,
    ),
    Nuisance(
        name="evenness",
        words="share of flanks in the contact over tip edges",
        prior=0.5,
        step=0.05,
        reach=1.2,
        level=0.5,
        is_scale=False,
    ),
)
# The unknown zero lies within half a pitch either way; its deviation is that of an equal distribution.
UNIFORM = 1.0 / math.sqrt(12.0)


def nuisances_of(campaign: Campaign, records: tuple[Measurement, ...]) -> tuple[Nuisance, ...]:
    """Return the nuisances that records of a campaign can feel."""
    loaded = [record for record in records if not record.quantity.of_gear]
    found: list[Nuisance] = []
    if any(record.quantity.axis == "angle" for record in loaded) and not campaign.angle_known:
        pitch = campaign.setup.pair.pinion.pitch_angle
        words, prior = "zero of the pinion angle", UNIFORM * pitch
        found.append(Nuisance(name="angle_offset", words=words, prior=prior, step=2e-4, reach=2.0, level=0.0, is_scale=False))
    if loaded:
        found += (*SCALES, *BUILD)
    if any(record.quantity.moving for record in loaded):
        found += MOVING
    if any(not record.quantity.free_constant or record.quantity.moving for record in loaded):
        prior = SERIES / (USUAL_STIFFNESS * campaign.setup.pair.face_width)
        words = "compliance in series with the teeth that the model misses"
        found.append(Nuisance(name="series_compliance", words=words, prior=prior, step=0.025, level=0.0, is_scale=False))
    return tuple(found)


def moved_settings(settings: Settings, nuisances: tuple[Nuisance, ...], moved: Array) -> Settings:
    """Return settings with nuisances so many prior deviations from the model's values, shape (number of them,)."""
    changes: dict[str, Any] = {nuisance.name: nuisance.value(float(place)) for nuisance, place in zip(nuisances, moved, strict=True)}
    return dataclasses.replace(settings, **changes)


def slope(record: Measurement, bench: Bench, settings: Settings, nuisance: Nuisance, stands: float, here: Array) -> Array:
    """Return the derivative of a record over a nuisance in prior deviations, shape (n,).

    Parameters
    ----------
    record : Measurement
        Any record.
    bench : Bench
        The model.
    settings : Settings
        Where it stands, the nuisance included.
    nuisance : Nuisance
        Which one.
    stands : float
        Where that stands, in prior deviations.
    here : ndarray, shape (n,)
        What the model predicts there.

    Raises
    ------
    InputError, SolveError, FloatingPointError
        If it cannot be computed on either side.
    """
    quantity = record.quantity
    # Kw is the largest value of a whole turn, wherever that begins.
    still = nuisance in MOVING or (nuisance.name == "series_compliance" and quantity.free_constant)
    blind = (still and not quantity.moving) or (nuisance.name == "angle_offset" and quantity.axis != "angle")
    if quantity.of_gear or blind:
        return np.zeros(len(record.axis))
    if nuisance.name == "gain" and quantity.axis == "angle":
        return nuisance.prior * here

    def quotient(step: float) -> Array:
        changes: dict[str, Any] = {nuisance.name: nuisance.value(stands + step)}
        return (bench.predict(record, dataclasses.replace(settings, **changes)) - here) / step

    # Motions cost a hundred times what slow records do, and another build new tables: forward differences there,
    # whose error is a step's share of the curvature.
    difference = one_sided if quantity.moving or nuisance in BUILD else two_sided
    return difference(quotient, nuisance.step)
