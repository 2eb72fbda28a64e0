"""How a model may be wrong though nothing is missing from it, and the variants of a system that are."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable

from gearfem.compliance.body import scale_body
from gearfem.compliance.record import ToothCompliance
from gearfem.contact.scaled import ScaledLaw
from gearfem.effects.centre_distance import CentreDistance
from gearfem.effects.lead_misalignment import LeadMisalignment
from gearfem.foundation.units import UM
from gearfem.sensing import System


@dataclasses.dataclass(frozen=True, kw_only=True)
class Variant:
    """A way in which a model may be wrong.

    Parameters
    ----------
    name : str
        Field of `Calibration`.
    words : str
        For reports, with its standard deviation.
    act : callable
        Takes a System and the value of the field, and returns the system that is wrong by so much.
    size : float
        One standard deviation: a factor, or what is added [SI].
    is_scale : bool
        Whether it multiplies.
    least, most : float
        How far the model can follow, in standard deviations; beyond, responses go on in straight lines.
    """

    name: str
    words: str
    act: Callable[[System, float], System]
    size: float
    is_scale: bool
    least: float = -4.0
    most: float = 4.0

    def value(self, moved: float) -> float:
        """Return the value of the field so many standard deviations from a model that is right."""
        return self.size**moved if self.is_scale else self.size * moved

    def both(self, one: float, other: float) -> float:
        """Return the value of two errors together."""
        return one * other if self.is_scale else one + other


def varied(system: System, errors: Iterable[tuple[Variant, float]]) -> System:
    """Return a system that is wrong in some ways, by the value of each."""
    for variant, value in errors:
        system = variant.act(system, value) if value != variant.value(0.0) else system
    return system


def _contact(system: System, scale: float) -> System:
    return dataclasses.replace(system, law=ScaledLaw(law=system.law, scale=scale))


def _body(system: System, scale: float) -> System:
    return dataclasses.replace(system, compliance=scale_body(system.compliance, scale))


def _depth(system: System, scale: float) -> System:
    def deeper(tooth: ToothCompliance) -> ToothCompliance:
        return dataclasses.replace(tooth, local_depth=tooth.local_depth * scale)

    return dataclasses.replace(system, compliance=system.compliance.each(deeper))


def _friction(system: System, coefficient: float) -> System:
    drive = system.drive
    return dataclasses.replace(system, drive=dataclasses.replace(drive, friction_coefficient=drive.friction_coefficient + coefficient))


def _misaligned(system: System, slope: float) -> System:
    return dataclasses.replace(system, flanks=LeadMisalignment(slope=slope).act(system.flanks, system.setup))


def _misplaced(system: System, amount: float) -> System:
    return dataclasses.replace(system, placement=CentreDistance(amount=amount).act(system.placement, system.setup))


# Sizes: what independent ways of computing each part differ by, and what nobody measured. Laws of contact: the linear one of Yang and Sun
# yields a third of Weber and Banaschek's. Depth of the contact: twice the way from the depth that yields as the tooth does to Weber and
# Banaschek's. Housings and bearings hold shafts to some hundredths of a millimetre. Friction and misalignment act alike to either side.
VARIANTS = (
    Variant(name="contact_scale", words="contact law, 50 %", act=_contact, size=1.5, is_scale=True),
    Variant(name="body_scale", words="gear bodies, 20 %", act=_body, size=1.2, is_scale=True),
    Variant(name="depth_scale", words="depth of the contact, 40 %", act=_depth, size=0.6, is_scale=True, least=-2.0, most=2.0),
    Variant(name="friction", words="tooth friction, 0.02", act=_friction, size=0.02, is_scale=False, least=0.0),
    Variant(name="misalignment", words="misalignment, 1 um over the face width", act=_misaligned, size=1.0 * UM, is_scale=False, least=0.0),
    Variant(name="centre_distance", words="centre distance, 20 um", act=_misplaced, size=20.0 * UM, is_scale=False, least=-2.0),
)
