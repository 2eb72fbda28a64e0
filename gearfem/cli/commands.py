"""The commands: arguments, help and order of steps; the work is in the stages and in the report."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from gearfem.cli.group import Commands, folder
from gearfem.cli.listener import Bars
from gearfem.foundation.errors import InputError

if TYPE_CHECKING:
    from gearfem.definition.setup import Setup
    from gearfem.effects import Effect

Command = TypeVar("Command", bound=Callable[..., None])
GEARS = click.Choice(["pinion", "wheel"])
SUPPORTS = click.Choice(["bore", "root", "root_chord"])

_model = click.argument("model", metavar="MODEL")
_out = click.option("--out", required=True, metavar="DIR", help="Folder for the files; made if missing.")
_sets = click.option(
    "--set", "overrides", multiple=True, metavar="KEY=VALUE", help="Replace a key of the model, as in TOML; may be repeated."
)
_steps = click.option(
    "--steps", type=click.IntRange(200, 100_000), default=400, show_default=True, help="Steps of the pinion angle from -1 to +1 pitch."
)
_support = click.option(
    "--support",
    type=SUPPORTS,
    default="bore",
    show_default=True,
    help="What is held: the whole gear at its bore, or the tooth at its root circle or on the chord of it.",
)


def _keep_effects(context: click.Context, option: click.Parameter, files: tuple[str, ...]) -> None:
    """Keep the files of effects for the reading of the model."""
    context.meta["gearfem.effects"] = files


_effects = click.option(
    "--effects",
    multiple=True,
    metavar="FILE",
    expose_value=False,
    callback=_keep_effects,
    help="A Python file with effects of your own, which the model may name in [[effect]]; it is run. May be repeated.",
)


def _model_command(command: Command) -> Command:
    return _model(_out(_sets(_effects(command))))


def _load(model: str, overrides: tuple[str, ...]) -> Setup:
    from gearfem.model import load_model

    # A refusal that only computing can find names the model too: the group adds it.
    click.get_current_context().find_root().obj = f"{model} with overrides" if overrides else model
    return load_model(model, overrides, effects=_kinds())


def _kinds() -> list[type[Effect]]:
    """Return the effects of the files that the command names."""
    files = click.get_current_context().meta.get("gearfem.effects", ())
    if not files:
        return []
    from gearfem.effects.catalogue import effects_from

    return [kind for file in files for kind in effects_from(file)]


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="gearfem", message="%(prog)s %(version)s")
def main() -> None:
    """Compute stiffness and dynamics of spur gear pairs from model files (TOML).

    Names of keys and columns end in their unit. Status 0: done; 1: a solve failed; 2: bad input, said in one line.

    \b
    Example:
      gearfem run studies/coal_combine/model.toml --out results
    """


@main.command(short_help="Run the whole chain; write every file and report.html.")
@_model_command
def run(model: str, out: str, overrides: tuple[str, ...]) -> None:
    """Run the whole chain of MODEL; write all tables, summary.json, pictures and report.html.

    \b
    Units: those that end the names of columns and keys (mm, um, N, N/um, rad, s).
    Example:
      gearfem run model.toml --out results --set pair.face_width_mm=60
    """
    from gearfem.cli import steps

    target = folder(out)
    setup = _load(model, overrides)
    with Bars() as progress:
        done = steps.everything(setup, target, progress)
    steps.say(done)


@main.command(short_help="Tooth compliance over the load radius.")
@_model_command
@_support
@click.option("--mesh", "mesh_file", default=None, metavar="FILE", help="Take the mesh of one gear from this file; see below.")
@click.option("--gear", type=GEARS, default=None, help="With --mesh: the gear that it is a mesh of.")
@click.option("--solid", is_flag=True, help="Three-dimensional elements at full resolution, the whole gear too (minutes).")
def compliance(
    model: str, out: str, overrides: tuple[str, ...], support: str, mesh_file: str | None, gear: str | None, solid: bool
) -> None:
    """Write compliance.csv, the deflection of one tooth of each gear over the radius of the load, and body.csv.

    body.csv takes the deflection apart: tooth, body, wind-up about the bore, and what the next teeth feel. Where effects change
    the compliance of a model: rows `... with effects` of teeth like most, and `... tooth N` of each that differs.

    A mesh from outside (any plane format of meshio, in mm, triangles or quadrilaterals of first or second order, the gear's
    centre at the origin and a tooth along +x) needs the boundary sets `flank`, and `bore` or `root` for what is held: node
    sets, physical groups, or point data that is not 0 on their nodes.

    \b
    Units: um per N/mm of line load, radius in mm.
    Methods: finite elements in plane strain and plane stress; Castigliano's trapezoid, always held at its root; solid elements,
    averaged over the face width under a uniform load: quick ones with --support root or root_chord, else with --solid.
    Example:
      gearfem compliance model.toml --out results --support root
      gearfem compliance model.toml --out results --mesh tooth.msh --gear pinion
    """
    from gearfem.cli import steps

    target = folder(out)
    if (mesh_file is None) != (gear is None):
        raise InputError("--mesh, --gear", "one without the other", "a mesh file together with the gear that it is a mesh of")
    if solid and mesh_file is not None:
        raise InputError("--solid", "together with --mesh", "one of them: a mesh from outside is plane")
    setup = _load(model, overrides)
    if mesh_file is not None:
        from gearfem.cli import meshes

        steps.say(meshes.compliance(setup, target, Path(mesh_file), "pinion" if gear == "pinion" else "wheel"))
        return
    with Bars() as progress:
        done = steps.compliance(setup, target, support, solid, progress)
    steps.say(done)


@main.command(short_help="Mesh stiffness and transmission error.")
@_model_command
@_steps
@click.option("--torque", "torques", type=float, multiple=True, metavar="NM", help="Torque on the pinion in N m; may be repeated.")
def stiffness(model: str, out: str, overrides: tuple[str, ...], steps: int, torques: tuple[float, ...]) -> None:
    """Write mesh_stiffness.csv: stiffness, transmission error, load shares and contact pressures over the pinion angle.

    With mesh_stiffness.png, stiffness of each torque with the zones of one, two and more pairs, and approach and recess of each
    pair at the first torque; and transmission_error_carpet.png, the transmission error over the angle from no torque to half
    as much again as the largest.

    Where the flanks of the model are not parallel over the face width: the face load factor K_Hbeta too, and
    load_over_width.png at the first torque. Solid elements of both gears then take some seconds.

    Where teeth differ: hunting.csv and hunting.png too, over all tooth combinations at the first torque.

    \b
    Units: N/um over the whole face width, um along the line of action, MPa, rad, N m.
    Example:
      gearfem stiffness model.toml --out results --torque 400 --torque 1605
    """
    from gearfem.cli import steps as work

    target = folder(out)
    setup = _load(model, overrides)
    with Bars() as progress:
        done = work.stiffness(setup, target, steps, torques, progress)
    work.say(done)


@main.command(short_help="Gear ratios, contact points, velocities.")
@_model_command
@click.option("--steps", type=click.IntRange(200, 100_000), default=400, show_default=True, help="Steps of the pinion angle.")
@click.option("--pitches", type=float, nargs=2, default=(-1.0, 1.0), show_default=True, help="First and last pinion angle, in pitches.")
@click.option("--gif", is_flag=True, help="engagement.gif too: the two gears over one pitch, with their contact points.")
def kinematics(model: str, out: str, overrides: tuple[str, ...], steps: int, pitches: tuple[float, float], gif: bool) -> None:
    """Write kinematics.csv: gear ratios, contact points and velocities of each pair in contact, worn teeth and odd ones too.

    With flank_outlines.png, flanks with what is missing from them enlarged; line_of_action.png, the way of the contact points, straight
    or not, and where one or two pairs carry; gear_ratios.png, the four ratios; and, of pair 0, rolling.png, specific_sliding.png and
    contact_pressure.png.

    \b
    Units: mm, deg, m/s at the model's speed, MPa, N, rad.
    Example:
      gearfem kinematics model.toml --out results --steps 1000 --gif
    """
    from gearfem.cli import steps as work

    target = folder(out)
    setup = _load(model, overrides)
    with Bars() as progress:
        done = work.kinematics(setup, target, steps, pitches, gif, progress)
    work.say(done)


@main.command(short_help="Motions and dynamic factors; sweeps over the speed.")
@_model_command
@click.option("--speeds", default=None, metavar="A:B:N", help="Sweep over N pinion speeds from A to B rpm, instead of the model's one.")
@click.option(
    "--both-ways", is_flag=True, help="Sweep up and down, each speed from the motion before it, so that jumps show both branches."
)
@click.option(
    "--workers", type=click.IntRange(1, 1024), default=None, help="Processes of a sweep; by default as many as pay, one per core at most."
)
@click.option("--resume", is_flag=True, help="Go on with the interrupted sweep in DIR; without it, a new one.")
def dynamics(
    model: str, out: str, overrides: tuple[str, ...], speeds: str | None, both_ways: bool, workers: int | None, resume: bool
) -> None:
    """Write rigid.csv, elastic.csv and classical.csv: steady motion and dynamic factor of three models at the model's speed.

    With time_series.png and spectrum.png of the elastic one. Where teeth differ or torques ripple, over the pitches after which
    the same teeth meet again. With --speeds instead: sweep.csv, sweep_spectrum.csv, sweep.png and
    waterfall.png of the elastic model over the speed.

    Columns of sweep.csv: speed, direction (rest, up or down), mesh and natural frequency and their ratio (tuning), largest and
    least dynamic factor, largest and mean normal force, mean and rms of the dynamic transmission error, parts of the time
    without contact on the working flank and in contact on the back flank, mesh cycles after which the motion repeats (0: it
    does not, the row holds statistics of 96 cycles; where teeth differ, those after which the same ones meet again), growth of
    neighbouring motions per cycle (the largest Floquet multiplier; above 1: chaotic), wheel torque in balance, steps per
    cycle, amplitude and phase of six mesh harmonics of the transmission error. sweep_spectrum.csv: its lines in orders of the
    pinion's turns.

    Ctrl-C leaves the finished speeds in sweep.csv, from where --resume goes on. The first sweep after installing compiles for
    some ten seconds.

    \b
    Units: s, rad, rad/s, rad/s2, N, um, rpm, Hz, N m.
    Example:
      gearfem dynamics model.toml --out results --set operation.pinion_speed_rpm=900
      gearfem dynamics model.toml --out results --speeds 500:3000:200 --both-ways
    """
    target = folder(out)
    if speeds is None and (both_ways or resume or workers is not None):
        raise InputError("--both-ways, --workers, --resume", "no --speeds", "these with --speeds A:B:N alone")
    setup = _load(model, overrides)
    from gearfem.cli import steps

    with Bars() as progress:
        if speeds is None:
            done = steps.dynamics(setup, target, progress)
        else:
            from gearfem.cli import sweeps

            wanted = sweeps.read_speeds(speeds)
            done = sweeps.run_sweep(setup, target, wanted, both_ways, workers, resume, progress)
    steps.say(done)


@main.command(short_help="Pictures of the loaded, deformed teeth.")
@_model_command
@click.option("--gear", type=GEARS, default=None, help="One gear; by default both.")
@click.option("--tooth", type=int, default=None, metavar="N", help="With --gear: tooth N, with its own flank; by default one like most.")
def render(model: str, out: str, overrides: tuple[str, ...], gear: str | None, tooth: int | None) -> None:
    """Draw the loaded, deformed tooth of each gear: tooth_*.png, and tooth_*.vtu for ParaView.

    The tooth carries the whole torque at the end of one-pair contact, or, where two pairs always carry, one base pitch above
    its lowest contact.

    \b
    Units: mm, MPa; the displacement is enlarged as the picture says.
    Example:
      gearfem render model.toml --out results --gear pinion
    """
    from gearfem.cli import steps

    target = folder(out)
    if tooth is not None and gear is None:
        raise InputError("--tooth", "no --gear", "a tooth together with its gear, --gear pinion or --gear wheel")
    setup = _load(model, overrides)
    with Bars() as progress:
        done = steps.render(setup, target, (gear,) if gear else ("pinion", "wheel"), progress, tooth)
    steps.say(done)


@main.command(short_help="Finite-element meshes for other programs.")
@_model
@_effects
@click.option("--out", required=True, metavar="PATH", help="A folder, or one file: *.vtu, *.vtk, *.msh, *.inp, *.xdmf ...")
@_sets
@click.option("--dim", type=int, default=2, show_default=True, help="2: the section of the tooth; 3: the tooth over its face width.")
@click.option("--gear", type=GEARS, default=None, help="One gear; by default both, of a single file the pinion.")
@_support
@click.option(
    "--resolution",
    type=click.FloatRange(0.5, 20.0),
    default=None,
    help="Elements along each side against half-module ones, up to 20; by default 3, of solids 1.5.",
)
@click.option("--tooth", type=int, default=None, metavar="N", help="Tooth N, with its own flank and its crack; by default one like most.")
def mesh(
    model: str, out: str, overrides: tuple[str, ...], dim: int, gear: str | None, support: str, resolution: float | None, tooth: int | None
) -> None:
    """Write the finite-element mesh of one tooth with its sector of the gear, mesh_*.vtu.

    A root crack is a seam whose two faces share places but no nodes; of sections they are the boundary set `crack`.

    \b
    Units: mm. Boundary sets `bore` (or `root`) and `flank`: physical groups in *.msh, node sets in *.inp, and in *.vtu,
    *.vtk and *.xdmf point data that is 1 on their nodes.
    Solids: hexahedra of 27 nodes in *.vtu, *.vtk, *.msh and *.mdpa, their corners as hexahedra of 8 elsewhere; in 12 layers.
    Example:
      gearfem mesh model.toml --dim 2 --gear wheel --out wheel.vtu
      gearfem mesh model.toml --dim 3 --gear pinion --support root --out tooth.msh
    """
    from gearfem.cli import meshes, steps

    if not out.strip():
        folder(out)
    if tooth is not None and gear is None:
        raise InputError("--tooth", "no --gear", "a tooth together with its gear, --gear pinion or --gear wheel")
    targets = meshes.targets(out, gear, dim)
    for path in targets.values():
        folder(str(Path(path).parent))
    setup = _load(model, overrides)
    steps.say(meshes.write(setup, targets, support, dim, resolution, tooth))


@main.command(short_help="Flanks worn over some hours of operation.")
@_model_command
@click.option("--hours", type=float, required=True, metavar="H", help="Time at the model's speed and torque, in hours.")
@click.option("--coefficient", type=float, required=True, metavar="K", help="k of Archard's law in 1/Pa, of both gears.")
@click.option("--wheel-coefficient", type=float, default=None, metavar="K", help="k of the wheel, where it differs.")
@click.option("--rolling", type=float, default=0.0, show_default=True, metavar="R", help="Part of rolling that wears as sliding (dirt).")
def wear(
    model: str, out: str, overrides: tuple[str, ...], hours: float, coefficient: float, wheel_coefficient: float | None, rolling: float
) -> None:
    """Wear the flanks of MODEL by Archard's law, contacts and load sharing following: worn.toml, which every command runs.

    With worn_pinion.csv and worn_wheel.csv, the flanks that it names; wear.csv, depths, volumes, transmission error and pressure
    over the life; wear_depth.png and wear_life.png. Nothing is written before the end of the life.

    Archard: depth = k p v_s t, p the pressure and v_s the sliding of each contact; per passage k w |v_s|/v_r, w the load per
    width and v_r the rolling velocity. k of lubricated steel lies about 1e-18 to 1e-16 per Pa (m2/N; 1e-18 is 1e-9 mm3/(N m)).
    Dirt that is rolled over wears the pitch point too: --rolling adds that part of the way rolled to the sliding.

    \b
    Units: h, 1/Pa, um, mm3, MPa.
    Example:
      gearfem wear model.toml --hours 3000 --coefficient 2e-17 --out worn
      gearfem run worn/worn.toml --out results
    """
    from gearfem.cli import steps, wearing

    target = folder(out)
    setup = _load(model, overrides)
    both = (coefficient, coefficient if wheel_coefficient is None else wheel_coefficient)
    with Bars() as progress:
        done = wearing.run_wear(setup, model, overrides, hours, both, rolling, target, progress)
    steps.say(done)


@main.command(short_help="A campaign measured on a virtual rig.")
@_model_command
@click.option("--plan", required=True, metavar="FILE", help="What is measured, by which instruments, under which seed; see below.")
def measure(model: str, out: str, overrides: tuple[str, ...], plan: str) -> None:
    """Measure MODEL, with all its effects, on a virtual rig: campaign.toml and its records, for planning tests and for teaching.

    With nominal.toml, the model without its effects, calibration and measured flanks, and truth.json, what the rig knows. It measures
    what this program computes: a diagnosis that succeeds on it has yet to succeed on a real pair.

    A plan holds name, seed, angle_zero ("unknown" or "pitch_point"), [scatter] (index_error_um, torque_scale), [instrument] and any
    number of [[record]]. An instrument has noise_std, coloured_noise_std with coloured_noise_samples, resolution,
    drift_per_turn, constant, gain, delay_s, resonance_Hz and resonance_ratio; a record may give each of them for itself, beside
    file, quantity, pinion_torque_Nm, pinion_speed_rpm (or pinion_speeds_rpm), gear, tooth, tooth_zero, role, turns, samples_per_turn
    and points.

    \b
    Units: those that end the names of keys; of an instrument those of the measured column.
    Example:
      gearfem measure model.toml --plan plan.toml --out campaign
    \b
    plan.toml:
      name = "rig 7, planned"
      seed = 7
      [scatter]
      index_error_um = 0.7
      [instrument]
      noise_std = 0.3
      resolution = 0.05
      [[record]]
      file = "te_150Nm.csv"
      quantity = "static_transmission_error"
      pinion_torque_Nm = 150.0
      turns = 3.0
      samples_per_turn = 720
    """
    from gearfem.cli import measuring, steps

    target = folder(out)
    setup = _load(model, overrides)
    with Bars() as progress:
        done = measuring.run_plan(setup, model, overrides, plan, target, progress)
    steps.say(done)


@main.command(short_help="What each effect would change in planned records.")
@_model_command
@click.option("--plan", required=True, metavar="FILE", help="The records, as for gearfem measure; its instruments are not used.")
@click.option("--only", multiple=True, metavar="NAME", help="These effects alone; may be repeated.")
@click.option("--tooth", type=int, default=0, show_default=True, metavar="N", help="Tooth of effects of one tooth.")
@click.option(
    "--strength", type=float, default=1.0, show_default=True, metavar="S", help="Part of the typical size over which responses are taken."
)
def templates(model: str, out: str, overrides: tuple[str, ...], plan: str, only: tuple[str, ...], tooth: int, strength: float) -> None:
    """Write the response of each record of a plan to each parameter of each effect, per unit: templates_*.csv.

    One column per parameter, beside axis and value without the effect: change of the value per unit of the parameter, each alone
    and counted from where it does nothing. Effects of MODEL belong to the value. For judging what a record can show, and for scans.

    \b
    Units: of each value those of its column, per unit that ends the name of the parameter.
    Example:
      gearfem templates model.toml --plan plan.toml --only runout --only tip_relief --out responses
    """
    from gearfem.cli import measuring, steps

    target = folder(out)
    setup = _load(model, overrides)
    with Bars() as progress:
        done = measuring.run_templates(setup, plan, only, tooth, strength, _kinds(), target, progress)
    steps.say(done)


@main.command(short_help="Where measurements and model disagree, and why.")
@click.argument("campaign", metavar="CAMPAIGN")
@_out
@click.option("--only", multiple=True, metavar="NAME", help="Choose among these effects alone; may be repeated.")
@click.option("--exclude", multiple=True, metavar="NAME", help="Leave this effect out; may be repeated.")
@click.option("--effects", "effect_files", multiple=True, metavar="FILE.py", help="Python file with further effects; may be repeated.")
def diagnose(campaign: str, out: str, only: tuple[str, ...], exclude: tuple[str, ...], effect_files: tuple[str, ...]) -> None:
    """Find where the measurements of CAMPAIGN and its model disagree, name the missing effect, and show the gap shrink.

    Writes report.html with its pictures, diagnosis.json, and updated.toml: the model with the named effects and the fitted nuisances,
    which every other command runs. Records of role holdout are opened at the end, when everything else is fixed.

    Verdicts: explained, partly_explained, no_discrepancy, unexplained (a gap that no known effect closes), ambiguous (several
    explanations, and what to measure to decide). Ctrl-C leaves no half-written file.

    \b
    Units: those that end the names of keys; gaps in the unit of the measured column.
    Example:
      gearfem diagnose rig7/campaign.toml --out results
      gearfem diagnose rig7/campaign.toml --out again --exclude profile_wear
      gearfem run results/updated.toml --out updated
    """
    target = folder(out)
    from gearfem.cli import diagnoses, steps

    with Bars() as progress:
        done = diagnoses.run_diagnosis(campaign, target, only, exclude, effect_files, progress)
    steps.say(done)
