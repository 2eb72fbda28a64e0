"""Everything that there is to observe: the records of all stages, with their effects, before anything moves."""

from __future__ import annotations

import dataclasses

from gearfem.compliance.record import Compliance
from gearfem.contact.scaled import Law
from gearfem.definition.setup import Setup
from gearfem.dynamics.record import DriveTrain
from gearfem.engagement import Mesh
from gearfem.engagement.grid import FINE, Grid
from gearfem.flank import Flanks
from gearfem.foundation import Record
from gearfem.placement import Placement
from gearfem.sensing.instrument import Instrument


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class System(Record):
    """A gear pair, mounted, driven and measured, as all effects leave it.

    Parameters
    ----------
    setup : Setup
        What it was made from.
    flanks, compliance, placement, law, drive, instrument : records
        Of the stages flank, compliance, placement, contact, drive and sensing.
    grid : Grid
        How closely pairs of teeth are tabulated.
    """

    setup: Setup
    flanks: Flanks
    compliance: Compliance
    placement: Placement
    law: Law
    drive: DriveTrain
    instrument: Instrument
    grid: Grid = FINE

    @property
    def mesh(self) -> Mesh:
        """What the engagement is computed from."""
        return Mesh(flanks=self.flanks, placement=self.placement, compliance=self.compliance, law=self.law, grid=self.grid)

    def torque(self, stated: float) -> float:
        """Return the true torque [N m] behind one that a record states."""
        return stated * self.setup.calibration.torque_scale
