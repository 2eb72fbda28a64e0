"""What the compliance stage hands on: deflection per line load, per gear, over the load's position."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from gearfem.definition.setup import Member
from gearfem.flank import Outline
from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class ComplianceCurve(Record):
    """Deflection of one tooth of one gear along the load line, where that line crosses the tooth's centreline.

    Parameters
    ----------
    method, support : str
        How it was computed (``fe_plane_strain``, ``fe_plane_stress``, ``castigliano``) and what was held
        (``bore``, ``root``, ``root_chord``).
    u : ndarray, shape (n,)
        Load positions as parameters of the `Outline`, increasing; loads are normal to it, into the metal.
    radius : ndarray, shape (n,)
        Radii of the load points [m].
    deflection : ndarray, shape (n,)
        Deflection per line load [m per N/m].
    depth : ndarray, shape (n,)
        Distance from the load point to the centreline along the load line [m].
    error : ndarray, shape (n,), optional
        Estimate of the relative error of `deflection` that the method's own arithmetic makes: of the mesh for finite
        elements, of rounding for a closed form. It says nothing of what the method leaves out.
    """

    method: str
    support: str
    u: Array
    radius: Array
    deflection: Array
    depth: Array
    error: Array | None = None


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class ToothCompliance(ComplianceCurve):
    """A compliance curve with the coupling of neighbour teeth through the body.

    Parameters
    ----------
    outline : Outline
        Outline of the teeth that were computed.
    offsets : tuple of int
        Neighbours described, without 0. +1 is the neighbour on the side of the loaded flank (at one pitch
        towards positive y of the `Outline`), -1 the one behind.
    coupling : ndarray, shape (len(offsets), n, n)
        coupling[k, i, j]: displacement of flank point i of the neighbour offsets[k], along the inward normal
        there, per line load at point j of the loaded tooth [m per N/m]. Reciprocity: the table of -o is the
        transpose of that of +o.
    local_depth : ndarray, shape (n,)
        Depth of the half space that yields under a line load as the tooth does between the contact and the centreline [m]:
        the law of contact adds that part, which `deflection` leaves out. See `gearfem.compliance.local_depth`.
    sound_depth : ndarray, shape (n,), optional
        The same of teeth with nothing missing, where metal is missing from these.
    """

    outline: Outline
    offsets: tuple[int, ...]
    coupling: Array
    local_depth: Array
    sound_depth: Array | None = None

    def coupled(self, scale: float) -> ToothCompliance:
        """Return the same tooth, neighbours of which feel a multiple of its load; what the nearest two lose or gain on average is its own.

        Two neighbours under equal loads yield as before: a scale says where deflection is felt, not how much of it there is.
        """
        nearest = np.mean([np.diagonal(self.coupling[self.offsets.index(offset)]) for offset in (-1, 1)], axis=0)
        return dataclasses.replace(self, deflection=self.deflection + (1.0 - scale) * nearest, coupling=scale * self.coupling)

    def on_half_space(self) -> ToothCompliance:
        """Return the same tooth, a half space down to its centreline as the rule of Weber and Banaschek (1953) has it."""
        return dataclasses.replace(self, local_depth=self.depth, sound_depth=None)

    def sound(self) -> ToothCompliance:
        """Return the same tooth, its contact as deep as with nothing missing."""
        return self if self.sound_depth is None else dataclasses.replace(self, local_depth=self.sound_depth, sound_depth=None)

    def deeper(self, scale: float) -> ToothCompliance:
        """Return the same tooth with a multiple of the depth of its contact."""
        sound = None if self.sound_depth is None else scale * self.sound_depth
        return dataclasses.replace(self, local_depth=scale * self.local_depth, sound_depth=sound)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Compliance(Record):
    """Compliance of both gears, whole, each held at its bore.

    Parameters
    ----------
    pinion, wheel : ToothCompliance
        One tooth of each gear and its coupling to the neighbours.
    pinion_odd, wheel_odd : tuple of (int, ToothCompliance)
        Teeth that yield differently (cracked ones), by number.
    """

    pinion: ToothCompliance
    wheel: ToothCompliance
    pinion_odd: tuple[tuple[int, ToothCompliance], ...] = ()
    wheel_odd: tuple[tuple[int, ToothCompliance], ...] = ()

    def of(self, member: Member) -> ToothCompliance:
        """Return the compliance of one member."""
        return self.pinion if member == "pinion" else self.wheel

    def on_half_space(self) -> Compliance:
        """Return the same teeth, half spaces between contact and centreline (Weber and Banaschek), for comparison."""
        return self.each(ToothCompliance.on_half_space)

    def coupled(self, scale: float) -> Compliance:
        """Return the same teeth, neighbours of which feel a multiple through the body, see `ToothCompliance.coupled`; 1 changes no bit."""
        return self.each(lambda tooth: tooth.coupled(scale))

    def each(self, change: Callable[[ToothCompliance], ToothCompliance]) -> Compliance:
        """Return what a change of single teeth makes of all of them."""
        return dataclasses.replace(
            self,
            pinion=change(self.pinion),
            wheel=change(self.wheel),
            pinion_odd=tuple((number, change(tooth)) for number, tooth in self.pinion_odd),
            wheel_odd=tuple((number, change(tooth)) for number, tooth in self.wheel_odd),
        )

    def odd(self, member: Member) -> dict[int, ToothCompliance]:
        """Return the teeth that yield differently, by number."""
        return dict(self.pinion_odd if member == "pinion" else self.wheel_odd)
