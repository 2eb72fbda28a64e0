"""How our own model may be wrong: variants of a system, each at one standard deviation."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from gearfem.compliance.body import scale_body
from gearfem.compliance.record import ToothCompliance
from gearfem.contact.scaled import ScaledLaw
from gearfem.effects.centre_distance import CentreDistance
from gearfem.effects.lead_misalignment import LeadMisalignment
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


def _deeper(system: System) -> System:
    def deeper(tooth: ToothCompliance) -> ToothCompliance:
        return dataclasses.replace(tooth, local_depth=tooth.depth**2 / tooth.local_depth)

    return dataclasses.replace(system, compliance=system.compliance.each(deeper))


def _misaligned(system: System) -> System:
    effect = LeadMisalignment(slope=MISALIGNED)
    return dataclasses.replace(system, flanks=effect.act(system.flanks, system.setup))


def _misplaced(system: System) -> System:
    effect = CentreDistance(amount=MISPLACED)
    return dataclasses.replace(system, placement=effect.act(system.placement, system.setup))


# Sizes: what independent ways of computing each part differ by, and what nobody measured (friction, alignment, centre distance). Laws of
# contact: the linear one of Yang and Sun yields a third of Weber and Banaschek's. Depth rules: twice the way from the depth that yields as
# the tooth does to Weber and Banaschek's.
VARIANTS = (
    Variant(words="contact law, 50 %", change=_contact(1.50)),
    Variant(words="gear bodies, 20 %", change=_body(1.20)),
    Variant(words="depth of the contact", change=_deeper),
    Variant(words="tooth friction, 0.02", change=_friction(0.02)),
    Variant(words="misalignment, 1 um over the face width", change=_misaligned),
    Variant(words="centre distance, 20 um", change=_misplaced),
)
