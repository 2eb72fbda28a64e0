"""The nuisances of a campaign as one vector, in prior deviations, and the settings of the model that belong to it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.modelling.bench import Settings, neutral
from gearfem.diagnosis.modelling.nuisances import BUILD, MOVING, Nuisance, moved_settings, nuisances_of
from gearfem.diagnosis.modelling.pitch_point import WAYS
from gearfem.diagnosis.modelling.teeth import Scatter
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.foundation import Array, Record
from gearfem.variants import Variant

# Prior deviation of the constant of a record [SI], which is not known at all.
FREE = 1.0


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Unknowns(Record):
    """What stands where among the unknowns: scales and zero, constants of records, teeth, model form.

    Parameters
    ----------
    pair : GearPair
        The gears.
    nuisances : tuple of Nuisance
        Scales and the zero of the angle, which are not linear: the outer unknowns. All others are inner ones.
    offsets : tuple of int
        Records with an unknown constant.
    scatter : Scatter
        Prior of the single teeth.
    teeth : ndarray
        Prior deviation of each unknown of the teeth [m]: of each tooth the index error, then its waviness.
    errors : tuple of Variant
        How the model may be wrong.
    level : Settings
        What holds where no unknown says otherwise; index errors add to its own.
    """

    pair: GearPair
    nuisances: tuple[Nuisance, ...]
    offsets: tuple[int, ...]
    scatter: Scatter
    teeth: Array
    errors: tuple[Variant, ...] = ()
    level: Settings

    @property
    def outer(self) -> int:
        """Number of the nuisances that are not linear."""
        return len(self.nuisances)

    @cached_property
    def places(self) -> Mapping[str, int]:
        """Places of the outer nuisances by their names."""
        return {nuisance.name: place for place, nuisance in enumerate(self.nuisances)}

    @property
    def first_tooth(self) -> int:
        """Place of the first tooth's index error."""
        return self.outer + len(self.offsets)

    @property
    def first_form(self) -> int:
        """Place of the first error of the model."""
        return self.first_tooth + len(self.teeth)

    @property
    def late(self) -> slice:
        """Places of the index errors; none where they stand still."""
        return slice(self.first_tooth, self.first_tooth if self.scatter.common else self.first_form, self.scatter.terms + 1)

    @property
    def wavy(self) -> NDArray[Any]:
        """Places of the waviness of all teeth."""
        own = np.arange(len(self.teeth))
        return np.asarray(self.first_tooth + own[own % (self.scatter.terms + 1) > 0])

    @property
    def wrong(self) -> slice:
        """Places of the errors of the model."""
        return slice(self.first_form, self.first_form + len(self.errors))

    @property
    def forms(self) -> slice:
        """Places of the forms common to all teeth of either gear."""
        return slice(self.wrong.stop, self.wrong.stop + 2 * self.scatter.terms)

    @property
    def ways(self) -> slice:
        """Places of the ways over which friction turns round."""
        return slice(self.forms.stop, self.forms.stop + len(WAYS))

    @property
    def touch(self) -> int:
        """Place of what the damper acts on; behind it stands only the rise of the largest Kw by waviness."""
        return int(self.ways.stop)

    @property
    def held(self) -> NDArray[Any]:
        """Places of what is linear nearby and yet held by predictions, since it bends far off: index errors, and errors of the model."""
        places = np.arange(self.wrong.stop)
        return np.concatenate([places[self.late], places[self.wrong]])

    def within(self, unknown: Array) -> Array:
        """Return of what predictions hold how much they can, in the order of `held`."""
        return np.concatenate([unknown[self.late], self._errors(unknown)])

    def at_limits(self, unknown: Array) -> NDArray[Any]:
        """Return which of those that predictions hold, in the order of `held`, stand at or beyond what the model can follow."""
        least, most = self._limits
        moved = unknown[self.wrong]
        return np.concatenate([np.zeros(len(unknown[self.late]), bool), (moved <= least) | (moved >= most)])

    def _errors(self, unknown: Array) -> Array:
        return np.clip(unknown[self.wrong], *self._limits)

    @cached_property
    def _limits(self) -> tuple[Array, Array]:
        return np.array([variant.least for variant in self.errors]), np.array([variant.most for variant in self.errors])

    def settings(self, unknown: Array) -> Settings:
        """Return the settings of unknowns, shape (k,)."""
        known, z1 = self.level, self.pair.pinion.teeth
        if not self.scatter.common:
            index = unknown[self.late] * self.scatter.index
            known = dataclasses.replace(known, pinion_late=known.pinion_late + index[:z1], wheel_late=known.wheel_late + index[z1:])
        if self.errors:
            known = dataclasses.replace(known, errors=tuple(self._errors(unknown).tolist()))
        return moved_settings(known, self.nuisances, unknown[: self.outer])

    def of(self, settings: Settings) -> Array:
        """Return the unknowns of settings up to errors of the model: all that is linear at 0, but for what predictions hold."""
        unknown = np.zeros(self.wrong.stop)
        unknown[: self.outer] = [nuisance.deviations(getattr(settings, nuisance.name)) for nuisance in self.nuisances]
        if not self.scatter.common:
            late = settings.pinion_late - self.level.pinion_late, settings.wheel_late - self.level.wheel_late
            unknown[self.late] = np.concatenate(late) / self.scatter.index
        if self.errors:
            unknown[self.first_form : self.first_form + len(settings.errors)] = settings.errors
        return unknown

    @property
    def scales(self) -> list[int]:
        """Places of the outer nuisances but for the zero of the angle and how the gears are built, of which little is expected."""
        return [place for place, nuisance in enumerate(self.nuisances) if nuisance.name != "angle_offset" and nuisance not in BUILD]

    def neutral(self, unknown: Array) -> Array:
        """Return unknowns with scales as the model has them and no errors of the model; zero of the angle, build and teeth stay."""
        found = unknown.copy()
        found[self.scales] = 0.0
        found[self.wrong] = 0.0
        return found

    @property
    def moving(self) -> list[int]:
        """Places of what motions alone say much of: inertias, damping and compliance in series."""
        return [place for place, nuisance in enumerate(self.nuisances) if nuisance in MOVING or nuisance.name == "series_compliance"]

    def resting(self, unknown: Array) -> Array:
        """Return unknowns with what motions alone say much of as the model has it; all else stays."""
        found = unknown.copy()
        found[self.moving] = 0.0
        return found

    def constant(self, record: int, unknown: Array) -> float:
        """Return the constant of a record [SI]; 0 where it has none."""
        return FREE * float(unknown[self.outer + self.offsets.index(record)]) if record in self.offsets else 0.0


def unknowns_of(
    campaign: Campaign,
    records: tuple[Measurement, ...],
    scatter: Scatter,
    errors: tuple[Variant, ...] = (),
    nuisances: tuple[Nuisance, ...] | None = None,
    level: Settings | None = None,
) -> Unknowns:
    """Return the unknowns of records of a campaign, under a model that may be wrong in some ways.

    Nuisances are by default those that the records can feel, and the level is that of the model.
    """
    pair = campaign.setup.pair
    return Unknowns(
        pair=pair,
        nuisances=nuisances_of(campaign, records) if nuisances is None else nuisances,
        offsets=tuple(i for i, record in enumerate(records) if record.quantity.free_constant),
        scatter=scatter,
        teeth=scatter.deviations(pair) if scatter.rest is None else np.ones(scatter.left),
        errors=errors,
        level=level or neutral(pair),
    )
