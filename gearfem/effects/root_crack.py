"""Root crack: a tooth that hinges on what is left of its root."""

from __future__ import annotations

import dataclasses

from gearfem.compliance import crack_tooth
from gearfem.compliance.crack import DEEPEST
from gearfem.compliance.crack_mesh import section_chord
from gearfem.compliance.record import Compliance
from gearfem.definition.setup import Member, Setup
from gearfem.effects.effect import Effect, Size, parameter
from gearfem.flank import Outline


def of_section(share: float) -> Size:
    """Return a share of the section through both 30 degree tangent points [m]."""
    return lambda setup, member: share * section_chord(Outline(gear=setup.pair.gear(member)))


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class RootCrack(Effect):
    """A crack from the 30 degree tangent point of the tensile fillet along the section through both such points."""

    name = "root_crack"
    stage = "compliance"
    repeats = "one tooth"
    history = "worn"
    sentence = "Root crack in tooth {tooth} of the {gear}: {depth_mm} mm deep"
    source = "Section of ISO 6336-3; a seam opened in the finite elements"

    gear: Member
    tooth: int
    depth: float = parameter(
        "depth from the tensile fillet into the tooth", "mm", low=0.0, high=of_section(DEEPEST), typical=of_section(0.2), neutral=0.0
    )

    def act(self, compliance: Compliance, setup: Setup) -> Compliance:
        """Add what the crack adds to the compliance of the tooth."""
        return crack_tooth(compliance, self.gear, self.tooth, self.depth)
