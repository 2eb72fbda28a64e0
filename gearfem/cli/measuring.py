"""The commands of the virtual rig: plan and nominal model read, campaign or responses written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from gearfem.cli.steps import Done
from gearfem.definition.model_file import read_tables, with_overrides
from gearfem.definition.setup import Setup
from gearfem.diagnosis.diagnose import choose
from gearfem.diagnosis.reading.quantities import QUANTITIES
from gearfem.effects import Effect
from gearfem.effects.catalogue import catalogue
from gearfem.effects.effect import MEMBERS
from gearfem.foundation import InputError
from gearfem.foundation.files import write_csv
from gearfem.foundation.progress import Progress
from gearfem.foundation.units import factor
from gearfem.model import load_model
from gearfem.rig import Plan, measure, read_plan
from gearfem.rig.measure import planned
from gearfem.templates import templates

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


def run_templates(
    setup: Setup,
    plan_file: str,
    only: Sequence[str],
    tooth: int,
    strength: float,
    further: Sequence[type[Effect]],
    out: Path,
    progress: Progress,
) -> Done:
    """Write the responses of planned records per unit parameter.

    Parameters
    ----------
    setup : Setup
        The pair; its own effects belong to the baseline.
    plan_file : str
        The plan.
    only : sequence of str
        Names of effects; by default the whole catalogue.
    tooth : int
        Tooth of effects of one tooth.
    strength : float
        Part of the typical size.
    further : sequence of type
        Effects beside the catalogue.
    out : Path
        Folder.
    progress : Progress
        Told after each parameter.

    Returns
    -------
    Done

    Raises
    ------
    InputError
        If the plan, a name, the tooth or the strength cannot be used.
    """
    plan, kinds = read_plan(plan_file, setup.pair), choose(catalogue(further), only, ())
    if not 0 <= tooth < min(setup.pair.pinion.teeth, setup.pair.wheel.teeth):
        raise InputError("--tooth", tooth, f"0 to {min(setup.pair.pinion.teeth, setup.pair.wheel.teeth) - 1}, a tooth of either gear")
    if not 0.0 < strength <= 1.0:
        raise InputError("--strength", strength, "a number above 0, up to 1")
    effects = [kind.example(setup, member, tooth) for kind in kinds.values() for member in (MEMBERS if kind.of_one_gear() else MEMBERS[:1])]
    table = templates(setup, effects, [planned(setup, record)[0] for record in plan.record], strength, progress)
    files = []
    for number, record in enumerate(plan.record):
        quantity = QUANTITIES[record.quantity]
        series = table.requests[number].axis, table.baseline[number]
        columns: dict[str, ArrayLike] = {
            name: part / unit for name, part, unit in zip(quantity.columns, series, quantity.factors, strict=True)
        }
        for name, column, (effect, field) in zip(table.names, table.response[number].T, table.parameters, strict=True):
            unit = factor(effect.key(field))
            columns[name] = column * (1.0 / unit if effect.parameters()[field].reciprocal else unit) / quantity.factors[1]
        files.append(out / f"templates_{record.file}")
        write_csv(files[-1], columns, (f"{setup.name}: change of {quantity.columns[1]} per unit of each parameter",))
    return Done([f"{len(table.names)} parameters of {len(effects)} effects, {len(plan.record)} records"], files)


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
