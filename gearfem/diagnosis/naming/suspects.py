"""Nuisances, errors of the model and index errors that do the work of something that is missing."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.index_errors import uneven
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.score import stays
from gearfem.diagnosis.fitting.straying import LOST, STRAYED
from gearfem.diagnosis.naming.gap import gap_left, wide
from gearfem.diagnosis.naming.search import Search
from gearfem.effects.effect import MEMBERS

# Prior deviations of a nuisance at which it does the work of something that is missing.
ASTRAY = 4.0
# Chance of nuisances and errors of the model as far off together, below which they do the work of an effect.
UNLIKELY = 0.01


def sound(search: Search) -> bool:
    """Return whether nuisances alone leave no gap and do the work of no effect, none of them by itself nor all together."""
    problem, alone = search.problem, search.alone
    return gap_left(alone, problem) < 1.0 and stays(problem, alone) and not improbable(problem, alone) and not wide(problem, alone)


def astray(search: Search) -> list[tuple[str, float]]:
    """Return the nuisances that stand too far off to be nuisances in the fit without effects, in prior deviations.

    Only those on which the records insist: to come back to what costs nothing would lose what counts as detected.
    """
    problem, alone = search.problem, search.alone
    moved = alone.point.unknown[: problem.outer]
    deviations = problem.beside(()).whole.weighed(alone.point.weights).deviations
    deviation = deviations[len(deviations) - problem.outer :]
    insists = (np.abs(moved) - STRAYED) ** 2 > search.problem.detected * deviation**2
    return [(problem.nuisances[at].words, float(moved[at])) for at in problem.unknowns.scales if insists[at] and abs(moved[at]) >= ASTRAY]


def turning(problem: Problem, fit: Fit) -> list[tuple[str, float]]:
    """Return the gears on which index errors of a fit hold waves once to three times a turn that no teeth have by chance."""
    waves = zip(MEMBERS, uneven(problem, fit)[1], strict=True)
    return [(f"a wave of the index errors of the {gear}", float(size)) for gear, size in waves if size > LOST]


def misshapen(problem: Problem, fit: Fit) -> list[tuple[str, float]]:
    """Return the errors of our model in a fit that are too large to be any.

    Variants, forms common to all teeth together (the root of their squares: of six healthy pairs it was 2.1 at most), the way over which
    friction turns round, what the damper acts on, and the rise of the largest Kw by waviness.
    """
    unknowns, unknown = problem.unknowns, fit.point.unknown
    moved = (
        ("forms common to all teeth, together", np.linalg.norm(unknown[unknowns.forms])),
        ("way over which friction turns round", np.linalg.norm(unknown[unknowns.ways])),
        ("what the damper acts on", unknown[unknowns.touch]),
        ("rise of the largest Kw by waviness", unknown[-1]),
    )
    return [*wrong_by(problem, fit), *((word, float(one)) for word, one in moved if abs(one) > LOST)]


def wrong_by(problem: Problem, fit: Fit) -> list[tuple[str, float]]:
    """Return the variants of the model in a fit that are too far off to be any: what is missing stands behind them."""
    moved = zip(problem.unknowns.errors, fit.point.unknown[problem.unknowns.wrong], strict=True)
    return [(f"error of the model, {variant.words},", float(one)) for variant, one in moved if abs(one) > LOST]


def improbable(problem: Problem, fit: Fit) -> bool:
    """Return whether nuisances and errors of the model in a fit are farther off than healthy ones are together, whatever the zero is."""
    unknowns = problem.unknowns
    own = [place for place, nuisance in enumerate(problem.nuisances) if nuisance.name != "angle_offset"]
    moved = np.concatenate([fit.point.unknown[own], fit.point.unknown[unknowns.wrong]])
    return bool(moved.size) and float(chi2.sf(moved @ moved, moved.size)) < UNLIKELY
