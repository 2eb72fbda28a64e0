"""Wear as an effect on the flanks of all teeth: depths at the nodes of their deviation."""

from __future__ import annotations

import dataclasses

import numpy as np

from gearfem.definition.setup import Member, Setup
from gearfem.effects.effect import Effect
from gearfem.effects.on_flank import without
from gearfem.flank import Flanks
from gearfem.foundation import Array


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Worn(Effect):
    """Metal worn off all teeth of one gear, of any shape; it stands in no model file, whose flanks come from tables of points.

    Parameters
    ----------
    gear : {"pinion", "wheel"}
        The gear.
    depth : ndarray, shape (n,)
        Depth at the roll lengths `Deviation.none(gear).roll` [m].
    """

    name = "worn"
    stage = "flank"
    repeats = "every tooth"
    history = "worn"
    sentence = "Wear of the {gear} over its life"
    source = "J. F. Archard, Contact and rubbing of flat surfaces (1953)"

    gear: Member
    depth: Array

    def act(self, flanks: Flanks, setup: Setup) -> Flanks:
        """Take the worn metal from all teeth."""
        return without(flanks, self.gear, lambda roll: self.depth) if self.depth.any() else flanks

    def describe(self) -> str:
        """Return the sentence for reports."""
        return f"Wear of the {self.gear} over its life: up to {1e6 * float(np.max(self.depth)):.4g} um"
