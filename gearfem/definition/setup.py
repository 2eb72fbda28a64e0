"""The definition of a gear pair, its load and its drive, in SI and radians, with every default resolved."""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property
from typing import Literal

from gearfem.definition.calibration import Calibration
from gearfem.definition.drive_parts import ShaftedInertia, Support
from gearfem.definition.measured_flank import MeasuredFlank
from gearfem.foundation import Record

Member = Literal["pinion", "wheel"]


def involute(angle: float) -> float:
    """Return inv(a) = tan a - a of a pressure angle [rad]."""
    return math.tan(angle) - angle


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Rack(Record):
    """Standard basic rack tooth profile (ISO 53), in modules.

    Parameters
    ----------
    addendum, dedendum, tip_radius : float
        Rack addendum, dedendum and the radius that rounds the tip of the generating rack [modules].
    """

    addendum: float = 1.0
    dedendum: float = 1.25
    tip_radius: float = 0.3


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Material(Record):
    """Linear elastic material of one gear.

    Parameters
    ----------
    youngs_modulus, yield_strength : float
        Young's modulus and tensile yield strength [Pa].
    poissons_ratio : float
        Poisson's ratio.
    density : float
        Density [kg/m3].
    surface_yield_pressure : float, optional
        Contact pressure at which the tooth's surface yields [Pa]; it rules the tip edge where given.
    """

    youngs_modulus: float = 206e9
    poissons_ratio: float = 0.3
    density: float = 7850.0
    yield_strength: float = 1200e6
    surface_yield_pressure: float | None = None

    @property
    def shear_modulus(self) -> float:
        """Shear modulus [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))

    @property
    def plane_strain_modulus(self) -> float:
        """E / (1 - nu^2) [Pa]."""
        return self.youngs_modulus / (1.0 - self.poissons_ratio**2)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Gear(Record):
    """One external spur gear, complete in itself: everything its tooth outline and its body need.

    Parameters
    ----------
    teeth : int
        Number of teeth z.
    module, pressure_angle : float
        Module [m] and pressure angle of the basic rack [rad].
    profile_shift : float
        Profile shift coefficient x.
    flank_thinning : float
        Metal moved off each flank along its normal to give backlash [m].
    root_radius, tip_radius, tip_edge_radius, bore_radius : float
        Radii [m]; the body is held on the bore.
    rack : Rack
        Basic rack that generates the flank and the fillet.
    material : Material
        Material of the whole gear.
    tip_run_out : float
        Arc of the flank over which the curvature of the tip edge runs out into the flank's [m]; 0 is an edge that ends at once.

    Notes
    -----
    Symbols as in ISO 21771: r = m z / 2, r_b = r cos(alpha). The half angle of the tooth on the base
    circle is pi/(2 z) + 2 x tan(alpha)/z + inv(alpha) - s_n/r_b, s_n the thinning along the normal
    (Wojnarowski & Onishchenko 2003, below eq. 1, with the thinning added).
    """

    teeth: int
    module: float
    pressure_angle: float
    profile_shift: float
    flank_thinning: float
    root_radius: float
    tip_radius: float
    tip_edge_radius: float
    bore_radius: float
    rack: Rack
    material: Material
    tip_run_out: float = 0.0

    @property
    def reference_radius(self) -> float:
        """Reference radius r = m z / 2 [m]."""
        return self.module * self.teeth / 2.0

    @property
    def base_radius(self) -> float:
        """Base radius r_b = r cos(alpha) [m]."""
        return self.reference_radius * math.cos(self.pressure_angle)

    @property
    def pitch_angle(self) -> float:
        """Angular pitch 2 pi / z [rad]."""
        return 2.0 * math.pi / self.teeth

    @property
    def base_half_angle(self) -> float:
        """Half angle of the tooth on the base circle [rad]."""
        return (
            math.pi / (2.0 * self.teeth)
            + 2.0 * self.profile_shift * math.tan(self.pressure_angle) / self.teeth
            + involute(self.pressure_angle)
            - self.flank_thinning / self.base_radius
        )

    def half_angle(self, radius: float) -> float:
        """Return the half angle of the tooth [rad] at a radius [m] not below the base radius."""
        return self.base_half_angle - involute(math.acos(self.base_radius / radius))

    def disc_mass(self, face_width: float) -> float:
        """Return the mass [kg] of a solid disc between bore and reference circle."""
        return math.pi * self.material.density * face_width * (self.reference_radius**2 - self.bore_radius**2)

    def disc_inertia(self, face_width: float) -> float:
        """Return the moment of inertia [kg m2] of a solid disc between bore and reference circle."""
        ring = self.reference_radius**4 - self.bore_radius**4
        return 0.5 * math.pi * self.material.density * face_width * ring


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class GearPair(Record):
    """Two external spur gears in engagement; the pinion drives.

    Parameters
    ----------
    pinion, wheel : Gear
        The driving and the driven gear, of equal module and pressure angle.
    centre_distance, face_width, normal_backlash : float
        Working centre distance a, face width b, normal backlash j_n of the stated thinning [m].

    Notes
    -----
    Lengths along the line of action are counted from the pitch point, positive in recess (where the
    contact travels). Symbols and formulas of ISO 21771.
    """

    pinion: Gear
    wheel: Gear
    centre_distance: float
    face_width: float
    normal_backlash: float

    @property
    def ratio(self) -> float:
        """Gear ratio z2/z1."""
        return self.wheel.teeth / self.pinion.teeth

    @property
    def base_pitch(self) -> float:
        """Transverse base pitch [m]."""
        return math.pi * self.pinion.module * math.cos(self.pinion.pressure_angle)

    @cached_property
    def working_pressure_angle(self) -> float:
        """Working transverse pressure angle [rad], from cos(alpha_w) = (r_b1 + r_b2)/a."""
        return math.acos((self.pinion.base_radius + self.wheel.base_radius) / self.centre_distance)

    @property
    def approach_length(self) -> float:
        """Path of approach on the line of action, wheel tip to pitch point [m]."""
        return self._path(self.wheel)

    @property
    def recess_length(self) -> float:
        """Path of recess on the line of action, pitch point to pinion tip [m]."""
        return self._path(self.pinion)

    def gear(self, member: Member | None) -> Gear:
        """Return the wheel, or the pinion for any other."""
        return self.wheel if member == "wheel" else self.pinion

    def _path(self, gear: Gear) -> float:
        height = math.sqrt(max(gear.tip_radius**2 - gear.base_radius**2, 0.0))
        return height - gear.base_radius * math.tan(self.working_pressure_angle)

    @property
    def contact_ratio(self) -> float:
        """Transverse contact ratio of the full tip circles (edge rounding not subtracted)."""
        return (self.approach_length + self.recess_length) / self.base_pitch

    @property
    def zero_backlash_centre_distance(self) -> float:
        """Centre distance [m] at which the unthinned gears mesh without play."""
        return zero_backlash_centre_distance(self.pinion, self.wheel)

    @property
    def working_backlash(self) -> float:
        """Play along the line of action at the working centre distance [m]: that of the thinning and of the distance.

        Base pitch less both tooth thicknesses on their involutes, p_b - 2 sum r_b (half angle - inv(alpha_w)); ISO 21771.
        """
        spread = involute(self.working_pressure_angle)
        return self.base_pitch - 2.0 * sum(gear.base_radius * (gear.base_half_angle - spread) for gear in (self.pinion, self.wheel))


def zero_backlash_centre_distance(pinion: Gear, wheel: Gear) -> float:
    """Return the centre distance [m] at which two unthinned gears mesh without play.

    Parameters
    ----------
    pinion, wheel : Gear
        Only teeth, module, pressure angle and profile shift are used.

    Notes
    -----
    inv(alpha_w) = inv(alpha) + 2 (x1 + x2) tan(alpha)/(z1 + z2), solved by Newton's method; ISO 21771.
    """
    angle = pinion.pressure_angle
    teeth = pinion.teeth + wheel.teeth
    target = involute(angle) + 2.0 * (pinion.profile_shift + wheel.profile_shift) * math.tan(angle) / teeth
    if target <= 0.0:
        raise ValueError(f"the profile shifts sum to {pinion.profile_shift + wheel.profile_shift:g}: no working pressure angle")
    working = (3.0 * target) ** (1.0 / 3.0)
    for _ in range(50):
        step = (involute(working) - target) / math.tan(working) ** 2
        working -= step
        if abs(step) < 1e-15:
            break
    return (pinion.base_radius + wheel.base_radius) / math.cos(working)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Operation(Record):
    """Load, speed and drive of the pair.

    Parameters
    ----------
    pinion_torque, wheel_torque : float
        Driving torque on the pinion and braking torque on the wheel [N m], both positive.
    efficiency : float
        Efficiency of the drive, 0 < eta <= 1.
    pinion_speed : float
        Mean angular velocity of the pinion [rad/s].
    pinion_inertia, wheel_inertia : float
        Moments of inertia of everything that turns with each gear [kg m2].
    friction_coefficient, damping_ratio : float
        Coefficient of tooth friction; zeta of D = 2 zeta sqrt(C M).
    pinion_chain, wheel_chain : tuple of ShaftedInertia
        Further inertias on elastic shafts, from the gear outward; the last one carries the side's torque.
    pinion_support, wheel_support : Support, optional
        Yielding supports along the line of action; None is rigid.
    """

    pinion_torque: float
    wheel_torque: float
    efficiency: float
    pinion_speed: float
    pinion_inertia: float
    wheel_inertia: float
    friction_coefficient: float
    damping_ratio: float
    pinion_chain: tuple[ShaftedInertia, ...] = ()
    wheel_chain: tuple[ShaftedInertia, ...] = ()
    pinion_support: Support | None = None
    wheel_support: Support | None = None


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Setup(Record):
    """What a calculation starts from: the pair, its operation, and what was assumed to complete them.

    Parameters
    ----------
    name : str
        Title of the model.
    pair : GearPair
        The two gears and how they are mounted.
    operation : Operation
        Load, speed and drive.
    flanks_given : tuple of MeasuredFlank
        Measured points of working flanks, instead of the involute.
    effects : tuple of Record
        Physical effects that the model names (`gearfem.effects.Effect`).
    calibration : Calibration
        Nuisances that were fitted to measurements.
    assumptions : tuple of str
        One sentence for each value that the model file left open and for each default that matters.
    source : str
        Canonical text of the model as it was resolved from (for its hash).
    """

    name: str
    pair: GearPair
    operation: Operation
    flanks_given: tuple[MeasuredFlank, ...] = ()
    effects: tuple[Record, ...] = ()
    calibration: Calibration = dataclasses.field(default_factory=Calibration)
    assumptions: tuple[str, ...] = ()
    source: str = ""
