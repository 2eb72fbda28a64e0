"""Tooth compliance by two-dimensional finite elements."""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gearfem.compliance.elasticity import QUADRATURE, Plane, PlaneStrain, stiffness
from gearfem.compliance.field import Field, make_field
from gearfem.compliance.harmonic_ring import HarmonicRing
from gearfem.compliance.load_lines import LoadLines, covered, forces, load_lines, readings
from gearfem.compliance.local_depth import local_depth
from gearfem.compliance.patchwork import Ids, refuse_folds
from gearfem.compliance.record import ComplianceCurve, ToothCompliance
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.compliance.supports import Bore, Structure, Support
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.cache import remembered
from gearfem.foundation.threads import one_thread

OFFSETS = (-3, -2, -1, 1, 2, 3)
# Ratio of the resolutions whose comparison gives the estimate of the error.
COARSER = 1.5


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class FiniteElements(Record):
    """Compliance from second-order plane finite elements on a structured mesh.

    Parameters
    ----------
    plane : Plane
        `PlaneStrain` (wide gears) or `PlaneStress` (thin ones).
    support : Support
        `Bore` (the whole gear), `Root` or `RootChord` (the tooth alone).
    resolution : float
        Elements along each side relative to a mesh of half-module elements, at least 1.

    Raises
    ------
    InputError
        If the resolution is below 1.

    Notes
    -----
    The deflection is read where the load line crosses the tooth's centreline, so that the unbounded dent under
    a line load stays out. Load and reading are both point sources; for elements of degree 2 the error of the reading is
    the product of the errors of two Green's functions, summed around their poles: h^(2 + 1) in the element size h. Orders
    fitted on four gears lie between 2.8 and 3.6. At the default resolution the largest error over the flank, against resolution 8 or
    more, is 0.05 % on both gears of Wojnarowski & Onishchenko (2003), bore and root held, and 0.09 % on eight gears of 8 to 200 teeth
    with rims from 0.1 modules up to nearly full discs.

    A position is left out where its load line meets the axis under the support: compare lengths to see how many.

    Examples
    --------
    >>> import math
    >>> from gearfem.definition.setup import Gear, Material, Rack
    >>> gear = Gear(teeth=17, module=1e-3, pressure_angle=math.radians(20), profile_shift=0.0, flank_thinning=0.0,
    ...             root_radius=7.25e-3, tip_radius=9.5e-3, tip_edge_radius=2e-5, bore_radius=4e-3, rack=Rack(),
    ...             material=Material())
    >>> curve = FiniteElements().curve(Outline(gear=gear), [2.2, 2.8])
    >>> bool(curve.deflection[1] > curve.deflection[0] > 0.0)
    True
    """

    plane: Plane = dataclasses.field(default_factory=PlaneStrain)
    support: Support = dataclasses.field(default_factory=Bore)
    resolution: float = 3.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.resolution >= 1.0:
            raise InputError("resolution", self.resolution, "a number from 1 (coarse) upwards; 3 is the default")

    @property
    def name(self) -> str:
        """Name in files, such as ``fe_plane_strain``."""
        return f"fe_{self.plane.name}"

    def curve(self, outline: Outline, u: ArrayLike) -> ComplianceCurve:
        """Return the compliance over load positions.

        Parameters
        ----------
        outline : Outline
            Outline of the tooth, and through it the gear.
        u : array_like, shape (n,)
            Increasing positions in [2, 4).

        Returns
        -------
        ComplianceCurve
            Without the positions whose load line crosses the centreline under the support.

        Raises
        ------
        InputError, SolveError
            If a position is not on the flank, no crossing lies above the support, or the mesh folds over.
        """
        return _curve(self, outline, np.atleast_1d(np.asarray(u, dtype=float)))

    def tooth(self, outline: Outline, u: ArrayLike, offsets: tuple[int, ...] = OFFSETS) -> ToothCompliance:
        """Return the compliance over load positions and its coupling to the neighbours, the bore held.

        Parameters
        ----------
        outline, u
            As for `curve`.
        offsets : tuple of int
            Neighbours, +1 at one pitch towards positive y.

        Returns
        -------
        ToothCompliance

        Raises
        ------
        InputError
            If the support is not the bore, besides the reasons of `curve`.
        """
        if 0 in offsets:
            raise InputError("offsets", offsets, "numbers of neighbours, without 0")
        return _tooth(self, outline, np.atleast_1d(np.asarray(u, dtype=float)), tuple(offsets))

    def error(self, outline: Outline, u: ArrayLike) -> Array:
        """Estimate the relative error of `curve` at each of its positions.

        Parameters
        ----------
        outline, u
            As for `curve`.

        Returns
        -------
        ndarray, shape (n,)
            Positive estimates, of the positions that `curve` keeps.

        Raises
        ------
        InputError
            If the resolution is below 1.5, so that there is no coarser mesh, besides the reasons of `curve`.

        Notes
        -----
        Richardson's comparison with a mesh coarser by 1.5: error = |d - d_coarse| / (1.5^p - 1). p = 2 is taken, below
        the order 3 that is observed, and the largest difference of each position and its two neighbours, because the sign of the
        error changes along the flank.
        """
        if self.resolution < COARSER:
            raise InputError("resolution", self.resolution, f"at least {COARSER:g} for an estimate of the error from a coarser mesh")
        coarse = dataclasses.replace(self, resolution=self.resolution / COARSER)
        return changed(self.curve(outline, u).deflection, coarse.curve(outline, u).deflection)

    def field(self, outline: Outline, u: float, force_per_width: float, neighbours: int = 1) -> Field:
        """Return displacement and stress of the loaded tooth and of sectors on each side.

        Parameters
        ----------
        outline : Outline
            Outline of the tooth.
        u : float
            Load position in [2, 4).
        force_per_width : float
            Line load [N/m].
        neighbours : int
            Sectors shown on each side, at most up to the opposite one; ignored for a tooth held at its root, which has none.

        Returns
        -------
        Field

        Raises
        ------
        InputError
            If the position is not on the flank, or the gear has not so many neighbours.
        """
        most = (outline.gear.teeth - 1) // 2
        if not 0 <= neighbours <= most:
            raise InputError("neighbours", neighbours, f"0 to {most} on each side of a tooth of this gear")
        lines = load_lines(outline, u)
        section = self._mesh(outline)
        beside = neighbours if len(section.upper) else 0
        offsets = tuple(range(-beside, beside + 1))
        with one_thread():
            load = force_per_width * forces(section, lines)
            matrix = stiffness(section.mesh, self.plane, outline.gear.material)
            moved = self._structure(outline, section, matrix, load).displacements(load, offsets)[:, :, 0]
        return make_field(section, moved, outline, self.plane, lines, force_per_width)

    # ---- steps ------------------------------------------------------------------------------------------

    def _mesh(self, outline: Outline) -> SectionMesh:
        section = self.support.section(outline, self.resolution)
        refuse_folds(section.mesh, QUADRATURE[0], "change the bore radius, the rack's tip radius or the tip edge radius")
        return section

    def _structure(self, outline: Outline, section: SectionMesh, matrix: Any, *weights: Array) -> Structure:
        """Return the structure of this stiffness matrix that takes these nodal forces and readings."""
        return self.support.structure(section, matrix, outline.gear.teeth, used_by(*weights))

    def _loads(self, outline: Outline, u: Array) -> SectionLoads:
        section, lines = self._mesh(outline), load_lines(outline, u)
        inside = covered(section, lines)
        if not inside.any():
            found = f"{len(lines.u)} load lines that all cross the tooth's centreline under it"
            raise InputError(f"support {self.support.name}", found, "a position higher on the flank, or another support")
        lines = lines.kept(inside)
        load, reading = forces(section, lines), readings(section, lines)
        return SectionLoads(section, stiffness(section.mesh, self.plane, outline.gear.material), lines, load, reading)

    def _loaded(self, outline: Outline, u: Array) -> tuple[SectionLoads, Structure]:
        loads = self._loads(outline, u)
        return loads, self._structure(outline, loads.section, loads.matrix, loads.load, loads.reading)

    def _columns(self, loads: SectionLoads, structure: Structure) -> dict[str, Any]:
        return {
            "method": self.name,
            "support": self.support.name,
            "u": loads.lines.u,
            "radius": loads.lines.radius,
            "deflection": structure.deflection(loads.load, loads.reading),
            "depth": loads.lines.depth,
        }

    def _local_depth(self, outline: Outline, loads: SectionLoads, structure: Structure) -> Array:
        squeezed = structure.displacements(loads.load - loads.reading, (0,))[0]
        return local_depth(loads.section, outline, loads.lines, squeezed, loads.matrix, self.plane)


class SectionLoads(NamedTuple):
    """A meshed section, its stiffness, and loads and readings of shape (2 n, k)."""

    section: SectionMesh
    matrix: Any
    lines: LoadLines
    load: Array
    reading: Array


def used_by(*weights: Array) -> Ids:
    """Return the nodes that take any of some loads or readings, shapes (2 n, k)."""
    return np.flatnonzero(np.any([np.any(weight != 0.0, axis=1).reshape(2, -1).any(axis=0) for weight in weights], axis=0))


def changed(fine: Array, coarse: Array) -> Array:
    """Return the relative error of a curve from one on a mesh coarser by `COARSER`, as `FiniteElements.error` explains."""
    padded = np.pad(np.abs(coarse - fine) / fine, 1, mode="edge")
    largest: Array = np.maximum.reduce([padded[:-2], padded[1:-1], padded[2:]])
    return largest / (COARSER**2 - 1.0)


# ---- remembered: equal content costs one solve per process ------------------------------------------


@remembered
def _curve(method: FiniteElements, outline: Outline, u: Array) -> ComplianceCurve:
    with one_thread():
        return ComplianceCurve(**method._columns(*method._loaded(outline, u)))


@remembered
def _tooth(method: FiniteElements, outline: Outline, u: Array, offsets: tuple[int, ...]) -> ToothCompliance:
    with one_thread():
        loads, ring = method._loaded(outline, u)
        if not isinstance(ring, HarmonicRing):
            raise InputError("support", method.support.name, "bore: a tooth held at its root is not coupled to its neighbours")
        coupling = ring.coupling(loads.load, offsets)
        depth = method._local_depth(outline, loads, ring)
        return ToothCompliance(**method._columns(loads, ring), outline=outline, offsets=offsets, coupling=coupling, local_depth=depth)
