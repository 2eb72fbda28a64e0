"""What a command does not show of the effects that its model names, said in one line."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection

from gearfem.assembly import effects_in, flanks_of
from gearfem.definition.setup import Setup
from gearfem.effects.effect import Effect, Stage
from gearfem.flank import Flanks
from gearfem.flank.lead import Lead
from gearfem.foundation import digest

SHAPES: tuple[Stage, ...] = ("flank",)
TEETH: tuple[Stage, ...] = (*SHAPES, "compliance")
ENGAGED: tuple[Stage, ...] = (*TEETH, "placement", "contact")
MOVING: tuple[Stage, ...] = (*ENGAGED, "drive")
WHERE: dict[Stage, str] = {
    "flank": "stiffness, kinematics and dynamics",
    "compliance": "compliance, stiffness and dynamics",
    "placement": "stiffness, kinematics and dynamics",
    "contact": "stiffness, kinematics and dynamics",
    "drive": "dynamics",
    "sensing": "measure and diagnose",
}


def unseen(setup: Setup, stages: Collection[Stage], lead: bool = True) -> list[str]:
    """Say which effects of a model do not act in what a command computes, and where they do.

    Parameters
    ----------
    setup : Setup
        The model.
    stages : collection of Stage
        Those whose effects act.
    lead : bool
        Whether gaps along the face width do.

    Returns
    -------
    list of str
        One line, or none.
    """
    places: dict[str, list[str]] = {}
    for effect in effects_in(setup):
        if effect.stage not in stages or (effect.stage == "flank" and not lead and along_width(effect, setup)):
            places.setdefault(WHERE[effect.stage], []).append(effect.name)
    parts = [f"{', '.join(dict.fromkeys(names))} (gearfem {where})" for where, names in places.items()]
    return [f"not in these results, but in those of other commands: {'; '.join(parts)}"] if parts else []


def along_width(effect: Effect, setup: Setup) -> bool:
    """Return whether an effect of the flanks opens gaps along the face width alone."""

    def shapes(effects: tuple[Effect, ...]) -> Flanks:
        return dataclasses.replace(flanks_of(dataclasses.replace(setup, effects=effects)), lead=Lead())

    return digest(shapes((effect,))) == digest(shapes(()))
