"""The engagement over many turns, where every tooth may differ: tables of the distinct pairs, solved angle by angle."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearfem.definition.setup import Member
from gearfem.engagement.engage import Mesh
from gearfem.engagement.grid import largest_approach
from gearfem.engagement.pair_table import kernels
from gearfem.engagement.turn_stack import Common, Kind, Stack, make_stack
from gearfem.foundation import Array, InputError, Record, SolveError
from gearfem.foundation.record import digest
from gearfem.foundation.units import MM
from gearfem.placement import evenly_spaced, rigidly_held, runout_gap

Ints = NDArray[np.int64]


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class StaticTurns(Record):
    """The slow engagement at n pinion angles; p pairs are followed at each.

    Parameters
    ----------
    pinion_angle, torque : ndarray, shape (n,)
        Angles [rad] in any order, over any number of turns, and torques on the pinion [N m].
    transmission_error : ndarray, shape (n,)
        Lag of the wheel behind perfect rigid gears, along the line of action [m].
    slope : ndarray, shape (n,)
        Change of the transmission error with the torque [m per N m].
    mesh_stiffness : ndarray, shape (n,)
        Slope of the nominal normal force T1/r_b1 over the transmission error [N/m].
    first : ndarray of int, shape (n,)
        Number of the first pair followed; the others come one by one after it.
    force : ndarray, shape (n, p)
        Normal force on each pair over the whole face width [N]; 0 where it does not touch.
    wheel_moment : ndarray, shape (n,)
        Moment of these forces on the wheel, without friction [N m].
    pinion_weight, wheel_weight : ndarray, shape (n, p)
        Derivatives of the transmission error over the index errors of both teeth of each pair.
    teeth : (int, int)
        Numbers of teeth.
    """

    pinion_angle: Array
    torque: Array
    transmission_error: Array
    slope: Array
    mesh_stiffness: Array
    first: Ints
    force: Array
    wheel_moment: Array
    pinion_weight: Array
    wheel_weight: Array
    teeth: tuple[int, int]

    @property
    def pairs(self) -> Ints:
        """Numbers of the pairs followed, shape (n, p)."""
        return self.first[:, None] + np.arange(self.force.shape[1])

    def by_index_errors(self, member: Member) -> Array:
        """Return the derivatives of the transmission error over the index errors of all teeth of a gear, shape (n, z)."""
        teeth, weight = (self.teeth[0], self.pinion_weight) if member == "pinion" else (self.teeth[1], self.wheel_weight)
        out = np.zeros((len(weight), teeth))
        np.add.at(out, (np.arange(len(weight))[:, None], self.pairs % teeth), weight)
        return out


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Turns(Record):
    """A pair of gears ready to be turned: tables are made when angles first need them, and kept by their content.

    Parameters
    ----------
    mesh : Mesh
        Flanks, placement, compliance and contact law; teeth may be odd, index errors, runout and support are those of the placement.

    Notes
    -----
    Only pairs of different kinds are tabulated: one if all teeth are equal, whatever the index errors; another for each
    combination with an odd tooth that the angles reach. Tables outlive the object: a change of index errors, runout,
    support, friction or drive costs none.
    """

    mesh: Mesh

    def __post_init__(self) -> None:
        super().__post_init__()
        placement = self.mesh.placement
        for name, late, teeth in (
            ("pinion_late", placement.pinion_late, self.teeth[0]),
            ("wheel_late", placement.wheel_late, self.teeth[1]),
        ):
            if late.shape != (teeth,):
                raise InputError(f"placement.{name}", f"shape {late.shape}", f"one value per tooth, {teeth}")

    @property
    def teeth(self) -> tuple[int, int]:
        """Numbers of teeth of both gears."""
        return self.mesh.placement.pair.pinion.teeth, self.mesh.placement.pair.wheel.teeth

    @property
    def hunting(self) -> int:
        """Number of pairs after which the same two teeth meet again."""
        return math.lcm(*self.teeth)

    @functools.cached_property
    def bare(self) -> Mesh:
        """The mesh without what no pair has for itself: index errors, runout, supports, and the play behind the back flanks."""
        placement = dataclasses.replace(rigidly_held(evenly_spaced(self.mesh.placement)), normal_backlash=0.0)
        return dataclasses.replace(self.mesh, placement=placement)

    @functools.cached_property
    def kinds(self) -> tuple[list[Kind], list[Kind]]:
        """Outline and compliance of every tooth of both gears."""
        return self._kinds("pinion", self.teeth[0]), self._kinds("wheel", self.teeth[1])

    def _kinds(self, member: Member, teeth: int) -> list[Kind]:
        flanks, compliance = self.mesh.flanks, self.mesh.compliance
        outlines, yields = flanks.odd(member), compliance.odd(member)
        usual = digest(flanks.of(member)), digest(compliance.of(member))
        outline = {tooth: digest(odd) for tooth, odd in outlines.items()}
        yielding = {tooth: digest(odd) for tooth, odd in yields.items()}
        return [Kind(outline.get(tooth, usual[0]), yielding.get(tooth, usual[1])) for tooth in range(teeth)]

    @functools.cached_property
    def common(self) -> Common:
        """What all pairs share."""
        return Common(digest((self.bare.placement, self.bare.grid)), digest((self.bare.law, self.bare.flanks.lead)))

    @functools.cached_property
    def plain(self) -> Turns:
        """The same gears evenly spaced, centred and rigidly supported; tables are shared."""
        turns = Turns(mesh=self.bare)
        turns.__dict__.update(kinds=self.kinds, common=self.common, _stacks=self._stacks)
        return turns

    @functools.cached_property
    def _stacks(self) -> dict[bytes, Stack]:
        return {}

    @functools.cached_property
    def period(self) -> int:
        """Number of pairs after which the same two kinds of teeth meet again: 1 if all are alike."""
        return math.lcm(*(1 if len(set(kinds)) == 1 else len(kinds) for kinds in self.kinds))

    def stack(self, pitches: Array) -> Stack:
        """Return the tables that pinion angles, in pitches, need."""
        far = math.ceil(self.mesh.placement.pair.contact_ratio) + 1
        whole = np.unique(np.floor(pitches).astype(np.int64) % self.period)
        numbers = np.unique((whole[:, None] + np.arange(-far, far + 2)) % self.period)
        key = numbers.tobytes()
        if key not in self._stacks:
            self._stacks[key] = make_stack(self.bare, self.common, [self._kind(number) for number in range(self.period)], numbers)
        return self._stacks[key]

    def _kind(self, number: int) -> tuple[Kind, Kind]:
        """Return what tells apart the pairs that need tables of their own."""
        return self.kinds[0][number % self.teeth[0]], self.kinds[1][number % self.teeth[1]]


def static(turns: Turns, pinion_angle: ArrayLike, torque: ArrayLike, friction: float = 0.0) -> StaticTurns:
    """Return the slow engagement at any pinion angles.

    Parameters
    ----------
    turns : Turns
        The gears.
    pinion_angle : array_like, shape (n,)
        Angles [rad], in any order and over any number of turns.
    torque : array_like, shape () or (n,)
        Torque on the pinion [N m], positive.
    friction : float
        Coefficient of tooth friction.

    Returns
    -------
    StaticTurns

    Raises
    ------
    InputError
        If a torque is not positive, or moves the teeth beyond what is followed.
    SolveError
        If any angle does not converge to 1e-11 of the load.

    Notes
    -----
    For every pair j in reach: available approach a_j = (e - gap_j - late1_j - late2_j - g - s sum F_k l2/r_b2) l2/r_b2 -
    sum C_jk F_k >= 0, F_j = K_j(a_j) a_j, and sum F_k (l1 + f sign(v_sl) h1) = T1, by Newton's method. A late pinion tooth also
    stands late1/r_b1 behind on its way.
    g is the common gap of the runouts, s the yield of the supports.

    Against `engage` at random angles, relative to the mean deflection: 1e-6 for unworn teeth, up to 6e-6 where the band of contact just
    meets an edge; 1e-5 with index errors; 1e-4 with reliefs; 2e-4 with a lead; up to 1e-2 at single angles where a pit on every tooth
    changes the curvature of both flanks within a hundredth of a pitch, 1e-3 on the whole.
    """
    placement = turns.mesh.placement
    pair = placement.pair
    angle = np.atleast_1d(np.asarray(pinion_angle, float))
    load = _load_at(angle, torque)
    pitches = angle / pair.pinion.pitch_angle
    stack = turns.stack(pitches)
    shape = (angle.size, stack.count)
    error, slope, first = np.full(angle.size, np.nan), np.zeros(angle.size), np.zeros(angle.size, np.int64)
    force, moment, weight1, weight2 = np.zeros(shape), np.zeros(angle.size), np.zeros(shape), np.zeros(shape)
    late = placement.pinion_late, placement.wheel_late
    base = pair.pinion.base_radius
    size = pair.face_width, base, pair.wheel.base_radius, 1.0 / (base * pair.pinion.pitch_angle)
    gap = runout_gap(placement, angle)[0]
    tables = stack.arrays(pair.pinion.module, late)
    failed = kernels().share(
        pitches, load, gap, float(friction), placement.support, *size, *tables, error, slope, first, force, moment, weight1, weight2
    )
    if failed >= 0:
        _fail(turns, load[failed], angle[failed], math.isfinite(error[failed]))
    return StaticTurns(
        pinion_angle=angle,
        torque=load,
        transmission_error=error,
        slope=slope,
        mesh_stiffness=1.0 / (slope * pair.pinion.base_radius),
        first=first,
        force=force,
        wheel_moment=moment,
        pinion_weight=weight1,
        wheel_weight=weight2,
        teeth=turns.teeth,
    )


def _load_at(angle: Array, torque: ArrayLike) -> Array:
    """Return the torque at every angle [N m], all of them finite and positive."""
    load = np.ascontiguousarray(np.broadcast_to(np.asarray(torque, float), angle.shape))
    if not (np.isfinite(angle).all() and np.isfinite(load).all() and (load > 0.0).all()):
        bad = f"{load.min():g} N m" if np.isfinite(load).all() else "a value that is not finite"
        allowed = "a positive torque at every angle: without one nothing holds the flanks together"
        raise InputError("operation.pinion_torque_Nm", bad, allowed)
    return load


def _fail(turns: Turns, torque: float, angle: float, solved: bool) -> None:
    limit = largest_approach(turns.mesh.placement.pair.pinion.module)
    if solved:
        found = f"{torque:g} N m, which presses a pair by more than {limit / MM:.4g} mm"
        raise InputError("operation.pinion_torque_Nm", found, "a torque that moves the teeth by at most a twentieth of the module")
    raise SolveError(f"load sharing did not converge at {torque:g} N m and a pinion angle of {angle:.6g} rad")
