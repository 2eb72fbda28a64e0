"""The whole diagnosis of a campaign, and its steps one by one."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Iterable, Mapping

import numpy as np

from gearfem.diagnosis.comparing.averages import averaged, has_means, of_single_teeth, shows_in_means, stand, without_single
from gearfem.diagnosis.comparing.compare import compare
from gearfem.diagnosis.comparing.comparison import Comparison
from gearfem.diagnosis.fitting.fit import Fit, again
from gearfem.diagnosis.fitting.inexact import stated
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.fitting.score import label, simplicity, stays
from gearfem.diagnosis.localising.localise import Localisation, localise
from gearfem.diagnosis.naming.name import name
from gearfem.diagnosis.naming.naming import Naming, Rival
from gearfem.diagnosis.proving.held_out import as_held_out_leaves, asked_alone, instead, without
from gearfem.diagnosis.proving.proof import Proof
from gearfem.diagnosis.proving.prove import prove
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.diagnosis.suggest import Suggestion, suggest
from gearfem.effects.effect import Effect
from gearfem.foundation import UNCOMPUTABLE, InputError, Record
from gearfem.foundation.errors import nearest
from gearfem.foundation.progress import Progress, quiet

# Draws of noise behind each map.
DRAWS = 100
# Turns in which means and single teeth are fitted at most, and what one must gain for another.
TURNS, SETTLED = 4, 1.0


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Diagnosis(Record):
    """What a campaign says about its model.

    Parameters
    ----------
    comparison : Comparison
        Model and campaign with nuisances alone.
    before, after : Localisation
        Where the gap is with nuisances alone, and where what is named leaves one; the same where nothing is named.
    naming : Naming
        Verdict, named effects and rivals.
    proof : Proof
        Named effects against records that were held out.
    suggestions : tuple of Suggestion
        What to measure next, the best first; empty unless the verdict is ambiguous.
    tried : tuple of str
        Names of the effects that it chose among.
    deviations : tuple of dict
        Standard deviation of each parameter of the named effects as it is stated [SI], by field, see `stated`.
    """

    comparison: Comparison
    before: Localisation
    after: Localisation
    naming: Naming
    proof: Proof
    suggestions: tuple[Suggestion, ...]
    tried: tuple[str, ...]
    deviations: tuple[dict[str, float], ...]

    @property
    def problem(self) -> Problem:
        """Records that were fitted, with noise and nuisances."""
        return self.comparison.problem

    @property
    def campaign(self) -> Campaign:
        """What was measured."""
        return self.comparison.campaign

    @property
    def alternatives(self) -> tuple[Rival, ...]:
        """Explanations that the data cannot tell from the named one, best first."""
        return self.naming.as_good


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

        comparison = compare(campaign)
        where = localise(comparison)
        problem, alone = comparison.problem, comparison.alone
        candidates = rank(problem, alone, kinds)
        mine = fit(problem, (TipRelief(gear="wheel", amount=1e-5, length=2e-3),), alone)
        naming = name(problem, alone, kinds)
        proof = prove(problem, naming.fit, alone)
    """
    comparison = compare(campaign, progress=progress)
    problem, alone = comparison.problem, comparison.alone
    before = localise(comparison, draws=DRAWS, progress=progress)
    named = name(problem, alone, kinds, progress)
    naming, proof = _opened(problem, named, progress)
    if naming.fit.effects and naming.fit is not named.fit:
        problem.prepare(naming.fit.effects, naming.fit.point.stood)
    after = localise(comparison, naming.fit, DRAWS, progress=progress) if naming.fit.effects else before
    draft = Diagnosis(
        comparison=comparison,
        before=before,
        after=after,
        naming=naming,
        proof=proof,
        suggestions=(),
        tried=tuple(sorted(kinds)),
        deviations=stated(problem, naming.fit),
    )
    rivals = [rival.effects for rival in draft.alternatives]
    return dataclasses.replace(draft, suggestions=suggest(problem, naming.fit, rivals, progress)) if rivals else draft


def _opened(problem: Problem, naming: Naming, progress: Progress) -> tuple[Naming, Proof]:
    """Return the verdict once the records held out are opened, and the proof of what is named then.

    What single teeth and turns have beside effects of all teeth is asked by itself first. Where the records withdraw the simplest of
    explanations that fit alike, each of the others is fitted to all records and asked the same.
    """
    sound, told = stays(problem, naming.alone), copy.copy(problem)
    told.untold = naming.untold
    if has_means(problem) and len({shows_in_means(effect) for effect in naming.fit.effects}) > 1:
        rest = without_single(problem, naming.fit)
        naming = asked_alone(naming, rest, prove(problem, naming.fit, rest, progress))

    def asked(one: Naming) -> tuple[Naming, Proof]:
        proof = prove(problem, one.fit, one.alone, progress)
        return as_held_out_leaves(one, proof, sound), proof

    held, proof = asked(naming)
    if held.fit is naming.fit:
        return held, proof
    kept, lost = list[tuple[Naming, Proof]](), {label(naming.fit.effects): held.reasons[-1]}
    for rival in naming.as_good:
        key = label(rival.effects)
        if key in lost:
            continue
        try:
            one, its = asked(instead(naming, rival, fit(told, rival.effects, rival.fit, progress)))
        except UNCOMPUTABLE:
            lost[key] = f"{' + '.join(effect.name for effect in rival.effects)} cannot be fitted to all records."
            continue
        if one.fit.effects:
            kept.append((one, its))
        else:
            lost[key] = one.reasons[-1]
    if not kept:
        return held, prove(problem, held.fit, held.alone, progress)
    found, proof = min(kept, key=lambda item: simplicity(item[0].fit.effects))
    return without(found, lost), proof


def choose(kinds: Mapping[str, type[Effect]], only: Iterable[str] = (), exclude: Iterable[str] = ()) -> Mapping[str, type[Effect]]:
    """Return some of the effects.

    Parameters
    ----------
    kinds : mapping of str to type
        All of them.
    only : iterable of str, or str
        Names of those that are allowed; none: all.
    exclude : iterable of str, or str
        Names of those that are not.

    Returns
    -------
    mapping of str to type
        The same, those that are left.

    Raises
    ------
    InputError
        If there is no effect of a name, or none is left.
    """
    wanted, unwanted = ({names} if isinstance(names, str) else set(names) for names in (only, exclude))
    for option, names in (("--only", wanted), ("--exclude", unwanted)):
        for word in sorted(names - set(kinds)):
            raise InputError(option, f'"{word}"', nearest(word, sorted(kinds)))
    left = {key: kind for key, kind in kinds.items() if (not wanted or key in wanted) and key not in unwanted}
    if not left:
        raise InputError("--only, --exclude", "no effect left", "at least one effect to choose among")
    return left


def fit(problem: Problem, effects: Iterable[Effect] | Effect, start: Fit, progress: Progress = quiet) -> Fit:
    """Fit given effects, whatever the ranking says of them: those of all teeth to the means over the pitches, others row by row.

    Parameters
    ----------
    problem : Problem
        From `compare`; stays prepared as it is.
    effects : iterable of Effect, or Effect
        With the values to begin from; gears and teeth stay. None: the nuisances alone, to set others beside.
    start : Fit
        Whose nuisances the fit begins with: nuisances alone, or an earlier fit.
    progress : Progress
        Told how far the fit is.

    Returns
    -------
    Fit
        To be compared by `score` with others from here.

    Raises
    ------
    InputError
        If an effect is none, or not on these gears.
    SolveError
        If the model cannot be computed where the fit begins.

    Notes
    -----
    By turns, as `name` does it: means with single teeth standing still, and these with the means, until that gains little.
    """
    chosen = (effects,) if isinstance(effects, Effect) else tuple(effects)
    for effect in chosen:
        if not isinstance(effect, Effect):
            raise InputError("effects", f"{effect!r:.60}", "effects with values to begin from, as TipRelief(...)")
        effect.check(problem.campaign.setup)
    if not has_means(problem):
        return again(copy.copy(problem), chosen, start.point.unknown)
    best, here = None, dataclasses.replace(start, effects=chosen)
    for number in range(TURNS):
        progress("fit", number, TURNS)
        here = _turn(problem, here)
        if best is not None and here.objective > best.objective - SETTLED:
            break
        best = here
    progress("fit", TURNS, TURNS)
    assert best is not None
    return min(best, here, key=lambda one: one.objective)


def _turn(problem: Problem, fit: Fit) -> Fit:
    """Return a fit once its nuisances and effects of all teeth are fitted to means anew, and single teeth under these."""
    common, single = (tuple(e for e in fit.effects if shows_in_means(e) == both) for both in (True, False))
    mean = averaged(problem, fit.settings, single)
    fitted = again(mean, common, mean.unknowns.of(fit.settings))
    teeth = of_single_teeth(problem, fitted.settings, fitted.effects)
    return stand(copy.copy(problem), fitted, teeth, again(teeth, single, np.zeros(teeth.unknowns.wrong.stop)))
