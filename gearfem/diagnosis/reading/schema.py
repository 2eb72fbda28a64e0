"""The tables of a campaign file, in the units of the file, and the lines that refuse what does not fit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, ValidationError

from gearfem.definition.schema import Table, Title
from gearfem.definition.validate import shown
from gearfem.diagnosis.reading.quantities import FASTEST, QUANTITIES, SLOWEST, Quantity
from gearfem.foundation import InputError
from gearfem.foundation.errors import nearest

Value = Annotated[float, Field(gt=-1e9, lt=1e9)]
Deviation = Annotated[float, Field(gt=0.0, lt=1e15)]
Number = Annotated[int, Field(ge=0, le=1000)]

ALLOWED = {
    "name": "one line of text",
    "model": "the path of a model file (*.toml), relative to the campaign file",
    "angle_zero": '"unknown" or "pitch_point"',
    "record": "tables [[record]]",
    "file": "the path of a CSV file, relative to the campaign file, in up to 200 characters",
    "quantity": " or ".join(f'"{name}"' for name in QUANTITIES),
    "pinion_torque_Nm": "a number above 0 Nm, below 1e9 Nm",
    "pinion_speed_rpm": f"0 for a slow record, from {SLOWEST:g} to {FASTEST:g} rpm for one taken at speed",
    "noise_std": "a number above 0 in the unit of the measured column",
    "role": '"fit" or "holdout"',
    "gear": '"pinion" or "wheel"',
    "tooth": "an integer from 0 to the gear's number of teeth less one",
    "tooth_zero": '"unknown", or leave it out where the first tooth is tooth 0',
}


class RecordTable(Table):
    """[[record]]: one measured series."""

    file: Title
    quantity: str
    pinion_torque_Nm: Value | None = None
    pinion_speed_rpm: Value | None = None
    noise_std: Deviation | None = None
    role: Literal["fit", "holdout"] | None = None
    gear: Literal["pinion", "wheel"] | None = None
    tooth: Number | None = None
    tooth_zero: Literal["unknown"] | None = None


class CampaignTable(Table):
    """A whole campaign file."""

    name: Title | None = None
    model: Title
    angle_zero: Literal["unknown", "pitch_point"]
    record: Annotated[list[RecordTable], Field(min_length=1)]


def validate_campaign(tables: Mapping[str, Any]) -> CampaignTable:
    """Return the validated tables of a campaign.

    Parameters
    ----------
    tables : mapping
        As read from the file.

    Raises
    ------
    InputError
        On the first thing that is wrong: unknown keys first, since a misspelt key also leaves a missing one behind.
    """
    try:
        campaign = CampaignTable.model_validate(dict(tables))
    except ValidationError as error:
        problems = error.errors(include_url=False, include_context=False)
        first = min(problems, key=lambda problem: problem["type"] != "extra_forbidden")
        raise _refusal(first["type"], first["loc"], first["input"]) from None
    for index, record in enumerate(campaign.record, 1):
        _check_record(f"record[{index}]", record)
    return campaign


def _refusal(kind: str, place: tuple[int | str, ...], found: object) -> InputError:
    where = "".join(f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in place).lstrip(".")
    key = str(place[-1])
    if isinstance(place[-1], int):
        return InputError(where, shown(found), "a table [[record]]")
    if kind == "extra_forbidden":
        table: type[BaseModel] = RecordTable if len(place) > 1 else CampaignTable
        names = tuple(table.model_fields)
        return InputError(where, "an unknown key", nearest(key, names))
    if kind == "missing":
        return InputError(where, "nothing", f"{ALLOWED[key]}; this key must be given")
    if kind == "too_short":
        return InputError(where, "no record", "at least one table [[record]]")
    return InputError(where, shown(found), ALLOWED[key])


def _check_record(where: str, record: RecordTable) -> None:
    """Refuse keys that a quantity needs and lacks, or that mean nothing with it."""
    if record.quantity not in QUANTITIES:
        raise InputError(f"{where}.quantity", shown(record.quantity), nearest(record.quantity, QUANTITIES))
    quantity = QUANTITIES[record.quantity]
    for key, needed, welcome in _rules(quantity):
        value = getattr(record, key)
        if value is None and needed:
            raise InputError(f"{where}.{key}", "nothing", f"{ALLOWED[key]}; {quantity.name} needs it")
        if value is not None and not welcome:
            raise InputError(f"{where}.{key}", shown(value), f"nothing: {quantity.name} has no such key")
    torque, speed = record.pinion_torque_Nm or 0.0, record.pinion_speed_rpm or 0.0
    if not quantity.of_gear and torque <= 0.0:
        raise InputError(f"{where}.pinion_torque_Nm", shown(record.pinion_torque_Nm), ALLOWED["pinion_torque_Nm"])
    if quantity.axis == "angle" and (not SLOWEST <= speed <= FASTEST if quantity.moving else speed < 0.0):
        raise InputError(f"{where}.pinion_speed_rpm", shown(record.pinion_speed_rpm), ALLOWED["pinion_speed_rpm"])


def _rules(quantity: Quantity) -> tuple[tuple[str, bool, bool], ...]:
    """Return for each key whether a quantity needs it and whether it may be given."""
    return (
        ("pinion_torque_Nm", not quantity.of_gear, True),
        ("pinion_speed_rpm", quantity.axis == "angle", True),
        ("gear", quantity.of_gear, quantity.of_gear),
        ("tooth", quantity.axis == "roll", quantity.axis == "roll"),
        ("tooth_zero", False, quantity.axis == "tooth"),
    )
