"""The local depth against a disc in closed form, against triangles refined at the load, and whatever must not change it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import skfem
from skfem.models.elasticity import linear_elasticity

from gearfem.compliance import FiniteElements, PlaneStrain, PlaneStress, load_positions
from gearfem.compliance.alone import Alone
from gearfem.compliance.elasticity import stiffness
from gearfem.compliance.load_lines import LoadLines, edge_shape, forces, load_lines, readings
from gearfem.compliance.local_depth import STATIONS, Boundary, boundary_forces, local_depth
from gearfem.compliance.ring import factorise
from gearfem.compliance.section_mesh import root_mesh, sector_mesh
from gearfem.definition.setup import Material
from gearfem.flank import Outline

STEEL = Material()


def half_plane_scale(plane):
    """Return 2 F (1 - nu^2)/(pi E) of a unit load, in either plane state."""
    lam, mu = plane.lame(STEEL)
    return (lam + 2.0 * mu) / (2.0 * np.pi * mu * (lam + mu))


# ---- disc between two line loads ---------------------------------------------------------------------


def disc(rings):
    """Second-order mesh of the unit disc, concentric squares turned into circles, and its rim clockwise from the left."""
    square = skfem.MeshQuad2.from_mesh(skfem.MeshQuad.init_tensor(*(np.linspace(-1.0, 1.0, 2 * rings + 1),) * 2))
    places = square.doflocs + 0.0
    largest, radius = np.abs(places).max(axis=0), np.hypot(*places)
    places = places * np.divide(largest, radius, out=np.ones_like(radius), where=radius > 0.0)
    rim = np.flatnonzero(largest > 1.0 - 1e-12)
    return skfem.MeshQuad2(places, square.t), rim[np.argsort(-np.arctan2(places[1, rim], places[0, rim]))]


def disc_depth(rings, plane):
    """Return ln of the local depth over the radius, under two opposite loads and read at the centre."""
    mesh, rim = disc(rings)
    places, size = mesh.doflocs, mesh.doflocs.shape[1]
    chain = np.concatenate([rim, rim[:1]])
    edges = np.stack([chain[:-2:2], chain[1:-1:2], chain[2::2]], axis=1)
    polar = np.unwrap(np.arctan2(places[1, edges], places[0, edges]), axis=1)
    along = polar @ edge_shape(STATIONS).T
    circle = np.stack([np.cos(along), np.sin(along)], axis=-1)
    total = np.zeros((2 * size, 1))
    for side in (1.0, -1.0):
        line = LoadLines(u=np.array([0.0]), point=np.array([[0.0, side]]), direction=np.array([[0.0, -side]]), depth=np.array([1.0]))
        # The path runs clockwise: the parameter grows as the polar angle falls.
        past = (side * np.pi / 2.0 - along + np.pi) % (2.0 * np.pi) - np.pi
        near = np.abs(past).max(axis=1, keepdims=True) < 2.0
        total += boundary_forces(Boundary(edges, circle, np.where(near, past, np.inf)), line, 2 * size)
    matrix = stiffness(mesh, plane, STEEL)
    centre, top = (int(np.argmin(np.hypot(places[0], places[1] - y))) for y in (0.0, 1.0))
    free = np.setdiff1d(np.arange(2 * size), [centre, centre + size, top])
    moved = np.zeros(2 * size)
    moved[free] = factorise(matrix[free][:, free]).solve(total[free, 0])
    # Between top and centre the opposite load's half plane yields ln(2 R/R).
    return np.log(2.0) - moved[top + size] / half_plane_scale(plane)


@pytest.mark.parametrize("plane", [PlaneStrain(), PlaneStress()])
def test_disc_between_two_loads(plane):
    """K. L. Johnson, Contact Mechanics, sec. 5.6: two half planes and a uniform tension F/(pi R) in all directions."""
    nu = STEEL.poissons_ratio
    uniform = (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu)) if isinstance(plane, PlaneStrain) else (1.0 - nu) / 2.0
    errors = [abs(disc_depth(rings, plane) - (np.log(2.0) - uniform)) for rings in (2, 4, 8)]
    print(f"disc, {plane.name}: errors of ln d_l {errors}")
    # 1e-3 of it; at least of second order, as four elements have corners unfolded to 180 degrees.
    assert errors[2] < 1e-4
    assert errors[0] > 16.0 * errors[2]


# ---- triangles refined at the load ----------------------------------------------------------------


def triangles(outline, u, levels):
    """Return a sector of straight triangles, each level half as large in a shrinking neighbourhood of the node nearest to u."""
    section = sector_mesh(outline, 3.0)
    ends = section.outline_u[::2]
    u = float(ends[np.argmin(np.abs(ends - u))])
    vertices = section.mesh.p[:, : section.mesh.t.max() + 1]
    mesh = skfem.MeshQuad(vertices, section.mesh.t).to_meshtri()
    point, reach = outline.point(u), 0.3 * outline.gear.module
    for _ in range(levels):
        middle = mesh.p[:, mesh.t].mean(axis=1)
        mesh = mesh.refined(np.flatnonzero(np.hypot(*(middle - point[:, None])) < reach))
        reach *= 0.6
    return mesh, u


def direct_depth(outline, u, levels=7):
    """Return u and ln(d_l/d) from the displacement at small distances below a load, of a sector with free cuts held at its bore."""
    mesh, u = triangles(outline, u, levels)
    lines = load_lines(outline, u)
    point, inward, depth = lines.point[0], lines.direction[0], float(lines.depth[0])
    basis = skfem.CellBasis(mesh, skfem.ElementVector(skfem.ElementTriP2()))
    matrix = linear_elasticity(*PlaneStrain().lame(STEEL)).assemble(basis).tocsc()
    load = np.zeros(basis.N)
    load[basis.nodal_dofs[:, np.argmin(np.hypot(*(mesh.p - point[:, None])))]] = inward
    bore = outline.gear.bore_radius * 1.001
    free = basis.complement_dofs(basis.get_dofs(lambda x: np.hypot(*x) < bore))
    moved = np.zeros(basis.N)
    moved[free] = factorise(matrix[free][:, free].tocsc()).solve(load[free])
    below = depth * np.append(np.linspace(0.02, 0.2, 19), 1.0)
    at = (basis.probes((point + below[:, None] * inward).T) @ moved).reshape(2, -1).T @ inward
    seen = (at[:-1] - at[-1]) / half_plane_scale(PlaneStrain()) + np.log(below[:-1] / depth)
    return u, float(np.polyfit(below[:-1], seen, 3)[-1])


@pytest.mark.parametrize(("member", "u"), [("pinion", 2.1), ("pinion", 2.5), ("wheel", 2.5), ("wheel", 2.9)])
def test_displacement_below_the_load(coal_combine, member, u):
    outline, plane = Outline(gear=getattr(coal_combine.pair, member)), PlaneStrain()
    at, expected = direct_depth(outline, u)
    section, lines = sector_mesh(outline, 3.0), load_lines(outline, at)
    matrix = stiffness(section.mesh, plane, STEEL)
    squeezed = Alone(section, matrix).displacements(forces(section, lines) - readings(section, lines), (0,))[0]
    found = float(np.log(local_depth(section, outline, lines, squeezed, matrix, plane)[0] / lines.depth[0]))
    print(f"{member}, u = {at:.3f}: ln(d_l/d) {found:.4f}, from the displacement below the load {expected:.4f}")
    # One per cent of the depth; both take the sector alone, its cuts free.
    assert found == pytest.approx(expected, abs=0.01)


# ---- what must not change it --------------------------------------------------------------------------

# 0.1 % of the local part: its logarithm ln(2 d_l/a) is about 4 at the load of the coal combine.
NEGLIGIBLE = 4e-3


def logarithm(gear, resolution=3.0, u=None):
    outline = Outline(gear=gear)
    tooth = FiniteElements(resolution=resolution).tooth(outline, load_positions(outline) if u is None else u)
    return np.log(tooth.local_depth / tooth.depth)


@pytest.mark.slow
@pytest.mark.parametrize("member", ["pinion", "wheel"])
def test_mesh_support_and_body_do_not_change_it(coal_combine, member):
    gear = getattr(coal_combine.pair, member)
    base, fine = logarithm(gear), logarithm(gear, 7.0)
    bore = logarithm(dataclasses.replace(gear, bore_radius=0.7 * gear.bore_radius))
    print(f"{member}: largest change of ln d_l by the mesh {np.abs(fine - base).max():.1e}, by the bore {np.abs(bore - base).max():.1e}")
    assert np.abs(fine - base).max() < NEGLIGIBLE
    assert np.abs(bore - base).max() < NEGLIGIBLE


def test_it_does_not_depend_on_the_tooth_being_alone(coal_combine):
    """A tooth clamped at its root is squeezed as one on the whole gear is, half a thickness above the clamp."""
    outline, plane = Outline(gear=coal_combine.pair.pinion), PlaneStrain()
    section, lines = root_mesh(outline, 5.0, chord=False), load_lines(outline, np.linspace(2.8, 3.0, 7))
    matrix = stiffness(section.mesh, plane, STEEL)
    squeezed = Alone(section, matrix).displacements(forces(section, lines) - readings(section, lines), (0,))[0]
    alone = np.log(local_depth(section, outline, lines, squeezed, matrix, plane) / lines.depth)
    change = np.abs(alone - logarithm(outline.gear, u=lines.u))
    print(f"largest change of ln d_l by the clamp {change.max():.1e}")
    assert change.max() < NEGLIGIBLE


def test_it_scales_with_the_module(gear_factory):
    u = np.linspace(2.1, 3.3, 9)
    small, large = (logarithm(gear_factory(24, module, 13.0 * module), u=u) for module in (1e-3, 5e-3))
    # Rounding of the factors.
    np.testing.assert_allclose(large, small, atol=1e-8)
