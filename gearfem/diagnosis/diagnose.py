"""The whole diagnosis of a campaign, and its steps one by one."""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Iterable, Mapping

from gearfem.diagnosis.campaign import Campaign
from gearfem.diagnosis.compare import compare
from gearfem.diagnosis.comparison import Comparison
from gearfem.diagnosis.fit import Fit
from gearfem.diagnosis.localise import Localisation, localise
from gearfem.diagnosis.name import name
from gearfem.diagnosis.problem import Problem
from gearfem.diagnosis.prove import Proof, prove
from gearfem.diagnosis.search import stays
from gearfem.diagnosis.suggest import Suggestion, suggest
from gearfem.diagnosis.verdict import Naming, Rival, sentence_of
from gearfem.effects.effect import Effect
from gearfem.foundation import InputError, Record
from gearfem.foundation.progress import Progress, quiet

# What a record held out may be left with, in parts of its floor, unless at least this share of its gap is closed, and that better than
# nuisances alone would.
OPEN, CLOSES = 2.0, 0.5
# What nuisances alone leave of records held out over what the named effects leave, below which these are no explanation; and where
# nuisances stray, which foretell other records too then.
WORSE, FAR_WORSE = 0.97, 0.5
# Standard errors by which they must do worse.
SURE = 2.0
# Most rounds in which derivatives are taken again; draws of noise behind each map.
SETTLED, DRAWS = 3, 100


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
    """

    comparison: Comparison
    before: Localisation
    after: Localisation
    naming: Naming
    proof: Proof
    suggestions: tuple[Suggestion, ...]

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
        if self.naming.verdict != "ambiguous":
            return ()
        most = len(self.naming.fit.effects)
        return tuple(rival for rival in self.naming.rivals if rival.near and len(rival.effects) <= most)


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
    if not campaign.fitted:
        raise InputError("record", "no record of role fit", "at least one record that is not held out", campaign.path)
    comparison = compare(campaign, progress=progress)
    problem, alone = comparison.problem, comparison.alone
    before = localise(comparison, draws=DRAWS, progress=progress)
    naming = name(problem, alone, kinds, progress)
    after = localise(comparison, naming.fit, DRAWS, progress=progress) if naming.fit.effects else before
    proof = prove(problem, naming.fit, naming.alone, progress)
    held = _held(naming, proof, stays(problem, naming.alone))
    if held.fit is not naming.fit:
        after, proof = before, prove(problem, held.fit, held.alone, progress)
    naming = held
    draft = Diagnosis(comparison=comparison, before=before, after=after, naming=naming, proof=proof, suggestions=())
    rivals = [rival.effects for rival in draft.alternatives]
    return dataclasses.replace(draft, suggestions=suggest(problem, naming.fit, rivals, progress)) if rivals else draft


def _held(naming: Naming, proof: Proof, sound: bool) -> Naming:
    """Return the verdict as the records held out leave it.

    A gap that stays open there is not explained, and effects that do worse there than nuisances alone are no explanation; by far worse, if
    these do the work of an effect: index errors of all teeth, say, are as good as a runout.
    """
    over = math.inf if proof.over_nuisances is None else proof.over_nuisances
    surely = proof.stderr is None or over + SURE * proof.stderr < 1.0
    if naming.verdict in ("explained", "partly_explained") and over < (WORSE if sound else FAR_WORSE) and surely:
        reason = f"On records held out, {naming.fit.effects[0].name} and what stands beside it leave more than nuisances alone."
        sentence, reasons = sentence_of("unexplained", naming.alone, naming.closed), (*naming.reasons, reason)
        return dataclasses.replace(naming, verdict="unexplained", fit=naming.alone, p_values=(), sentence=sentence, reasons=reasons)
    far = [gap for gap in proof.of("holdout") if gap.rms(gap.after) > OPEN * gap.floor_rms]
    open_gaps = [gap for gap in far if gap.closure < CLOSES or over < WORSE]
    if naming.verdict != "explained" or not open_gaps:
        return naming
    files = ", ".join(gap.measurement.file for gap in open_gaps)
    reason = f"A gap stays open on records held out ({files}): something else acts there, or the effects are not quite these."
    sentence = sentence_of("partly_explained", naming.fit, naming.closed)
    return dataclasses.replace(naming, verdict="partly_explained", sentence=sentence, reasons=(*naming.reasons, reason))


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
        From `compare`.
    effects : iterable of Effect
        With the values to begin from; gears and teeth stay.
    start : Fit
        Whose nuisances the fit begins with: nuisances alone, or an earlier fit.
    """
    return problem.fit(tuple(effects), start.point.unknown)
