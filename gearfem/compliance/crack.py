"""What a crack in the root of one tooth adds to its compliance: a seam opened in the mesh of a sound ring."""

from __future__ import annotations

import dataclasses
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from gearfem.compliance.crack_mesh import crack_mesh, section_chord
from gearfem.compliance.elasticity import Plane, PlaneStrain
from gearfem.compliance.finite_elements import OFFSETS
from gearfem.compliance.harmonic_ring import CutRing
from gearfem.compliance.load_lines import load_lines
from gearfem.compliance.record import Compliance, ToothCompliance
from gearfem.compliance.seam import Seam
from gearfem.definition.setup import Member
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.cache import remembered
from gearfem.foundation.threads import one_thread
from gearfem.foundation.units import MM

# Deepest crack over the chord of the section, and how many depths are computed, closer to one another where they are small.
DEEPEST, DEPTHS = 0.75, 15
SHALLOWEST = 0.003
# Elements at the tip over the chord.
FINE = 5e-4


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class CrackTable(Record):
    """What cracks of several depths add to the compliance of a tooth.

    Parameters
    ----------
    chord : float
        Length of the section through both 30 degree tangent points [m].
    share : ndarray, shape (d,)
        Depths over the chord.
    deflection : ndarray, shape (d, n)
        What each adds to the deflection per line load at n load positions [m per N/m].
    coupling : ndarray, shape (d, o, n, n)
        What each adds to the coupling of o neighbours as in `ToothCompliance` [m per N/m].
    """

    chord: float
    share: Array
    deflection: Array
    coupling: Array

    @property
    def deepest(self) -> float:
        """Largest depth [m]."""
        return DEEPEST * self.chord

    @cached_property
    def _spline(self) -> CubicSpline:
        # A shallow crack in bent metal adds in proportion to its depth squared, a deep one over the square of what is left.
        scale = ((1.0 - self.share) / self.share)[:, None] ** 2
        return CubicSpline(self.share, scale * np.hstack([self.deflection, self.coupling.reshape(len(self.share), -1)]))

    def at(self, depth: float) -> tuple[Array, Array]:
        """Return what a crack of a depth [m] adds to deflection and coupling, shapes (n,), (o, n, n).

        Both are 0 at depth 0, and so are their slopes there: the first to grow is the square of the depth.

        Raises
        ------
        InputError
            If the depth is below 0 or above `deepest`.
        """
        _refuse_depth(depth, self.chord)
        share = depth / self.chord
        added = self._spline(share) * (share / (1.0 - share)) ** 2
        count = self.deflection.shape[1]
        return added[:count], added[count:].reshape(self.coupling.shape[1:])


def crack_table(
    outline: Outline, u: ArrayLike, offsets: tuple[int, ...] = OFFSETS, plane: Plane | None = None, resolution: float = 1.0
) -> CrackTable:
    """Compute what root cracks add to the compliance of one tooth in a sound ring; equal content costs one table per process.

    Parameters
    ----------
    outline : Outline
        Outline of the tooth; all teeth of the gear have it.
    u : array_like, shape (n,)
        Load positions in [2, 4).
    offsets : tuple of int
        Neighbours, as in `ToothCompliance`.
    plane : Plane
        By default plane strain.
    resolution : float
        Of the mesh.

    Returns
    -------
    CrackTable

    Raises
    ------
    InputError, SolveError
        If the fillet has no 30 degree tangent, or the mesh folds over.

    Notes
    -----
    The crack starts where the tangent of the fillet on the described side stands at 30 degrees to the tooth's axis, and runs straight
    through the section of both such points, square to that axis. Its faces touch without friction where a load presses them
    together; gaps and forces still grow in proportion to the load. On both gears of Wojnarowski & Onishchenko (2003) that
    happens under loads on the lowest 30 to 40 % of the flank (cracks of 0.3 of the section; 15 to 22 % at 0.1). Friction, which is
    not known, would hold the faces there, so that what is added is an upper bound for such loads.

    The increment is the displacement of the loaded point along its load, with the crack less without it, on one mesh; the
    contact is far from the crack, so that the local depth stays that of the sound tooth.

    Errors on the same gears: of the mesh, against twice its resolution, up to 1 % of the increment above the lowest
    third of the flank (0.5 % for depths above a tenth of the section) and up to 1.5 % of the sound tooth's deflection on it; of
    the interpolation over the depth the same. In a bent strip with an edge crack the same elements meet published stress
    intensities within 0.3 %. Left out is what the crack adds to a neighbour's own deflection: up to 0.1 % of it at a depth of 0.1 of
    the section, 0.4 % at 0.3, 0.8 % at 0.6, and a fifth more at 0.75.
    """
    return _table(outline, np.atleast_1d(np.asarray(u, dtype=float)), tuple(offsets), plane or PlaneStrain(), resolution)


@remembered
def _table(outline: Outline, u: Array, offsets: tuple[int, ...], plane: Plane, resolution: float) -> CrackTable:
    chord, teeth = section_chord(outline), outline.gear.teeth
    share = DEEPEST * np.linspace(0.0, 1.0, DEPTHS) ** 1.5
    share[0] = SHALLOWEST
    lines, ring, rows = load_lines(outline, u), None, []
    with one_thread():
        for part in share:
            section = crack_mesh(outline, float(part) * chord, FINE * chord, resolution)
            seam = Seam(section, plane, outline.gear.material, teeth, lines)
            ring = ring or CutRing(seam.schur, teeth)
            rows.append(seam.increments(ring, offsets))
    own, others = (np.array(values) for values in zip(*rows, strict=True))
    return CrackTable(chord=chord, share=share, deflection=own, coupling=others)


def cracked(tooth: ToothCompliance, depth: float, plane: Plane | None = None) -> ToothCompliance:
    """Return a tooth with a crack in the root of its loaded side.

    Parameters
    ----------
    tooth : ToothCompliance
        The tooth without this crack, on a sound gear.
    depth : float
        Of the crack [m]; 0 gives every array back bit for bit.
    plane : Plane
        That in which the tooth was computed, by default plane strain.

    Returns
    -------
    ToothCompliance
        With a larger deflection and another coupling: what neighbours see of this tooth and, transposed, what it sees of them.

    Raises
    ------
    InputError
        If the depth is below 0 or above 0.75 of the section, or the fillet has no 30 degree tangent.
    """
    _refuse_depth(depth, section_chord(tooth.outline))
    deflection, coupling = crack_table(tooth.outline, tooth.u, tooth.offsets, plane).at(depth)
    return dataclasses.replace(tooth, deflection=tooth.deflection + deflection, coupling=tooth.coupling + coupling)


def crack_tooth(compliance: Compliance, member: Member, number: int, depth: float, plane: Plane | None = None) -> Compliance:
    """Return the compliance of a pair with a crack in the root of one tooth.

    Parameters
    ----------
    compliance : Compliance
        The pair without this crack.
    member : {"pinion", "wheel"}
        Gear of the tooth.
    number : int
        Of the tooth.
    depth : float
        Of the crack [m].
    plane : Plane
        As in `cracked`.

    Returns
    -------
    Compliance
        With this tooth among the odd ones of its gear.

    Raises
    ------
    InputError
        If the gear has no such tooth, or as `cracked`.
    """
    teeth = compliance.of(member).outline.gear.teeth
    if not 0 <= number < teeth:
        raise InputError("tooth", number, f"0 to {teeth - 1}, the teeth of the {member}")
    odd = compliance.odd(member)
    odd[number] = cracked(odd.get(number, compliance.of(member)), depth, plane)
    changed = tuple((key, odd[key]) for key in sorted(odd))
    if member == "pinion":
        return dataclasses.replace(compliance, pinion_odd=changed)
    return dataclasses.replace(compliance, wheel_odd=changed)


def deepest_crack(outline: Outline) -> float:
    """Return the depth [m] up to which cracks are computed: 0.75 of the section through both 30 degree tangents."""
    return DEEPEST * section_chord(outline)


def _refuse_depth(depth: float, chord: float) -> None:
    if not 0.0 <= depth <= DEEPEST * chord:
        allowed = f"0 to {DEEPEST * chord / MM:.4g} mm, {DEEPEST:g} of the section through the 30 degree tangents"
        raise InputError("depth_mm", f"{depth / MM:g}", allowed)
