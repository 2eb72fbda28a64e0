"""Effects whose work nuisances have done, looked for with the nuisances as the model has them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gearfem.assembly import assemble
from gearfem.definition.setup import Member
from gearfem.diagnosis.approach import approached
from gearfem.diagnosis.candidate import Candidate
from gearfem.diagnosis.fit import Fit
from gearfem.diagnosis.nuisances import Nuisance
from gearfem.diagnosis.problem import Problem
from gearfem.diagnosis.shapes import bounded, stands
from gearfem.diagnosis.side_by_side import side_by_side
from gearfem.diagnosis.straying import beyond
from gearfem.diagnosis.verdict import gap_left
from gearfem.effects.effect import Effect
from gearfem.foundation import Array, InputError, SolveError
from gearfem.foundation.progress import Progress
from gearfem.variants import Variant

# Strengths at which effects are tried, in typical ones, and how many of them are worth a fit.
STRENGTHS, MOST = (-1.0, 1.0, 4.0, 16.0), 4


def unveiled(problem: Problem, alone: Fit, candidates: Sequence[Candidate], progress: Progress) -> list[tuple[tuple[Effect, ...], Array]]:
    """Return single effects to fit, and nuisances to start from, where those alone stray.

    None where no scale and no error of the model does, or where they leave a gap all the same: what is missing shows in that.

    Parameters
    ----------
    problem, alone : Problem, Fit
        Whose scales may do the work of what is missing, so that derivatives there show nothing of it.
    candidates : sequence of Candidate
        Effects that the records feel; those of all teeth that can be scaled are tried at several strengths.
    progress : Progress
        Told after each effect.

    Returns
    -------
    list of (tuple of Effect, ndarray of shape (k,))
        Those that do what a scale or an error that strays does, in its place; and those that bring a model with its own scales nearest to
        the records, as slow records have them, tuned to the resonances.
    """
    unknown = alone.point.unknown
    astray = problem.strayed(unknown).any() or beyond(unknown[problem.unknowns.wrong]).any()
    if not astray or gap_left(alone, problem) > 1.0:
        return []
    setup, neutral = problem.campaign.setup, problem.unknowns.neutral(unknown)
    level = problem.settings(neutral)
    whole = [c.effect for c in candidates if not hasattr(c.effect, "tooth") and not stands(c.effect)]
    jobs = list({(type(effect), effect.member): None for effect in whole})

    def nearest(job: tuple[type[Effect], Member]) -> tuple[float, tuple[Effect, ...]]:
        example = job[0].example(setup, job[1])
        tried = [(bounded(example.scaled(strength, setup), setup),) for strength in STRENGTHS]
        return min(((problem.left_at(effects, neutral), effects) for effects in tried), key=lambda item: item[0])

    def begin(effects: tuple[Effect, ...]) -> tuple[tuple[Effect, ...], Array]:
        try:
            return approached(problem, level, effects)
        except (InputError, SolveError):
            return effects, neutral

    words = "effects in the place of nuisances"
    bare, found = problem.left_at((), neutral), []
    for number, best in enumerate(side_by_side(nearest, jobs)):
        progress(words, number, len(jobs) + MOST)
        found.append(best)
    nearer = [effects for least, effects in sorted(found, key=lambda item: item[0]) if least < bare][:MOST]
    starts = []
    for number, start in enumerate(side_by_side(begin, nearer)):
        progress(words, len(jobs) + number, len(jobs) + MOST)
        starts.append(start)
    progress(words, len(jobs) + MOST, len(jobs) + MOST)
    return [*in_place(problem, unknown, candidates), *starts]


def in_place(problem: Problem, unknown: Array, candidates: Sequence[Candidate]) -> Iterator[tuple[tuple[Effect, ...], Array]]:
    """Yield the candidate that would do what each scale or error of the model that strays does, and the unknowns (k,) without this."""
    setup, unknowns, kinds = problem.campaign.setup, problem.unknowns, {type(candidate.effect) for candidate in candidates}
    system, ways = assemble(setup), dict[int, Nuisance | Variant](enumerate(unknowns.errors, unknowns.wrong.start))
    for place, way in ({place: unknowns.nuisances[place] for place in unknowns.scales} | ways).items():
        if way.cause is None or not beyond(unknown[place]):
            continue
        effect, without = way.cause(system, way.value(float(unknown[place]))), unknown.copy()
        without[place] = 0.0
        if isinstance(effect, Effect) and type(effect) in kinds:
            yield (bounded(effect, setup),), without
