"""Transmission errors of the other sign: a wheel that leads where it should lag."""

from __future__ import annotations

import copy
import dataclasses
import math
from pathlib import Path

from gearfem.diagnosis.fitting.approach import FAR_OFF, ROUGH, from_zeros, part_of
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.foundation import InputError

# What a fit of the other sign may leave of a record at most to be believed, in parts of what can be expected and of what the other leaves.
BELIEVED, BETTER = 2.0, 0.25


def refuse_mirrored(problem: Problem, fit: Fit) -> None:
    """Refuse slow transmission errors that nuisances meet well with the other sign, and leave far off as they are.

    Parameters
    ----------
    problem : Problem
        Records that may be fitted, without errors of the model.
    fit : Fit
        Nuisances alone, roughly.

    Raises
    ------
    InputError
        That names the first of these records.

    Notes
    -----
    A mesh has its own course: of 72 campaigns of two simulators, with effects and without, turned over four left less than 4 times the
    expected square, with any zero of the pinion angle; nuisances meet these within 2 times as they are. One that an effect leaves far off
    either way is not refused.
    """
    slow = [i for i, record in enumerate(problem.records) if record.quantity.name == "static_transmission_error"]
    off = fit.squares / problem.floor
    if not slow or off[slow].max() <= FAR_OFF:
        return
    turned = copy.copy(problem)
    turned.records = tuple(dataclasses.replace(record, value=-record.value) for record in problem.records)
    few = part_of(turned, slow)
    left = min((float((one.squares / few.floor).max()) for one in from_zeros(few, ROUGH)), default=math.inf)
    if left < min(BELIEVED, BETTER * off[slow].max()):
        record = problem.records[slow[0]]
        found = f"what the model meets turned over: {left:.2g} times the expected square is left so, {off[slow].max():.3g} times as it is"
        file = Path(problem.campaign.path).parent / record.file
        raise InputError(f"column {record.quantity.columns[1]}", found, "positive where the wheel lags", str(file))
