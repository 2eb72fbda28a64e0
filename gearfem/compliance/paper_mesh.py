"""The finite-element model of Wojnarowski & Onishchenko (2003): 585 eight-node hexahedra, 896 nodes, 128 of them held."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, Protocol

import numpy as np
import skfem
from numpy.typing import NDArray

from gearfem.compliance.face_width import FaceWidth
from gearfem.compliance.load_lines import LoadLines, load_lines
from gearfem.compliance.prism import Prism, section_matrices
from gearfem.compliance.record import ComplianceCurve
from gearfem.compliance.reductions import alone
from gearfem.compliance.solid_mesh import SolidMesh, extrude
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.threads import one_thread

# Elements across the thickness, up the height and along the face width.
ACROSS, UP, ALONG = 3, 13, 15
# From the end of the fillet on the root circle to the end of the involute; the round and the arc of the tip are left out.
FOOT, HEAD = 1.0, 3.0
ELEMENT = skfem.ElementQuad1()


class Clamp(Protocol):
    """Which eight nodes of each section are held."""

    name: ClassVar[str]

    def held(self, grid: NDArray[np.int64], refinement: int) -> NDArray[np.int64]:
        """Return the held nodes of a grid, rows from the foot up."""


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class TwoLayers(Record):
    """The four nodes of each of the two lowest rows: the lowest layer of elements is rigid."""

    name: ClassVar[str] = "two_layers"

    def held(self, grid: NDArray[np.int64], refinement: int) -> NDArray[np.int64]:
        """Return the nodes of the lowest layer of elements."""
        return grid[: refinement + 1].ravel()


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class LayerAndSides(Record):
    """The four nodes of the lowest row and two nodes up each side."""

    name: ClassVar[str] = "layer_and_sides"

    def held(self, grid: NDArray[np.int64], refinement: int) -> NDArray[np.int64]:
        """Return the nodes of the foot and of the sides up to two elements."""
        return np.unique(np.concatenate([grid[0], grid[: 2 * refinement + 1, [0, -1]].ravel()]))


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class PaperMesh(Record):
    """Compliance from the published mesh: 3 x 13 x 15 eight-node hexahedra with full integration.

    Parameters
    ----------
    clamp : Clamp
        `TwoLayers` or `LayerAndSides`: the paper holds 128 nodes, 8 in each of 16 sections, and does not say which.
    refinement : int
        Each element is divided by this number in each direction, with the same body held.

    Raises
    ------
    InputError
        If the refinement is below 1.

    Notes
    -----
    What the paper leaves open is assumed: rows at equal steps of arc length along the outline, from the end of the fillet on
    the root circle to the end of the involute; nodes of a row at equal steps on the chord between both sides, sections at equal steps of
    the face width; the line load spread evenly over the 16 nodes' width (consistent, half at the ends). The deflection is read where the
    load line crosses the centreline, between the middle nodes, and averaged over the face width.
    """

    clamp: Clamp = dataclasses.field(default_factory=TwoLayers)
    refinement: int = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.refinement >= 1:
            raise InputError("refinement", self.refinement, "a whole number from 1 upwards")

    def positions(self, outline: Outline) -> Array:
        """Return the parameters u of the rows that carry loads: those on the involute."""
        rows = _rows(outline, 1)
        return rows[rows >= 2.0]

    def curve(self, outline: Outline, face_width: float) -> ComplianceCurve:
        """Return the compliance under a uniform load on each row of the flank, averaged over the face width.

        Parameters
        ----------
        outline : Outline
            Outline of the tooth.
        face_width : float
            Face width [m].

        Returns
        -------
        ComplianceCurve
            At `positions`, but for those whose load line crosses the centreline at or below the foot.

        Raises
        ------
        SolveError
            If the solution does not converge.
        """
        lines = load_lines(outline, self.positions(outline))
        grid, points, mesh = self._section(outline)
        height = points[grid[:, 0], 0]
        lines = lines.kept(lines.crossing > height[0])
        width = self._width(face_width)
        load, reading = self._forces(outline, grid, lines), self._readings(grid, height, lines)
        with one_thread():
            matrices = section_matrices(mesh, ELEMENT, skfem.quadrature.get_quadrature(ELEMENT, 3))
            support = alone(len(points), self.clamp.held(grid, self.refinement))
            solution = Prism(matrices, width, outline.gear.material, support)
            along = np.tile(width.load(width.places[0], width.places[-1]), (len(lines.u), 1)).T
            shown = [np.einsum("ik,imk,m->k", reading[:, part], plane, width.average) for part, plane, _ in solution.solve(load, along)]
        return ComplianceCurve(
            method="paper_mesh",
            support=self.clamp.name,
            u=lines.u,
            radius=lines.radius,
            deflection=np.concatenate(shown),
            depth=lines.depth,
        )

    def mesh(self, outline: Outline, face_width: float) -> SolidMesh:
        """Return the mesh of hexahedra."""
        grid, points, _ = self._section(outline)
        places = self._width(face_width).places
        nodes, hexes = extrude(points, _quads(grid), places)
        number = np.arange(len(points))
        sides = grid[_rows(outline, self.refinement) >= 2.0][:, [0, -1]]
        held, flank = (np.tile(np.isin(number, own), len(places)) for own in (self.clamp.held(grid, self.refinement), sides))
        return SolidMesh(nodes=nodes, hexes=hexes, held=held, flank=flank, support=self.clamp.name)

    # ---- steps ------------------------------------------------------------------------------------------

    def _width(self, face_width: float) -> FaceWidth:
        if not (np.isfinite(face_width) and face_width > 0.0):
            raise InputError("face_width", face_width, "a positive length")
        return FaceWidth(face_width * (np.arange(ALONG * self.refinement + 1) / (ALONG * self.refinement) - 0.5), 1)

    def _section(self, outline: Outline) -> tuple[NDArray[np.int64], Array, Any]:
        """Return the numbers of the nodes in rows from the foot up and from y < 0 to y > 0, the nodes, and the plane mesh."""
        side = outline.point(_rows(outline, self.refinement))
        part = np.linspace(-1.0, 1.0, ACROSS * self.refinement + 1)
        points = np.stack([np.repeat(side[:, :1], len(part), axis=1), side[:, 1:] * part], axis=2)
        grid = np.arange(points[..., 0].size).reshape(points.shape[:2])
        flat = points.reshape(-1, 2)
        return grid, flat, skfem.MeshQuad(np.ascontiguousarray(flat.T), np.ascontiguousarray(_quads(grid).T))

    def _forces(self, outline: Outline, grid: NDArray[np.int64], lines: LoadLines) -> Array:
        rows = np.searchsorted(_rows(outline, self.refinement), lines.u - 1e-9)
        result = np.zeros((2 * grid.size, len(rows)))
        for axis in (0, 1):
            result[grid[rows, -1] + axis * grid.size, np.arange(len(rows))] = lines.direction[:, axis]
        return result

    def _readings(self, grid: NDArray[np.int64], height: Array, lines: LoadLines) -> Array:
        """Return weights of the nodes around each crossing: linear between two rows, the mean of the nodes beside the axis."""
        row = np.clip(np.searchsorted(height, lines.crossing) - 1, 0, len(height) - 2)
        part = (lines.crossing - height[row]) / (height[row + 1] - height[row])
        middle = np.unique([(grid.shape[1] - 1) // 2, grid.shape[1] // 2])
        result = np.zeros((2 * grid.size, len(row)))
        for column in middle:
            for nodes, weight in ((grid[row, column], 1.0 - part), (grid[row + 1, column], part)):
                for axis in (0, 1):
                    result[nodes + axis * grid.size, np.arange(len(row))] += weight * lines.direction[:, axis] / len(middle)
        return result


def _rows(outline: Outline, refinement: int) -> Array:
    """Return the parameters of rows at equal steps of arc length, the steps of the published mesh divided."""
    u = np.linspace(FOOT, HEAD, 4001)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(outline.point(u), axis=0).T))])
    rows: Array = np.interp(np.arange(UP * refinement + 1) / (UP * refinement) * arc[-1], arc, u)
    return rows


def _quads(grid: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the nodes of the quadrilaterals, counter-clockwise: rows run along x, columns along y."""
    return np.stack([part.ravel() for part in (grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:])], axis=1)
