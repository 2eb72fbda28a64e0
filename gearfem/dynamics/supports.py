"""Supports of a placement as the gears move on them at speed: with their masses, or without where these hardly show."""

from __future__ import annotations

import dataclasses
import math

from gearfem.definition.drive_parts import Support
from gearfem.dynamics.record import DriveTrain
from gearfem.placement import Placement

# A gear that swings on its support by so many times the mesh's frequency moves as if it had no mass, but for the square of its inverse.
STIFF = 8.0
# Of critical, where nothing states what a support loses: that of steel parts without dampers. A model's ratio is that of the teeth.
RATIO = 0.005


def on_supports(placement: Placement, drive: DriveTrain, natural: float) -> tuple[Placement, DriveTrain]:
    """Return a placement and a drive in which the gears move with their masses on what the placement's supports yield.

    Parameters
    ----------
    placement : Placement
        With its supports.
    drive : DriveTrain
        With the masses of the gears, and supports that it states itself.
    natural : float
        Natural frequency of the two gears on their mean mesh stiffness, rigidly held [rad/s].

    Returns
    -------
    Placement, DriveTrain
        Each yield has gone over to the drive; or, under a gear whose own frequency 1/sqrt(c m) on it is more than 8 times the mesh's, to
        the series without mass. Both are as they were where nothing yields.

    Notes
    -----
    A support c has the damper d = 2 zeta sqrt(m/c) with zeta = 0.005. Where the drive states a support under the same gear, both yield one
    after the other: c = c0 + c1 on the stated mass, and d = d0 (c0/c)^2 + d1 (c1/c)^2, which loses what both dampers lose while each
    part takes its share c_i/c of the stretch. A mass that is left out would change motions by some (natural/frequency)^2, 1/64, of what
    the yield does; 3 % were found (tests/truth/test_supports.py).
    """
    one, first = _held(drive.pinion_support, placement.pinion_support, drive.pinion_mass, natural)
    two, second = _held(drive.wheel_support, placement.wheel_support, drive.wheel_mass, natural)
    return (
        dataclasses.replace(placement, series=placement.series + first + second, pinion_support=0.0, wheel_support=0.0),
        dataclasses.replace(drive, pinion_support=one, wheel_support=two),
    )


def _held(stated: Support | None, compliance: float, mass: float, natural: float) -> tuple[Support | None, float]:
    """Return a gear's support with a further compliance in it, and what of that stays without mass."""
    if compliance == 0.0:
        return stated, 0.0
    if stated is None:
        if compliance * mass * (STIFF * natural) ** 2 < 1.0:
            return None, compliance
        return Support(compliance=compliance, mass=mass, damping=_damper(mass, compliance)), 0.0
    whole = stated.compliance + compliance
    damping = stated.damping * (stated.compliance / whole) ** 2 + _damper(stated.mass, compliance) * (compliance / whole) ** 2
    return Support(compliance=whole, mass=stated.mass, damping=damping), 0.0


def _damper(mass: float, compliance: float) -> float:
    return 2.0 * RATIO * math.sqrt(mass / compliance)
