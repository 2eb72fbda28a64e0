"""The life of a worn pair on disk: its history, the worn flanks as points, and a model that names them."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gearfem.definition.measured_points import farthest_roll
from gearfem.definition.setup import Member
from gearfem.flank import Deviation, Outline, make_flanks
from gearfem.foundation import Array
from gearfem.foundation.files import write_csv
from gearfem.foundation.toml import write_toml
from gearfem.foundation.units import MM, MPA, UM
from gearfem.report.summary import identity
from gearfem.wear import Life
from gearfem.wear.volume import MM3

MEMBERS: tuple[Member, Member] = ("pinion", "wheel")
# As many as the fit of measured points needs to follow a worn flank to a few micrometres.
POINTS = 400


def write_life(life: Life, out: Path) -> Path:
    """Write wear.csv: depths, volumes, transmission error and pressure over the life.

    Parameters
    ----------
    life : Life
        From `gearfem.wear.wear_over`.
    out : Path
        Folder.

    Returns
    -------
    Path
        The file; depths count from the beginning of this life, volumes from the involute.
    """
    path = Path(out) / "wear.csv"
    columns: dict[str, Any] = {"time_h": life.hours, "pinion_turns": life.turns}
    columns |= {f"{member}_depth_um": life.depth(member).max(axis=1) / UM for member in MEMBERS}
    columns |= {"pinion_volume_mm3": life.pinion_volume / MM3, "wheel_volume_mm3": life.wheel_volume / MM3}
    columns |= {
        "transmission_error_peak_to_peak_um": life.transmission_error / UM,
        "contact_pressure_MPa": life.contact_pressure / MPA,
    }
    write_csv(path, columns, (identity(life.setup), law_sentence(life), *life.remarks))
    return path


def law_sentence(life: Life) -> str:
    """Say by which coefficients a pair has worn."""
    law = life.law
    dirt = f", of rolling {law.rolling:g} as if it slid" if law.rolling else ""
    return (
        f"Archard's law, k = {law.pinion_coefficient:g} (pinion) and {law.wheel_coefficient:g} (wheel) per Pa{dirt}; "
        f"{life.hours[-1]:g} h at {life.setup.operation.pinion_torque:g} N m, quasi-static load."
    )


def worn_flank(life: Life, member: Member, tooth: int | None = None) -> tuple[Array, Array]:
    """Return the flank of a gear at the end of its life as points of a model file.

    Parameters
    ----------
    life : Life
        Of the pair.
    member : {"pinion", "wheel"}
        Gear.
    tooth : int, optional
        One that was measured for itself; by default all others.

    Returns
    -------
    roll, depth : ndarray, shape (n,)
        From the form circle to where the worn flank ends [m]; what effects of the model take is not in it, since they act
        on the worn model too.
    """
    flanks = make_flanks(life.setup)
    outline = flanks.of(member) if tooth is None else flanks.odd(member)[tooth]
    before = outline.deviation or Deviation.none(outline.gear)
    after = before.plus(lambda roll: life.depth(member)[-1])
    worn = Outline(gear=outline.gear, deviation=after)
    # A flank worn by a tenth of a module and more meets the tip circle at roll lengths that tables of points leave out.
    end = min(worn.flank_end, (1.0 - 1e-9) * farthest_roll(outline.gear))
    roll = np.linspace(worn.flank_start, end, POINTS)
    return roll, after.at(roll)


def write_worn_model(life: Life, tables: Mapping[str, Any], out: Path, name: str) -> tuple[Path, ...]:
    """Write a model of the worn pair, worn.toml, and its flanks, worn_pinion.csv and worn_wheel.csv.

    Parameters
    ----------
    life : Life
        Of the pair.
    tables : mapping
        Tables of the model before.
    out : Path
        Folder.
    name : str
        Title of the worn model.

    Returns
    -------
    tuple of Path
        The files, the model last.
    """
    worn: dict[str, Any] = copy.deepcopy(dict(tables))
    worn["name"] = name
    files, comments = [], (identity(life.setup), law_sentence(life), *life.remarks)
    for member in MEMBERS:
        worn[member]["flank"] = []
        for tooth in (None, *sorted(make_flanks(life.setup).odd(member))):
            file = f"worn_{member}.csv" if tooth is None else f"worn_{member}_tooth_{tooth}.csv"
            roll, depth = worn_flank(life, member, tooth)
            write_csv(Path(out) / file, {"roll_length_mm": roll / MM, "deviation_um": depth / UM}, comments)
            worn[member]["flank"].append({"file": file} if tooth is None else {"file": file, "tooth": tooth})
            files.append(Path(out) / file)
    write_toml(Path(out) / "worn.toml", worn)
    return (*files, Path(out) / "worn.toml")
