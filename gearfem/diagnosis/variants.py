"""How our own model may be wrong: variants of a system, each at one standard deviation."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from gearfem.compliance.body import scale_body
from gearfem.contact.scaled import ScaledLaw
from gearfem.effects.centre_distance import CentreDistance
from gearfem.effects.lead_misalignment import LeadMisalignment
from gearfem.flank import Outline
from gearfem.foundation.units import UM
from gearfem.sensing import System

# Housings and bearings hold shafts to some hundredths of a millimetre.
MISALIGNED, MISPLACED = 1.0 * UM, 20.0 * UM


@dataclasses.dataclass(frozen=True, kw_only=True)
class Variant:
    """A way in which the model may be wrong, at one standard deviation.

    Parameters
    ----------
    words : str
        For reports.
    change : callable
        Takes a System and returns the variant.
    """

    words: str
    change: Callable[[System], System]


def _contact(scale: float) -> Callable[[System], System]:
    return lambda system: dataclasses.replace(system, law=ScaledLaw(law=system.law, scale=scale))


def _body(scale: float) -> Callable[[System], System]:
    return lambda system: dataclasses.replace(system, compliance=scale_body(system.compliance, scale))


def _friction(coefficient: float) -> Callable[[System], System]:
    def change(system: System) -> System:
        drive = system.drive
        return dataclasses.replace(system, drive=dataclasses.replace(drive, friction_coefficient=drive.friction_coefficient + coefficient))

    return change


def _half_space(system: System) -> System:
    return dataclasses.replace(system, compliance=system.compliance.on_half_space())


def _sharp_edges(system: System) -> System:
    flanks = system.flanks

    def sharper(outline: Outline) -> Outline:
        return dataclasses.replace(outline, gear=dataclasses.replace(outline.gear, tip_edge_radius=0.25 * outline.gear.tip_edge_radius))

    # The compliance stays: its table counts from form circle to round, whose beginning moves by a hundredth of the flank.
    flanks = dataclasses.replace(
        flanks,
        pinion=sharper(flanks.pinion),
        wheel=sharper(flanks.wheel),
        pinion_odd=tuple((number, sharper(outline)) for number, outline in flanks.pinion_odd),
        wheel_odd=tuple((number, sharper(outline)) for number, outline in flanks.wheel_odd),
    )
    return dataclasses.replace(system, flanks=flanks)


def _misaligned(system: System) -> System:
    effect = LeadMisalignment(slope=MISALIGNED)
    return dataclasses.replace(system, flanks=effect.act(system.flanks, system.setup))


def _misplaced(system: System) -> System:
    effect = CentreDistance(amount=MISPLACED)
    return dataclasses.replace(system, placement=effect.act(system.placement, system.setup))


# Sizes: what independent ways of computing each part differ by (Hertz depth rules, body formulae), and friction,
# alignment and centre distance that nobody measured.
VARIANTS = (
    Variant(words="contact law, 20 %", change=_contact(1.20)),
    Variant(words="gear bodies, 20 %", change=_body(1.20)),
    Variant(words="depth of the contact", change=_half_space),
    Variant(words="tooth friction, 0.02", change=_friction(0.02)),
    Variant(words="tip edges, from 0.02 to 0.005 modules", change=_sharp_edges),
    Variant(words="misalignment, 1 um over the face width", change=_misaligned),
    Variant(words="centre distance, 20 um", change=_misplaced),
)
