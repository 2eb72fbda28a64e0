"""What records leave of a verdict once the model stands: those held out above all."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping, Sequence

from gearfem.diagnosis.comparing.averages import shows_in_means
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.score import Label, label
from gearfem.diagnosis.naming.naming import Naming, Rival, Verdict, sentence_of
from gearfem.diagnosis.naming.verdict import explains
from gearfem.diagnosis.proving.proof import Gap, Proof
from gearfem.effects.effect import Effect

# What a record held out may be left with, in parts of what can be expected of it, unless at least this share of its gap is closed.
STAYS_OPEN, CLOSES = 2.0, 0.5
# What nuisances alone leave of records held out over what the named effects leave, below which these are no explanation; and where
# nuisances stray, which foretell other records too then.
WORSE, FAR_WORSE = 0.97, 0.5
# The same of the records that were fitted, which names that are right cannot leave much farther off: of 53 names those that were wrong left
# 0.49 and 0.72 at least, those that were right 0.86.
UNMET = 0.8
# What a free smooth correction may leave of records held out over what names leave that do no better there than nuisances alone: of 16 such
# names, eight of them wrong, it was 0.89 or more, and 0.61 for a runout in the place of a wheel that is loose on its seat.
SMOOTHER = 0.8
# The same of what turns with a shaft and stands for no gap: of ten such names a ripple for a bent shaft was left 0.91, right ones 0.99 at
# least.
BEATEN = 0.95
# Standard errors by which a name must do better, or worse.
SURE = 2.0


def as_held_out_leaves(naming: Naming, proof: Proof, sound: bool) -> Naming:
    """Return the verdict as the records held out leave it.

    Parameters
    ----------
    naming, proof : Naming, Proof
        The verdict so far, and what is left of each record.
    sound : bool
        Whether nuisances alone do the work of no effect.

    Notes
    -----
    Effects that surely leave more there than nuisances alone are no explanation, nor those that do not surely leave less, and not half
    as much less as if they were right, where these records would show it; the verdict is that without any. Where nuisances do the work
    of an effect they foretell other records too (index errors of all teeth, say, are as good as a runout), and names must surely be by
    far worse before they are none; or leave open what nuisances surely foretell better. Names that do not surely beat nuisances must
    not be beaten by a smooth correction, which knows no physics. What turns with a shaft must surely beat nuisances, and not be beaten
    by that by a twentieth, if nuisances leave no gap without it: index errors hold its waves, and waves of anything else, as of a
    resonance that the model has too wide. A gap that stays open is not explained. Names that lower what a fit costs, row by row as if all
    were linear, and yet leave more of the fitted records are none either: motions whose flanks hammer may take another way for next to
    nothing.
    """
    if naming.fit.effects and proof.over_fitted is not None and proof.over_fitted < UNMET:
        return _withdrawn(naming, naming.without if sound else "unexplained", "more", records="the records that were fitted")
    over, doubt = proof.over_nuisances, SURE * (proof.stderr or 0.0)
    held = [gap for gap in proof.records if gap.measurement.proves]
    far = [gap for gap in held if gap.rms(gap.after) > STAYS_OPEN * gap.expected_rms]
    if naming.fit.effects and over is not None:
        waves = naming.gapless and _turning(naming.fit.effects)
        if words := _refused(proof, sound, waves):
            verdict: Verdict = "unexplained" if words == "more" and not sound else naming.without
            return _withdrawn(naming, verdict, words, _smooth(proof) if waves else "")
        surely, better = over + doubt < 1.0, over - doubt >= 1.0
        if far and over < WORSE and surely and naming.verdict != "ambiguous":
            return _withdrawn(naming, "unexplained", "more")
        if not better and (proof.over_smooth or 1.0) < SMOOTHER:
            return _withdrawn(naming, "unexplained", "not surely less", _smooth(proof))
    wide = [gap for gap in held if gap not in far and gap.rms(gap.after) > STAYS_OPEN * gap.floor_rms]
    if naming.fit.effects and wide:
        reason = f"Records held out ({_files(wide)}) are foretold no better than the parameters are known."
        naming = dataclasses.replace(naming, reasons=(*naming.reasons, reason))
    open_gaps = [gap for gap in far if gap.closure < CLOSES]
    if naming.verdict != "explained" or not open_gaps:
        return naming
    reason = f"A gap stays open on records held out ({_files(open_gaps)}): something else acts there, or the effects are not quite these."
    return naming.with_rest(reason)


def asked_alone(naming: Naming, rest: Fit, proof: Proof) -> Naming:
    """Return the verdict once what single teeth and turns have is asked by itself: what the records held out show of it.

    Parameters
    ----------
    naming : Naming
        The verdict so far.
    rest : Fit
        Of the effects that are named of all teeth, without the others.
    proof : Proof
        What is left of each record with all that is named, and with these alone in the place of nuisances alone.
    """
    stay = set(label(rest.effects))
    others = tuple(effect for effect in naming.fit.effects if stay.isdisjoint(label((effect,))))
    words = _refused(proof, True, naming.gapless and _turning(others))
    if not words:
        return naming
    alone, kept = (" + ".join(effect.name for effect in effects) for effects in (others, rest.effects))
    found = dataclasses.replace(
        naming,
        fit=rest,
        p_values=naming.p_values[: len(rest.effects)],
        rivals=tuple(_lacking(naming.rivals, others)),
        sentence=sentence_of(naming.verdict, rest, naming.closed),
        reasons=(*naming.reasons, f"On records held out, {words} is left with {alone} beside {kept} than without."),
    )
    return _settled(found)


def _lacking(rivals: Iterable[Rival], withdrawn: tuple[Effect, ...]) -> Iterator[Rival]:
    """Yield explanations of what all teeth have without what is withdrawn of single ones; other explanations of that go with it."""
    gone = set(label(withdrawn))
    for rival in rivals:
        left = tuple(effect for effect in rival.effects if gone.isdisjoint(label((effect,))))
        if gone <= set(label(rival.effects)) and all(shows_in_means(effect) for effect in left):
            yield dataclasses.replace(rival, effects=left)


def _files(gaps: Sequence[Gap]) -> str:
    """Return the files of records in words."""
    return ", ".join(gap.measurement.file for gap in gaps)


def _refused(proof: Proof, sound: bool, waves: bool) -> str:
    """Return why names are none by what they leave of records held out, in words, or nothing; `waves` turn and stand for no gap."""
    over, foretold, doubt = proof.over_nuisances, proof.foretold or 1.0, SURE * (proof.stderr or 0.0)
    if over is None:
        return ""
    if over < (WORSE if sound else FAR_WORSE) and over + doubt < 1.0:
        return "more"
    better = over - doubt >= 1.0
    missed = foretold - doubt > 1.0 and not better and over < 0.5 * (1.0 + foretold)
    beaten = not better or (proof.over_smooth or 1.0) < BEATEN
    return "not surely less" if (sound and missed) or (waves and beaten) else ""


def _turning(effects: Sequence[Effect]) -> bool:
    """Return whether all of the effects turn with the gears."""
    return all(effect.repeats == "once a turn" for effect in effects)


def _smooth(proof: Proof) -> str:
    """Return in words what a smooth correction leaves."""
    return "" if proof.over_smooth is None else f" A free smooth correction leaves {proof.over_smooth:.2f} times as much."


def _withdrawn(naming: Naming, verdict: Verdict, words: str, rest: str = "", records: str = "records held out") -> Naming:
    """Return a verdict that names nothing, and why."""
    beside = " and what stands beside it" if len(naming.fit.effects) > 1 else ""
    reason = f"On {records}, {words} is left with {naming.fit.effects[0].name}{beside} than with nuisances alone.{rest}"
    sentence = sentence_of(verdict, naming.alone, naming.closed)
    return dataclasses.replace(naming, verdict=verdict, fit=naming.alone, p_values=(), sentence=sentence, reasons=(*naming.reasons, reason))


def instead(naming: Naming, rival: Rival, fit: Fit) -> Naming:
    """Return the verdict that names, in the place of what it did, an explanation that is as good, as fitted to all records."""
    others = (naming.named, *(one for one in naming.rivals if one is not rival))
    shifted = (dataclasses.replace(one, score_difference=one.score_difference - rival.score_difference) for one in others)
    return dataclasses.replace(
        naming,
        fit=fit,
        p_values=rival.p_values,
        rivals=tuple(sorted(shifted, key=lambda one: one.score_difference)),
        sentence=sentence_of(naming.verdict, fit, naming.closed),
    )


def without(naming: Naming, lost: Mapping[tuple[Label, ...], str]) -> Naming:
    """Return the verdict once records held out have left some of the explanations that fit alike, by their labels with the reasons."""
    rivals = tuple(
        dataclasses.replace(one, near=False, why=lost[label(one.effects)]) if label(one.effects) in lost else one for one in naming.rivals
    )
    return _settled(dataclasses.replace(naming, rivals=rivals, reasons=(*naming.reasons, *lost.values())))


def _settled(naming: Naming) -> Naming:
    """Return a verdict that is ambiguous no longer if nothing is left that fits alike."""
    if naming.verdict != "ambiguous" or naming.as_good:
        return naming
    verdict = explains(naming.closed, (naming.level, naming.left))
    return dataclasses.replace(naming, verdict=verdict, sentence=sentence_of(verdict, naming.fit, naming.closed))
