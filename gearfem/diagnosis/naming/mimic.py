"""How far errors of our own model imitate the effects of a fit."""

from __future__ import annotations

import numpy as np

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.modelling.differences import one_sided
from gearfem.diagnosis.modelling.model_form import form_errors
from gearfem.effects.effect import Effect
from gearfem.foundation import Array

# How far each error of the model goes to see what it imitates, in standard deviations: responses bend within one.
PART = 0.5


def mimicked(problem: Problem, fit: Fit) -> tuple[float, ...]:
    """Return of each effect of a fit the strength at which errors of our model imitate it, over the strength it has.

    Parameters
    ----------
    problem : Problem
        Prepared near the fit, under any effects.
    fit : Fit
        Any.

    Returns
    -------
    tuple of float
        The root of the sum of squares over all variants of the model and common form errors, each at one standard deviation: of what each
        would be taken for if this effect were free beside the others of the fit and all nuisances. Form errors are those that flanks
        without the effect have: how far its own shape may differ from its name imitates nothing.
    """
    point, count = fit.point, problem.unknowns.first_form - problem.outer
    if not fit.effects:
        return ()
    problem = problem.beside(fit.effects)
    without = [fit.effects[:out] + fit.effects[out + 1 :] for out in range(len(fit.effects))]
    responses = [problem.response(point, others) for others in without]
    form = np.concatenate([part[:, count:] for part in problem.linear.columns])
    wrong = _finite(problem, fit)
    form[:, : wrong.shape[1]] = wrong
    vectors = np.column_stack([*responses, form, problem.scales])
    gram, _ = problem.linear.first(count).weighed(point.weights).measure(vectors, point.residual)
    size, outer = len(responses), problem.outer
    gram[len(gram) - outer :, len(gram) - outer :] += np.eye(outer)
    found = []
    for own in range(size):
        others = [place for place in (*range(size), *range(len(gram) - outer, len(gram))) if place != own]
        shared = np.linalg.lstsq(gram[np.ix_(others, others)], gram[others, own], rcond=1e-12)[0]
        freed = gram[own] - shared @ gram[others]
        errors = _form_scales(problem, without[own], form.shape[1])
        found.append(float(np.linalg.norm(errors * freed[size : len(gram) - outer]) / max(freed[own], 1e-300)))
    return tuple(found)


def _finite(problem: Problem, fit: Fit) -> Array:
    """Return what each error of the model would do if it were larger by a part, in parts: whitened, shape (m, v)."""
    unknown, unknowns = fit.point.stood, problem.unknowns
    columns = []
    for place, variant in enumerate(unknowns.errors, unknowns.wrong.start):

        def quotient(part: float, place: int = place) -> Array:
            moved = unknown.copy()
            moved[place] += part
            return problem.change(fit.point, fit.effects, moved) / part

        columns.append(one_sided(quotient, PART if unknown[place] + PART <= variant.most else -PART))
    return np.column_stack(columns) if columns else np.empty((len(fit.white), 0))


def _form_scales(problem: Problem, effects: tuple[Effect, ...], count: int) -> Array:
    """Return by how much smaller errors of the model are under effects than under those of the columns, shape (count,).

    Only forms common to all teeth are.
    """
    unknowns, scales = problem.unknowns, np.ones(count)
    parts = zip(*(form_errors(problem.bench(own)) for own in (effects, problem.effects)), strict=True)
    forms = slice(unknowns.forms.start - unknowns.first_form, unknowns.forms.stop - unknowns.first_form)
    scales[forms] = np.repeat([here / prepared for here, prepared in parts], unknowns.scatter.terms)
    return scales
