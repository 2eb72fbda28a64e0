"""The engagement stage: the loaded pair over the pinion angle, and its forces for the dynamics."""

from __future__ import annotations

import dataclasses
import itertools
import math
from functools import cached_property
from typing import NamedTuple

import numpy as np

from gearfem.compliance.record import Compliance
from gearfem.contact import EdgedLine, Line
from gearfem.contact.peak import largest_pressure
from gearfem.engagement.contacts import find_contacts, find_second_contacts, join
from gearfem.engagement.grid import FINE, LARGEST_OVERLOAD, Grid, largest_approach
from gearfem.engagement.record import Contacts, Engagement, MeshForce
from gearfem.engagement.sharing import LineLaw, PairSystem, Sharing, share_error, share_torque
from gearfem.engagement.teeth import read_compliance
from gearfem.engagement.width import FaceSlices, LeadTable, lead_table
from gearfem.flank import Flanks
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.units import MM
from gearfem.placement import Placement, rigidly_held, runout_gap

# A ten-thousandth of a pitch: the rounding of a difference over it stays below 1e-7 of the ratio.
DIFFERENCE = 1e-4


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Mesh(Record):
    """Everything that engagement needs of earlier stages.

    Parameters
    ----------
    flanks, placement, compliance : records
        Of the stages of these names.
    law : LineLaw
        Contact law of the two materials.
    slices : FaceSlices
        How the face width is cut where the gap of the flanks opens along it.
    grid : Grid
        How closely pairs are tabulated where many turns are followed.
    """

    flanks: Flanks
    placement: Placement
    compliance: Compliance
    law: LineLaw
    slices: FaceSlices = dataclasses.field(default_factory=FaceSlices)
    grid: Grid = FINE

    @cached_property
    def lead(self) -> LeadTable | None:
        """What the lead of the flanks adds to the approach; None where they are parallel, which costs no solid elements."""
        if self.flanks.lead.uniform:
            return None
        return lead_table(self.flanks, self.placement, self.compliance, self.law, self.slices)

    @property
    def first_touch(self) -> float:
        """Gap along the face width where a pair touches first [m]."""
        lead = self.lead
        return float(self.flanks.lead.gap[0]) if lead is None else lead.first_touch

    def pairs(self, pinion_angle: Array) -> tuple[int, ...]:
        """Return the pairs that may touch at any of these angles [rad], corner contact included."""
        pitches = np.asarray(pinion_angle) / self.placement.pair.pinion.pitch_angle
        reach = math.ceil(self.placement.pair.contact_ratio)
        return tuple(range(math.floor(pitches.min()) - reach, math.ceil(pitches.max()) + reach + 1))

    def contacts(self, pinion_angle: Array) -> Contacts:
        """Return the first contacts of all pairs in reach at angles [rad], shape (n,)."""
        return find_contacts(self.flanks, self.placement, pinion_angle, self.pairs(pinion_angle))

    def touching(self, contacts: Contacts) -> Contacts:
        """Return first contacts and, beside them, the second ones of pairs that touch on both sides of a hollow."""
        return join(contacts, find_second_contacts(self.flanks, self.placement, contacts.pinion_angle, contacts.pairs))

    def system(self, contacts: Contacts, torque: float = 0.0) -> PairSystem:
        """Return the pairs at these contacts, ready to be loaded; pairs that touch twice by at most a torque on the pinion [N m]."""
        pair = self.placement.pair
        read = read_compliance(self.compliance, contacts)
        lever, arm = contacts.arm2 / pair.wheel.base_radius, contacts.arm1 * pair.face_width
        # Supports move with the sum of all loads and put every pair off by the same lag.
        supports = self.placement.support * pair.face_width * lever[:, :, None] * lever[:, None, :]
        line = Line(contacts.flank_radius, read.depth1, read.depth2, contacts.edge, contacts.edge_radius)
        lead = self.lead
        return PairSystem(
            linear=read.linear + supports + self._beside(contacts, line, torque / arm),
            lever=lever,
            arm=arm,
            gap=self.gap(contacts),
            line=line,
            lead=None if lead is None else lead.at(self.position(contacts)),
        )

    def _beside(self, contacts: Contacts, line: Line, force: Array) -> Array:
        """Return what contact gives between the touches of a pair [m per N/m], shape (n, p, p); 0 between pairs."""
        count = len(contacts.pairs)
        beside = np.zeros((len(force), count, count))
        for j, k in itertools.permutations(range(count), 2):
            both = contacts.reach[:, j] & contacts.reach[:, k]
            if contacts.pairs[j] == contacts.pairs[k] and both.any():
                distance = np.hypot(*(contacts.point[both, j] - contacts.point[both, k]).T)
                # The wider contact of both, and the mean of their depths: what one yields under the other is the same both ways.
                one, other = (Line(*(values[both, column] for values in line)) for column in (j, k))
                depths = {name: 0.5 * (getattr(one, name) + getattr(other, name)) for name in ("depth1", "depth2")}
                wide = one._replace(radius=np.maximum(one.radius, other.radius), **depths)
                beside[both, j, k] = self.law.beside(np.maximum(force[both, j], force[both, k]), distance, wide)
        return beside

    def gap(self, contacts: Contacts) -> Array:
        """Return the lag of the wheel at which each pair touches, the lead of the flanks included [m], shape (n, p)."""
        gap: Array = contacts.gap + self.first_touch * self.placement.pair.wheel.base_radius / contacts.arm2
        return gap

    def position(self, contacts: Contacts) -> Array:
        """Return pinion angles counted for each pair from its own pitch point [rad], shape (n, p)."""
        angle: Array = contacts.pinion_angle[:, None] - np.asarray(contacts.pairs) * self.placement.pair.pinion.pitch_angle
        return angle


def standard_angles(placement: Placement, steps: int = 400) -> Array:
    """Return pinion angles [rad] from one pitch before to one pitch after angle 0, steps + 1 of them."""
    return np.linspace(-1.0, 1.0, steps + 1) * placement.pair.pinion.pitch_angle


class Loads(NamedTuple):
    """Contacts and their forces over the face width [N], the transmission error [m], its slope over the torque, and the deflection."""

    contacts: Contacts
    force: Array
    transmission_error: Array
    slope: Array
    deflection: Array


def loads(mesh: Mesh, pinion_angle: Array, torque: float) -> Loads:
    """Return contacts and forces at pinion angles, under one torque: `engage` without ratios; arguments and errors as there."""
    if not torque > 0.0:
        raise InputError(
            "operation.pinion_torque_Nm", f"{torque:g} N m", "a positive torque: without one nothing holds the flanks together"
        )
    contacts, sharing = _share(mesh, pinion_angle, mesh.pairs(pinion_angle), torque)
    deflection = sharing.transmission_error - mesh.gap(contacts).min(axis=1)
    _refuse_overload(mesh, torque, float(deflection.max()))
    force = sharing.force * mesh.placement.pair.face_width
    return Loads(contacts, force, sharing.transmission_error, sharing.slope, deflection)


def engage(mesh: Mesh, pinion_angle: Array, torque: float) -> Engagement:
    """Return the loaded engagement at pinion angles, under one torque.

    Parameters
    ----------
    mesh : Mesh
        Flanks, placement, compliance and contact law.
    pinion_angle : ndarray, shape (n,)
        Angles [rad].
    torque : float
        Torque on the pinion [N m], positive.

    Returns
    -------
    Engagement

    Raises
    ------
    InputError
        If the torque is not positive, or moves the teeth by more than a twentieth of the module.
    SolveError
        If any angle does not converge.

    Notes
    -----
    Ratios are dphi1/dphi2: unloaded by the arms of the pair that touches first (a rigid contact turns the
    wheel by l1/l2, less what runout adds), loaded by the central difference of the transmission error over 2e-4 pitches, which
    replaces a kink by its mean over that width. Physics: Wojnarowski & Onishchenko (2003), sections 2 and 3.
    """
    found, pair = loads(mesh, pinion_angle, torque), mesh.placement.pair
    contacts, force = found.contacts, found.force
    small = DIFFERENCE * pair.pinion.pitch_angle
    before, after = (_share(mesh, pinion_angle + shift * small, mesh.pairs(pinion_angle), torque)[1] for shift in (-1, 1))
    change = (after.transmission_error - before.transmission_error) / (2.0 * small)
    rows = np.arange(len(pinion_angle))
    first = np.argmin(contacts.gap, axis=1)
    nominal = torque / pair.pinion.base_radius
    _, runout = runout_gap(mesh.placement, pinion_angle)
    return Engagement(
        contacts=contacts,
        pinion_torque=torque,
        force=force,
        transmission_error=found.transmission_error,
        mesh_stiffness=1.0 / (found.slope * pair.pinion.base_radius),
        secant_stiffness=nominal / found.deflection,
        single_stiffness=_single_stiffness(mesh, contacts, torque),
        contact_pressure=contact_pressure(mesh, contacts, force),
        gear_ratio=1.0 / (1.0 / pair.ratio - change / pair.wheel.base_radius),
        gear_ratio_unloaded=1.0 / (contacts.arm1[rows, first] / contacts.arm2[rows, first] - runout / pair.wheel.base_radius),
        gear_ratio_force=(force * contacts.arm2).sum(axis=1) / (force * contacts.arm1).sum(axis=1),
    )


def _refuse_overload(mesh: Mesh, torque: float, error: float) -> None:
    """Refuse a torque that bends the teeth so far that small displacements, and the contacts that are followed, end."""
    limit = largest_approach(mesh.placement.pair.pinion.module)
    if error > limit:
        found = f"{torque:g} N m, which moves the teeth by {error / MM:.4g} mm along the line of action"
        raise InputError(
            "operation.pinion_torque_Nm", found, f"a torque that moves them by at most {limit / MM:.4g} mm, a twentieth of the module"
        )


def largest_torque(mesh: Mesh, torque: float, error: float) -> float:
    """Return a torque [N m] that `engage` takes, from the deflection [m] under another one: it grows less than in proportion."""
    return torque * largest_approach(mesh.placement.pair.pinion.module) / error


def _share(mesh: Mesh, angle: Array, pairs: tuple[int, ...], torque: float) -> tuple[Contacts, Sharing]:
    contacts = mesh.touching(find_contacts(mesh.flanks, mesh.placement, angle, pairs))
    return contacts, share_torque(mesh.system(contacts, torque), mesh.law, torque)


def _single_stiffness(mesh: Mesh, contacts: Contacts, torque: float) -> Array:
    """Return the secant stiffness of each pair alone under the whole load where its flanks touch, 0 elsewhere."""
    system = dataclasses.replace(mesh, placement=rigidly_held(mesh.placement)).system(contacts)
    force = torque / system.arm
    own = np.einsum("ajj->aj", system.linear) * force
    approach = own + system.local(mesh.law).approach(force)
    return np.where(contacts.on_flanks, force * mesh.placement.pair.face_width / approach, 0.0)


def contact_pressure(mesh: Mesh, contacts: Contacts, force: Array) -> Array:
    """Return the largest pressure of each contact [Pa] under forces over the face width [N], shape (n, p)."""
    pair = mesh.placement.pair
    line_load = force / pair.face_width
    law = EdgedLine(pinion=pair.pinion.material, wheel=pair.wheel.material)
    lead, touching, surface = mesh.lead, line_load > 0.0, np.zeros_like(line_load)
    line = Line(contacts.flank_radius, surface, surface, contacts.edge, contacts.edge_radius)
    largest = line_load if lead is None else line_load * lead.peak_at(mesh.position(contacts), line_load)
    pressure = np.zeros_like(line_load)
    pressure[touching] = largest_pressure(law, largest[touching], Line(*(values[touching] for values in line)))
    return pressure


def mesh_force(mesh: Mesh, torque: float, steps: int = 240, levels: int = 48) -> MeshForce:
    """Return the forces of the engagement over pinion angle and transmission error.

    Parameters
    ----------
    mesh : Mesh
        Flanks, placement, compliance and contact law.
    torque : float
        Operating torque [N m]; the table reaches four times its largest transmission error.
    steps, levels : int
        Angles over one pitch and levels of the transmission error; worn flanks get more levels.

    Returns
    -------
    MeshForce

    Raises
    ------
    InputError
        If teeth differ, in shape or place, or a gear runs out: the forces then do not repeat every pitch.

    Notes
    -----
    The angles lie at half steps, so that angle 0, where the sliding of pair 0 reverses, lies between two of
    them. The levels grow with the square, since the force rises with a horizontal tangent.
    """
    _refuse_uneven(mesh)
    pair = mesh.placement.pair
    pitch = pair.pinion.pitch_angle
    angle = (np.arange(steps) + 0.5) / steps * pitch
    contacts = mesh.touching(mesh.contacts(angle))
    system = mesh.system(contacts, LARGEST_OVERLOAD * torque)
    operating = share_torque(system, mesh.law, torque)
    unloaded = system.gap.min(axis=1)
    deflection = _levels(unloaded, operating.transmission_error, levels)
    levels = deflection.size
    force = np.zeros((steps, levels, len(contacts.pairs)))
    last = None
    for level in range(1, levels):
        last = share_error(system, mesh.law, np.full(steps, deflection[level]), last).force
        force[:, level] = last * pair.face_width
    sign = np.sign(contacts.sliding_velocity)

    def summed(weight: Array) -> Array:
        total: Array = np.einsum("alj,aj->al", force, weight)
        return total

    return MeshForce(
        pinion_angle=angle,
        period=pitch,
        deflection=deflection,
        normal_force=force.sum(axis=-1),
        pinion_moment=summed(contacts.arm1),
        wheel_moment=summed(contacts.arm2),
        pinion_friction=summed(sign * contacts.friction_arm1),
        wheel_friction=summed(sign * contacts.friction_arm2),
        unloaded_error=unloaded,
        sliding_reversals=np.array([0.0]),
        base_radius1=pair.pinion.base_radius,
        base_radius2=pair.wheel.base_radius,
        normal_backlash=mesh.placement.normal_backlash,
        mean_stiffness=float(np.mean(1.0 / (operating.slope * pair.pinion.base_radius))),
    )


def _levels(unloaded: Array, operating: Array, levels: int) -> Array:
    """Return transmission errors [m] from the first touch at any angle to four times the largest deflection at all.

    Where the first touch wanders there are as many more as keep the steps no larger than the largest of perfect gears.
    """
    top = LARGEST_OVERLOAD * float((operating - unloaded).max())
    spread = float(np.ptp(unloaded))
    count = math.ceil(levels * max(1.0, math.sqrt(spread * (spread + top)) / top))
    grown: Array = unloaded.min() + (spread + top) * np.linspace(0.0, 1.0, count) ** 2
    return grown


def _refuse_uneven(mesh: Mesh) -> None:
    """Refuse teeth that differ from each other: their forces do not repeat every pitch."""
    flanks, placement = mesh.flanks, mesh.placement
    late = any(np.ptp(values) > 0.0 for values in (placement.pinion_late, placement.wheel_late))
    kinds = {
        "odd teeth": bool(flanks.pinion_odd or flanks.wheel_odd or mesh.compliance.pinion_odd or mesh.compliance.wheel_odd),
        "index errors": late,
        "runout": any(placement.pinion_runout) or any(placement.wheel_runout),
    }
    found = " and ".join(kind for kind, there in kinds.items() if there)
    if found:
        raise InputError("effects", found, "teeth all alike, for forces over one pitch: others repeat only after whole turns")
