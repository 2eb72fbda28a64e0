"""Motions whose flanks hammer: means over their pitches tell of all teeth only where their rows are met too."""

from __future__ import annotations

import dataclasses

from gearfem.diagnosis.comparing.averages import hammering
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.calibrate import calibrated, left_of
from gearfem.diagnosis.naming.naming import Naming
from gearfem.diagnosis.reading.measurement import Measurement

# What names may leave of rows over what nuisances alone leave, before a mean speaks for nothing; and what is little enough to be met.
WORSE, MET = 1.2, 0.5


def untold(problem: Problem, naming: Naming) -> tuple[str, ...]:
    """Return the files of motions whose flanks hammer and of whose rows names by the means leave more than nuisances alone do.

    Parameters
    ----------
    problem : Problem
        Of the records row by row.
    naming : Naming
        Of their means.

    Returns
    -------
    tuple of str

    Notes
    -----
    Once flanks part, the mean over the pitches is that of a motion that does not come back with the pitch: a ripple that nobody knows of
    moves it as a backlash would, which leaves the rows farther off.
    """
    if not naming.fit.effects:
        return ()
    fits, found = (naming.alone, naming.fit), []
    benches = [problem.bench(fit.effects) for fit in fits]
    for record in problem.records:
        if record.erratic or not any(hammering(record, bench, fit.settings) > 0.0 for bench, fit in zip(benches, fits, strict=True)):
            continue
        before, after = (_rms(problem, record, fit) for fit in fits)
        if after > WORSE * before:
            found.append(record.file)
    return tuple(found)


def left_open(problem: Problem, files: tuple[str, ...], naming: Naming) -> Naming:
    """Return a verdict once records that its means leave out have been looked at: what is named does not explain those that stay open."""
    missed = [
        record.file
        for record in problem.records
        if record.file in files and _rms(problem, record, naming.fit) > MET * _rms(problem, record, naming.alone)
    ]
    naming = dataclasses.replace(naming, untold=files) if files else naming
    if not missed or not naming.fit.effects:
        return naming
    reason = f"Left out of the means, and open: {', '.join(missed)}, whose flanks hammer; names by their means left their rows worse."
    return naming.with_rest(reason)


def _rms(problem: Problem, record: Measurement, fit: Fit) -> float:
    """Return the root mean square that a fit leaves of a record [SI]."""
    left, _, _ = left_of(record, calibrated(problem.campaign.setup, fit.settings, fit.effects))
    return record.rms(left)
