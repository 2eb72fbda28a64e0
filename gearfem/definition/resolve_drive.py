"""The drive train of a model file, [[drive.inertia]] and [drive.support], in SI, with its defaults said in sentences."""

from __future__ import annotations

from gearfem.definition.drive_parts import ShaftedInertia, Support
from gearfem.definition.schema import Model
from gearfem.definition.setup import Gear, Member
from gearfem.foundation import InputError
from gearfem.foundation.units import UM_PER_KN


def resolve_chain(model: Model, member: Member, notes: list[str]) -> tuple[ShaftedInertia, ...]:
    """Return the inertias on one side of the pair, from the gear outward.

    Parameters
    ----------
    model : Model
        Validated tables.
    member : {"pinion", "wheel"}
        Side.
    notes : list of str
        Takes one sentence for each damping that was left open.

    Raises
    ------
    InputError
        If two inertias share a name.
    """
    names = [table.name for table in model.drive.inertia]
    for place, name in enumerate(names):
        if name in names[:place]:
            raise InputError(f"drive.inertia[{place + 1}].name", f'"{name}" again', "a name of its own for each inertia")
    chain = [table for table in model.drive.inertia if table.side == member]
    notes += [f'Damping of the shaft of "{table.name}" not given: none.' for table in chain if not table.given("shaft_damping_Nms_per_rad")]
    return tuple(
        ShaftedInertia(
            name=table.name,
            inertia=table.inertia_kg_m2,
            stiffness=table.shaft_stiffness_Nm_per_rad,
            damping=table.shaft_damping_Nms_per_rad,
        )
        for table in chain
    )


def resolve_support(model: Model, member: Member, gear: Gear, face_width: float, notes: list[str]) -> Support | None:
    """Return the support of one gear along the line of action; None where it is rigid.

    Parameters
    ----------
    model : Model
        Validated tables.
    member : {"pinion", "wheel"}
        Gear that is held.
    gear : Gear
        Its geometry, for the mass that is assumed where none is given.
    face_width : float
        Face width [m].
    notes : list of str
        Takes the sentences about values that were left open.

    Raises
    ------
    InputError
        If a mass or a damping is given to a rigid support.
    """
    table = model.drive.support
    compliance: float = getattr(table, f"{member}_um_per_kN") * UM_PER_KN
    mass_key, damping_key = f"{member}_mass_kg", f"{member}_damping_Ns_per_m"
    if compliance == 0.0:
        for key in (mass_key, damping_key):
            if table.given(key):
                raise InputError(f"drive.support.{key}", f"{getattr(table, key):g}", f"this key only beside {member}_um_per_kN above 0")
        return None
    mass: float | None = getattr(table, mass_key)
    if mass is None:
        mass = gear.disc_mass(face_width)
        notes.append(f"Mass on the support of the {member} not given: a solid disc between bore and reference circle, {mass:.4g} kg.")
    if not table.given(damping_key):
        notes.append(f"Damping of the support of the {member} not given: none.")
    return Support(compliance=compliance, mass=mass, damping=getattr(table, damping_key))
