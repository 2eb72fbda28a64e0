"""Compliance of one tooth by beam theory over its real thickness, of its foundation, of a crack, and of the contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .gear import Array, Gear

# Sainsot, Velex & Duverger, J. Mech. Design 126 (2004): A, B, C, D, E, F of L*, M*, P*, Q*.
SAINSOT = np.array(
    [
        [-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045],
        [60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086],
        [-50.952e-5, 185.50e-3, 0.0538e-4, 53.3e-3, 0.2895, 0.9236],
        [-6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904],
    ]
)
# Tada, Paris & Irwin: K = stress sqrt(pi a) F(a/W) of an edge crack in bending.
TADA = np.array([14.0, -13.08, 7.33, -1.40, 1.122])


@dataclass(frozen=True)
class ToothTable:
    """Compliances times width and Young's modulus against roll length; `lever` squared times the hinge is a crack's share."""

    roll: Array
    beam: Array
    body: Array
    lever: Array
    section: float


@lru_cache(maxsize=64)
def tooth_table(gear: Gear, poisson: float = 0.3) -> ToothTable:
    """Integrate bending, shear and compression from the root up to the load, and add Sainsot's foundation.

    Plane strain in the beam; dimensionless result: deflection = table * force / (width * E).
    """
    form = math.hypot(gear.base_radius * 1.0001, gear.form_roll)
    radius = np.linspace(form, gear.tip_radius, 80)
    psi = gear.half_angle(radius)
    height, half = radius * np.cos(psi), radius * np.sin(psi)
    foot = gear.root_radius
    t = np.linspace(1.0, 0.0, 40, endpoint=False)
    neck = height[0] - t * (height[0] - foot)
    flare = half[0] + 0.33 * gear.module * (1.0 - np.sqrt(1.0 - 0.97 * t**2))
    axis, thick = np.concatenate([neck, height]), np.concatenate([flare, half])
    roll = np.linspace(max(gear.form_roll, 0.02 * gear.tip_roll), gear.tip_roll, 48)
    load_radius = np.hypot(gear.base_radius, roll)
    load_psi = gear.half_angle(load_radius)
    angle = np.arctan(roll / gear.base_radius) - load_psi
    top, side = load_radius * np.cos(load_psi), load_radius * np.sin(load_psi)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    y = foot + (top - foot)[:, None] * (nodes + 1.0) / 2.0
    dy = (top - foot)[:, None] * weights / 2.0
    h = np.interp(y, axis, thick)
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    moment = cos * (top[:, None] - y) - sin * side[:, None]
    plane = 1.0 - poisson**2
    bending = (plane * moment**2 / (2.0 * h**3 / 3.0) * dy).sum(1)
    shear = (1.2 * cos**2 * 2.0 * (1.0 + poisson) / (2.0 * h) * dy).sum(1)
    compression = (plane * sin**2 / (2.0 * h) * dy).sum(1)
    crossing = top - side * np.tan(angle) - foot
    body = _foundation(gear, math.atan(thick[0] / foot), crossing, angle)
    at = int(np.argmin(np.abs(np.gradient(flare, neck) + math.tan(math.radians(30.0)))))
    lever = np.maximum(np.cos(angle) * (top - neck[at]) - np.sin(angle) * side, 0.0)
    return ToothTable(roll, bending + shear + compression, body, lever, 2.0 * float(flare[at]))


def _foundation(gear: Gear, theta: float, crossing: Array, angle: Array) -> Array:
    ratio = min(max(gear.root_radius / gear.bore_radius, 1.4), 7.0)
    basis = np.array([theta**-2, ratio**2, ratio / theta, 1.0 / theta, ratio, 1.0])
    big_l, big_m, big_p, big_q = SAINSOT @ basis
    u = np.maximum(crossing, 0.0) / (2.0 * gear.root_radius * theta)
    return np.asarray(np.cos(angle) ** 2 * (big_l * u**2 + big_m * u + big_p * (1.0 + big_q * np.tan(angle) ** 2)))


def crack_table(gear: Gear, depth: float, poisson: float = 0.3) -> Array:
    """Extra compliance (times width and E) of a cracked tooth: the hinge of linear fracture mechanics, growing faster when deep."""
    table = tooth_table(gear)
    reach = min(depth / table.section, 0.6)
    x = np.linspace(0.0, reach, 200)
    hinge = 72.0 * math.pi * (1.0 - poisson**2) / table.section**2 * np.trapezoid(x * np.polyval(TADA, x) ** 2, x)
    return hinge * table.lever**2


@dataclass(frozen=True)
class ContactLaw:
    """Approach of two flanks: logarithmic in load with depth `depth` times the module, or a power of the load.

    The power law (Palmgren's exponent is 0.9) is set to meet the logarithmic one at a line load of E * module / 5000.
    """

    power: float | None = 0.9
    depth: float = 0.7

    def approach(self, force: Array, radius: Array, youngs: float, module: float, width: float) -> tuple[Array, Array]:
        """Return the approach of both flanks together and its slope; linear below a thousandth of the anchor load."""
        anchor = youngs * module / 5000.0
        line = force / width
        least = 1e-3 * anchor
        q = np.maximum(line, least)
        if self.power is None:
            delta, slope = self._log(q, radius, youngs, module)
        else:
            level = self._log(np.full_like(q, anchor), np.full_like(q, 0.6 * module), youngs, module)[0]
            delta = level * (q / anchor) ** self.power
            slope = self.power * delta / q
        low = line < least
        slope = np.where(low, delta / least, slope)
        return np.where(low, slope * line, delta), slope / width

    def _log(self, q: Array, radius: Array, youngs: float, module: float) -> tuple[Array, Array]:
        plane = 0.91
        half = np.sqrt(8.0 * q * radius * plane / (math.pi * youngs))
        scale = 2.0 * plane / (math.pi * youngs)
        value = 2.0 * np.log(2.0 * self.depth * module / half) - 0.3 / 0.7
        value = np.maximum(value, 1.5)
        return scale * q * value, scale * (value - 1.0)
