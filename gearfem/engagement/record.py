"""What the engagement stage hands on: everything over the pinion angle."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.foundation import Array, Record


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Contacts(Record):
    """Where each tooth pair would touch, at each pinion angle, if it touched alone and rigid.

    The fixed frame has its origin O1 at the pinion's axis and x towards the wheel's; the pinion turns from
    x to y. At angle 0 pair 0 touches at the pitch point. Pair k is pinion tooth k with wheel tooth k, and
    comes one pitch after pair k - 1. All arrays are (n angles, p pairs) unless stated. A worn pair that may touch on both sides of a
    hollow stands there several times: first touches come first, in the order of the pairs, then the others.

    Parameters
    ----------
    pinion_angle : ndarray, shape (n,)
        Angles [rad].
    pairs : tuple of int, length p
        Numbers of the pairs.
    reach : ndarray of bool
        Whether the pair has a contact point on flank or tip round at all.
    gap : ndarray
        Lag of the wheel at which the pair touches, times its base radius: distance to the perfect involutes at the
        centre distance as mounted, along the line of action [m]. 0 on the path of contact of unworn teeth; positive where
        metal is missing or a tooth is late; where `reach` is false it is a bound that no load closes.
    u1, u2 : ndarray
        Contact points as parameters of the two outlines.
    point : ndarray, shape (n, p, 2)
        Contact points in the fixed frame [m].
    pressure_angle : ndarray
        Angle between the common normal and the normal to the line of centres [rad].
    arm1, arm2 : ndarray
        Arms l1, l2 of the normal force about the two axes [m].
    friction_arm1, friction_arm2 : ndarray
        Distances h1, h2 of the contact point from the feet of the two arms, along the normal [m]. A friction
        force F_t = f P sign(v_sl) takes F_t h1 from the pinion and gives F_t h2 to the wheel.
    equivalent_radius : ndarray
        Equivalent radius of curvature at the contact point [m]; of worn flanks at most ten times that of involutes.
    flank_radius : ndarray
        The same of the two flanks, as if they went on past their tip rounds [m].
    edge, edge_radius : ndarray
        Arc from the contact point to the beginning of the nearest tip round, negative on it, and its radius [m].
    rolling_velocity1, rolling_velocity2, sliding_velocity : ndarray
        Velocity of the contact point along each flank and their difference v1 - v2, per unit angular
        velocity of the pinion [m/rad]; the sliding is negative in approach.
    """

    pinion_angle: Array
    pairs: tuple[int, ...]
    reach: NDArray[Any]
    gap: Array
    u1: Array
    u2: Array
    point: Array
    pressure_angle: Array
    arm1: Array
    arm2: Array
    friction_arm1: Array
    friction_arm2: Array
    equivalent_radius: Array
    flank_radius: Array
    edge: Array
    edge_radius: Array
    rolling_velocity1: Array
    rolling_velocity2: Array
    sliding_velocity: Array

    def count_pairs(self, touching: NDArray[Any]) -> NDArray[np.intp]:
        """Return how many pairs touch at each angle, from which of the contacts do; a pair that touches twice counts once."""
        count: NDArray[np.intp] = np.sum([touching[:, np.equal(self.pairs, pair)].any(axis=1) for pair in set(self.pairs)], axis=0)
        return count

    @property
    def first(self) -> Contacts:
        """The first touch of each pair alone."""
        count = len(set(self.pairs))
        parts = {field.name: getattr(self, field.name) for field in dataclasses.fields(self) if field.name not in ("pinion_angle", "pairs")}
        return dataclasses.replace(self, pairs=self.pairs[:count], **{name: values[:, :count] for name, values in parts.items()})

    @property
    def on_flanks(self) -> NDArray[Any]:
        """Whether flanks touch, not a tip round or the edge of an undercut; of unworn teeth the path of contact."""
        return self.reach & (self.edge >= 0.0)

    @property
    def material_velocity1(self) -> Array:
        """Velocity of the pinion's point in contact, along the flanks, per unit angular velocity of the pinion [m/rad].

        The footnote's velocities of Wojnarowski & Onishchenko (2003): on worn flanks they differ from the rolling velocities
        of eq. 12, since the contact moves along the normal too; the sliding is the same.
        """
        return self.friction_arm1

    @property
    def material_velocity2(self) -> Array:
        """The same of the wheel's point [m/rad]: it turns by l1/l2."""
        return self.arm1 / self.arm2 * self.friction_arm2

    @property
    def specific_sliding1(self) -> Array:
        """Sliding over the velocity of the pinion's own point, ISO 21771; infinite on its base circle."""
        with np.errstate(divide="ignore"):
            return self.sliding_velocity / self.material_velocity1

    @property
    def specific_sliding2(self) -> Array:
        """The same of the wheel, the sliding being that of the wheel's point against the pinion's."""
        with np.errstate(divide="ignore"):
            return -self.sliding_velocity / self.material_velocity2


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Engagement(Record):
    """The loaded engagement over the pinion angle, at one torque.

    Parameters
    ----------
    contacts : Contacts
        Geometry of all pairs at the same angles.
    pinion_torque : float
        Torque on the pinion [N m].
    force : ndarray, shape (n, p)
        Normal force on each contact over the whole face width [N]; 0 where it does not touch.
    transmission_error : ndarray, shape (n,)
        Lag of the wheel behind perfect rigid gears, along the line of action [m].
    mesh_stiffness, secant_stiffness : ndarray, shape (n,)
        Slope and secant of the nominal normal force T1/r_b1 over the transmission error, counted from the first touch [N/m].
    single_stiffness : ndarray, shape (n, p)
        Secant stiffness of each pair, were it to carry the whole load alone [N/m]; 0 where its flanks do not touch.
    contact_pressure : ndarray, shape (n, p)
        Largest pressure on each pair, Hertz's but where its band runs over a tip edge [Pa]; 0 where it does not touch.
    gear_ratio, gear_ratio_unloaded, gear_ratio_force : ndarray, shape (n,)
        dphi1/dphi2 under the torque, of the rigid transmission function, and sum P l2 / sum P l1.
    """

    contacts: Contacts
    pinion_torque: float
    force: Array
    transmission_error: Array
    mesh_stiffness: Array
    secant_stiffness: Array
    single_stiffness: Array
    contact_pressure: Array
    gear_ratio: Array
    gear_ratio_unloaded: Array
    gear_ratio_force: Array

    @property
    def pairs_in_contact(self) -> NDArray[np.intp]:
        """Number of pairs that carry, shape (n,)."""
        return self.contacts.count_pairs(self.force > 0.0)

    @property
    def load_share(self) -> Array:
        """Share of each contact in the sum of the normal forces, shape (n, p)."""
        total: Array = self.force.sum(axis=1, keepdims=True)
        return self.force / total


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class MeshForce(Record):
    """Quasi-static forces of the working flanks over pinion angle and transmission error, for the dynamics.

    The transmission error is e = r_b1 psi1 - r_b2 psi2 (wheel's lag along the line of action); tables are
    zero where nothing touches and linear beyond their last column.

    Parameters
    ----------
    pinion_angle : ndarray, shape (n,)
        Equally spaced angles over one period, the end excluded [rad].
    period : float
        Angle after which everything repeats [rad].
    deflection : ndarray, shape (m,)
        Transmission errors, increasing, from no contact to well above the operating load [m].
    normal_force : ndarray, shape (n, m)
        Sum of the normal forces [N].
    pinion_moment, wheel_moment : ndarray, shape (n, m)
        Sums of P l1 and P l2 [N m].
    pinion_friction, wheel_friction : ndarray, shape (n, m)
        Sums of P sign(v_sl) h1 and P sign(v_sl) h2: moments per unit coefficient of friction [N m].
    unloaded_error : ndarray, shape (n,)
        Transmission error of the rigid gears (0 for perfect ones) [m].
    sliding_reversals : ndarray, shape (k,)
        Angles at which the sliding of a pair changes its sign, where the friction tables jump [rad].
    base_radius1, base_radius2, normal_backlash, mean_stiffness : float
        Base radii and backlash [m]; mean slope of the mesh at the operating torque [N/m].
    """

    pinion_angle: Array
    period: float
    deflection: Array
    normal_force: Array
    pinion_moment: Array
    wheel_moment: Array
    pinion_friction: Array
    wheel_friction: Array
    unloaded_error: Array
    sliding_reversals: Array
    base_radius1: float
    base_radius2: float
    normal_backlash: float
    mean_stiffness: float
