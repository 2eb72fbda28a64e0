"""The measured flanks of a model file, [[pinion.flank]] and [[wheel.flank]], read and referred to their gears."""

from __future__ import annotations

import json
from pathlib import Path

from gearfem.definition.measured_flank import MeasuredFlank
from gearfem.definition.measured_points import read_flank
from gearfem.definition.schema import Model
from gearfem.definition.setup import GearPair, Member
from gearfem.foundation import InputError

MEMBERS: tuple[Member, Member] = ("pinion", "wheel")


def resolve_flanks(model: Model, pair: GearPair, folder: Path, notes: list[str]) -> tuple[MeasuredFlank, ...]:
    """Return the measured flanks of both gears.

    Parameters
    ----------
    model : Model
        Validated tables.
    pair : GearPair
        Nominal gears.
    folder : Path
        Folder of the model file, from which the names of files are counted.
    notes : list of str
        Takes one sentence for each flank.

    Raises
    ------
    InputError
        If a tooth does not exist or is given twice, or a file cannot be used.
    """
    found: list[MeasuredFlank] = []
    for member in MEMBERS:
        table, gear = (model.pinion, pair.pinion) if member == "pinion" else (model.wheel, pair.wheel)
        given: set[int | None] = set()
        for place, entry in enumerate(table.flank, 1):
            where = f"{member}.flank[{place}]"
            if entry.tooth is not None and entry.tooth >= gear.teeth:
                raise InputError(f"{where}.tooth", entry.tooth, f"from 0 up to {gear.teeth - 1}, the last tooth of the {member}")
            if entry.tooth in given:
                whose = "all teeth" if entry.tooth is None else f"tooth {entry.tooth}"
                raise InputError(f"{where}.tooth", f"{whose} again", "one flank for each tooth, and one for all others")
            given.add(entry.tooth)
            path = folder / entry.file
            if not path.is_file():
                allowed = "the name of a CSV file, counted from the folder of the model file"
                raise InputError(f"{where}.file", f"{json.dumps(entry.file, ensure_ascii=False)}, no such file", allowed)
            flank = read_flank(path, entry.file, member, entry.tooth, gear)
            notes.append(f"Flank of the {flank.name}: {flank.roll.size} measured points, given in {flank.system}.")
            found.append(flank)
    return tuple(found)
