"""What holds a gear or a tooth: the bore of the whole gear, or the root of the tooth alone."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, Protocol

from gearfem.compliance.alone import Alone
from gearfem.compliance.harmonic_ring import HarmonicRing
from gearfem.compliance.patchwork import Ids
from gearfem.compliance.ring import Ring
from gearfem.compliance.section_mesh import SectionMesh, root_mesh, sector_mesh
from gearfem.compliance.uneven_ring import Sector, UnevenRing
from gearfem.flank import Outline
from gearfem.foundation import Array, Record

# The tooth alone is read closer to its clamp than the whole gear; its mesh is small enough to be finer.
FINER = 2.0


class Structure(Protocol):
    """A supported structure that takes loads on one tooth."""

    def deflection(self, load: Array, reading: Array) -> Array:
        """Return what each reading shows under the load of the same column."""

    def displacements(self, load: Array, offsets: tuple[int, ...]) -> Array:
        """Return the nodal displacements of sectors under the loads on sector 0."""


class Support(Protocol):
    """What is held, and so what is meshed."""

    name: ClassVar[str]

    def section(self, outline: Outline, resolution: float) -> SectionMesh:
        """Return the mesh of one sector or tooth."""

    def structure(self, section: SectionMesh, stiffness: Any, teeth: int, ports: Ids | None = None) -> Structure:
        """Return the factorised structure, which takes loads and readings at the nodes `ports`, if they are given."""


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Bore(Record):
    """The whole gear, held on its bore: tooth, body and the wind-up between bore and teeth."""

    name: ClassVar[str] = "bore"

    def section(self, outline: Outline, resolution: float) -> SectionMesh:
        """Return the mesh of one sector."""
        return sector_mesh(outline, resolution)

    def structure(self, section: SectionMesh, stiffness: Any, teeth: int, ports: Ids | None = None) -> HarmonicRing:
        """Return the ring of all sectors."""
        if section.symmetric:
            return Ring(section, stiffness, teeth, ports)
        return UnevenRing(Sector(section, stiffness, teeth, ports), teeth)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Root(Record):
    """The tooth above the root circle, held on the arc between the ends of its two fillets."""

    name: ClassVar[str] = "root"

    def section(self, outline: Outline, resolution: float) -> SectionMesh:
        """Return the mesh of the tooth."""
        return root_mesh(outline, FINER * resolution, chord=False)

    def structure(self, section: SectionMesh, stiffness: Any, teeth: int, ports: Ids | None = None) -> Alone:
        """Return the tooth alone."""
        return Alone(section, stiffness)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class RootChord(Record):
    """The tooth above the straight chord between the ends of its two fillets, held on that chord."""

    name: ClassVar[str] = "root_chord"

    def section(self, outline: Outline, resolution: float) -> SectionMesh:
        """Return the mesh of the tooth."""
        return root_mesh(outline, FINER * resolution, chord=True)

    def structure(self, section: SectionMesh, stiffness: Any, teeth: int, ports: Ids | None = None) -> Alone:
        """Return the tooth alone."""
        return Alone(section, stiffness)
