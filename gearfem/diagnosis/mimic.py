"""How far errors of our own model imitate the effects of a fit."""

from __future__ import annotations

import numpy as np

from gearfem.diagnosis.fit import Fit
from gearfem.diagnosis.problem import Problem


def mimicked(problem: Problem, fit: Fit) -> tuple[float, ...]:
    """Return of each effect of a fit the strength at which errors of our model imitate it, over the strength it has.

    Parameters
    ----------
    problem : Problem
        Prepared near the fit.
    fit : Fit
        Any.

    Returns
    -------
    tuple of float
        The root of the sum of squares over all variants of the model and common form errors, each at one standard deviation: of what each
        would be taken for if this effect were free beside the others of the fit and all nuisances.
    """
    point, count = fit.point, problem.unknowns.first_form - problem.outer
    if not fit.effects:
        return ()
    without = (problem.predict(fit.effects[:out] + fit.effects[out + 1 :], point.stood) for out in range(len(fit.effects)))
    responses = [problem.whiten(tuple(a - b for a, b in zip(point.predicted, bare, strict=True))) for bare in without]
    form = np.concatenate([part[:, count:] for part in problem.linear.columns])
    vectors = np.column_stack([*responses, form, problem.scales])
    gram, _ = problem.linear.first(count).weighed(point.weights).measure(vectors, point.residual)
    size, outer = len(responses), problem.outer
    gram[-outer:, -outer:] += np.eye(outer)
    found = []
    for own in range(size):
        others = [place for place in (*range(size), *range(len(gram) - outer, len(gram))) if place != own]
        shared = np.linalg.lstsq(gram[np.ix_(others, others)], gram[others, own], rcond=1e-12)[0]
        freed = gram[own] - shared @ gram[others]
        found.append(float(np.linalg.norm(freed[size : len(gram) - outer]) / max(freed[own], 1e-300)))
    return tuple(found)
