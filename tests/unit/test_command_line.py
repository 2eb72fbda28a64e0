"""The command line: what it writes, and how it fails in one line without a traceback."""

from __future__ import annotations

import functools
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from gearfem.cli import steps as work
from gearfem.cli.listener import Bars
from gearfem.compliance import SolidElements
from tests.unit.shell import MODEL, assert_refused, call, rows

MESHES = Path(__file__).parents[2] / "meshes"
COMMANDS = ["run", "compliance", "stiffness", "kinematics", "dynamics", "render", "mesh"]


# ---- failing ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", COMMANDS)
def test_a_refused_model_ends_in_one_line_and_leaves_nothing(tmp_path, command):
    out = tmp_path / "out"
    assert_refused(call(command, MODEL, "--out", out, "--set", "material.poissons_ratio=0.5"), MODEL, "material.poissons_ratio", "0.5")
    assert not out.exists()


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("pair.helix_angle_deg=10", "helical gears are not supported"),
        ("wheel.teeth=-51", "internal gears are not supported"),
        ("pinion.bore_radius_mm=61", "root radius"),
        ("pair.face_width_mm=nan", "nan"),
        ("pinion.profile_shift=-0.5", "contact ratio"),
        ("pair.fase_width_mm=60", "face_width_mm"),
        ("effect=[{name='tip_releif'}]", "tip_relief (the nearest valid name)"),
        ("nonsense", "key=value"),
    ],
)
def test_overrides_are_checked_as_the_file_is(tmp_path, override, words):
    assert_refused(call("run", MODEL, "--out", tmp_path, "--set", override), words)


def test_a_missing_model_and_a_broken_one_are_one_line(tmp_path):
    assert_refused(call("run", tmp_path / "none.toml", "--out", tmp_path), "none.toml", "no such file")
    broken = tmp_path / "broken.toml"
    broken.write_text("[pair\n")
    assert_refused(call("run", broken, "--out", tmp_path), "broken.toml", "line 1", "TOML")


@pytest.mark.parametrize("command", COMMANDS)
def test_an_out_that_cannot_be_a_folder_is_refused(tmp_path, command):
    taken = tmp_path / "taken"
    taken.write_text("mine")
    assert_refused(call(command, MODEL, "--out", taken), "--out", "taken")
    assert_refused(call(command, MODEL, "--out", taken / "below"), "--out", "taken")
    assert taken.read_text() == "mine"


def test_options_out_of_range_are_refused(tmp_path):
    assert_refused(call("stiffness", MODEL, "--out", tmp_path, "--steps", 199), "--steps", "199", "an integer from 200 to 100000")
    assert_refused(call("compliance", MODEL, "--out", tmp_path, "--support", "hub"), "--support", "'hub'", "bore or root or root_chord")
    assert_refused(call("stiffness", MODEL, "--out", tmp_path, "--torque", "nan"), "--torque", "above 0")
    assert_refused(call("stiffness", MODEL, "--out", tmp_path, "--torque", "-5"), "--torque", "above 0")
    assert_refused(call("mesh", MODEL, "--out", tmp_path, "--dim", 1), "--dim", "2, the section")
    assert_refused(call("mesh", MODEL, "--out", tmp_path / "a.ply", "--dim", 3), "--out", ".vtu")
    assert_refused(call("mesh", MODEL, "--out", tmp_path, "--dim", 3, "--resolution", 0.4), "resolution")
    assert_refused(call("mesh", MODEL, "--out", tmp_path / "a.stl"), "--out", ".vtu")
    assert_refused(call("mesh", MODEL, "--out", tmp_path, "--resolution", 0.5), "resolution")
    assert_refused(call("mesh", MODEL, "--out", tmp_path, "--resolution", "1e4"), "--resolution", "10000.0", "from 0.5 to 20")


@pytest.mark.parametrize(
    ("given", "found"),
    [
        (["run", MODEL], ["--out: found nothing", "DIR"]),
        (["run"], ["MODEL: found nothing"]),
        (["run", MODEL, "--out"], ["--out: found nothing behind it", "a value"]),
        (["stiffness", MODEL, "--out", "x", "--steps", "many"], ["--steps: found 'many'", "an integer from 200 to 100000"]),
        (["stiffness", MODEL, "--out", "x", "--torque", "much"], ["--torque: found 'much'", "a number"]),
        (["run", MODEL, "--out", "x", "--outer", "1"], ["--outer", "--out"]),
        (["run", MODEL, "again", "--out", "x"], ["(again)"]),
        (["walk"], ["'walk'", "stiffness"]),
        (["--loud"], ["--loud", "--version"]),
    ],
)
def test_wrong_words_are_one_line_with_option_found_and_allowed(given, found):
    assert_refused(call(*given), *found, "; allowed: ")


def test_a_name_that_no_file_can_have_is_refused(tmp_path):
    assert_refused(call("run", MODEL, "--out", tmp_path / ("x" * 300)), "file name too long")


def test_no_words_at_all_show_the_help():
    assert "Commands:" in call().output


@pytest.mark.parametrize("command", COMMANDS)
def test_an_out_without_a_name_or_that_cannot_be_made_is_refused(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    assert_refused(call(command, MODEL, "--out", ""), "--out")
    # A file system that takes no folders from anyone, whatever its permissions say.
    if Path("/proc/self").exists():
        assert_refused(call(command, MODEL, "--out", "/proc/gearfem"), "--out", "/proc/gearfem")
    assert not list(tmp_path.iterdir())


def test_a_folder_in_the_place_of_a_file_is_named_itself(tmp_path):
    (tmp_path / "kinematics.csv").mkdir()
    result = call("kinematics", MODEL, "--out", tmp_path, "--steps", 200)
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr == f"error: {tmp_path / 'kinematics.csv'}: is a directory\n"


# ---- helping ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_explains_itself_with_units_and_an_example(command):
    text = call(command, "-h").output
    assert "Units:" in text
    assert f"gearfem {command} " in text
    assert call(command, "--help").output == text


def test_version_and_module_form():
    from gearfem import __version__

    assert call("--version").output.strip().endswith(__version__)
    done = subprocess.run([sys.executable, "-m", "gearfem", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"gearfem {__version__}\n"


def test_help_costs_no_validation_and_no_numerics():
    code = "import sys\nfrom gearfem.cli import main\ntry: main(['run', '-h'])\nfinally: print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"pydantic", "scipy", "skfem", "matplotlib", "pyvista", "rich", "jinja2", "meshio"} & set(done.stderr.split())


def test_a_bar_appears_only_for_a_step_that_lasts(monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with Bars(patience=0.02) as bars:
        bars("short", 0, 1)
        bars("short", 1, 1)
        time.sleep(0.1)
        assert bars._bar is None
        bars("long", 0, 2)
        limit = time.monotonic() + 10.0
        while bars._bar is None and time.monotonic() < limit:
            time.sleep(0.01)
        assert bars._bar is not None
        bars("long", 2, 2)
        assert bars._bar is None


# ---- writing ----------------------------------------------------------------------------------------


def test_stiffness_of_two_torques_and_an_overridden_width(tmp_path):
    result = call(
        "stiffness", MODEL, "--out", tmp_path, "--steps", 200, "--torque", 800, "--torque", 1605, "--set", "pair.face_width_mm=60"
    )
    assert result.exit_code == 0, result.output
    table = rows(tmp_path / "mesh_stiffness.csv")
    assert [float(row["pinion_torque_Nm"]) for row in table] == [800.0] * 201 + [1605.0] * 201
    angles = [float(row["pinion_angle_rad"]) for row in table[:201]]
    # Ten digits are written.
    assert angles == pytest.approx(np.linspace(-2 * np.pi / 16, 2 * np.pi / 16, 201), abs=1e-9)
    shares = [float(row[name]) for name in row_names(table, "load_share") for row in [table[100]]]
    assert sum(shares) == pytest.approx(1.0, abs=1e-9)
    assert "N/(mm um)" in result.stdout
    assert f"wrote {tmp_path / 'mesh_stiffness.csv'}" in result.stdout


def row_names(table: list[dict[str, str]], start: str) -> list[str]:
    """Return the columns whose names begin with `start`."""
    return [name for name in table[0] if name.startswith(start)]


def test_kinematics_writes_its_table(tmp_path):
    result = call("kinematics", MODEL, "--out", tmp_path / "new" / "folder", "--steps", 200)
    assert result.exit_code == 0, result.output
    table = rows(tmp_path / "new" / "folder" / "kinematics.csv")
    assert len({row["pinion_angle_rad"] for row in table}) == 201


@pytest.mark.parametrize("support", ["bore", "root", pytest.param("root_chord", marks=pytest.mark.slow)])
def test_compliance_holds_what_it_is_told(tmp_path, support):
    result = call("compliance", MODEL, "--out", tmp_path, "--support", support)
    assert result.exit_code == 0, result.output
    table = rows(tmp_path / "compliance.csv")
    found = {(row["gear"], row["method"], row["support"]) for row in table}
    methods = ["fe_plane_strain", "fe_plane_stress"] + ([] if support == "bore" else ["fe_3d"])
    wanted = {(gear, method, support) for gear in ("pinion", "wheel") for method in methods}
    assert found == wanted | {("pinion", "castigliano", "root"), ("wheel", "castigliano", "root")}
    assert ("--solid" in result.stdout) == (support == "bore")
    assert all(float(row["error_estimate"]) > 0.0 for row in table)
    # Coarse and quick, but a mesh that is worth reading: no method's arithmetic costs a hundredth.
    assert max(float(row["error_estimate"]) for row in table) < 0.01


def test_solid_teeth_lie_between_the_plane_states(tmp_path):
    assert call("compliance", MODEL, "--out", tmp_path, "--support", "root").exit_code == 0
    for gear in ("pinion", "wheel"):
        curves = {}
        for method in ("fe_plane_strain", "fe_plane_stress", "fe_3d"):
            own = [row for row in rows(tmp_path / "compliance.csv") if (row["gear"], row["method"]) == (gear, method)]
            curves[method] = np.array([[float(row[key]) for key in ("radius_mm", "deflection_um_per_N_per_mm")] for row in own]).T
        radius, solid = curves["fe_3d"]
        strain, stress = (np.interp(radius, *curves[method]) for method in ("fe_plane_strain", "fe_plane_stress"))
        assert 8 <= len(radius) <= 10
        # The width of nine modules: nearer to plane strain, over the upper half of the flank, where shear near the clamp fades.
        upper = slice(len(radius) // 2, None)
        assert (strain < solid)[upper].all()
        assert (solid < stress)[upper].all()


def test_solids_and_meshes_from_outside_exclude_each_other(tmp_path):
    mesh = MESHES / "coal_combine_pinion_2d.vtu"
    assert_refused(call("compliance", MODEL, "--out", tmp_path, "--solid", "--mesh", mesh, "--gear", "pinion"), "--solid", "--mesh")


@pytest.mark.slow
def test_whole_gears_as_solids_are_computed_when_asked_for(tmp_path, monkeypatch):
    # Coarse ones: those of full resolution take minutes.
    monkeypatch.setattr(work, "SolidElements", functools.partial(SolidElements, resolution=0.75, layers=4))
    result = call("compliance", MODEL, "--out", tmp_path, "--solid")
    assert result.exit_code == 0, result.output
    assert "left out: the whole" not in result.stdout
    table = [row for row in rows(tmp_path / "compliance.csv") if row["method"] == "fe_3d"]
    assert {(row["gear"], row["support"]) for row in table} == {("pinion", "bore"), ("wheel", "bore")}


def test_a_refusal_found_while_computing_names_the_model(tmp_path):
    result = call("stiffness", MODEL, "--out", tmp_path / "out", "--set", "operation.pinion_torque_Nm=1e8")
    assert result.exit_code == 2
    assert result.output.startswith(f"error: {MODEL} with overrides: operation.pinion_torque_Nm: found 1e+08 N m")
    assert result.output.count("\n") == 1
    assert not (tmp_path / "out").exists()
