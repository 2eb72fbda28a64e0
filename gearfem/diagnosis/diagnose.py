"""The whole diagnosis of a campaign, and its steps one by one."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Iterable, Mapping

import numpy as np

from gearfem.assembly import assemble
from gearfem.diagnosis.campaign import Campaign
from gearfem.diagnosis.compare import compare
from gearfem.diagnosis.comparison import Comparison
from gearfem.diagnosis.fit import Fit, Problem
from gearfem.diagnosis.linear import eliminate
from gearfem.diagnosis.localise import Localisation, localise
from gearfem.diagnosis.name import Naming, Rival, name
from gearfem.diagnosis.prove import Proof, prove
from gearfem.diagnosis.suggest import Suggestion, suggest
from gearfem.diagnosis.system_bench import SystemBench
from gearfem.effects.effect import Effect
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.progress import Progress, quiet

# Terms of the waviness of a flank: tooth by tooth it is finer than what a comparison needs to find the angle and the noise.
TERMS = 14
# Rounds of the first fit, before derivatives are taken again; most rounds in which they are; draws of noise behind each map.
EARLY, SETTLED, DRAWS = 4, 3, 100


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Diagnosis(Record):
    """What a campaign says about its model.

    Parameters
    ----------
    comparison : Comparison
        Model and campaign with nuisances alone.
    before, after : Localisation
        Where the gap is with nuisances alone, and where what is named leaves one; the same where nothing is named.
    problem : Problem
        Records that were fitted, with noise and nuisances.
    naming : Naming
        Verdict, named effects and rivals.
    proof : Proof
        Named effects against records that were held out.
    suggestions : tuple of Suggestion
        What to measure next, the best first; empty unless the verdict is ambiguous.
    """

    comparison: Comparison
    before: Localisation
    after: Localisation
    problem: Problem
    naming: Naming
    proof: Proof
    suggestions: tuple[Suggestion, ...]

    @property
    def campaign(self) -> Campaign:
        """What was measured."""
        return self.problem.campaign

    @property
    def alternatives(self) -> tuple[Rival, ...]:
        """Explanations that the data cannot tell from the named one, best first."""
        if self.naming.verdict != "ambiguous":
            return ()
        most = len(self.naming.fit.effects)
        near = (rival for rival in self.naming.rivals if rival.score_difference < self.naming.threshold)
        return tuple(rival for rival in near if len(rival.effects) <= most)


def diagnose(campaign: Campaign, kinds: Mapping[str, type[Effect]], progress: Progress = quiet) -> Diagnosis:
    """Find where model and measurement disagree, name what is missing, and prove it on records held out.

    Parameters
    ----------
    campaign : Campaign
        From `read_campaign`.
    kinds : mapping of str to type
        Effects to choose among: `gearfem.effects.catalogue.catalogue()`, or a part of it from `choose`.
    progress : Progress
        Told how far the work is.

    Returns
    -------
    Diagnosis

    Raises
    ------
    InputError
        If the campaign leaves no record to fit.
    SolveError
        If the model cannot be computed.

    Notes
    -----
    The steps one by one, each of which can be looked at and repeated with other arguments:

        comparison = compare(campaign, bench_of(campaign))
        where = localise(comparison)
        problem, alone = start(comparison)
        candidates = rank(problem, alone, kinds)
        mine = fit(problem, (TipRelief(gear="wheel", amount=1e-5, length=2e-3),), alone)
        naming = name(problem, alone, kinds)
        proof = prove(problem, naming.fit, alone)
    """
    if not campaign.of("fit"):
        raise InputError("record", "no record of role fit", "at least one record that is not held out", campaign.path)
    comparison = compare(campaign, bench_of(campaign), progress=progress)
    problem, alone = start(comparison)
    comparison = remainder(comparison, problem, alone)
    before = localise(comparison, _forms(problem), DRAWS, progress=progress)
    naming = name(problem, alone, kinds, progress)
    after = localise(remainder(comparison, problem, naming.fit), None, DRAWS, progress=progress) if naming.fit.effects else before
    proof = prove(problem, naming.fit, naming.alone, progress)
    draft = Diagnosis(comparison=comparison, before=before, after=after, problem=problem, naming=naming, proof=proof, suggestions=())
    rivals = [rival.effects for rival in draft.alternatives]
    return dataclasses.replace(draft, suggestions=suggest(problem, naming.fit, rivals, progress)) if rivals else draft


def choose(kinds: Mapping[str, type[Effect]], only: Iterable[str] = (), exclude: Iterable[str] = ()) -> Mapping[str, type[Effect]]:
    """Return some of the effects.

    Parameters
    ----------
    kinds : mapping of str to type
        All of them.
    only : iterable of str
        Names of those that are allowed; none: all.
    exclude : iterable of str
        Names of those that are not.

    Raises
    ------
    InputError
        If there is no effect of a name, or none is left.
    """
    wanted, unwanted = set(only), set(exclude)
    for option, names in (("--only", wanted), ("--exclude", unwanted)):
        for word in sorted(names - set(kinds)):
            close = difflib.get_close_matches(word, kinds, n=1, cutoff=0.5)
            raise InputError(option, f'"{word}"', f"{close[0]} (the nearest valid name)" if close else ", ".join(sorted(kinds)))
    left = {key: kind for key, kind in kinds.items() if (not wanted or key in wanted) and key not in unwanted}
    if not left:
        raise InputError("--only, --exclude", "no effect left", "at least one effect to choose among")
    return left


def bench_of(campaign: Campaign, effects: Iterable[Effect] = ()) -> SystemBench:
    """Return the campaign's model, with or without further effects, ready to predict records."""
    return SystemBench(system=assemble(campaign.setup, tuple(effects)))


def start(comparison: Comparison) -> tuple[Problem, Fit]:
    """Return the problem that all fits of a campaign share, and the fit of the nuisances alone.

    Parameters
    ----------
    comparison : Comparison
        Of nuisances alone: its noise and its angle zero are where everything starts from.
    """
    records = comparison.records
    scatter = dataclasses.replace(comparison.scatter, terms=TERMS)
    problem = Problem(comparison.campaign, tuple(r.measurement for r in records), tuple(r.noise for r in records), scatter)
    moved = np.array([shift.deviations if shift.name == "angle_offset" else 0.0 for shift in comparison.shifts])
    # Scales that try to do the work of a missing effect stand at their limits, where derivatives mean little.
    alone = problem.fit((), problem.prepare((), moved), EARLY)
    return problem, problem.fit((), problem.prepare((), alone.point.unknown))


def settle(problem: Problem, fit: Fit) -> Fit:
    """Return a fit whose linear nuisances have been taken again where it ended, until that changes nothing any more.

    Parameters
    ----------
    problem : Problem
        Prepared at the fit afterwards.
    fit : Fit
        Effects and nuisances as found with derivatives from elsewhere.
    """
    best = problem.fit(fit.effects, problem.prepare(fit.effects, fit.point.unknown))
    for _ in range(SETTLED - 1):
        ahead = problem.fit(best.effects, problem.prepare(best.effects, best.point.unknown))
        gained, best = best.objective - ahead.objective, min(best, ahead, key=lambda one: one.objective)
        if gained < 1.0 + 1e-3 * best.objective:
            break
    return best


def fit(problem: Problem, effects: Iterable[Effect], start: Fit) -> Fit:
    """Fit given effects, whatever the ranking says of them.

    Parameters
    ----------
    problem : Problem
        From `start`.
    effects : iterable of Effect
        With the values to begin from; gears and teeth stay.
    start : Fit
        Whose nuisances the fit begins with: nuisances alone, or an earlier fit.
    """
    return problem.fit(tuple(effects), start.point.unknown)


def remainder(comparison: Comparison, problem: Problem, fit: Fit) -> Comparison:
    """Return the comparison in which a fit stands instead of the nuisances alone, to see by `localise` what it leaves."""
    records = tuple(dataclasses.replace(record, after=left) for record, left in zip(comparison.records, fit.left, strict=True))
    elimination = eliminate(np.concatenate([problem.scales, problem.whiten(problem.columns)], axis=1))
    return dataclasses.replace(
        comparison, settings=fit.settings, records=records, residual=problem.effective(fit.point), elimination=elimination
    )


def _forms(problem: Problem) -> Array:
    return problem.whiten(tuple(columns[:, problem.first_form - problem.outer :] for columns in problem.columns))
