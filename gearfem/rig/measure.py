"""Measurements on the virtual rig: what the model predicts, spoilt as instruments spoil it, written as a campaign."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np

from gearfem.assembly import assemble
from gearfem.definition.calibration import Calibration
from gearfem.definition.setup import Gear, Setup
from gearfem.diagnosis.reading.quantities import QUANTITIES, Quantity
from gearfem.effects.roll import active_flank
from gearfem.foundation import Array
from gearfem.foundation.files import write_csv, write_json
from gearfem.foundation.progress import Progress, quiet
from gearfem.foundation.toml import write_toml
from gearfem.foundation.units import RPM, UM
from gearfem.rig.plan import InstrumentTable, Plan, PlannedRecord
from gearfem.sensing import Request, Resonance, System, observe, requests

# Constants of unknown size are drawn up to here, in the unit of the column: the range of an encoder's zero in um.
LARGEST_CONSTANT = 30.0


def measure(setup: Setup, plan: Plan, nominal: dict[str, Any], out: Path, progress: Progress = quiet) -> list[Path]:
    """Measure a gear pair on the virtual rig and write the campaign.

    Parameters
    ----------
    setup : Setup
        The pair as it truly is, with all its effects.
    plan : Plan
        What is measured, and how.
    nominal : dict
        Tables of the model that the campaign names, as its owner believes it.
    out : Path
        Folder for campaign.toml, nominal.toml, truth.json and the records.
    progress : Progress
        Told after each record.

    Returns
    -------
    list of Path
        Files written.

    Raises
    ------
    InputError, SolveError
        As the prediction does; then nothing is written.

    Notes
    -----
    Index errors, angle zero and each record's errors are drawn from generators of their own, all from the seed: a record
    more or less changes no other one.
    """
    root = np.random.SeedSequence(plan.seed)
    teeth_seed, zero_seed, *seeds = root.spawn(2 + len(plan.record))
    truth = _truth(setup, plan, np.random.default_rng(teeth_seed), np.random.default_rng(zero_seed))
    system = assemble(dataclasses.replace(setup, calibration=truth))
    columns, drawn = {}, {}
    for number, (record, seed) in enumerate(zip(plan.record, seeds, strict=True)):
        progress("records", number, len(plan.record))
        columns[record.file], drawn[record.file] = _series(system, plan, record, np.random.default_rng(seed))
    progress("records", len(plan.record), len(plan.record))
    comments = (f"{plan.name}: virtual rig, seed {plan.seed}",)
    for file, series in columns.items():
        write_csv(out / file, series, comments)
    write_toml(out / "nominal.toml", nominal)
    write_json(out / "truth.json", _told(setup, truth, drawn))
    write_toml(out / "campaign.toml", _campaign(plan))
    return [out / name for name in (*columns, "nominal.toml", "truth.json", "campaign.toml")]


def _truth(setup: Setup, plan: Plan, teeth: np.random.Generator, zero: np.random.Generator) -> Calibration:
    """Draw what is wrong with the pair and its mounting, beside what the model's calibration says."""
    pair, known = setup.pair, setup.calibration
    scatter = plan.scatter.index_error_um * UM

    def late(gear: Gear, before: Array) -> Array:
        drawn = scatter * teeth.standard_normal(gear.teeth)
        return drawn + before if before.size else drawn

    pinion, wheel = late(pair.pinion, known.pinion_late), late(pair.wheel, known.wheel_late)
    offset = zero.uniform(-0.5, 0.5) * pair.pinion.pitch_angle if plan.angle_zero == "unknown" else 0.0
    return dataclasses.replace(
        known,
        torque_scale=known.torque_scale * plan.scatter.torque_scale,
        angle_offset=known.angle_offset + offset,
        pinion_late=pinion,
        wheel_late=wheel,
        offsets=(),
    )


def _series(system: System, plan: Plan, record: PlannedRecord, random: np.random.Generator) -> tuple[dict[str, Array], dict[str, float]]:
    """Return the columns of a record in the units of its file, and what was drawn for it."""
    quantity, chain = QUANTITIES[record.quantity], plan.instrument_of(record)
    gear = system.setup.pair.gear(record.gear)
    first = int(random.integers(gear.teeth)) if record.tooth_zero else 0
    request, turns = planned(system.setup, record, first)
    axis = request.axis - first
    value = observe(dataclasses.replace(system, instrument=_instrument(system, chain)), request) / quantity.factors[1]
    constant = chain.constant
    if constant is None:
        constant = float(random.uniform(-LARGEST_CONSTANT, LARGEST_CONSTANT)) if quantity.free_constant else 0.0
    value = _spoilt(value + constant, turns, chain, random)
    return dict(zip(quantity.columns, (axis / quantity.factors[0], value), strict=True)), {"constant": constant, "first_tooth": first}


def planned(setup: Setup, record: PlannedRecord, first: int = 0) -> tuple[Request, Array]:
    """Return what a planned record asks of a system, from its first tooth on, and how many turns have passed there.

    Parameters
    ----------
    setup : Setup
        The pair.
    record : PlannedRecord
        Of a plan.
    first : int
        First tooth of a record over teeth.

    Returns
    -------
    request : Request
    turns : ndarray, shape (n,)
    """
    gear = setup.pair.gear(record.gear)
    axis, turns = _axis(setup, record, QUANTITIES[record.quantity], gear)
    request = requests()[record.quantity](
        axis=axis + first,
        pinion_torque=record.pinion_torque_Nm or 0.0,
        pinion_speed=(record.pinion_speed_rpm or 0.0) * RPM,
        gear=record.gear or "pinion",
        tooth=record.tooth or 0,
        file=record.file,
    )
    return request, turns


def _instrument(system: System, chain: InstrumentTable) -> Any:
    """Return the instrument of the system with the planned chain behind it."""
    before = system.instrument
    more = () if chain.resonance_Hz is None else (Resonance(frequency=chain.resonance_Hz, ratio=chain.resonance_ratio),)
    return dataclasses.replace(
        before, gain=before.gain * chain.gain, delay=before.delay + chain.delay_s, resonances=(*before.resonances, *more)
    )


def _axis(setup: Setup, record: PlannedRecord, quantity: Quantity, gear: Gear) -> tuple[Array, Array]:
    """Return where the record is taken [SI], and how many turns have passed there."""
    if quantity.axis == "angle":
        turns = np.arange(round(record.turns * record.samples_per_turn)) / record.samples_per_turn
        return 2.0 * math.pi * turns, turns
    if quantity.axis == "tooth":
        teeth = np.arange(float(max(round(record.turns * gear.teeth), 1)))
        return teeth, teeth / gear.teeth
    if quantity.axis == "roll":
        active = active_flank(setup, record.gear or "pinion")
        return np.linspace(active.lowest, active.tip, record.points), np.zeros(record.points)
    speeds = np.sort(np.array(record.pinion_speeds_rpm, float)) * RPM
    return speeds, np.zeros(len(speeds))


def _spoilt(value: Array, turns: Array, chain: InstrumentTable, random: np.random.Generator) -> Array:
    """Return readings with drift, coloured and white noise, then rounded to the steps of the converter."""
    count = len(value)
    white, pushed = random.standard_normal(count), random.standard_normal(count)
    kept = math.exp(-1.0 / chain.coloured_noise_samples)
    coloured = np.empty(count)
    state = pushed[0]
    for place in range(count):
        state = kept * state + math.sqrt(1.0 - kept**2) * pushed[place] if place else pushed[0]
        coloured[place] = state
    read = value + chain.drift_per_turn * turns + chain.coloured_noise_std * coloured + chain.noise_std * white
    return np.round(read / chain.resolution) * chain.resolution if chain.resolution > 0.0 else read


def _told(setup: Setup, truth: Calibration, drawn: dict[str, dict[str, float]]) -> dict[str, Any]:
    """Return what the rig knows and a diagnosis has to find."""
    return {
        "effects": [effect.table() for effect in setup.effects if hasattr(effect, "table")],
        "stiffness_scale": truth.stiffness_scale,
        "torque_scale": truth.torque_scale,
        "angle_offset_rad": truth.angle_offset,
        "pinion_index_error_um": truth.pinion_late / UM,
        "wheel_index_error_um": truth.wheel_late / UM,
        "records": drawn,
    }


def _campaign(plan: Plan) -> dict[str, Any]:
    keys = ("file", "quantity", "pinion_torque_Nm", "pinion_speed_rpm", "role", "gear", "tooth", "tooth_zero")
    records = []
    for record in plan.record:
        quantity, chain = QUANTITIES[record.quantity], plan.instrument_of(record)
        entry: dict[str, Any] = {key: getattr(record, key) for key in keys if getattr(record, key) is not None}
        if quantity.axis == "angle":
            entry.setdefault("pinion_speed_rpm", 0.0)
        if chain.noise_std or chain.coloured_noise_std:
            entry["noise_std"] = math.hypot(chain.noise_std, chain.coloured_noise_std)
        records.append(entry)
    return {"name": plan.name, "model": "nominal.toml", "angle_zero": plan.angle_zero, "record": records}
