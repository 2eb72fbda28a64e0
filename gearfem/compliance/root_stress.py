"""Largest tensile stress in the fillet of a loaded tooth, from plane finite elements."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from gearfem.compliance.elasticity import Plane, stiffness
from gearfem.compliance.finite_elements import FiniteElements
from gearfem.compliance.load_lines import forces, load_lines
from gearfem.compliance.supports import Bore
from gearfem.definition.setup import Material
from gearfem.flank import Outline
from gearfem.flank.outline import FILLET, FLANK
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.threads import one_thread

# Where the derivative of a quadratic along its edge is most accurate (Barlow 1976), on -1 ... 1.
GAUSS = np.array([-1.0, 1.0]) / np.sqrt(3.0)
# Half width in u and degree of the polynomial through the stress around its largest value.
WINDOW, DEGREE = 0.3, 4
STRESS_RESOLUTION = 6.0


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class FilletStress(Record):
    """Largest tensile stress along the fillet over the load's position.

    Parameters
    ----------
    method : str
        How it was computed, such as ``fe_plane_strain``.
    u, radius : ndarray, shape (n,)
        Load positions as parameters of the `Outline`, and their radii [m].
    stress : ndarray, shape (n,)
        Stress along the surface per line load [Pa per N/m].
    place : ndarray, shape (n,)
        Parameters u of the outline, between 1 and 2, where it is largest.
    tangent_angle : ndarray, shape (n,)
        Angle between the tooth's axis and the tangent there [rad]; ISO 6336-3 puts it at 30 degrees.
    """

    method: str
    u: Array
    radius: Array
    stress: Array
    place: Array
    tangent_angle: Array


def fillet_stress(outline: Outline, u: ArrayLike, method: FiniteElements | None = None) -> FilletStress:
    """Return the largest tensile stress in the fillet on the loaded side, per line load.

    Parameters
    ----------
    outline : Outline
        Outline of the tooth, and through it the gear.
    u : array_like, shape (n,)
        Increasing load positions in [2, 4).
    method : FiniteElements, optional
        With the bore held: the end of the fillet is where a clamp at the root would be. By default plane strain
        with a resolution of 6.

    Returns
    -------
    FilletStress

    Raises
    ------
    InputError
        If a position is not on the flank, or the root is held.
    SolveError
        If the mesh folds over or the matrix is singular.

    Notes
    -----
    On the free surface the stress along it is E' times the strain along it (`surface_stress`). Its largest value is that of
    the polynomial of degree 4 fitted to the points within 0.3 of the largest one in u; the fit evens out the step of 1 to 3 % at
    the node where three patches of the mesh meet. Measured on the pinion of the coal combine against resolution 12:
    0.7 % off at resolution 4, 0.2 % at 6, an order of about 2. Loads within
    a tenth of the module of the fillet are too near for these figures.

    Examples
    --------
    >>> import math
    >>> from gearfem.definition.setup import Gear, Material, Rack
    >>> gear = Gear(teeth=17, module=1e-3, pressure_angle=math.radians(20), profile_shift=0.0, flank_thinning=0.0,
    ...             root_radius=7.25e-3, tip_radius=9.5e-3, tip_edge_radius=2e-5, bore_radius=4e-3, rack=Rack(),
    ...             material=Material())
    >>> record = fillet_stress(Outline(gear=gear), [2.5, 2.95])
    >>> bool(record.stress[1] > record.stress[0] > 0.0)
    True
    """
    method = method or FiniteElements(resolution=STRESS_RESOLUTION)
    if not isinstance(method.support, Bore):
        raise InputError("support", method.support.name, "bore: held at the root, a tooth has its clamp where the stress is read")
    lines = load_lines(outline, u)
    section = method._mesh(outline)
    load = forces(section, lines)
    loaded = np.flatnonzero(load.reshape(2, -1, len(lines.u)).any(axis=(0, 2)))
    with one_thread():
        matrix = stiffness(section.mesh, method.plane, outline.gear.material)
        moved = method.support.structure(section, matrix, outline.gear.teeth, loaded).displacements(load, (0,))[0]
    nodes = section.mesh.doflocs.T[section.outline]
    displacement = np.stack(np.split(moved, 2))[:, section.outline].transpose(2, 1, 0)
    stress = surface_stress(nodes, displacement, method.plane, outline.gear.material)
    at = _along(section.outline_u[:, None], _shapes(GAUSS)).reshape(-1)
    peaks = np.array([_largest(at, values) for values in stress.reshape(len(lines.u), -1)])
    normal = outline.normal(peaks[:, 0])
    return FilletStress(
        method=method.name,
        u=lines.u,
        radius=lines.radius,
        stress=peaks[:, 1],
        place=peaks[:, 0],
        tangent_angle=np.pi / 2.0 - np.arctan2(normal[:, 1], normal[:, 0]),
    )


def stress_error(outline: Outline, u: ArrayLike, method: FiniteElements | None = None) -> Array:
    """Estimate the relative error of `fillet_stress` at each load position.

    Parameters
    ----------
    outline, u, method
        As for `fillet_stress`.

    Returns
    -------
    ndarray, shape (n,)
        |s - s_coarse|/s with a mesh of half the resolution, which bounds the error of an order of 1 or above; the largest of
        each position and its two neighbours, because the sign of the change varies.

    Raises
    ------
    InputError
        If the resolution is below 2, besides the reasons of `fillet_stress`.
    """
    method = method or FiniteElements(resolution=STRESS_RESOLUTION)
    if method.resolution < 2.0:
        raise InputError("resolution", method.resolution, "at least 2 for an estimate of the error from a coarser mesh")
    fine = fillet_stress(outline, u, method).stress
    coarse = fillet_stress(outline, u, dataclasses.replace(method, resolution=method.resolution / 2.0)).stress
    change = np.pad(np.abs(fine - coarse) / np.abs(fine), 1, mode="edge")
    largest: Array = np.maximum.reduce([change[:-2], change[1:-1], change[2:]])
    return largest


def surface_stress(nodes: Array, displacement: Array, plane: Plane, material: Material) -> Array:
    """Return the stress along a free surface at the two Gauss points of each quadratic edge.

    Parameters
    ----------
    nodes : ndarray, shape (2 m + 1, 2)
        Ends and middles of m edges in a row [m].
    displacement : ndarray, shape (k, 2 m + 1, 2)
        Nodal displacements of k cases [m].
    plane, material : Plane, Material
        Plane state and material.

    Returns
    -------
    ndarray, shape (k, m, 2)
        Stress [Pa].

    Notes
    -----
    With no load on the surface the one stress in the section there acts along it: sigma = E' t . du/ds, E' = E in plane stress
    and E/(1 - nu^2) in plane strain (4 mu (lambda + mu)/(lambda + 2 mu) of the plane's constants). The derivative along an
    edge needs its own three nodes and no others; no extrapolation.
    """
    slopes = _slopes(GAUSS)
    tangent, change = _along(nodes, slopes), np.stack([_along(case, slopes) for case in displacement])
    lam, mu = plane.lame(material)
    modulus = 4.0 * mu * (lam + mu) / (lam + 2.0 * mu)
    stress: Array = modulus * (change * tangent).sum(axis=-1) / (tangent**2).sum(axis=-1)
    return stress


def _shapes(place: Array) -> Array:
    return np.stack([0.5 * place * (place - 1.0), 1.0 - place**2, 0.5 * place * (place + 1.0)], axis=1)


def _slopes(place: Array) -> Array:
    return np.stack([place - 0.5, -2.0 * place, place + 0.5], axis=1)


def _along(values: Array, weights: Array) -> Array:
    """Combine the three nodes of each edge, shape (2 m + 1, c), to shape (m, len(weights), c)."""
    edges = np.stack([values[:-2:2], values[1:-1:2], values[2::2]], axis=1)
    combined: Array = np.einsum("pn,mnc->mpc", weights, edges)
    return combined


def _largest(u: Array, stress: Array) -> tuple[float, float]:
    """Return where on the fillet the stress is largest, and its value."""
    inside = (u > FILLET) & (u < FLANK)
    u, stress = u[inside], stress[inside]
    middle = min(max(float(u[np.argmax(stress)]), FILLET + WINDOW), FLANK - WINDOW)
    near = np.abs(u - middle) <= WINDOW
    fit = np.polynomial.Polynomial.fit(u[near], stress[near], min(DEGREE, int(near.sum()) - 1))
    # A thousandth of the window places the top of a parabola to a millionth of its height.
    fine = np.linspace(middle - WINDOW, middle + WINDOW, 1001)
    values = fit(fine)
    top = int(np.argmax(values))
    return float(fine[top]), float(values[top])
