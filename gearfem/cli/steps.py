"""What each command computes and writes; everything heavy is imported by whoever asks for this module."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np

from gearfem.assembly import flanks_of
from gearfem.cli.notices import ENGAGED, MOVING, SHAPES, TEETH, unseen
from gearfem.compliance import (
    Bore,
    Castigliano,
    FiniteElements,
    PlaneStrain,
    PlaneStress,
    Root,
    RootChord,
    SolidCurve,
    SolidElements,
    body_compliance,
    load_positions,
    with_error,
)
from gearfem.compliance.body import BodyCompliance
from gearfem.compliance.record import ComplianceCurve
from gearfem.compliance.solid_curve import QUICK
from gearfem.definition.setup import GearPair, Member, Setup
from gearfem.engagement.carpet import error_carpet
from gearfem.engagement.engage import engage
from gearfem.engagement.width_load import load_over_width
from gearfem.flank import Flanks, Outline
from gearfem.foundation import Array, InputError
from gearfem.foundation.progress import Progress
from gearfem.foundation.units import N_PER_MM_UM, UM_PER_N_PER_MM
from gearfem.pipeline import Results, with_effects
from gearfem.pipeline import run as run_chain
from gearfem.report import (
    Rendering,
    summarise,
    write_animation,
    write_body,
    write_compliance,
    write_dynamics,
    write_kinematics,
    write_kinematics_pictures,
    write_measured_flanks,
    write_measured_picture,
    write_motion_pictures,
    write_pictures,
    write_render,
    write_report,
    write_stiffness,
    write_stiffness_pictures,
    write_summary,
    write_vtu,
    write_width_picture,
)
from gearfem.report.hunting import combinations, write_hunting

MEMBERS: tuple[Member, ...] = ("pinion", "wheel")
# A longer stretch is another question than a look at the engagement.
MOST_PITCHES = 1000.0
SUPPORTS: dict[str, type[Bore] | type[Root] | type[RootChord]] = {"bore": Bore, "root": Root, "root_chord": RootChord}


class Done(NamedTuple):
    """What a command has to say at its end."""

    lines: list[str]
    files: list[Path]


def say(done: Done) -> None:
    """Print a summary and where the files are."""
    for line in done.lines:
        click.echo(line)
    for path in done.files:
        click.echo(f"wrote {path}")


# ---- commands ---------------------------------------------------------------------------------------


def everything(setup: Setup, out: Path, progress: Progress) -> Done:
    """Run the whole chain and write every file of it."""
    results = run_chain(setup, comparison=True, progress=progress)
    files = [write_compliance(results, out), write_body(setup, _bodies(results.flanks), out)]
    files += [write_stiffness(results, out), write_kinematics(results, out), *write_dynamics(results, out)]
    if setup.flanks_given:
        files.append(write_measured_flanks(results, out))
    files.append(write_summary(results, out))
    progress("pictures", 0, 3)
    renderings = [_draw(results.setup, results.flanks, member, out) for member in MEMBERS]
    progress("pictures", 1, 3)
    pictures = write_pictures(results, out)
    progress("pictures", 2, 3)
    files += [*pictures.values(), *(path for rendering in renderings for path in (rendering.path, rendering.path.with_suffix(".vtu")))]
    files.append(write_report(results, out, rendering=renderings[0], pictures=pictures))
    progress("pictures", 3, 3)
    notices = sorted({rendering.notice for rendering in renderings if rendering.notice})
    return Done(_numbers(results) + _left_out_lines(results) + notices + unseen(setup, MOVING), files)


def compliance(setup: Setup, out: Path, support: str, solid: bool, progress: Progress) -> Done:
    """Compute the compliance of both gears by several methods, with the finite elements held at the support.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.
    out : Path
        Folder.
    support : str
        What is held.
    solid : bool
        Whether solids are computed at their default resolution, the whole gear too; otherwise teeth alone at a quicker one.
    progress : Progress
        Told how far the work is.
    """
    flanks = flanks_of(setup)
    held = SUPPORTS[support]()
    methods: list[FiniteElements | Castigliano | SolidCurve] = [
        FiniteElements(plane=PlaneStrain(), support=held),
        FiniteElements(plane=PlaneStress(), support=held),
        Castigliano(),
    ]
    whole = support == "bore"
    if solid or not whole:
        elements = SolidElements(support=held) if solid else SolidElements(support=held, resolution=QUICK)
        methods.append(SolidCurve(method=elements, face_width=setup.pair.face_width))
    curves: list[tuple[Member, ComplianceCurve]] = []
    lines = []
    jobs = [(member, method) for member in MEMBERS for method in methods]
    for number, (member, method) in enumerate(jobs):
        progress("compliance", number, len(jobs))
        curve, line = _curve(_outline(flanks, member), method)
        curves.append((member, curve))
        lines.append(f"{member}, {line}")
    progress("compliance", len(jobs), len(jobs))
    if whole and not solid:
        lines.append("fe_3d is left out: the whole gears as solids take minutes, --solid asks for them")
    for member, curve in with_effects(setup):
        curves.append((member, curve))
        low, high = curve.deflection.min() / UM_PER_N_PER_MM, curve.deflection.max() / UM_PER_N_PER_MM
        lines.append(f"{member}, {curve.method}, {curve.support}: {low:.5f} to {high:.5f} um per N/mm")
    lines += unseen(setup, TEETH, lead=False)
    results = Results(setup=setup, flanks=flanks, comparison=tuple(curves), assumptions=setup.assumptions)
    parts = _bodies(flanks)
    return Done(
        lines + [_body_line(member, part) for member, part in parts], [write_compliance(results, out), write_body(setup, parts, out)]
    )


def stiffness(setup: Setup, out: Path, steps: int, torques: Sequence[float], progress: Progress) -> Done:
    """Compute the engagement under one or more torques."""
    wanted = tuple(torques) or (setup.operation.pinion_torque,)
    for torque in wanted:
        if not (math.isfinite(torque) and torque > 0.0):
            raise InputError("--torque", torque, "a number above 0 N m")
    angles = _angles(setup.pair, steps)
    prepared = run_chain(setup, "compliance", progress=progress).mesh
    assert prepared is not None
    progress("solid elements of a lead", 0, 1)
    leads = prepared.lead is not None
    progress("solid elements of a lead", 1, 1)
    results = run_chain(setup, "engagement", torque=wanted[0], angles=angles, progress=progress)
    assert results.mesh is not None
    assert results.engagement is not None
    engagements = [results.engagement]
    for number, torque in enumerate(wanted[1:], start=1):
        progress("engagement", number, len(wanted))
        engagements.append(engage(results.mesh, angles, torque))
    progress("engagement", len(wanted), len(wanted))
    carpet = error_carpet(results.mesh, angles, max(wanted), progress)
    lines = [line for one in engagements for line in _numbers(dataclasses.replace(results, engagement=one))]
    widths = [load_over_width(results.mesh, one, progress) for one in engagements] if leads else []
    for one, along in zip(engagements, widths, strict=False):
        factor = along.face_load_factor
        lines.append(f"face load factor K_Hbeta at {one.pinion_torque:g} N m: {factor.min():.3f} to {factor.max():.3f}")
    files = [write_stiffness(results, out, engagements, widths), *write_stiffness_pictures(setup, engagements, carpet, out)]
    if widths:
        files.append(write_width_picture(setup, engagements[0].pinion_torque, widths[0], out))
    if (pitches := combinations(results.mesh)) > 1:
        progress("all tooth combinations", 0, 1)
        files += write_hunting(setup, results.mesh, wanted[0], out)
        progress("all tooth combinations", 1, 1)
        lines.append(f"teeth differ: the same ones meet again after {pitches} pitches, over which hunting.csv runs at {wanted[0]:g} N m")
    return Done([*dict.fromkeys(lines), *unseen(setup, ENGAGED)], files)


def kinematics(setup: Setup, out: Path, steps: int, pitches: tuple[float, float], gif: bool, progress: Progress) -> Done:
    """Compute the engagement for its kinematics."""
    first, last = pitches
    if not (math.isfinite(first) and math.isfinite(last) and first + 1.0 <= last <= first + MOST_PITCHES):
        found, allowed = f"{first:g} {last:g}", f"two numbers, the second larger by 1 to {MOST_PITCHES:g}"
        raise InputError("--pitches", found, allowed)
    angles = np.linspace(first, last, steps + 1) * setup.pair.pinion.pitch_angle
    results = run_chain(setup, "engagement", angles=angles, progress=progress)
    files = [write_kinematics(results, out), *write_kinematics_pictures(results, out)]
    if setup.flanks_given:
        files += [write_measured_flanks(results, out), write_measured_picture(results, out)]
    if gif:
        progress("animation", 0, 1)
        files.append(write_animation(results, out))
        progress("animation", 1, 1)
    return Done([*_numbers(results), *unseen(setup, ENGAGED)], files)


def dynamics(setup: Setup, out: Path, progress: Progress) -> Done:
    """Compute the three models of the dynamics."""
    results = run_chain(setup, progress=progress)
    assert results.elastic is not None
    files = [*write_dynamics(results, out), *write_motion_pictures(results.elastic, setup, out)]
    return Done([*_numbers(results), *unseen(setup, MOVING)], files)


def render(setup: Setup, out: Path, members: Sequence[str], progress: Progress, tooth: int | None = None) -> Done:
    """Draw the loaded teeth: those like most, or one by its number."""
    flanks = flanks_of(setup)
    lines, files = [], []
    for number, member in enumerate(member for member in MEMBERS if member in members):
        progress("rendering", number, len(members))
        rendering = _draw(setup, flanks, member, out, tooth)
        files += [rendering.path, rendering.path.with_suffix(".vtu")]
        lines += [f"{member}: {rendering.title}", *([rendering.notice] if rendering.notice else [])]
    progress("rendering", len(members), len(members))
    if setup.pair.contact_ratio >= 2.0:
        lines.append("the whole load is on one tooth in these pictures, although no pair of these gears ever carries it alone")
    return Done([*dict.fromkeys(lines), *unseen(setup, SHAPES, lead=False)], files)


# ---- parts ------------------------------------------------------------------------------------------


def _curve(outline: Outline, method: FiniteElements | Castigliano | SolidCurve) -> tuple[ComplianceCurve, str]:
    """Return a compliance curve on the flank with its error, and what to say of it."""
    positions = method.positions() if isinstance(method, SolidCurve) else load_positions(outline)
    positions = positions[positions <= 3.0]
    curve = with_error(method, outline, method.curve(outline, positions))
    low, high = curve.deflection.min() / UM_PER_N_PER_MM, curve.deflection.max() / UM_PER_N_PER_MM
    left = positions.size - curve.u.size
    note = f"; {left} positions left out, whose load line crosses the centreline below the support" if left else ""
    assert curve.error is not None
    error = f" (error of the numbers at most {100.0 * curve.error.max():.1g} %)"
    radii = f"radii {1e3 * curve.radius.min():.2f} to {1e3 * curve.radius.max():.2f} mm"
    return curve, f"{curve.method}, {curve.support}, {radii}: {low:.5f} to {high:.5f} um per N/mm{error}{note}"


def _outline(flanks: Flanks, member: Member) -> Outline:
    return flanks.pinion if member == "pinion" else flanks.wheel


def _bodies(flanks: Flanks) -> tuple[tuple[Member, BodyCompliance], ...]:
    """Return the parts of the deflection of both gears at the load positions of the flank."""
    outlines = {member: _outline(flanks, member) for member in MEMBERS}
    positions = {member: load_positions(outline) for member, outline in outlines.items()}
    return tuple((member, body_compliance(outline, positions[member][positions[member] <= 3.0])) for member, outline in outlines.items())


def _body_line(member: Member, part: BodyCompliance) -> str:
    share, felt = (100.0 * values / part.whole for values in (part.wind_up, part.neighbours[:, 0]))
    return (
        f"{member}, body: wind-up about the bore is {share.min():.0f} to {share.max():.0f} % of the deflection, "
        f"the next tooth moves by {felt.min():.0f} to {felt.max():.0f} % of it"
    )


def _left_out_lines(results: Results) -> list[str]:
    return [
        f"{row['gear']}, {row['method']}, {row['support']}: {row['count']} positions left out, whose load line crosses the centreline "
        "below the support"
        for row in summarise(results)["compliance_rows_left_out"]
    ]


def _angles(pair: GearPair, steps: int) -> Array:
    return np.linspace(-1.0, 1.0, steps + 1) * pair.pinion.pitch_angle


def _draw(setup: Setup, flanks: Flanks, member: Member, out: Path, tooth: int | None = None) -> Rendering:
    """Draw one tooth under the whole normal force at the outer end of one-pair contact."""
    pair = setup.pair
    teeth = flanks.of(member).gear.teeth
    if tooth is not None and not 0 <= tooth < teeth:
        raise InputError("--tooth", tooth, f"0 to {teeth - 1}, the teeth of the {member}")
    outline = _outline(flanks, member) if tooth is None else flanks.odd(member).get(tooth, flanks.of(member))
    mate = _outline(flanks, "wheel" if member == "pinion" else "pinion")
    lowest = pair.centre_distance * math.sin(pair.working_pressure_angle) - mate.flank_end
    # One base pitch above the lowest point the next pair takes its share; a tooth without such a point is loaded at its tip.
    roll = min(lowest + pair.base_pitch, outline.flank_end)
    u = float(outline.parameter(roll))
    force = setup.operation.pinion_torque / pair.pinion.base_radius / pair.face_width
    field = FiniteElements().field(outline, u, force)
    path = out / f"tooth_{member}.png"
    write_vtu(field, path.with_suffix(".vtu"))
    return write_render(field, path, outline=outline)


def _numbers(results: Results) -> list[str]:
    """Return the main numbers of a result, one per line."""
    values: dict[str, Any] = summarise(results)
    lines = [f"{results.setup.name}: contact ratio {results.setup.pair.contact_ratio:.4f}"]
    if results.engagement is not None:
        stiffness = results.engagement.mesh_stiffness / results.setup.pair.face_width / N_PER_MM_UM
        lines.append(
            f"mesh stiffness at {results.engagement.pinion_torque:g} N m: mean {values['mesh_stiffness_mean_N_per_mm_um']:.3f}, "
            f"least {stiffness.min():.3f}, largest {stiffness.max():.3f} N/(mm um); "
            f"ISO 6336-1 method B {values['iso6336_c_gamma_alpha_N_per_mm_um']:.3f}"
        )
        ratio = f"{values['gear_ratio_min']:.5f} to {values['gear_ratio_max']:.5f}, mean {values['gear_ratio_mean']:.5f}"
        lines.append(f"gear ratio under this torque: {ratio}")
    factors = [f"{name} {values[key]:.3f}" for name in ("rigid", "elastic", "classical") if (key := f"dynamic_factor_{name}") in values]
    if factors:
        lines.append(f"largest dynamic factor: {', '.join(factors)}")
    return lines
