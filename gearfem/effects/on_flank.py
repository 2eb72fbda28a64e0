"""Metal taken from flanks: from all teeth of a gear, or from one."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

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
    differing = ((number, outline) for number, outline in sorted(odd.items()) if not _alike(outline, whole))
    changes: dict[str, Any] = {member: whole, f"{member}_odd": tuple(differing)}
    return dataclasses.replace(flanks, **changes)


def _less(outline: Outline, depth: Callable[[Array], Array]) -> Outline:
    before = outline.deviation or Deviation.none(outline.gear)
    return dataclasses.replace(outline, deviation=before.plus(depth))


def _alike(one: Outline, two: Outline) -> bool:
    """Return whether two outlines of a gear miss the same metal; then neither is odd."""
    first, second = (outline.deviation or Deviation.none(outline.gear) for outline in (one, two))
    return np.array_equal(first.roll, second.roll) and np.array_equal(first.depth, second.depth)
