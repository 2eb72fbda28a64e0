"""Campaigns: measurements of one gear pair, read, checked and in SI."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from gearfem.definition.model_file import read_tables
from gearfem.definition.setup import GearPair, Setup
from gearfem.definition.validate import shown
from gearfem.diagnosis.reading.faults import Fault, find_faults
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.quantities import QUANTITIES
from gearfem.diagnosis.reading.roles import Role, share_roles
from gearfem.diagnosis.reading.schema import ALLOWED, RecordTable, validate_campaign
from gearfem.diagnosis.reading.series import read_series
from gearfem.diagnosis.reading.siblings import refuse_duplicates, refuse_odd_units
from gearfem.diagnosis.reading.thinning import thinned
from gearfem.effects.effect import Effect
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.units import RPM
from gearfem.model import load_model

# Rows times teeth at most, each of which takes some 400 bytes of memory: 12 GB.
ROWS = 30_000_000
# Noise that no record holds: of so many rows over the angle or the speed three times what they vary by, noise included (records say 1.4
# times at most), or of any a hundred-millionth of it; and least noise in the unit of the file.
FEW, LOUDEST, FAINTEST, LEAST_NOISE = 8, 3.0, 1e-8, 1e-9


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Campaign(Record):
    """Measurements of one gear pair and the model that its owner believes in.

    Parameters
    ----------
    name : str
        Title.
    path, model : str
        Files of the campaign and of its model.
    setup : Setup
        That model.
    angle_known : bool
        Whether pinion angle 0 is pair 0 in contact at the pitch point.
    records : tuple of Measurement
        In the order of the file.
    remarks : tuple of Fault
        Faults that were repaired and decisions that were taken, to be reported.
    """

    name: str
    path: str
    model: str
    setup: Setup
    angle_known: bool
    records: tuple[Measurement, ...]
    remarks: tuple[Fault, ...] = ()

    def of(self, role: Role) -> tuple[Measurement, ...]:
        """Return the records of one role."""
        return tuple(record for record in self.records if record.role == role)

    @property
    def fitted(self) -> tuple[Measurement, ...]:
        """Records that are fitted: those of role "fit", without those whose first tooth is unknown unless there are no others.

        A gear off the rig whose first tooth nobody knows says little about single teeth; that tooth is sought when such a record is proven.
        """
        records = self.of("fit")
        return tuple(record for record in records if record.tooth_known) or records


def read_campaign(path: str | Path, effects: Iterable[type[Effect]] = ()) -> Campaign:
    """Read a campaign, check its data and share out the roles that it leaves open.

    Parameters
    ----------
    path : str or Path
        Campaign file, or the folder that holds it as campaign.toml; model and records are found relative to it.
    effects : iterable of type
        Effects from outside the catalogue that the model may name.

    Returns
    -------
    Campaign

    Raises
    ------
    InputError
        One line with file, key or row, what was found and what is allowed. Isolated spikes and single missing rows are
        repaired and listed in `remarks`; every other fault of the data is refused.
    """
    if not str(path):
        raise InputError("campaign", '""', "a campaign file (*.toml), or the folder that holds campaign.toml")
    path = Path(path)
    path = path / "campaign.toml" if path.is_dir() else path
    try:
        table = validate_campaign(read_tables(path))
    except InputError as error:
        raise error.in_file(str(path)) from None
    model = path.parent / table.model
    if not model.is_file():
        raise InputError("model", shown(table.model), f"{ALLOWED['model']}: there is no such file, {model}", str(path))
    setup = load_model(model, effects=effects)
    records, remarks, kick = [], [], setup.calibration.kick
    for index, entry in enumerate(table.record, 1):
        try:
            record, found = _measurement(path.parent, entry, setup.pair)
        except InputError as error:
            where = f"record[{index}].{error.where}" if error.file is None else error.where
            raise InputError(where, error.found, error.allowed, error.file or str(path)) from None
        records.append(record)
        remarks += found
    try:
        refuse_duplicates(records)
        refuse_odd_units([record for record in records if record.quantity.name == "static_transmission_error"], path.parent)
    except InputError as error:
        raise error.in_file(str(path)) from None
    records, passed_over = thinned(records, setup.pair)
    remarks += passed_over
    rows, most = sum(len(record.axis) for record in records), ROWS // (setup.pair.pinion.teeth + setup.pair.wheel.teeth)
    if rows > most:
        raise InputError("record", f"{rows} rows in all", f"up to {most} for this pair: keep every second row, or fewer turns", str(path))
    roles, decisions = share_roles([entry.role for entry in table.record], [(r.quantity, r.pinion_torque, r.pinion_speed) for r in records])
    for record, decision in zip(records, decisions, strict=True):
        if decision:
            remarks.append(Fault(record=record.file, kind="role", rows=(), sentence=decision))
    campaign = Campaign(
        name=table.name or path.stem,
        path=str(path),
        model=str(model),
        setup=setup,
        angle_known=table.angle_zero == "pitch_point",
        records=tuple(dataclasses.replace(one, role=role, kick=kick(one.file)) for one, role in zip(records, roles, strict=True)),
        remarks=(),
    )
    for record in campaign.of("fit"):
        if record not in campaign.fitted:
            idle = "no part in the fit, since its first tooth is unknown: that is sought when the verdict is proven"
            remarks.append(Fault(record=record.file, kind="role", rows=(), sentence=idle))
    return dataclasses.replace(campaign, remarks=tuple(remarks))


def _measurement(folder: Path, entry: RecordTable, pair: GearPair) -> tuple[Measurement, list[Fault]]:
    quantity = QUANTITIES[entry.quantity]
    gear = pair.gear(entry.gear)
    if entry.tooth is not None and entry.tooth >= gear.teeth:
        raise InputError("tooth", entry.tooth, f"an integer from 0 to {gear.teeth - 1}, the teeth of the {entry.gear}")
    series = read_series(folder / entry.file, quantity.columns)
    try:
        keep, faults = find_faults(entry.file, quantity, series, pair, gear)
    except InputError as error:
        raise error.in_file(str(folder / entry.file)) from None
    axis, value = (column * unit for column, unit in zip((series.axis, series.value), quantity.factors, strict=True))
    _check_noise(entry.noise_std, series.value[keep], LOUDEST if len(axis) >= FEW and not quantity.of_gear else math.inf)
    record = Measurement(
        file=entry.file,
        quantity=quantity,
        axis=axis,
        value=value,
        line=series.line,
        keep=keep,
        pinion_torque=0.0 if quantity.of_gear else entry.pinion_torque_Nm or 0.0,
        pinion_speed=(entry.pinion_speed_rpm or 0.0) * RPM if quantity.axis == "angle" else 0.0,
        gear=entry.gear,
        tooth=entry.tooth,
        tooth_known=entry.tooth_zero is None,
        noise_std=None if entry.noise_std is None else entry.noise_std * quantity.factors[1],
        role_given=entry.role is not None,
    )
    return record, faults


def _check_noise(stated: float | None, value: Array, loudest: float) -> None:
    """Refuse a deviation of noise that the values of a record, in the unit of the file, cannot hold: so many times what they vary by.

    Of a gear off the rig it may stand for how well a method is trusted, which errs alike over a whole trace.
    """
    if stated is None:
        return
    varies = float(np.std(value))
    least, most = max(FAINTEST * varies, LEAST_NOISE), loudest * varies if varies else math.inf
    if not least <= stated <= most:
        held = f"in the unit of the column, whose values vary by {varies:.3g}, noise included; or the column is in another unit"
        allowed = f"from {least:.3g} to {most:.3g} {held}"
        raise InputError("noise_std", f"{stated:g}", allowed)
