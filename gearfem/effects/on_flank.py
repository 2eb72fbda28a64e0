"""Metal taken from flanks: from all teeth of a gear, or from one."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from gearfem.definition.setup import Member
from gearfem.flank import Deviation, Flanks, Outline
from gearfem.foundation import Array


def without(flanks: Flanks, member: Member, depth: Callable[[Array], Array], tooth: int | None = None) -> Flanks:
    """Return flanks with metal missing along the normal of the involute.

    Parameters
    ----------
    flanks : Flanks
        Both gears.
    member : {"pinion", "wheel"}
        The gear.
    depth : callable
        Depth [m], positive into the tooth, of roll lengths [m].
    tooth : int, optional
        The tooth; by default all of them, those that differ already included.

    Returns
    -------
    Flanks
    """
    odd = flanks.odd(member)
    if tooth is None:
        whole = _less(flanks.of(member), depth)
        odd = {number: _less(outline, depth) for number, outline in odd.items()}
    else:
        whole = flanks.of(member)
        odd[tooth] = _less(odd.get(tooth, whole), depth)
    changes: dict[str, Any] = {member: whole, f"{member}_odd": tuple(sorted(odd.items()))}
    return dataclasses.replace(flanks, **changes)


def _less(outline: Outline, depth: Callable[[Array], Array]) -> Outline:
    before = outline.deviation or Deviation.none(outline.gear)
    return dataclasses.replace(outline, deviation=before.plus(depth))
