"""The command that lets flanks wear: a life computed, its history, the worn flanks and a model of them written."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gearfem.assembly import effects_in
from gearfem.cli.notices import ENGAGED, along_width, unseen
from gearfem.cli.steps import Done
from gearfem.definition.model_file import read_tables, with_overrides
from gearfem.definition.setup import Setup
from gearfem.flank import fitted_flanks
from gearfem.foundation import InputError
from gearfem.foundation.progress import Progress
from gearfem.foundation.units import UM
from gearfem.model import load_model
from gearfem.report.wear_plots import write_wear_pictures
from gearfem.report.wear_table import MEMBERS, law_sentence, worn_flank, write_life, write_worn_model
from gearfem.wear import Archard, Life, wear_over
from gearfem.wear.volume import MM3


def run_wear(
    setup: Setup,
    model: str,
    overrides: Sequence[str],
    hours: float,
    coefficients: tuple[float, float],
    rolling: float,
    out: Path,
    progress: Progress,
) -> Done:
    """Wear a pair over some hours.

    Parameters
    ----------
    setup : Setup
        The pair.
    model : str
        Its file.
    overrides : sequence of str
        Keys that replace the file's.
    hours : float
        Time at the operation's speed and torque [h].
    coefficients : (float, float)
        Of pinion and wheel [1/Pa].
    rolling : float
        Part of rolling that wears as sliding does.
    out : Path
        Folder; nothing is written before the end of the life.
    progress : Progress
        Told how much of it is done.

    Returns
    -------
    Done
    """
    if not (math.isfinite(hours) and hours > 0.0):
        raise InputError("--hours", hours, "a number above 0 h")
    try:
        law = Archard(pinion_coefficient=coefficients[0], wheel_coefficient=coefficients[1], rolling=rolling)
    except InputError as error:
        option = "--rolling" if error.where == "rolling" else "--coefficient, --wheel-coefficient"
        raise InputError(option, error.found, error.allowed) from None
    turns = hours * 3600.0 * setup.operation.pinion_speed / (2.0 * math.pi)
    try:
        life = wear_over(setup, law, turns, progress=progress)
    except InputError as error:
        raise _named(error, setup) from None
    tables, _ = with_overrides(read_tables(model), overrides)
    files = [write_life(life, out), *write_worn_model(life, tables, out, f"{setup.name}, worn over {life.hours[-1]:.6g} h")]
    lines = [law_sentence(life), *life.remarks, *_lines(life), _followed(life, files[-1]), *unseen(setup, ENGAGED)]
    return Done(lines, [*files, *write_wear_pictures(life, out)])


def _named(error: InputError, setup: Setup) -> InputError:
    """Return a refusal that names the option, or the effects, behind it: lives too long, flanks that are not parallel."""
    if error.where == "turns of the pinion":
        return InputError("--hours", error.found, error.allowed)
    along = [effect for effect in effects_in(setup) if effect.stage == "flank" and along_width(effect, setup)]
    names = sorted({effect.name for effect in along})
    if error.where != "model" or not names:
        return error
    return InputError("effect", f"{' and '.join(names)}, which gearfem wear does not take", "effects that are the same for all widths")


def _lines(life: Life) -> list[str]:
    volumes = {"pinion": life.pinion_volume, "wheel": life.wheel_volume}
    lines = [
        f"{member}: up to {life.depth(member)[-1].max() / UM:.4g} um deep, {volumes[member][-1] / MM3:.4g} mm3 missing from a flank"
        for member in MEMBERS
    ]
    swing = life.transmission_error[[0, -1]] / UM
    return [*lines, f"transmission error, peak to peak: {swing[0]:.4g} um before, {swing[1]:.4g} um after ({life.turns.size - 1} steps)"]


def _followed(life: Life, model: Path) -> str:
    """Say how closely the fit that every command makes of the points follows the worn flanks."""
    away: dict[str, float] = {}
    try:
        fits = fitted_flanks(load_model(model))
    except InputError as error:
        return f"these flanks are worn beyond what a model takes: {error}"
    for fit in fits:
        roll, depth = worn_flank(life, fit.points.member, fit.points.tooth)
        gear = fit.points.member if fit.points.tooth is None else f"{fit.points.member}, tooth {fit.points.tooth}"
        away[gear] = float(np.abs(fit.deviation.at(roll) - depth).max())
    worst = ", ".join(f"{value / UM:.2g} um ({member})" for member, value in away.items())
    return f"the fit of these points, which every command takes, follows the worn flanks to {worst}"
