"""Metal taken from flanks: from all teeth of a gear, or from one."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from gearfem.definition.setup import Member
from gearfem.flank import Deviation, Flanks, Outline
from gearfem.foundation import Array, InputError


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

    Raises
    ------
    InputError
        With the gear, and the tooth if it is one alone, where what is left is no flank.
    """
    odd = flanks.odd(member)
    if tooth is None:
        whole = _less(flanks.of(member), depth, f"flank of the {member}")
        odd = {number: _less(outline, depth, f"flank of the {member}, tooth {number}") for number, outline in odd.items()}
    else:
        whole = flanks.of(member)
        odd[tooth] = _less(odd.get(tooth, whole), depth, f"flank of the {member}, tooth {tooth}")
    differing = ((number, outline) for number, outline in sorted(odd.items()) if not _alike(outline, whole))
    changes: dict[str, Any] = {member: whole, f"{member}_odd": tuple(differing)}
    return dataclasses.replace(flanks, **changes)


def _less(outline: Outline, depth: Callable[[Array], Array], name: str) -> Outline:
    before = outline.deviation or Deviation.none(outline.gear)
    try:
        return dataclasses.replace(outline, deviation=before.plus(depth))
    except InputError as error:
        raise InputError(name, error.found, error.allowed) from None


def _alike(one: Outline, two: Outline) -> bool:
    """Return whether two outlines of a gear miss the same metal; then neither is odd."""
    first, second = (outline.deviation or Deviation.none(outline.gear) for outline in (one, two))
    return np.array_equal(first.roll, second.roll) and np.array_equal(first.depth, second.depth)
