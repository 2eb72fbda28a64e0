"""What effects of single teeth and turns gain by themselves, and not by where index errors and waviness act beside them."""

from __future__ import annotations

import copy

from gearfem.diagnosis.comparing.averages import shows_in_means
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.score import score


def borrowed(problem: Problem, fit: Fit) -> str:
    """Return which effect of a fit gains too little by itself, in words; empty if none does.

    Parameters
    ----------
    problem : Problem
        Nuisances standing still; it stays as it is prepared.
    fit : Fit
        Any.

    Raises
    ------
    InputError, SolveError
        If the records cannot be computed without one of the effects.

    Notes
    -----
    Index errors and waviness act linearly about one point, and otherwise under other effects. Waviness that is large beside the deflection
    acts otherwise still: an effect that changes hardly more than these columns may come nearer to that, without being there. Columns are
    those under all effects of the fit here, whether one of them is left out or not. By itself an effect must gain as much as scores of one
    explanation may differ by where fits begin.
    """
    asked = [effect for effect in fit.effects if not shows_in_means(effect)]
    if not asked:
        return ""
    own = copy.copy(problem)
    own.prepare(fit.effects, fit.point.stood)
    stands = score(own, own.fit(fit.effects, fit.point.stood, rounds=0))
    for effect in asked:
        others = tuple(one for one in fit.effects if one is not effect)
        without = score(own, own.fit(others, fit.point.stood))
        if without - stands < problem.wander:
            # First fits have been led by other columns.
            stands = min(stands, score(own, own.fit(fit.effects, fit.point.stood)))
        if without - stands < problem.wander:
            return (
                f"{effect.describe()}: gains {without - stands:.0f} in the score by itself, less than {problem.wander:.0f}; "
                "the rest is what it makes of waviness and index errors"
            )
    return ""
