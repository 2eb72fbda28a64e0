"""Scales and errors of the model that do just what an effect of the catalogue does."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import Any

from gearfem.assembly import assemble
from gearfem.definition.setup import Setup
from gearfem.diagnosis.modelling.nuisances import Nuisance
from gearfem.diagnosis.modelling.unknowns import Unknowns
from gearfem.effects.effect import Effect
from gearfem.foundation import Record
from gearfem.sensing import System
from gearfem.variants import Variant


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class StandIn(Record):
    """An unknown of which some cause does the same.

    Parameters
    ----------
    place : int
        Where it stands among the unknowns.
    way : Nuisance or Variant
        What it is.
    system : System
        The model without it.
    """

    place: int
    way: Nuisance | Variant
    system: System

    def cause(self, moved: float) -> Any:
        """Return what does the same as the unknown so many prior deviations from the model: an effect, where the catalogue has one."""
        assert self.way.cause is not None
        return self.way.cause(self.system, self.way.value(moved))

    @cached_property
    def nominal(self) -> Any:
        """What does the same as the unknown where the model is right."""
        return self.cause(0.0)

    def serves(self, effect: Effect) -> bool:
        """Return whether it does what an effect does."""
        return type(self.nominal) is type(effect)

    def moved(self, effect: Effect) -> float:
        """Return by how many prior deviations the unknown is from the model where it does the same as an effect that it serves."""
        (field,) = effect.parameters()
        here, nominal = getattr(effect, field), getattr(self.nominal, field)
        return self.way.deviations(here / nominal if self.way.is_scale else here - nominal)

    def doubt(self, effect: Effect, field: str) -> float:
        """Return by how much a parameter of an effect that it serves is unknown since it is, in the parameter's own coordinate."""
        known = effect.parameters()[field]
        here, nominal, moved = (known.coordinate(getattr(one, field)) for one in (effect, self.nominal, self.cause(1.0)))
        return abs((moved - nominal) * (here / nominal if self.way.is_scale else 1.0))


def stand_ins(unknowns: Unknowns, setup: Setup) -> tuple[StandIn, ...]:
    """Return the unknowns of a pair that do just what a cause does."""
    ways = {place: unknowns.nuisances[place] for place in unknowns.scales} | dict(enumerate(unknowns.errors, unknowns.wrong.start))
    if not ways:
        return ()
    system = assemble(setup)
    return tuple(StandIn(place=place, way=way, system=system) for place, way in ways.items() if way.cause is not None)
