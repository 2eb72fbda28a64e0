"""By what explanations of one problem are told apart: scores, labels, and whether nuisances stay."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.index_errors import uneven
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.straying import beyond
from gearfem.effects.effect import Effect
from gearfem.foundation import Array

# Costs in the score, in units of the objective where noise alone is left: of each parameter, and of each tooth or gear tried.
PARAMETER = 8.0
# What a fit may leave of a record, over what can be expected, before another start is tried.
FAR = 2.0
# What a parameter costs that ends at a bound: the shape wants to be another one.
AT_BOUND = 30.0

# Name, gear ("" without, or where either may have it) and tooth (-1 without) of an effect.
Label: TypeAlias = tuple[str, str, int]


def score(problem: Problem, fit: Fit) -> float:
    """Return the score of a fit, by which explanations of one problem are told apart; lower is better.

    Parameters
    ----------
    problem : Problem
        Of the records that were fitted.
    fit : Fit
        Of effects and nuisances, or of nuisances alone.

    Returns
    -------
    float
        Its objective, and what it pays for parameters, for the teeth and gears among which its effects were chosen, and for parameters at
        a bound; errors of model and index that do the work of an effect cost as one must gain.
    """
    pair = problem.campaign.setup.pair
    teeth = 2.0 * math.log(pair.pinion.teeth + pair.wheel.teeth)
    cost = sum(PARAMETER * len(effect.parameters()) + (teeth if hasattr(effect, "tooth") else 0.0) for effect in fit.effects)
    strayed = problem.detected * float((beyond(errors_of(problem, fit)) ** 2).sum())
    return fit.objective + cost + AT_BOUND * len(fit.bound) + strayed


def errors_of(problem: Problem, fit: Fit) -> Array:
    """Return errors of our model in prior deviations, and how far index errors are from those of single teeth, see `uneven`."""
    return np.concatenate([fit.point.unknown[problem.unknowns.first_form :], uneven(problem, fit).ravel()])


def stays(problem: Problem, fit: Fit) -> bool:
    """Return whether scales, errors of our model and index errors of a fit stay where they do the work of no effect."""
    return not problem.strayed(fit.point.unknown).any() and not beyond(errors_of(problem, fit)).any()


def near_by(problem: Problem, fit: Fit) -> bool:
    """Return whether a fit leaves no record far off and its nuisances stay: one from elsewhere would end no better."""
    return stays(problem, fit) and bool((fit.squares / problem.floor).max() < FAR)


def label(effects: tuple[Effect, ...]) -> tuple[Label, ...]:
    """Return names, gears and teeth, by which explanations are told apart."""
    return tuple(sorted((e.name, "" if e.either_gear else getattr(e, "gear", ""), getattr(e, "tooth", -1)) for e in effects))


def simplicity(effects: tuple[Effect, ...]) -> tuple[int, int]:
    """Return how many effects there are, and parameters: of explanations that fit alike the one with fewest is named."""
    return len(effects), sum(len(effect.parameters()) for effect in effects)
