"""What of a tooth's deflection is the body's: wind-up about the bore, and what the other teeth feel of it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import ArrayLike

from gearfem.compliance.elasticity import stiffness
from gearfem.compliance.finite_elements import FiniteElements
from gearfem.compliance.load_lines import forces, load_lines
from gearfem.compliance.record import Compliance, ToothCompliance
from gearfem.compliance.supports import Bore, Root
from gearfem.definition.setup import Gear, Member
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.threads import one_thread


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class BodyCompliance(Record):
    """The deflection of a tooth of a gear held at its bore, taken apart.

    Parameters
    ----------
    u, radius : ndarray, shape (n,)
        Load positions as parameters of the `Outline`, and their radii [m].
    whole, tooth : ndarray, shape (n,)
        Deflection per line load of the tooth on the gear held at its bore, and of the tooth alone held at its root [m per N/m].
    rotation : ndarray, shape (n,)
        Rotation of the root circle about the bore in the middle of the tooth spaces, per torque and face width [rad per N].
    wind_up : ndarray, shape (n,)
        Part of `whole` that this rotation makes: rotation x (moment arm of the load line)^2 [m per N/m].
    neighbours : ndarray, shape (n, 3)
        Displacement of the same flank point of the teeth one, two and three pitches away, along the inward normal there, per line
        load on this tooth [m per N/m]; by reciprocity the same on either side.
    """

    u: Array
    radius: Array
    whole: Array
    tooth: Array
    rotation: Array
    wind_up: Array
    neighbours: Array

    @property
    def body(self) -> Array:
        """What the body adds to the tooth held at its root: whole - tooth, shape (n,) [m per N/m]."""
        added: Array = self.whole - self.tooth
        return added


def body_compliance(outline: Outline, u: ArrayLike, method: FiniteElements | None = None) -> BodyCompliance:
    """Take the deflection of a tooth apart into tooth, body and wind-up, with what the neighbours feel.

    Parameters
    ----------
    outline : Outline
        Outline of the tooth, and through it the gear.
    u : array_like, shape (n,)
        Increasing load positions in [2, 4).
    method : FiniteElements, optional
        Plane state and resolution; held at the bore. By default plane strain.

    Returns
    -------
    BodyCompliance
        Without the positions whose load line crosses the centreline under the root circle, where the tooth alone is held.

    Raises
    ------
    InputError, SolveError
        If the method does not hold the bore, or as `FiniteElements.curve`.

    Notes
    -----
    A load on one tooth is the sum of harmonics over the teeth. Harmonic 0, the same part 1/z of the load on every tooth, carries
    all the torque and turns the body; the others, whose torques cancel, bend it. The rotation is that of harmonic 0. Its
    mean over any circle up to the root is exactly that of the clamped annulus, `annulus_wind_up`; in the middle of the
    spaces the surface of the root turns less, by 2.1 % on the pinion of the coal combine (16 teeth) and 0.2 % on the
    wheel (51 teeth).

    `body` holds the wind-up and the local yielding of the body below the tooth. The neighbours feel the wind-up in full, plus
    what the local yielding leaves at their place.
    """
    method = method or FiniteElements()
    if not isinstance(method.support, Bore):
        raise InputError("support", method.support.name, "bore: wind-up is that of a body held at its bore")
    alone = dataclasses.replace(method, support=Root()).curve(outline, u)
    both = method.tooth(outline, alone.u, (1, 2, 3))
    if both.u.size != alone.u.size:
        raise InputError("bore_radius_mm", outline.gear.bore_radius * 1e3, "a bore below the crossings of load line and centreline")
    rotation = wind_up_profile(method, outline, alone.u)[1][0]
    return BodyCompliance(
        u=alone.u,
        radius=alone.radius,
        whole=both.deflection,
        tooth=alone.deflection,
        rotation=rotation,
        wind_up=rotation * moment_arm(outline, alone.u) ** 2,
        neighbours=np.diagonal(both.coupling, axis1=1, axis2=2).T,
    )


def scale_body(compliance: Compliance, scale: float, method: FiniteElements | None = None) -> Compliance:
    """Multiply the compliance of both gear bodies.

    Parameters
    ----------
    compliance : Compliance
        Both gears, each held at its bore.
    scale : float
        Of the bodies' share, positive; 1 gives every array back bit for bit.
    method : FiniteElements, optional
        That which made the compliance, by default plane strain.

    Returns
    -------
    Compliance

    Raises
    ------
    InputError
        If the scale is not positive, or the compliance is of another method.

    Notes
    -----
    d + (scale - 1) b with the share b of `body_share`, and the same for the coupling, all of which is the body's. A tooth that yields
    more than the others of its gear stands on the same body and gets the same b. The slope over the scale is b everywhere.
    """
    if not 0.0 < scale < math.inf:
        raise InputError("scale", scale, "a positive number; 1 leaves the bodies as they are")
    method = method or FiniteElements()
    if compliance.pinion.method != method.name:
        raise InputError("method", method.name, f"the method of this compliance, {compliance.pinion.method}")

    def scaled(member: Member, tooth: ToothCompliance) -> ToothCompliance:
        sound = compliance.of(member)
        added, coupled = body_share(sound, method), sound.coupling
        return dataclasses.replace(
            tooth,
            deflection=tooth.deflection + (scale - 1.0) * added,
            coupling=tooth.coupling + (scale - 1.0) * coupled,
        )

    return dataclasses.replace(
        compliance,
        pinion=scaled("pinion", compliance.pinion),
        wheel=scaled("wheel", compliance.wheel),
        pinion_odd=tuple((number, scaled("pinion", tooth)) for number, tooth in compliance.pinion_odd),
        wheel_odd=tuple((number, scaled("wheel", tooth)) for number, tooth in compliance.wheel_odd),
    )


def body_share(tooth: ToothCompliance, method: FiniteElements | None = None) -> Array:
    """Return what the body adds to the deflection of a tooth: that on the whole gear less that of the tooth held at its root.

    Parameters
    ----------
    tooth : ToothCompliance
        On the gear held at its bore.
    method : FiniteElements, optional
        That which made it, by default plane strain.

    Returns
    -------
    ndarray, shape (n,)
        [m per N/m].

    Notes
    -----
    A load line that crosses the centreline under the root circle is read where the tooth alone is held and does not
    move: there all is the body's. The share is continuous, with a kink.
    """
    method = dataclasses.replace(method or FiniteElements(), support=Root())
    alone = method.curve(tooth.outline, tooth.u)
    held = np.zeros_like(tooth.deflection)
    held[np.searchsorted(tooth.u, alone.u)] = alone.deflection
    return np.asarray(tooth.deflection - held)


def moment_arm(outline: Outline, u: ArrayLike) -> Array:
    """Return the distance of load lines from the gear's centre, shape (n,) [m]; the base radius on the flank."""
    point, normal = outline.point(u), outline.normal(u)
    arm: Array = np.abs(point[..., 0] * normal[..., 1] - point[..., 1] * normal[..., 0])
    return arm


def annulus_wind_up(gear: Gear, radius: ArrayLike) -> Array:
    """Return the rotation of circles of a plain disc clamped at the bore, per torque and face width.

    Parameters
    ----------
    gear : Gear
        Gives the bore radius and the shear modulus.
    radius : array_like, shape (n,)
        Radii of circles, up to that on which the torque acts [m].

    Returns
    -------
    ndarray, shape (n,)
        [rad per N].

    Notes
    -----
    theta(r) = T/(4 pi G b) (1/r_b^2 - 1/r^2): the shear stress T/(2 pi r^2 b) turns neighbouring rings by
    tau/(G r) dr. Exact, in plane strain and plane stress alike.

    Examples
    --------
    >>> from gearfem.definition.setup import Material, Rack
    >>> gear = Gear(teeth=17, module=1e-3, pressure_angle=0.349, profile_shift=0.0, flank_thinning=0.0, root_radius=7.25e-3,
    ...             tip_radius=9.5e-3, tip_edge_radius=2e-5, bore_radius=4e-3, rack=Rack(), material=Material())
    >>> float(annulus_wind_up(gear, 4e-3))
    0.0
    """
    turn: Array = (1.0 / gear.bore_radius**2 - 1.0 / np.asarray(radius, float) ** 2) / (4.0 * math.pi * gear.material.shear_modulus)
    return turn


def wind_up_profile(method: FiniteElements, outline: Outline, u: ArrayLike) -> tuple[Array, Array]:
    """Return the rotation over the radius in the middle of the tooth spaces, under a torque shared by all teeth.

    Parameters
    ----------
    method : FiniteElements
        Held at the bore.
    outline : Outline
        Outline of the tooth.
    u : array_like, shape (k,)
        Load positions, one case each.

    Returns
    -------
    radius : ndarray, shape (c,)
        From the root circle inwards [m].
    rotation : ndarray, shape (c, k)
        Per torque and face width [rad per N].
    """
    with one_thread():
        section, lines = method._mesh(outline), load_lines(outline, u)
        load = forces(section, lines)
        matrix = stiffness(section.mesh, method.plane, outline.gear.material)
        ring = Bore().structure(section, matrix, outline.gear.teeth)
        nodes, moved = ring.wind_up(load)
    radius = np.hypot(*section.mesh.doflocs[:, nodes])
    order = np.argsort(-radius)
    # Loads press on the side of positive y, against growing polar angles.
    rotation = -moved / radius[:, None] / moment_arm(outline, lines.u)
    return radius[order], rotation[order]
