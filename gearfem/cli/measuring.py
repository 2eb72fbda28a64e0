"""The command of the virtual rig: plan and nominal model read, campaign written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gearfem.cli.steps import Done
from gearfem.definition.model_file import read_tables, with_overrides
from gearfem.definition.setup import Setup
from gearfem.foundation import InputError
from gearfem.foundation.progress import Progress
from gearfem.model import load_model
from gearfem.rig import Plan, measure, read_plan

HIDDEN = ("effect", "calibration")


def run_plan(setup: Setup, model: str, overrides: Sequence[str], plan_file: str, out: Path, progress: Progress) -> Done:
    """Measure a model as a plan says.

    Parameters
    ----------
    setup : Setup
        The pair as it truly is.
    model : str
        Its file.
    overrides : sequence of str
        Keys that replace the file's.
    plan_file : str
        The plan.
    out : Path
        Folder of the campaign.
    progress : Progress
        Told after each record.

    Returns
    -------
    Done

    Raises
    ------
    InputError
        If the plan, or the nominal model that it names, cannot be used.
    """
    plan = read_plan(plan_file, setup.pair)
    files = measure(setup, plan, _nominal(plan, Path(plan_file), model, overrides), out, progress)
    hidden = [effect.describe() for effect in setup.effects if hasattr(effect, "describe")]
    lines = [f"{len(plan.record)} records, seed {plan.seed}; hidden: {'; '.join(hidden) or 'no effect'}"]
    return Done([*lines, "truth.json says what was drawn: keep it from whoever is to find out"], files)


def _nominal(plan: Plan, plan_file: Path, model: str, overrides: Sequence[str]) -> dict[str, Any]:
    """Return the model that the campaign names: the plan's, or the measured one without all that is to be found."""
    if plan.nominal is None:
        tables, _ = with_overrides(read_tables(model), overrides)
        tables = {key: value for key, value in tables.items() if key not in HIDDEN}
        return {key: _without_flanks(value) if key in ("pinion", "wheel") else value for key, value in tables.items()}
    path = plan_file.parent / plan.nominal
    if load_model(path).flanks_given:
        raise InputError("nominal", f'"{plan.nominal}", which names files of measured flanks', "a model without them", str(plan_file))
    return read_tables(path)


def _without_flanks(table: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in table.items() if key != "flank"}
