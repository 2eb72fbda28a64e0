"""Where in the engagement a sample lies: zones of the mesh phase, and the teeth that carry."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.setup import GearPair
from gearfem.foundation import Array

PHASES = 24
ZONES = ("double_entry", "single", "double_exit", "approach", "recess", "pair_change", "all")
WORDS = {
    "double_entry": "just after a pair has come into contact (two pairs carry)",
    "single": "where one pair carries alone",
    "double_exit": "just before a pair leaves contact (two pairs carry)",
    "approach": "before the pitch point, one pair carrying",
    "recess": "behind the pitch point, one pair carrying",
    "pair_change": "where pairs enter or leave",
    "all": "all over the record",
}
# Teeth that bend into contact early, and transitions under load, reach this far from the theoretical change, in pitches.
CHANGE = 0.06


def in_zones(angle: Array, pair: GearPair) -> NDArray[Any]:
    """Return which zones samples lie in.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        True pinion angles [rad].
    pair : GearPair
        The gears, whose unloaded path of contact bounds the zones.

    Returns
    -------
    ndarray of bool, shape (n, 7)
        In the order of `ZONES`.

    Notes
    -----
    At phase u (in pitches, 0 at the pitch point) pair 0 leaves at the recess over the base pitch, and the pair after it has come in at 1
    less the approach over it. Above a contact ratio of 2 no zone has a single pair; zones then mean the nearest change.
    """
    enters = 1.0 - pair.approach_length / pair.base_pitch
    leaves = pair.recess_length / pair.base_pitch
    phase = np.mod(angle / pair.pinion.pitch_angle, 1.0)
    since = np.mod(phase - enters, 1.0)
    double = math.fmod(leaves - enters + 2.0, 1.0) if pair.contact_ratio < 2.0 else 1.0
    both = since < double
    first = both & (since < 0.5 * double)
    alone = ~both
    centred = np.mod(phase + 0.5, 1.0) - 0.5
    change = np.zeros(len(phase), bool)
    for place in (enters, leaves):
        change |= np.abs(np.mod(phase - place + 0.5, 1.0) - 0.5) < CHANGE
    columns = (first, alone, both & ~first, alone & (centred < 0.0), alone & (centred >= 0.0), change, np.ones(len(phase), bool))
    return np.stack(columns, axis=1)


def phase_cells(angle: Array, pair: GearPair) -> NDArray[Any]:
    """Return the cell of the mesh phase of each sample, 0 to 23 from the pitch point on, shape (n,)."""
    phase = np.mod(angle / pair.pinion.pitch_angle, 1.0)
    return np.asarray(np.minimum((phase * PHASES).astype(int), PHASES - 1))


def leading_teeth(angle: Array, pair: GearPair) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the teeth of the pair nearest to the middle of its path of contact at each sample, shapes (n,)."""
    middle = 0.5 * (pair.recess_length - pair.approach_length) / pair.base_pitch
    number = np.round(angle / pair.pinion.pitch_angle - middle).astype(int)
    return number % pair.pinion.teeth, number % pair.wheel.teeth


def order_lines(pair: GearPair, highest: float) -> list[tuple[str, float]]:
    """Return the orders that gears can make, up to a highest one: name in the format's words and order of the pinion's turns.

    Shaft lines, mesh harmonics and their first two sidebands of both shafts; the wheel's come in fractions.
    """
    wheel = 1.0 / pair.ratio
    orders = [1.0, 2.0, 3.0, wheel, 2.0 * wheel]
    for harmonic in range(1, int(highest / pair.pinion.teeth) + 1):
        centre = float(harmonic * pair.pinion.teeth)
        orders += [centre, *(centre + side * shaft for side in (-2, -1, 1, 2) for shaft in (1.0, wheel))]
    return [(f"{order:.6g}", order) for order in sorted({round(order, 9) for order in orders}) if order <= highest]
