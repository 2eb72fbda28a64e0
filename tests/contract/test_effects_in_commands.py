"""Every effect of a model acts in every command, or the command says in one line that it does not and which ones do."""

from __future__ import annotations

import functools
from pathlib import Path

import meshio
import numpy as np
import pytest
from click.testing import CliRunner

from gearfem import make_setup
from gearfem.cli import main, meshes, notices, sweeps
from gearfem.compliance.mesh_file import read_mesh
from gearfem.definition.setup import Setup
from gearfem.effects import Effect
from gearfem.effects.catalogue import catalogue
from gearfem.foundation import InputError, digest
from gearfem.foundation.progress import quiet
from gearfem.foundation.toml import to_toml
from gearfem.pipeline import run, with_effects
from gearfem.sensing import observe, requests

MODEL = {
    "name": "all commands",
    "pair": {"module_mm": 3.0, "face_width_mm": 15.0, "normal_backlash_mm": 0.06},
    "pinion": {"teeth": 18, "profile_shift": 0.2},
    "wheel": {"teeth": 27},
    "operation": {"pinion_torque_Nm": 90.0, "pinion_speed_rpm": 6000.0, "friction_coefficient": 0.03},
}
CHAIN = {"name": "motor", "side": "pinion", "inertia_kg_m2": 0.002, "shaft_stiffness_Nm_per_rad": 2e4, "shaft_damping_Nms_per_rad": 0.5}
KNOWN = catalogue()
TOOTH = 3
# What turns forward under load never touches its back flanks: no command shows a play that nothing takes up.
UNUSED = {"backlash"}


@functools.cache
def setup_with(name: str = "") -> Setup:
    """Return the pair with one effect of typical size on tooth 3 of the pinion."""
    bare = make_setup(MODEL)
    return make_setup({**MODEL, "effect": [KNOWN[name].example(bare, "pinion", TOOTH).table()]}) if name else bare


def stiffness(setup: Setup) -> list[np.ndarray]:
    """Return what `stiffness` and `kinematics` compute, over the angles at which tooth 3 carries."""
    angle = np.linspace(2.4, 3.6, 30) * setup.pair.pinion.pitch_angle
    engagement = run(setup, "engagement", angles=angle).engagement
    assert engagement is not None
    return [engagement.transmission_error, engagement.gear_ratio]


def speeds(setup: Setup) -> list[np.ndarray]:
    """Return what `dynamics --speeds` computes at one speed."""
    mesh, drive = sweeps._excitation(setup, quiet)
    (point,) = sweeps.sweep(mesh, drive, [600.0]).points
    return [np.array([point.dynamic_factor_max, point.error_mean, point.error_rms])]


def curves(setup: Setup) -> list[np.ndarray]:
    """Return what `compliance` computes of effects, over the shape of the teeth."""
    results = run(setup, "flank")
    shape = [outline.point(np.linspace(2.0, 3.0, 30)) for outline in (results.flanks.pinion, results.flanks.wheel)]
    return [*shape, *(curve.deflection for _, curve in with_effects(setup))]


def readings(setup: Setup) -> list[np.ndarray]:
    """Return what `measure` and `diagnose` compute."""
    system = run(setup, "compliance").system
    assert system is not None
    angle = np.linspace(0.0, 6.28, 60)
    asked = (
        requests()["static_transmission_error"](axis=angle, pinion_torque=90.0),
        requests()["dynamic_transmission_error"](axis=angle, pinion_torque=90.0, pinion_speed=700.0),
    )
    return [observe(system, request) for request in asked]


COMMANDS = {
    "stiffness, kinematics": (stiffness, notices.ENGAGED, True),
    "dynamics --speeds": (speeds, notices.MOVING, True),
    "compliance": (curves, notices.TEETH, False),
    "measure, diagnose": (readings, (*notices.MOVING, "sensing"), True),
}


@functools.cache
def plain(command: str) -> list[np.ndarray]:
    """Return what a command computes without effects."""
    return COMMANDS[command][0](setup_with())


def differ(one: list[np.ndarray], other: list[np.ndarray]) -> bool:
    """Return whether results differ by more than a millionth of their size."""
    if [part.shape for part in one] != [part.shape for part in other]:
        return True
    return any(np.abs(a - b).max() > 1e-6 * np.abs(b).max() for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("command", COMMANDS)
def test_no_effect_is_passed_over_in_silence(command: str, name: str) -> None:
    compute, stages, lead = COMMANDS[command]
    setup = setup_with(name)
    said = " ".join(notices.unseen(setup, stages, lead))
    shown = differ(compute(setup), plain(command))
    # Its own teeth carry a tooth's pit and crack; a lag of 0 s and the like are no typical values.
    assert shown != (name in said) or (name in UNUSED and not shown), said


@pytest.mark.parametrize("name", ["pitting", "root_crack"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_meshes_of_one_tooth_have_its_pit_and_its_crack(tmp_path: Path, name: str, dimension: int) -> None:
    files = {"pinion": tmp_path / "mesh.vtu"}
    resolution = 1.0 if dimension == 2 else 0.5
    ordinary = meshes.write(setup_with(name), files, "bore", dimension, resolution, None)
    assert any(f"teeth {TOOTH} differ" in line for line in ordinary.lines)
    before = read_mesh(files["pinion"], dimension)
    meshes.write(setup_with(name), files, "bore", dimension, resolution, TOOTH)
    after = read_mesh(files["pinion"], dimension)
    assert digest(before.points) != digest(after.points)
    # Nodes of the faces of a crack share their places, all others stand alone.
    double = len(after.points) - len(np.unique(np.round(after.points, 9), axis=0))
    assert (double > 3) == (name == "root_crack")


def test_a_crack_is_a_boundary_set_as_long_as_it_is_deep(tmp_path: Path) -> None:
    setup, file = setup_with("root_crack"), tmp_path / "crack.inp"
    depth = meshes.cracks(setup, "pinion")[TOOTH]
    meshes.write(setup, {"pinion": file}, "bore", 2, 1.0, TOOTH)
    text = file.read_text().lower()
    assert "nset=crack" in text.replace(" ", "")
    meshes.write(setup, {"pinion": tmp_path / "crack.vtu"}, "bore", 2, 1.0, TOOTH)
    mesh = meshio.read(tmp_path / "crack.vtu")
    faces = mesh.points[mesh.point_data["crack"] == 1]
    assert np.ptp(faces[:, 1]) == pytest.approx(1e3 * depth, rel=1e-6, abs=0.0)
    assert np.ptp(faces[:, 0]) < 1e-9


def test_a_crack_needs_its_sector(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="bore"):
        meshes.write(setup_with("root_crack"), {"pinion": tmp_path / "mesh.vtu"}, "root", 2, None, TOOTH)


EXAMPLES = ("tip_relief", "pitting", "root_crack", "pitch_error", "runout", "friction", "torque_ripple", "sensor_gain", "body_compliance")
CALLS = {
    "compliance": (),
    "dynamics": (),
    "dynamics --speeds": ("--speeds", "3000:4000:2"),
    "kinematics": ("--steps", "200"),
    "mesh": ("--tooth", "3", "--gear", "pinion"),
    "render": ("--tooth", "3", "--gear", "pinion"),
    "stiffness": ("--steps", "200"),
    "run": (),
}


QUICK = ("mesh", "dynamics --speeds")


@pytest.mark.parametrize("chained", [False, True], ids=["two inertias", "a shaft"])
@pytest.mark.parametrize("command", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in CALLS])
def test_commands_take_all_kinds_of_effects_together(tmp_path: Path, command: str, chained: bool) -> None:
    bare = make_setup(MODEL)
    tables: list[Effect] = [KNOWN[name].example(bare, "pinion", TOOTH) for name in EXAMPLES]
    drive = {"drive": {"inertia": [CHAIN]}} if chained else {}
    (tmp_path / "model.toml").write_text(to_toml({**MODEL, **drive, "effect": [effect.table() for effect in tables]}))
    words = [command.split()[0], str(tmp_path / "model.toml"), "--out", str(tmp_path / "out"), *CALLS[command]]
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 0, result.output
    assert "sensor_gain" in result.output
