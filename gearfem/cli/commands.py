"""The commands of the chain: arguments, help and order of steps; the work is in the stages and in the report."""

from __future__ import annotations

from pathlib import Path

import click

from gearfem.cli.group import Commands, folder
from gearfem.cli.listener import Bars
from gearfem.cli.options import GEARS, load, model_command, steps_option, support_option
from gearfem.foundation.errors import InputError


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
@model_command
def run(model: str, out: str, overrides: tuple[str, ...]) -> None:
    """Run the whole chain of MODEL; write all tables, summary.json, pictures and report.html.

    \b
    Units: those that end the names of columns and keys (mm, um, N, N/um, rad, s).
    Example:
      gearfem run model.toml --out results --set pair.face_width_mm=60
    """
    from gearfem.cli import steps

    target = folder(out)
    setup = load(model, overrides)
    with Bars() as progress:
        done = steps.everything(setup, target, progress)
    steps.say(done)


@main.command(short_help="Tooth compliance over the load radius.")
@model_command
@support_option
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
    setup = load(model, overrides)
    if mesh_file is not None:
        from gearfem.cli import meshes

        steps.say(meshes.compliance(setup, target, Path(mesh_file), "pinion" if gear == "pinion" else "wheel"))
        return
    with Bars() as progress:
        done = steps.compliance(setup, target, support, solid, progress)
    steps.say(done)


@main.command(short_help="Mesh stiffness and transmission error.")
@model_command
@steps_option
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
    setup = load(model, overrides)
    with Bars() as progress:
        done = work.stiffness(setup, target, steps, torques, progress)
    work.say(done)


@main.command(short_help="Gear ratios, contact points, velocities.")
@model_command
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
    setup = load(model, overrides)
    with Bars() as progress:
        done = work.kinematics(setup, target, steps, pitches, gif, progress)
    work.say(done)


@main.command(short_help="Motions and dynamic factors; sweeps over the speed.")
@model_command
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
    setup = load(model, overrides)
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
@model_command
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
    setup = load(model, overrides)
    with Bars() as progress:
        done = steps.render(setup, target, (gear,) if gear else ("pinion", "wheel"), progress, tooth)
    steps.say(done)
