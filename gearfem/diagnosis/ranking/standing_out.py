"""What stands out among places that are alike but for chance: teeth of a gear, orders of a shaft."""

from __future__ import annotations

import numpy as np

from gearfem.foundation import Array

# Places that may stand out, and by how much more something must explain there than anywhere else.
MOST, STANDS_OUT = 2, 3.0


def standing_out(gains: Array, aside: int = 0) -> list[int]:
    """Return the places where something would explain most, if they stand out of all others, the best first; at most `MOST`.

    Parameters
    ----------
    gains : ndarray, shape (k,)
        What it would explain at each place: what chance and errors of our own model look like, they look like at several.
    aside : int
        How many neighbours on either side, round a gear, feel the same.
    """
    first = [int(place) for place in np.argsort(-gains, kind="stable")[:MOST]]
    beside = {(place + step) % len(gains) for place in first for step in range(-aside, aside + 1)}
    usual = max((gain for place, gain in enumerate(gains.tolist()) if place not in beside), default=0.0)
    return [place for place in first if gains[place] > STANDS_OUT * usual]
