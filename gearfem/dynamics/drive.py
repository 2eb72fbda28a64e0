"""The drive train of a definition, and what its models changed in it, in words."""

from __future__ import annotations

from gearfem.definition.setup import Setup
from gearfem.dynamics.record import DriveTrain


def make_drive(setup: Setup) -> DriveTrain:
    """Return the drive train that a definition states: inertias, shafts, supports, torques and losses.

    Parameters
    ----------
    setup : Setup
        Definition of pair and operation.

    Returns
    -------
    DriveTrain
    """
    operation = setup.operation
    return DriveTrain(
        pinion_inertia=operation.pinion_inertia,
        wheel_inertia=operation.wheel_inertia,
        pinion_torque=operation.pinion_torque,
        wheel_torque=operation.wheel_torque,
        efficiency=operation.efficiency,
        pinion_speed=operation.pinion_speed,
        friction_coefficient=operation.friction_coefficient,
        damping_ratio=operation.damping_ratio,
        pinion_chain=operation.pinion_chain,
        wheel_chain=operation.wheel_chain,
        pinion_support=operation.pinion_support,
        wheel_support=operation.wheel_support,
        pinion_mass=setup.pair.pinion.disc_mass(setup.pair.face_width),
        wheel_mass=setup.pair.wheel.disc_mass(setup.pair.face_width),
    )


def wheel_torque_sentence(model: str, drive: DriveTrain, wheel_torque: float) -> str:
    """Return the sentence that says how far a model moved the wheel's torque to reach its balance.

    Parameters
    ----------
    model : str
        "rigid", "elastic" or "classical".
    drive : DriveTrain
        Holds the stated wheel torque.
    wheel_torque : float
        Torque at which the model balances [N m].

    Returns
    -------
    str

    Examples
    --------
    >>> drive = DriveTrain(pinion_inertia=10.16, wheel_inertia=6.72, pinion_torque=1605.0, wheel_torque=4911.0,
    ...     efficiency=0.96, pinion_speed=53.0, friction_coefficient=0.1, damping_ratio=0.18)
    >>> wheel_torque_sentence("rigid", drive, 4911.3)
    'Rigid model: wheel torque scaled from 4911 to 4911.3 N m (+0.006 %), so that the work balances at the efficiency 0.96.'
    """
    change = 100.0 * (wheel_torque / drive.wheel_torque - 1.0)
    if model == "rigid":
        reason = f"the work balances at the efficiency {drive.efficiency:g}"
    else:
        reason = f"the mean power of the orbit balances at the tooth friction {drive.friction_coefficient:g} (the efficiency is not used)"
    moved = f"wheel torque scaled from {drive.wheel_torque:.6g} to {wheel_torque:.6g} N m ({change:+.3f} %)"
    return f"{model.capitalize()} model: {moved}, so that {reason}."
