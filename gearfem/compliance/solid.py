"""Tooth compliance by three-dimensional finite elements."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from gearfem.compliance.elasticity import ELEMENT, QUADRATURE
from gearfem.compliance.face_width import FaceWidth, graded_places
from gearfem.compliance.load_lines import LoadLines, covered, forces, load_lines, readings
from gearfem.compliance.patchwork import refuse_folds
from gearfem.compliance.prism import section_matrices, solve_prism
from gearfem.compliance.record import ComplianceCurve
from gearfem.compliance.section_mesh import SectionMesh
from gearfem.compliance.solid_field import SolidField, von_mises_3d
from gearfem.compliance.solid_mesh import SolidMesh, solid_mesh
from gearfem.compliance.supports import Bore, Support
from gearfem.compliance.width_record import WidthInfluence, WidthProfile
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.threads import one_thread


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SolidElements(Record):
    """Compliance from triquadratic hexahedra (27 nodes, full integration) on the extruded section.

    Parameters
    ----------
    support : Support
        `Bore` (the whole gear, as wide as its teeth, held on the bore), `Root` or `RootChord` (the tooth alone).
    resolution : float
        Resolution of the section, as of `FiniteElements`, at least 0.5.
    layers : int
        Elements along the face width under a uniform load, at least 2; they crowd towards the ends, and where loads end more are added.

    Raises
    ------
    InputError
        If resolution or layers are too small.

    Notes
    -----
    The deflection is read as in the plane: where the load line crosses the tooth's centreline. Between plane stress (face width
    small against the module) and plane strain (large, at mid-face). The ends of a wide face are softer than its middle, since they do
    not share their load with a neighbour on both sides and are free to bulge.

    All support is on the section, the same over the width: the whole ring of sectors is solved in three dimensions by harmonics,
    without a cut through the body.

    At the default resolution, on the coal combine pair of Wojnarowski & Onishchenko (2003), the width average with the root held
    is within 0.02 % of that at twice the resolution and the layers, the ends of the face within 0.05 %. With the bore held
    the sections are as coarse as `FiniteElements` at this resolution, which is then 0.1 to 0.3 % too stiff.

    Examples
    --------
    >>> import math
    >>> from gearfem.definition.setup import Gear, Material, Rack
    >>> from gearfem.compliance import Root
    >>> gear = Gear(teeth=17, module=1e-3, pressure_angle=math.radians(20), profile_shift=0.0, flank_thinning=0.0,
    ...             root_radius=7.25e-3, tip_radius=9.5e-3, tip_edge_radius=2e-5, bore_radius=4e-3, rack=Rack(),
    ...             material=Material())
    >>> profile = SolidElements(support=Root(), resolution=0.5, layers=4).profile(Outline(gear=gear), 2.8, 0.01)
    >>> profile.mid < profile.average < min(profile.ends)
    True
    """

    support: Support = dataclasses.field(default_factory=Bore)
    resolution: float = 1.5
    layers: int = 12

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.resolution >= 0.5:
            raise InputError("resolution", self.resolution, "a number from 0.5 (coarse) upwards; 1.5 is the default")
        if not self.layers >= 2:
            raise InputError("layers", self.layers, "a whole number from 2 upwards; 12 is the default")

    @property
    def name(self) -> str:
        """Name in files, ``fe_3d``."""
        return "fe_3d"

    def curve(self, outline: Outline, u: ArrayLike, face_width: float) -> ComplianceCurve:
        """Return the compliance under a uniform load, averaged over the face width.

        Parameters
        ----------
        outline : Outline
            Outline of the tooth, and through it the gear.
        u : array_like, shape (n,)
            Increasing positions in [2, 4).
        face_width : float
            Face width [m].

        Returns
        -------
        ComplianceCurve
            Without the positions whose load line crosses the centreline under the support.

        Raises
        ------
        InputError, SolveError
            If a position is not on the flank, no crossing lies above the support, the mesh folds over, or the solution
            does not converge.
        """
        section, lines = self._section(outline, u)
        width = self._width(outline, face_width)
        deflection = width.average @ self._profiles(
            outline, section, width, lines, np.tile(width.load(*_whole(width)), (len(lines.u), 1)).T
        )
        return ComplianceCurve(
            method=self.name, support=self.support.name, u=lines.u, radius=lines.radius, deflection=deflection, depth=lines.depth
        )

    def profile(self, outline: Outline, u: float, face_width: float, loaded: tuple[float, float] | None = None) -> WidthProfile:
        """Return the deflection over the face width under a uniform or a partial line load.

        Parameters
        ----------
        outline, face_width
            As for `curve`.
        u : float
            Load position in [2, 4).
        loaded : tuple of float
            Places from mid-face between which the load acts [m]; by default the whole face width.

        Returns
        -------
        WidthProfile

        Raises
        ------
        InputError, SolveError
            If the load does not lie on the face width, besides the reasons of `curve`.
        """
        section, lines = self._section(outline, u)
        width, start, stop = self._loaded(outline, face_width, loaded)
        shown = self._profiles(outline, section, width, lines, width.load(start, stop)[:, None])[:, 0]
        return WidthProfile(
            u=float(u),
            radius=float(lines.radius[0]),
            place=width.places,
            deflection=shown,
            average=float(width.average @ shown),
            loaded=(start, stop),
        )

    def influence(self, outline: Outline, u: ArrayLike, face_width: float, slices: int) -> tuple[WidthInfluence, ...]:
        """Return the deflection of each slice of the face width under a load on each slice.

        Parameters
        ----------
        outline, face_width
            As for `profile`.
        u : array_like, shape (n,)
            Increasing load positions in [2, 4).
        slices : int
            Number of equal slices, at least 2.

        Returns
        -------
        tuple of WidthInfluence
            One for each position, without those whose load line crosses the centreline under the support.

        Raises
        ------
        InputError, SolveError
            If there are fewer than 2 slices, besides the reasons of `profile`.

        Notes
        -----
        With the bore held, some harmonics of the ring stand for all, and the conjugate gradients stop earlier: of what is uneven over
        the width, that misses 2e-4 (tests/limits/test_solid_limits.py), where coarse meshes as of `FaceSlices` miss 2 %.
        """
        if not slices >= 2:
            raise InputError("slices", slices, "a whole number from 2 upwards")
        section, lines = self._section(outline, u)
        edges = face_width * (np.arange(slices + 1) / slices - 0.5)
        width = self._width(outline, face_width, tuple(edges[1:-1]))
        # Mid-face is a plane of symmetry: the other half of the columns is known.
        half, count = (slices + 1) // 2, len(lines.u)
        along = np.stack([width.load(*edges[j : j + 2]) for j in range(half)], axis=1)
        columns = lines.kept(np.repeat(np.arange(count), half))
        shown = self._profiles(outline, section, width, columns, np.tile(along, count), sparing=True)
        matrix = np.empty((count, slices, slices))
        middles = np.stack([width.at(place) for place in 0.5 * (edges[1:] + edges[:-1])])
        matrix[:, :, :half] = (middles @ shown).reshape(slices, count, half).swapaxes(0, 1)
        matrix[:, :, slices - half :] = matrix[:, ::-1, half - 1 :: -1]
        return tuple(
            WidthInfluence(u=float(place), radius=float(radius), edges=edges, matrix=own)
            for place, radius, own in zip(lines.u, lines.radius, matrix, strict=True)
        )

    def field(
        self, outline: Outline, u: float, face_width: float, force_per_width: float, loaded: tuple[float, float] | None = None
    ) -> SolidField:
        """Return displacement and stress of the loaded tooth; with the bore held, of its whole sector.

        Parameters
        ----------
        outline, u, face_width, loaded
            As for `profile`.
        force_per_width : float
            The line load [N/m].

        Returns
        -------
        SolidField

        Raises
        ------
        InputError, SolveError
            As `profile` does.
        """
        section, lines = self._section(outline, u)
        width, start, stop = self._loaded(outline, face_width, loaded)
        along = force_per_width * width.load(start, stop)[:, None]
        nodes = section.mesh.doflocs.shape[1]
        with one_thread():
            matrices = section_matrices(section.mesh, ELEMENT, QUADRATURE)
            gear = outline.gear

            def keep(_: slice, plane: Array, across: Array) -> Array:
                return np.concatenate([plane, across])

            moved = solve_prism(section, matrices, width, gear.material, gear.teeth, forces(section, lines), along, keep)
        vectors = moved[..., 0].reshape(3, nodes, len(width.places))
        ends = [[*lines.point[0], z] for z in (start, stop)]
        return SolidField(
            mesh=solid_mesh(section, width.places, self.support.name),
            displacement=vectors.transpose(2, 1, 0).reshape(-1, 3),
            von_mises=von_mises_3d(section, width, gear.material, vectors).T.ravel(),
            load_line=np.array(ends),
            load_direction=np.append(lines.direction[0], 0.0),
            force_per_width=float(force_per_width),
        )

    def mesh(self, outline: Outline, face_width: float) -> SolidMesh:
        """Return the mesh for a uniform load; with the bore held, that of one sector of the ring."""
        section = self.support.section(outline, self.resolution)
        return solid_mesh(section, self._width(outline, face_width).places, self.support.name)

    # ---- steps ------------------------------------------------------------------------------------------

    def _section(self, outline: Outline, u: ArrayLike) -> tuple[SectionMesh, LoadLines]:
        section, lines = self.support.section(outline, self.resolution), load_lines(outline, u)
        refuse_folds(section.mesh, QUADRATURE[0], "change the bore radius, the rack's tip radius or the tip edge radius")
        inside = covered(section, lines)
        if not inside.any():
            found = f"{len(lines.u)} load lines that all cross the tooth's centreline under it"
            raise InputError(f"support {self.support.name}", found, "a position higher on the flank, or another support")
        return section, lines.kept(inside)

    def _width(self, outline: Outline, face_width: float, ends: tuple[float, ...] = ()) -> FaceWidth:
        if not (np.isfinite(face_width) and face_width > 0.0):
            raise InputError("face_width", face_width, "a positive length")
        return FaceWidth(graded_places(face_width, self.layers, outline.gear.module, ends), 2)

    def _loaded(self, outline: Outline, face_width: float, loaded: tuple[float, float] | None) -> tuple[FaceWidth, float, float]:
        start, stop = loaded or (-0.5 * face_width, 0.5 * face_width)
        if not -0.5 * face_width <= start < stop <= 0.5 * face_width:
            half = 0.5e3 * face_width
            raise InputError("loaded", f"({start * 1e3:g}, {stop * 1e3:g}) mm", f"increasing places from {-half:g} to {half:g} mm")
        return self._width(outline, face_width, (start, stop)), start, stop

    def _profiles(
        self, outline: Outline, section: SectionMesh, width: FaceWidth, lines: LoadLines, along: Array, sparing: bool = False
    ) -> Array:
        """Return the deflection along the width of each column, shape (m, k)."""
        reading, gear = readings(section, lines), outline.gear

        def keep(columns: slice, plane: Array, _: Array) -> Array:
            shown: Array = np.einsum("ik,imk->mk", reading[:, columns], plane)
            return shown

        with one_thread():
            matrices = section_matrices(section.mesh, ELEMENT, QUADRATURE)
            return solve_prism(section, matrices, width, gear.material, gear.teeth, forces(section, lines), along, keep, sparing)


def _whole(width: FaceWidth) -> tuple[float, float]:
    return float(width.places[0]), float(width.places[-1])
