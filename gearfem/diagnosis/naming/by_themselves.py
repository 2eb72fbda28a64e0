"""What effects of single teeth and turns gain by themselves, and not by where index errors and waviness act beside them."""

from __future__ import annotations

import copy

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.effects.effect import Effect


def gained_by_themselves(problem: Problem, fit: Fit) -> tuple[float, ...]:
    """Return what each effect of a fit gains over the others, columns of index errors and waviness as they are under all of them.

    Parameters
    ----------
    problem : Problem
        Nuisances standing still; it stays as it is prepared.
    fit : Fit
        Any.

    Returns
    -------
    tuple of float

    Notes
    -----
    Index errors and waviness act linearly about one point, and otherwise under other effects. Waviness that is large beside the deflection
    acts otherwise still: an effect that changes hardly more than the columns may come nearer to that, without being there.
    """
    own = copy.copy(problem)
    own.prepare(fit.effects, fit.point.stood)
    whole = own.fit(fit.effects, fit.point.stood, rounds=0).objective
    without = (fit.effects[:out] + fit.effects[out + 1 :] for out in range(len(fit.effects)))
    return tuple(own.fit(others, fit.point.stood).objective - whole for others in without)


def least_beside(problem: Problem, effects: tuple[Effect, ...]) -> float:
    """Return what effects of single teeth and turns must gain to be named.

    Waviness that is not linear imitates teeth, not what turns with a shaft: for this as much as scores of the same explanation may differ
    by is enough.
    """
    return problem.detected if any(hasattr(effect, "tooth") for effect in effects) else max(problem.wander, problem.imitated)
