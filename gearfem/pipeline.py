"""The straight line from a definition to motions: one function per stage, one record handed on."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Literal

import numpy as np

from gearfem.assembly import assemble, effects_in, flanks_of
from gearfem.assumptions import even, of_flanks, of_system, uneven_sentence
from gearfem.compliance import (
    Bore,
    Castigliano,
    FiniteElements,
    PlaneStrain,
    PlaneStress,
    Root,
    SolidCurve,
    SolidElements,
    load_positions,
    with_error,
)
from gearfem.compliance.record import Compliance, ComplianceCurve
from gearfem.compliance.solid_curve import QUICK
from gearfem.definition.calibration import Calibration
from gearfem.definition.setup import Member, Setup
from gearfem.dynamics import classical_motion, elastic_motion, rigid_motion, unloaded_transport, wheel_torque_sentence
from gearfem.dynamics.periodic import kinked
from gearfem.dynamics.record import ElasticMotion, RigidMotion
from gearfem.dynamics.turns_plan import moving
from gearfem.dynamics.uneven import uneven_classical, uneven_motion, uneven_rigid
from gearfem.effects.effect import Effect
from gearfem.engagement.engage import Mesh, engage, mesh_force, standard_angles
from gearfem.engagement.record import Engagement, MeshForce
from gearfem.engagement.turns import Turns
from gearfem.flank import Flanks
from gearfem.foundation import Array, Record, digest
from gearfem.foundation.progress import Progress, quiet
from gearfem.sensing import System

Stage = Literal["flank", "compliance", "engagement", "dynamics"]
STAGES: tuple[Stage, ...] = ("flank", "compliance", "engagement", "dynamics")
MEMBERS: tuple[Member, ...] = ("pinion", "wheel")
# The transition from one pair to two takes a twentieth of a pitch, 320 of these steps; Kw is met to about 0.1 %.
RIGID_STEPS = 6400


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Results(Record):
    """The records of all stages that were run; later ones are None.

    Parameters
    ----------
    setup : Setup
        What it was computed from.
    flanks, compliance, mesh, engagement, mesh_force : records
        Of the stages of these names; `mesh` is what the engagement was computed from, for further torques.
    system : System
        The same with drive and instrument: everything that the motions were computed from.
    comparison : tuple of (member, ComplianceCurve)
        The same compliance by other methods and supports, where asked for.
    rigid, elastic, classical : RigidMotion, ElasticMotion, ElasticMotion
        Motions of the three dynamic models.
    assumptions : tuple of str
        Everything that was assumed on the way, the definition's included.
    """

    setup: Setup
    flanks: Flanks
    compliance: Compliance | None = None
    mesh: Mesh | None = None
    system: System | None = None
    comparison: tuple[tuple[Member, ComplianceCurve], ...] = ()
    engagement: Engagement | None = None
    mesh_force: MeshForce | None = None
    rigid: RigidMotion | None = None
    elastic: ElasticMotion | None = None
    classical: ElasticMotion | None = None
    assumptions: tuple[str, ...] = ()


def run(
    setup: Setup,
    until: Stage = "dynamics",
    *,
    effects: Iterable[Effect] = (),
    torque: float | None = None,
    angles: Array | None = None,
    comparison: bool = False,
    progress: Progress = quiet,
) -> Results:
    """Run the chain from a gear pair to its motions, up to a stage.

    Parameters
    ----------
    setup : Setup
        Gear pair, load and drive.
    until : {"flank", "compliance", "engagement", "dynamics"}
        Last stage to run.
    effects : iterable of Effect
        Physical effects beside those that the setup names.
    torque : float, optional
        Torque on the pinion [N m]; by default the operation's. A fitted scale of the torque acts on either.
    angles : ndarray, shape (n,), optional
        Pinion angles of the engagement [rad]; by default 401 from -1 to +1 pitch around the pitch point.
    comparison : bool
        Whether compliance is computed by the other methods and supports too, all with estimates of their errors.
    progress : Progress
        Told how far the work is.

    Returns
    -------
    Results
        All records made on the way.

    Raises
    ------
    InputError
        If the gears cannot mesh.
    SolveError
        If a computation does not reach its tolerance.
    ValueError
        If `until` is not a stage.

    Examples
    --------
    >>> from gearfem.model import load_model
    >>> results = run(load_model("studies/coal_combine/model.toml"), until="flank")
    >>> results.flanks.pinion.undercut
    False
    """
    if until not in STAGES:
        raise ValueError(f"until: found {until!r}; allowed: {', '.join(STAGES)}")
    last = STAGES.index(until)
    setup = dataclasses.replace(setup, effects=(*setup.effects, *effects))
    progress("flanks and compliance", 0, 2)
    flanks = flanks_of(setup)
    results = Results(setup=setup, flanks=flanks, assumptions=setup.assumptions + of_flanks(flanks, setup))
    if last >= STAGES.index("compliance"):
        results = _with_compliance(results, comparison, progress)
    if last >= STAGES.index("engagement"):
        results = _with_engagement(results, setup.operation.pinion_torque if torque is None else torque, angles)
    if last >= STAGES.index("dynamics"):
        results = _with_dynamics(results, progress)
    return results


def compare_methods(flanks: Flanks, face_width: float, progress: Progress = quiet) -> tuple[tuple[Member, ComplianceCurve], ...]:
    """Return the compliance of both gears by every plane state and support, by Castigliano's theorem, and of solid teeth.

    Parameters
    ----------
    flanks : Flanks
        Outlines of both gears.
    face_width : float
        Face width of the solid teeth [m].
    progress : Progress
        Told how far the work is.

    Returns
    -------
    tuple of (member, ComplianceCurve)
        Plane strain on the whole gear is left out: it is the compliance stage itself. So is the whole gear as a solid, for its
        cost. Solid teeth have fewer positions.
    """
    solid = SolidCurve(method=SolidElements(support=Root(), resolution=QUICK), face_width=face_width)
    methods = (
        FiniteElements(plane=PlaneStress(), support=Bore()),
        FiniteElements(plane=PlaneStrain(), support=Root()),
        FiniteElements(plane=PlaneStress(), support=Root()),
        Castigliano(),
        solid,
    )
    jobs = [(member, method) for member in MEMBERS for method in methods]
    curves: list[tuple[Member, ComplianceCurve]] = []
    for number, (member, method) in enumerate(jobs):
        progress("compliance by other methods", number, len(jobs))
        outline = flanks.pinion if member == "pinion" else flanks.wheel
        positions = method.positions() if isinstance(method, SolidCurve) else load_positions(outline)
        curves.append((member, with_error(method, outline, method.curve(outline, positions[positions <= 3.0]))))
    progress("compliance by other methods", len(jobs), len(jobs))
    return tuple(curves)


def with_effects(setup: Setup) -> tuple[tuple[Member, ComplianceCurve], ...]:
    """Return the compliance that the effects of a model leave, of the whole gears, where it is not the one without them.

    Parameters
    ----------
    setup : Setup
        The model.

    Returns
    -------
    tuple of (member, ComplianceCurve)
        Of a gear whose bodies an effect changes, one tooth like most (method ``... with effects``); then each tooth that differs (``...
        tooth n``). Errors are those of the mesh of the tooth without a crack.
    """
    compliance = assemble(setup).compliance
    plain = tuple(effect for effect in effects_in(setup) if effect.stage == "flank")
    before = assemble(dataclasses.replace(setup, effects=plain, calibration=Calibration())).compliance
    method = FiniteElements()
    found: list[tuple[Member, ComplianceCurve]] = []
    for member in MEMBERS:
        usual = compliance.of(member)
        named = [] if digest(usual) == digest(before.of(member)) else [("with effects", usual)]
        for words, curve in (*named, *((f"tooth {number}", tooth) for number, tooth in sorted(compliance.odd(member).items()))):
            own = with_error(method, curve.outline, curve)
            found.append((member, dataclasses.replace(own, method=f"{curve.method} {words}")))
    return tuple(found)


def _with_compliance(results: Results, comparison: bool, progress: Progress) -> Results:
    system = assemble(results.setup)
    compliance = system.compliance
    progress("flanks and compliance", 2, 2)
    if comparison:
        method, flanks = FiniteElements(), results.flanks
        pinion, wheel = (with_error(method, flanks.of(member), compliance.of(member)) for member in MEMBERS)
        compliance = dataclasses.replace(compliance, pinion=pinion, wheel=wheel)
    pair = results.setup.pair
    return dataclasses.replace(
        results,
        compliance=compliance,
        mesh=system.mesh,
        system=system,
        comparison=(*compare_methods(results.flanks, pair.face_width, progress), *_odd(results.setup)) if comparison else (),
        assumptions=results.assumptions + of_system(system),
    )


def _odd(setup: Setup) -> tuple[tuple[Member, ComplianceCurve], ...]:
    """Return the teeth that differ; those like most are the compliance stage itself."""
    return tuple((member, curve) for member, curve in with_effects(setup) if not curve.method.endswith("with effects"))


def _with_engagement(results: Results, torque: float, angles: Array | None) -> Results:
    assert results.mesh is not None
    assert results.system is not None
    torque = results.system.torque(torque)
    positions = standard_angles(results.mesh.placement) if angles is None else np.asarray(angles, float)
    return dataclasses.replace(results, engagement=engage(results.mesh, positions, torque))


def _with_dynamics(results: Results, progress: Progress) -> Results:
    assert results.system is not None
    drive, pair = results.system.drive, results.setup.pair
    discs = pair.pinion.disc_inertia(pair.face_width), pair.wheel.disc_inertia(pair.face_width)
    repeating = even(results.system) and not drive.ripples
    results = (_with_even_dynamics if repeating else _with_uneven_dynamics)(results, discs, progress)
    motions = {"rigid": results.rigid, "elastic": results.elastic, "classical": results.classical}
    torques = [wheel_torque_sentence(name, drive, motion.wheel_torque) for name, motion in motions.items() if motion is not None]
    classical = f"Classical model: inertias of the gears alone, solid discs of {discs[0]:.4g} and {discs[1]:.4g} kg m2."
    return dataclasses.replace(results, assumptions=(*results.assumptions, *torques, classical))


def _with_even_dynamics(results: Results, discs: tuple[float, float], progress: Progress) -> Results:
    """Return the motions of teeth that are all alike, over one pitch."""
    assert results.mesh is not None
    assert results.system is not None
    drive, pair = results.system.drive, results.setup.pair
    forces = mesh_force(results.mesh, drive.pinion_torque)
    mesh, held = moving(results.mesh, drive)
    own = forces if mesh is results.mesh else mesh_force(mesh, drive.pinion_torque)
    pitch = pair.pinion.pitch_angle
    positions = np.arange(RIGID_STEPS) / RIGID_STEPS * pitch
    ratio = _closed(engage(results.mesh, positions, drive.pinion_torque).gear_ratio_force, pair.ratio)
    rigid = rigid_motion(positions, ratio, pitch, drive, kinked)
    coarse = rigid_motion(positions[::2], ratio[::2], pitch, drive, kinked)
    change = abs(rigid.dynamic_factor.max() - coarse.dynamic_factor.max())
    return dataclasses.replace(
        results,
        mesh_force=forces,
        rigid=rigid,
        elastic=elastic_motion(own, held, unloaded_transport(own, held), progress=progress),
        classical=classical_motion(forces, drive, *discs, progress=progress),
        assumptions=(
            *results.assumptions,
            f"Rigid model: {RIGID_STEPS} angles over the pitch; with half of them its largest dynamic factor changes by {change:.2g}.",
        ),
    )


def _with_uneven_dynamics(results: Results, discs: tuple[float, float], progress: Progress) -> Results:
    """Return the motions of teeth that differ, or under torques that ripple, over whole turns."""
    assert results.mesh is not None
    assert results.system is not None
    turns, drive = Turns(mesh=results.mesh), results.system.drive
    progress("motions over whole turns", 0, 3)
    rigid = uneven_rigid(turns, drive)
    progress("motions over whole turns", 1, 3)
    elastic = uneven_motion(turns, drive)
    progress("motions over whole turns", 2, 3)
    classical = uneven_classical(turns, drive, *discs)
    progress("motions over whole turns", 3, 3)
    return dataclasses.replace(
        results, rigid=rigid, elastic=elastic, classical=classical, assumptions=(*results.assumptions, uneven_sentence(turns, drive))
    )


def _closed(ratio: Array, teeth: float) -> Array:
    """Return the ratio of the forces with its mean over the wheel's angle set to that of the teeth.

    Energy makes it so (the wheel's work is the pinion's); the contact points of undeformed teeth miss it by some 1e-5.
    """
    return ratio * float(np.mean(1.0 / ratio)) * teeth
