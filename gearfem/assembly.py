"""A gear pair and its effects brought together: the records of all stages before anything moves."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import TypeVar

from gearfem.compliance import make_compliance
from gearfem.compliance.record import Compliance
from gearfem.contact import EdgedLine
from gearfem.contact.scaled import Law, evened
from gearfem.definition.calibration import Calibration
from gearfem.definition.setup import Setup
from gearfem.dynamics import DriveTrain, make_drive
from gearfem.effects.catalogue import in_history
from gearfem.effects.effect import Effect, Stage
from gearfem.flank import Flanks, make_flanks
from gearfem.foundation import InputError
from gearfem.foundation.cache import remembered
from gearfem.placement import Placement, make_placement
from gearfem.sensing import Instrument, System
from gearfem.variants import VARIANTS, varied

Stated = TypeVar("Stated")


def assemble(setup: Setup, effects: Iterable[Effect] = ()) -> System:
    """Bring a gear pair and its effects together: the records of all stages before anything moves.

    Parameters
    ----------
    setup : Setup
        Gear pair, load and drive; the effects and the calibration that it names act too.
    effects : iterable of Effect
        Further effects, after those of the setup.

    Returns
    -------
    System

    Raises
    ------
    InputError
        If an effect is beyond its bounds, or leaves gears that cannot mesh.
    SolveError
        If a compliance cannot be computed.
    FloatingPointError
        If an effect leaves what is no number.
    EffectError
        If the `act` of an effect fails.

    Notes
    -----
    Effects of a stage act in the order of the part's history (`gearfem.effects.effect.HISTORY`), then as given. Each stage is
    remembered by what it depends on, so that a changed effect repeats nothing before its own stage.

    Examples
    --------
    >>> from gearfem.effects.runout import Runout
    >>> from gearfem.model import load_model
    >>> system = assemble(load_model("studies/coal_combine/model.toml"), [Runout(gear="wheel", eccentricity=2e-5, angle=0.0)])
    >>> system.placement.wheel_runout
    (2e-05, 0.0)
    """
    chosen, bare = _checked([*effects_in(setup), *effects], setup), _bare(setup)

    def of(stage: Stage) -> tuple[Effect, ...]:
        return tuple(effect for effect in chosen if effect.stage == stage)

    fitted, drive = setup.calibration, make_drive(setup)
    flanks = _flanks(bare, of("flank"))
    compliance = _compliance(flanks, bare, of("compliance"))
    placement = _late(make_placement(setup), fitted)
    placement = dataclasses.replace(placement, series=fitted.series_compliance)
    placement = _act(placement, of("placement"), bare)
    # A stiffness scale is one of Young's moduli: every compliance, the contact's too, depends on force over modulus alone.
    materials = (gear.material for gear in (setup.pair.pinion, setup.pair.wheel))
    pinion, wheel = (dataclasses.replace(steel, youngs_modulus=fitted.stiffness_scale * steel.youngs_modulus) for steel in materials)
    law: Law = EdgedLine(pinion=pinion, wheel=wheel)
    drive = _act(_scaled(drive, fitted), of("drive"), bare)
    system = System(
        setup=setup,
        # The compliance stays that of the model's tip edges: its table begins and ends with rounds that move by a hundredth of the flank.
        flanks=flanks.edged(fitted.tip_edge_scale),
        compliance=compliance.coupled(fitted.coupling_scale),
        placement=placement,
        law=evened(_act(law, of("contact"), bare), fitted.evenness),
        # A fitted scale belongs to the damping that the effects leave, as its fit has it.
        drive=dataclasses.replace(drive, damping_ratio=drive.damping_ratio * fitted.damping_scale),
        instrument=_act(Instrument(gain=fitted.gain), of("sensing"), bare),
    )
    system = varied(system, ((variant, getattr(fitted, variant.name)) for variant in VARIANTS))
    return dataclasses.replace(system, compliance=_softer(system.compliance, 1.0 / fitted.stiffness_scale))


def effects_in(setup: Setup) -> tuple[Effect, ...]:
    """Return the effects that a setup names."""
    return tuple(effect for effect in setup.effects if isinstance(effect, Effect))


def _checked(effects: Iterable[Effect], setup: Setup) -> tuple[Effect, ...]:
    """Return effects in the order in which they act; refuse those that are beyond their bounds."""
    chosen = in_history(effects)
    for effect in chosen:
        try:
            effect.check(setup)
        except InputError as error:
            raise InputError(f"{effect.name}.{error.where}", error.found, error.allowed) from None
    return chosen


def flanks_of(setup: Setup) -> Flanks:
    """Return the flanks of a gear pair with the effects that it names, without computing anything further."""
    flanks = _flanks(_bare(setup), tuple(effect for effect in _checked(effects_in(setup), setup) if effect.stage == "flank"))
    return flanks.edged(setup.calibration.tip_edge_scale)


def _bare(setup: Setup) -> Setup:
    """Return the setup by which stages are remembered: as designed, so that each depends on its own effects alone."""
    return dataclasses.replace(setup, effects=(), calibration=Calibration(), name="", assumptions=(), source="")


def _act(record: Stated, effects: tuple[Effect, ...], setup: Setup) -> Stated:
    """Return the record of a stage with all effects of that stage in it."""
    for effect in effects:
        record = effect.acted(record, setup)
    return record


_designed = remembered(make_flanks)


@remembered
def _flanks(setup: Setup, effects: tuple[Effect, ...]) -> Flanks:
    return _act(_designed(setup), effects, setup)


@remembered
def _compliance(flanks: Flanks, setup: Setup, effects: tuple[Effect, ...]) -> Compliance:
    return _act(make_compliance(flanks), effects, setup)


def _scaled(drive: DriveTrain, fitted: Calibration) -> DriveTrain:
    """Return a drive with the fitted scales of its torques and inertias."""
    return dataclasses.replace(
        drive,
        pinion_torque=drive.pinion_torque * fitted.torque_scale,
        wheel_torque=drive.wheel_torque * fitted.torque_scale,
        pinion_inertia=drive.pinion_inertia * fitted.inertia_scale,
        wheel_inertia=drive.wheel_inertia * fitted.inertia_scale,
    )


def _late(placement: Placement, fitted: Calibration) -> Placement:
    """Return a placement with the fitted index errors."""
    late = ((placement.pinion_late, fitted.pinion_late), (placement.wheel_late, fitted.wheel_late))
    pinion, wheel = (stated + error if error.size else stated for stated, error in late)
    return dataclasses.replace(placement, pinion_late=pinion, wheel_late=wheel)


def _softer(compliance: Compliance, scale: float) -> Compliance:
    """Return a compliance of which teeth and bodies yield a multiple; contacts are the law's."""
    return compliance.each(lambda tooth: dataclasses.replace(tooth, deflection=scale * tooth.deflection, coupling=scale * tooth.coupling))
