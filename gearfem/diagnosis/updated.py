"""The model with everything that a diagnosis found in it, as a model file that every other command runs."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

from gearfem.definition.calibration import Calibration
from gearfem.definition.model_file import read_tables
from gearfem.definition.setup import GearPair, Setup
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.modelling.calibrate import calibration_of
from gearfem.diagnosis.proving.proof import Gap, Proof
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.effects.effect import MEMBERS, Effect
from gearfem.foundation.toml import write_toml
from gearfem.foundation.units import UM, factor

# Stands for infinity, which files do not take, in the unit of any key.
ENDLESS = 1e15


def write_updated(campaign: Campaign, fit: Fit, proof: Proof, path: Path) -> Path:
    """Write the campaign's model with named effects and fitted nuisances.

    Parameters
    ----------
    campaign : Campaign
        Whose model it is; its keys are kept as they are.
    fit : Fit
        Effects and nuisances.
    proof : Proof
        With the constants of all records.
    path : Path
        Target file; files of measured flanks are counted from its folder.

    Returns
    -------
    Path

    Notes
    -----
    What the model's own [calibration] says stays in the sum: scales are multiplied, angles, index errors and constants added.
    """
    tables = read_tables(campaign.model)
    for member in MEMBERS:
        if "flank" in tables[member]:
            flanks = [
                {**flank, "file": _moved(flank["file"], Path(campaign.model).parent, path.parent)} for flank in tables[member]["flank"]
            ]
            tables[member] = {**tables[member], "flank": flanks}
    if fit.effects:
        tables["effect"] = [*tables.get("effect", []), *(effect_table(effect, campaign.setup) for effect in fit.effects)]
    tables["calibration"] = calibration_table(campaign.setup.calibration, fit.settings, proof, campaign.setup.pair)
    write_toml(path, tables)
    return path


def effect_table(effect: Effect, setup: Setup) -> dict[str, str | int | float]:
    """Return an effect as a table of a model file, every digit kept; values at a bound are read as within it.

    Parameters
    ----------
    effect : Effect
        As fitted.
    setup : Setup
        The pair it is on.
    """
    table = effect.table()
    for field, known in effect.parameters().items():
        key = effect.key(field)
        low, high = known.bounds(setup, effect.member)
        value = min(getattr(effect, field) / factor(key), ENDLESS)
        # Dividing by the unit may round across the bound; the next number inwards does not.
        while not low <= value * factor(key) <= high:
            value = math.nextafter(value, 0.5 * (low + min(high, ENDLESS)) / factor(key))
        table[key] = value
    return table


def calibration_table(known: Calibration, settings: Settings, proof: Proof, pair: GearPair) -> dict[str, Any]:
    """Return [calibration] with fitted nuisances on top of those that the model has."""
    both = calibration_of(known, settings)
    own = [gap for gap in proof.records if gap.measurement.quantity.free_constant or any(gap.measurement.kick)]
    return {
        "stiffness_scale": both.stiffness_scale,
        "torque_scale": both.torque_scale,
        "inertia_scale": both.inertia_scale,
        "damping_scale": both.damping_scale,
        "gain": both.gain,
        "series_compliance_um_per_N": both.series_compliance / UM,
        "coupling_scale": both.coupling_scale,
        "tip_edge_scale": both.tip_edge_scale,
        "contact_compliance_scale": both.contact_scale,
        "body_compliance_scale": both.body_scale,
        "contact_depth_scale": both.depth_scale,
        "contact_evenness": both.evenness,
        "friction_coefficient": both.friction,
        "misalignment_um": both.misalignment / UM,
        "centre_distance_um": both.centre_distance / UM,
        "angle_offset_rad": both.angle_offset,
        "pinion_index_error_um": (both.pinion_late / UM).tolist(),
        "wheel_index_error_um": (both.wheel_late / UM).tolist(),
        "record": [_record(known, gap, pair) for gap in own],
    }


def _record(known: Calibration, gap: Gap, pair: GearPair) -> dict[str, Any]:
    """Return the constant of a record, its first tooth where that was sought, and how its motion begins."""
    record = gap.measurement
    table: dict[str, Any] = {"file": record.file, "offset_um": (known.offset(record.file) + gap.offset) / UM}
    if not record.tooth_known:
        teeth = pair.gear(record.gear).teeth
        table["first_tooth"] = (known.first_tooth(record.file) + gap.first_tooth) % teeth
    if any(record.kick):
        table["kick"] = list(record.kick)
    return table


def _moved(file: str, source: Path, target: Path) -> str:
    """Return the name of a file counted from another folder."""
    return Path(os.path.relpath((source / file).resolve(), target.resolve())).as_posix()
