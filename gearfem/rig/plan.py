"""The plan of a campaign on the virtual rig: what is measured, by which instruments, under which seed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, ValidationError

from gearfem.definition.model_file import read_tables
from gearfem.definition.schema import Table, Title
from gearfem.definition.setup import GearPair
from gearfem.definition.validate import shown
from gearfem.diagnosis.reading.quantities import QUANTITIES
from gearfem.foundation import InputError
from gearfem.foundation.errors import nearest

NotNegative = Annotated[float, Field(ge=0.0, lt=1e12)]
Positive = Annotated[float, Field(gt=0.0, lt=1e12)]
Finite = Annotated[float, Field(gt=-1e12, lt=1e12)]

EXAMPLE = """\
name = "rig 7, planned"
seed = 7
angle_zero = "unknown"            # or "pitch_point"

[scatter]                         # what is wrong with every real pair; default none
index_error_um = 0.7              # standard deviation over the teeth of both gears
torque_scale = 1.003

[instrument]                      # of all records that do not say otherwise, in the unit of the measured column
noise_std = 0.3                   # white
coloured_noise_std = 0.1          # of a first-order process over the samples ...
coloured_noise_samples = 20.0     # ... with this correlation length
resolution = 0.05                 # step of the converter
drift_per_turn = 0.02
gain = 1.0
delay_s = 0.0
# resonance_Hz = 8000.0 and resonance_ratio = 0.1

[[record]]
file = "te_150Nm.csv"
quantity = "static_transmission_error"
pinion_torque_Nm = 150.0
turns = 3.0
samples_per_turn = 720

[[record]]
file = "te_3000rpm.csv"
quantity = "dynamic_transmission_error"
pinion_torque_Nm = 150.0
pinion_speed_rpm = 3000.0
role = "holdout"

[[record]]
file = "runout_wheel.csv"
quantity = "radial_runout"
gear = "wheel"
turns = 2.0
"""
UNITS = "in the unit of the measured column"
WORDS: dict[str, str] = {
    "name": "one line of text",
    "seed": "an integer from 0",
    "nominal": "the path of the model file that the campaign names, relative to the plan",
    "angle_zero": '"unknown" or "pitch_point"',
    "scatter": "a table [scatter]",
    "instrument": "a table [instrument]",
    "record": "tables [[record]], at least one",
    "file": "the name of a CSV file, without folders",
    "quantity": " or ".join(f'"{name}"' for name in QUANTITIES),
    "pinion_torque_Nm": "a number above 0 Nm",
    "pinion_speed_rpm": "a number above 0 rpm",
    "pinion_speeds_rpm": "a list of numbers above 0 rpm",
    "role": '"fit" or "holdout"',
    "gear": '"pinion" or "wheel"',
    "tooth": "an integer from 0 to the gear's number of teeth less one",
    "tooth_zero": '"unknown"',
    "turns": "a number above 0, at most 1000: turns of the pinion, or of the gear that is measured",
    "samples_per_turn": "an integer from 10 to 100000",
    "points": "an integer from 10 to 10000",
    "index_error_um": "a number from 0 um",
    "torque_scale": "a number from 0.5 to 2",
    "noise_std": f"a number from 0 {UNITS}",
    "coloured_noise_std": f"a number from 0 {UNITS}",
    "coloured_noise_samples": "a number above 0",
    "resolution": f"a number from 0 {UNITS}",
    "drift_per_turn": f"a number {UNITS}",
    "constant": f"a number {UNITS}; default: drawn where the quantity has an unknown one",
    "gain": "a number from 0.1 to 10",
    "delay_s": "a number from 0 to 0.1 s",
    "resonance_Hz": "a number above 0 Hz",
    "resonance_ratio": "a number above 0, at most 2",
}


class ScatterTable(Table):
    """[scatter]: what is wrong with every real pair."""

    index_error_um: NotNegative = 0.0
    torque_scale: Annotated[float, Field(ge=0.5, le=2.0)] = 1.0


class InstrumentTable(Table):
    """[instrument]: errors of a measuring chain, in the unit of the measured column."""

    noise_std: NotNegative = 0.0
    coloured_noise_std: NotNegative = 0.0
    coloured_noise_samples: Positive = 20.0
    resolution: NotNegative = 0.0
    drift_per_turn: Finite = 0.0
    constant: Finite | None = None
    gain: Annotated[float, Field(ge=0.1, le=10.0)] = 1.0
    delay_s: Annotated[float, Field(ge=0.0, le=0.1)] = 0.0
    resonance_Hz: Positive | None = None
    resonance_ratio: Annotated[float, Field(gt=0.0, le=2.0)] = 0.1


class PlannedRecord(InstrumentTable):
    """[[record]]: one series, with an instrument of its own where it says so."""

    file: Annotated[str, Field(min_length=5, max_length=100, pattern=r"^[^/\\\x00-\x1f]+\.csv$")]
    quantity: str
    pinion_torque_Nm: Positive | None = None
    pinion_speed_rpm: Positive | None = None
    pinion_speeds_rpm: list[Positive] | None = None
    role: Literal["fit", "holdout"] | None = None
    gear: Literal["pinion", "wheel"] | None = None
    tooth: Annotated[int, Field(ge=0, le=999)] | None = None
    tooth_zero: Literal["unknown"] | None = None
    turns: Annotated[float, Field(gt=0.0, le=1000.0)] = 3.0
    samples_per_turn: Annotated[int, Field(ge=10, le=100_000)] = 720
    points: Annotated[int, Field(ge=10, le=10_000)] = 61


class Plan(Table):
    """A whole plan."""

    name: Title
    seed: Annotated[int, Field(ge=0)]
    nominal: Title | None = None
    angle_zero: Literal["unknown", "pitch_point"] = "unknown"
    scatter: ScatterTable = ScatterTable()
    instrument: InstrumentTable = InstrumentTable()
    record: Annotated[list[PlannedRecord], Field(min_length=1)]

    def instrument_of(self, record: PlannedRecord) -> InstrumentTable:
        """Return the instrument of a record: its own keys, then those of [instrument]."""
        own = {key: getattr(record, key) for key in InstrumentTable.model_fields if record.given(key)}
        return self.instrument.model_copy(update=own)


def read_plan(path: str | Path, pair: GearPair) -> Plan:
    """Read a plan.

    Parameters
    ----------
    path : str or Path
        TOML file.
    pair : GearPair
        The gears that are to be measured.

    Returns
    -------
    Plan

    Raises
    ------
    InputError
        One line with file, key, what was found and what is allowed.
    """
    try:
        plan = Plan.model_validate(read_tables(path))
        for number, record in enumerate(plan.record, 1):
            _check(f"record[{number}]", record, pair)
            if record.file in [other.file for other in plan.record[: number - 1]]:
                raise InputError(f"record[{number}].file", shown(record.file), "a file of its own for each record")
    except ValidationError as error:
        problems = error.errors(include_url=False, include_context=False)
        first = min(problems, key=lambda problem: problem["type"] != "extra_forbidden")
        raise _refusal(first["type"], first["loc"], first["input"]).in_file(str(path)) from None
    except InputError as error:
        raise error.in_file(str(path)) from None
    return plan


def _refusal(kind: str, place: tuple[int | str, ...], found: Any) -> InputError:
    where = "".join(f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in place).lstrip(".")
    key = str(next(part for part in reversed(place) if isinstance(part, str)))
    if kind == "extra_forbidden":
        tables: dict[str, type[BaseModel]] = {"record": PlannedRecord, "scatter": ScatterTable, "instrument": InstrumentTable}
        names = list(tables.get(str(place[0]) if len(place) > 1 else "", Plan).model_fields)
        return InputError(where, "an unknown key", nearest(key, names))
    return InputError(where, "nothing" if kind == "missing" else shown(found), WORDS[key])


def _check(where: str, record: PlannedRecord, pair: GearPair) -> None:
    """Refuse keys that a quantity needs and lacks, or that mean nothing with it."""
    if record.quantity not in QUANTITIES:
        raise InputError(f"{where}.quantity", shown(record.quantity), nearest(record.quantity, QUANTITIES))
    quantity = QUANTITIES[record.quantity]
    rules = {
        "pinion_torque_Nm": not quantity.of_gear,
        "pinion_speed_rpm": quantity.moving and quantity.axis == "angle",
        "pinion_speeds_rpm": quantity.axis == "speed",
        "gear": quantity.of_gear,
        "tooth": quantity.axis == "roll",
    }
    for key, needed in rules.items():
        value = getattr(record, key)
        if needed and not value and value != 0:
            raise InputError(f"{where}.{key}", "nothing", f"{WORDS[key]}; {quantity.name} needs it")
        if value is not None and not needed:
            raise InputError(f"{where}.{key}", shown(value), f"nothing: {quantity.name} has no such key")
    teeth = pair.gear(record.gear).teeth
    if record.tooth is not None and record.tooth >= teeth:
        raise InputError(f"{where}.tooth", record.tooth, f"an integer from 0 to {teeth - 1}, the teeth of the {record.gear}")
    if record.tooth_zero and quantity.axis != "tooth":
        raise InputError(f"{where}.tooth_zero", shown(record.tooth_zero), f"nothing: {quantity.name} has no such key")
