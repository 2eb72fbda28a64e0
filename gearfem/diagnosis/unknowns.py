"""The nuisances of a campaign as one vector, in prior deviations, and the settings of the model that belong to it."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import GearPair
from gearfem.diagnosis.bench import Settings
from gearfem.diagnosis.campaign import Campaign, Measurement
from gearfem.diagnosis.nuisances import BUILD, Nuisance, moved_settings, nuisances_of
from gearfem.diagnosis.teeth import Scatter
from gearfem.foundation import Array, Record

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
    """

    pair: GearPair
    nuisances: tuple[Nuisance, ...]
    offsets: tuple[int, ...]
    scatter: Scatter
    teeth: Array

    @property
    def outer(self) -> int:
        """Number of the nuisances that are not linear."""
        return len(self.nuisances)

    @property
    def first_tooth(self) -> int:
        """Place of the first tooth's index error."""
        return self.outer + len(self.offsets)

    @property
    def first_form(self) -> int:
        """Place of the first variant of the model."""
        return self.first_tooth + len(self.teeth)

    @property
    def late(self) -> slice:
        """Places of the index errors."""
        return slice(self.first_tooth, self.first_form, self.scatter.terms + 1)

    @property
    def wavy(self) -> NDArray[Any]:
        """Places of the waviness of all teeth."""
        own = np.arange(len(self.teeth))
        return np.asarray(self.first_tooth + own[own % (self.scatter.terms + 1) > 0])

    def settings(self, unknown: Array) -> Settings:
        """Return the settings of unknowns, shape (k,)."""
        index, z1 = unknown[self.late] * self.scatter.index, self.pair.pinion.teeth
        return moved_settings(Settings(pinion_late=index[:z1], wheel_late=index[z1:]), self.nuisances, unknown[: self.outer])

    def of(self, settings: Settings) -> Array:
        """Return the unknowns of settings, shape (first_form,): all that is linear at 0, but for the index errors."""
        unknown = np.zeros(self.first_form)
        unknown[: self.outer] = [nuisance.deviations(getattr(settings, nuisance.name)) for nuisance in self.nuisances]
        unknown[self.late] = np.concatenate([settings.pinion_late, settings.wheel_late]) / self.scatter.index
        return unknown

    @property
    def scales(self) -> list[int]:
        """Places of the outer nuisances but for the zero of the angle and how the gears are built, of which little is expected."""
        return [place for place, nuisance in enumerate(self.nuisances) if nuisance.name != "angle_offset" and nuisance not in BUILD]

    def neutral(self, unknown: Array) -> Array:
        """Return unknowns with scales as the model has them; zero of the angle, build of the gears and all that is linear stay."""
        found = unknown.copy()
        found[self.scales] = 0.0
        return found

    def constant(self, record: int, unknown: Array) -> float:
        """Return the constant of a record [SI]; 0 where it has none."""
        return FREE * float(unknown[self.outer + self.offsets.index(record)]) if record in self.offsets else 0.0


def unknowns_of(campaign: Campaign, records: tuple[Measurement, ...], scatter: Scatter) -> Unknowns:
    """Return the unknowns of records of a campaign."""
    return Unknowns(
        pair=campaign.setup.pair,
        nuisances=nuisances_of(campaign, records),
        offsets=tuple(i for i, record in enumerate(records) if record.quantity.free_constant),
        scatter=scatter,
        teeth=scatter.deviations(campaign.setup.pair),
    )
