"""How far errors of our own model imitate the effects of a fit."""

from __future__ import annotations

import numpy as np

from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.point import Point
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
        would be taken for if this effect were free beside the others of the fit and all nuisances. Errors are those that a pair
        without the effect has: how far its own shape may differ from its name imitates nothing.
    """
    point, count = fit.point, problem.unknowns.first_form - problem.outer
    if not fit.effects:
        return ()
    problem = problem.beside(fit.effects)
    without = [fit.effects[:out] + fit.effects[out + 1 :] for out in range(len(fit.effects))]
    responses = [problem.response(point, others) for others in without]
    form = np.concatenate([part[:, count:] for part in problem.linear.columns])
    linear, size, outer = problem.linear.first(count).weighed(point.weights), len(responses), problem.outer
    found = []
    for own, (effects, response) in enumerate(zip(without, responses, strict=True)):
        wrong = _finite(problem, point, effects, response)
        form[:, : wrong.shape[1]] = wrong
        gram, _ = linear.measure(np.column_stack([*responses, form, problem.scales]), point.residual)
        gram[len(gram) - outer :, len(gram) - outer :] += np.eye(outer)
        others = [place for place in (*range(size), *range(len(gram) - outer, len(gram))) if place != own]
        shared = np.linalg.lstsq(gram[np.ix_(others, others)], gram[others, own], rcond=1e-12)[0]
        freed = gram[own] - shared @ gram[others]
        errors = _form_scales(problem, effects, form.shape[1])
        found.append(float(np.linalg.norm(errors * freed[size : len(gram) - outer]) / max(freed[own], 1e-300)))
    return tuple(found)


def _finite(problem: Problem, point: Point, effects: tuple[Effect, ...], response: Array) -> Array:
    """Return what each error of the model would do, a part larger and without the effect of a response: in parts, white (m, v)."""
    unknown, unknowns = point.stood, problem.unknowns
    columns = []
    for place, variant in enumerate(unknowns.errors, unknowns.wrong.start):

        def quotient(part: float, place: int = place) -> Array:
            moved = unknown.copy()
            moved[place] += part
            return np.asarray((problem.change(point, effects, moved) + response) / part)

        columns.append(one_sided(quotient, PART if unknown[place] + PART <= variant.most else -PART))
    return np.column_stack(columns) if columns else np.empty((len(response), 0))


def _form_scales(problem: Problem, effects: tuple[Effect, ...], count: int) -> Array:
    """Return by how much smaller errors of the model are under effects than under those of the columns, shape (count,).

    Only forms common to all teeth are.
    """
    unknowns, scales = problem.unknowns, np.ones(count)
    parts = zip(*(form_errors(problem.bench(own)) for own in (effects, problem.effects)), strict=True)
    forms = slice(unknowns.forms.start - unknowns.first_form, unknowns.forms.stop - unknowns.first_form)
    scales[forms] = np.repeat([here / prepared for here, prepared in parts], unknowns.scatter.terms)
    return scales
