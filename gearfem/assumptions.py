"""What a computation takes for granted, in sentences for the report."""

from __future__ import annotations

import numpy as np

from gearfem.assembly import effects_in
from gearfem.definition.calibration import Calibration
from gearfem.definition.setup import Setup
from gearfem.dynamics.record import DriveTrain
from gearfem.dynamics.supports import RATIO, STIFF
from gearfem.dynamics.uneven import repeats
from gearfem.effects.catalogue import in_history
from gearfem.engagement.turns import Turns
from gearfem.flank import Flanks, fitted_flanks, path_of_contact
from gearfem.foundation import digest
from gearfem.sensing import System

CONTACT = (
    "The contact is a line contact without friction, its band cut off at a tip edge; below it, each tooth yields as its "
    "finite elements do down to its centreline."
)
RATIOS = (
    "The rigid model takes the ratio of the forces under the operation torque, which changes hands over a finite angle; "
    "the elastic model takes the unloaded ratio, since its own deflection adds the rest."
)
UNIFORM = "Plane strain across the whole face width; the load is uniform along it."
SLICED = (
    "Plane strain across the face width. Flanks that are not parallel share the load over slices on the influence of whole solid gears, "
    "which adds to the approach under a uniform load; axes do not tilt under load."
)
BODIES = "Each gear is a disc with a solid web, held rigidly on its bore;"
FITTED = "Fitted values of [calibration] act on stiffness, torque, inertia, damping, readings, tooth spacing and compliance."
EVEN = "All teeth are equal and perfectly spaced."


def of_flanks(flanks: Flanks, setup: Setup) -> tuple[str, ...]:
    """Return what holds for the flanks and what acts on the pair beyond its design, one sentence each."""
    full, left = setup.pair.contact_ratio, sum(path_of_contact(flanks, setup.pair)) / setup.pair.base_pitch
    undercut = f"Undercut shortens the path of contact: the contact ratio is {left:.4f}, not the {full:.4f} of the full tip circles."
    effects = (f"Effect: {effect.describe()}." for effect in in_history(effects_in(setup)))
    return (
        *(() if left > full - 1e-9 else (undercut,)),
        *(flank.sentence for flank in fitted_flanks(setup)),
        *effects,
        *(() if digest(setup.calibration) == digest(Calibration()) else (FITTED,)),
    )


def of_system(system: System) -> tuple[str, ...]:
    """Return what the methods take for granted in this system."""
    return (
        UNIFORM if system.flanks.lead.uniform else SLICED,
        f"{BODIES} {_supports(system)}",
        CONTACT,
        RATIOS,
        *((EVEN,) if even(system) else ()),
    )


def _supports(system: System) -> str:
    """Return how shafts and bearings yield."""
    placement, drive, moving = system.placement, system.drive, not system.drive.two_inertias
    if placement.pinion_support or placement.wheel_support:
        also = "; those of [drive] yield in the elastic dynamics besides" if moving else ""
        masses = f"solid discs of {drive.pinion_mass:.4g} and {drive.wheel_mass:.4g} kg between bore and reference circle"
        return (
            f"the supports of the effect yield wherever there is load, at speed with the masses of the gears on them, {masses}, damped "
            f"by {RATIO:g} of critical; without mass in the classical model, and under a gear that swings on its support by more than "
            f"{STIFF:g} times the frequency of the mesh{also}."
        )
    return "shafts and bearings yield in the elastic dynamics alone, where given." if moving else "shafts and bearings are rigid."


def even(system: System) -> bool:
    """Return whether all teeth of each gear are alike and in their places."""
    flanks, compliance, placement = system.flanks, system.compliance, system.placement
    odd = (flanks.pinion_odd, flanks.wheel_odd, compliance.pinion_odd, compliance.wheel_odd)
    places = (placement.pinion_late, placement.wheel_late, np.array([*placement.pinion_runout, *placement.wheel_runout]))
    return not any(odd) and not any(np.any(place) for place in places)


def uneven_sentence(turns: Turns, drive: DriveTrain) -> str:
    """Return over what stretch the motions of teeth that differ were taken, and how each model takes the difference."""
    pitches = repeats(turns, drive)
    whole = f"{pitches} pitches of the pinion, {pitches / turns.teeth[0]:.4g} of its turns"
    return (
        f"Teeth differ or torques ripple: all three models run over {whole}. The rigid one takes the ratio of the forces and of eccentric "
        "gears, under steady torques; in the other two every tooth acts as it is."
    )
