"""Motions that no model foretells: they take another way for next to nothing, as flanks do that hammer under a light load."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from gearfem.diagnosis.comparing.averages import floor_of, hammering, mean_of
from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.noise import Noise
from gearfem.foundation import UNCOMPUTABLE

# Part of the inertias by which they are changed, a fortieth of what is unknown of them, and what may be left of the mean over the
# pitches, in the objective, when what a change up does is added to what one down does. Of 37 pairs of one simulator six have a motion
# under a twentieth of the rated torque that is left with 0.15 to 200. Of 377 motions of another, six are left with a hundredth of their
# course row by row, and only one of these, of an oval gear, with more than 0.04 here.
CHANGE, UNDONE = 1e-3, 0.1


def marked(records: Sequence[Measurement], noises: Sequence[Noise], bench: SystemBench, settings: Settings) -> tuple[Measurement, ...]:
    """Return records, those marked of whose motions no model foretells the course.

    Parameters
    ----------
    records : sequence of Measurement
        Of any quantity.
    noises : sequence of Noise
        Of each.
    bench : SystemBench
        The model.
    settings : Settings
        Where it stands, with index errors near those of the gears.

    Returns
    -------
    tuple of Measurement
        None is marked where no other record over the pinion angle would be left.

    Notes
    -----
    What such a record costs a fit jumps by tens with every parameter that moves, by a millionth of its doubt too: a fit stands still at the
    luckiest place it has met, derivatives are chance, and names gain by either.
    """
    sized = zip(records, noises, strict=True)
    found = tuple(dataclasses.replace(record, erratic=erratic(record, noise, bench, settings)) for record, noise in sized)
    return found if any(record.quantity.axis == "angle" and not record.erratic for record in found) else tuple(records)


def erratic(record: Measurement, noise: Noise, bench: SystemBench, settings: Settings) -> bool:
    """Return whether a motion as settings have it takes another way for next to nothing."""
    if not record.quantity.is_motion:
        return False
    changed = (dataclasses.replace(settings, inertia_scale=(1.0 + way * CHANGE) * settings.inertia_scale) for way in (0.0, 1.0, -1.0))
    try:
        here, ahead, behind = (bench.predict(record, one) for one in changed)
    except UNCOMPUTABLE:
        return True
    mean = mean_of(record, noise, bench.pair)
    undone = mean.whitener.apply(ahead + behind - 2.0 * here)
    return float(undone @ undone) > 2.0 * UNDONE * floor_of(record, mean, bench.pair, hammering(record, bench, settings))


def said(records: Sequence[Measurement]) -> tuple[str, ...]:
    """Return in words which records are marked, if any."""
    files = [record.file for record in records if record.erratic]
    if not files:
        return ()
    whose = "Its" if len(files) == 1 else "Their"
    why = f"{whose} flanks go another way for a thousandth of the inertias, and no model foretells which."
    return (f"Left out of means and proof: {', '.join(files)}. {why}",)
