"""The commands beside the chain: meshes, wear, the virtual rig and the diagnosis."""

from __future__ import annotations

from pathlib import Path

import click

from gearfem.cli.commands import main
from gearfem.cli.group import folder
from gearfem.cli.listener import Bars
from gearfem.cli.options import GEARS, effects_option, kinds, load, model_argument, model_command, out_option, sets_option, support_option
from gearfem.foundation.errors import InputError


@main.command(short_help="Finite-element meshes for other programs.")
@model_argument
@effects_option
@click.option("--out", required=True, metavar="PATH", help="A folder, or one file: *.vtu, *.vtk, *.msh, *.inp, *.xdmf ...")
@sets_option
@click.option("--dim", type=int, default=2, show_default=True, help="2: the section of the tooth; 3: the tooth over its face width.")
@click.option("--gear", type=GEARS, default=None, help="One gear; by default both, of a single file the pinion.")
@support_option
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
    setup = load(model, overrides)
    steps.say(meshes.write(setup, targets, support, dim, resolution, tooth))


@main.command(short_help="Flanks worn over some hours of operation.")
@model_command
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
    setup = load(model, overrides)
    both = (coefficient, coefficient if wheel_coefficient is None else wheel_coefficient)
    with Bars() as progress:
        done = wearing.run_wear(setup, model, overrides, hours, both, rolling, target, progress)
    steps.say(done)


@main.command(short_help="A campaign measured on a virtual rig.")
@model_command
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
    setup = load(model, overrides)
    with Bars() as progress:
        done = measuring.run_plan(setup, model, overrides, plan, target, progress)
    steps.say(done)


@main.command(short_help="What each effect would change in planned records.")
@model_command
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
    setup = load(model, overrides)
    with Bars() as progress:
        done = measuring.run_templates(setup, plan, only, tooth, strength, kinds(), target, progress)
    steps.say(done)


@main.command(short_help="Where measurements and model disagree, and why.")
@click.argument("campaign", metavar="CAMPAIGN")
@out_option
@click.option("--only", multiple=True, metavar="NAME", help="Choose among these effects alone; may be repeated.")
@click.option("--exclude", multiple=True, metavar="NAME", help="Leave this effect out; may be repeated.")
@click.option("--effects", "effect_files", multiple=True, metavar="FILE.py", help="Python file with further effects; may be repeated.")
def diagnose(campaign: str, out: str, only: tuple[str, ...], exclude: tuple[str, ...], effect_files: tuple[str, ...]) -> None:
    """Find where the measurements of CAMPAIGN and its model disagree, name the missing effect, and show the gap shrink.

    CAMPAIGN is a file, or the folder that holds it as campaign.toml.

    Writes report.html with its pictures, diagnosis.json, maps.csv, and updated.toml: the model with the named effects and the fitted
    nuisances, which every other command runs. Records of role holdout are opened at the end, when everything else is fixed.

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
