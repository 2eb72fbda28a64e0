"""What records that were held out leave of a verdict."""

from __future__ import annotations

import dataclasses
import math

from gearfem.diagnosis.prove import Proof
from gearfem.diagnosis.verdict import Naming, sentence_of

# What a record held out may be left with, in parts of its floor, unless at least this share of its gap is closed.
OPEN, CLOSES = 2.0, 0.5
# What nuisances alone leave of records held out over what the named effects leave, below which these are no explanation; and where
# nuisances stray, which foretell other records too then.
WORSE, FAR_WORSE = 0.97, 0.5
# Standard errors by which they must do worse.
SURE = 2.0


def as_held_out_leaves(naming: Naming, proof: Proof, sound: bool) -> Naming:
    """Return the verdict as the records held out leave it.

    A gap that stays open there is not explained, and effects that do worse there than nuisances alone are no explanation: surely worse, or
    so that a gap stays open. Where these do the work of an effect, by far worse: index errors of all teeth, say, are as good as a runout.
    """
    over = math.inf if proof.over_nuisances is None else proof.over_nuisances
    far = [gap for gap in proof.of("holdout") if gap.rms(gap.after) > OPEN * gap.floor_rms]
    surely = over < (WORSE if sound else FAR_WORSE) and (proof.stderr is None or over + SURE * proof.stderr < 1.0)
    if naming.verdict in ("explained", "partly_explained") and (surely or (far and over < WORSE)):
        reason = f"On records held out, {naming.fit.effects[0].name} and what stands beside it leave more than nuisances alone."
        sentence, reasons = sentence_of("unexplained", naming.alone, naming.closed), (*naming.reasons, reason)
        return dataclasses.replace(naming, verdict="unexplained", fit=naming.alone, p_values=(), sentence=sentence, reasons=reasons)
    open_gaps = [gap for gap in far if gap.closure < CLOSES]
    if naming.verdict != "explained" or not open_gaps:
        return naming
    files = ", ".join(gap.measurement.file for gap in open_gaps)
    reason = f"A gap stays open on records held out ({files}): something else acts there, or the effects are not quite these."
    sentence = sentence_of("partly_explained", naming.fit, naming.closed)
    return dataclasses.replace(naming, verdict="partly_explained", sentence=sentence, reasons=(*naming.reasons, reason))
