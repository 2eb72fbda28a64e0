"""The sweep of `gearfem dynamics`: its files, what is refused, and going on after an interrupt."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result

from gearfem.cli import sweeps
from gearfem.foundation import InputError
from gearfem.foundation.units import RPM
from gearfem.model import load_model
from tests.unit import shell
from tests.unit.shell import MODEL, obey_interrupts, rows

SPEEDS = "400:800:5"


def call(out: Path, *words: object) -> Result:
    """Run the sweep in this process."""
    return shell.call("dynamics", MODEL, "--out", out, *words)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Folder of a whole sweep up and down, and what the command said."""
    out = tmp_path_factory.mktemp("sweep")
    result = call(out, "--speeds", SPEEDS, "--both-ways", "--workers", 1)
    assert result.exit_code == 0, result.output
    return out, result.stdout


def test_one_row_for_each_speed_and_direction(swept):
    out, said = swept
    table = rows(out / "sweep.csv")
    assert [row["direction"] for row in table] == ["up"] * 5 + ["down"] * 5
    assert [float(row["pinion_speed_rpm"]) for row in table] == pytest.approx([400.0, 500.0, 600.0, 700.0, 800.0] * 2)
    assert "largest dynamic factor" in said
    assert sorted(os.listdir(out)) == ["sweep.csv", "sweep.png", "sweep_spectrum.csv", "waterfall.png"]


def test_columns_hold_what_they_say(swept):
    """Units by identities: mesh frequency of 16 teeth, Kw of the mean load, rms of the harmonics, loads of 1605 N m."""
    for row in rows(swept[0] / "sweep.csv"):
        value = {name: float(text) for name, text in row.items() if name != "direction"}
        # Ten digits are written.
        assert value["mesh_frequency_Hz"] == pytest.approx(value["pinion_speed_rpm"] / 60.0 * 16)
        assert value["tuning"] == pytest.approx(value["mesh_frequency_Hz"] / value["natural_frequency_Hz"])
        assert value["dynamic_factor_min"] < 1.0 < value["dynamic_factor"] < 2.0
        harmonics = np.array([value[f"te_harmonic_{number}_um"] for number in range(1, 7)])
        # What is above the sixth harmonic is a few per cent of the whole.
        assert value["transmission_error_rms_um"] == pytest.approx(np.sqrt(0.5 * (harmonics**2).sum()), rel=0.03, abs=0.0)
        assert 20.0 < value["transmission_error_mean_um"] < 25.0
        assert value["mesh_force_max_N"] > value["mesh_force_mean_N"] == pytest.approx(1605.0 / 60.14e-3, rel=0.03, abs=0.0)
        assert value["wheel_torque_Nm"] == pytest.approx(1605.0 * 51 / 16 * 0.986, rel=0.002, abs=0.0)
        assert (value["contact_loss"], value["back_contact"], value["period_cycles"]) == (0.0, 0.0, 1.0)
        assert all(abs(value[f"te_harmonic_{number}_phase_rad"]) <= np.pi for number in range(1, 7))


def test_spectrum_holds_the_harmonics_in_orders(swept):
    lines = rows(swept[0] / "sweep_spectrum.csv")
    first = rows(swept[0] / "sweep.csv")[0]
    found = {float(row["order"]): float(row["transmission_error_um"]) for row in lines[:6]}
    assert found == {16.0 * number: pytest.approx(float(first[f"te_harmonic_{number}_um"])) for number in range(1, 7)}


@pytest.mark.slow
def test_agrees_with_the_single_speed(swept, tmp_path):
    """Wheel torque, mean and rms of the transmission error, and Kw, from the sweep and from Gear's method at one of its speeds."""
    result = shell.call("dynamics", MODEL, "--out", tmp_path, "--set", "operation.pinion_speed_rpm=700")
    assert result.exit_code == 0, result.output
    single = rows(tmp_path / "elastic.csv")
    error, factor = (np.array([float(row[name]) for row in single]) for name in ("transmission_error_um", "dynamic_factor"))
    found = {name: float(text) for name, text in rows(swept[0] / "sweep.csv")[3].items() if name != "direction"}
    assert found["transmission_error_mean_um"] == pytest.approx(error.mean(), rel=1e-5, abs=0.0)
    assert found["transmission_error_rms_um"] == pytest.approx(error.std(), rel=1e-4, abs=0.0)
    # The largest Kw lies where friction reverses; 400 samples a cycle miss it by up to a step times the slope, 0.3 per radian.
    assert factor.max() <= found["dynamic_factor"] < factor.max() + 0.3 * 14.2 / 400
    assert {"time_series.png", "spectrum.png"} <= set(os.listdir(tmp_path))


class Stop:
    """Progress that interrupts after a number of finished speeds."""

    def __init__(self, after: int) -> None:
        self.after = after

    def __call__(self, label: str, done: int, total: int) -> None:
        if label == "sweep" and done >= self.after:
            raise KeyboardInterrupt


@pytest.mark.slow
def test_resumed_sweep_is_the_uninterrupted_one(swept, tmp_path):
    """Interrupted on the way up, then on the way down, its last line torn: the same files to the last byte."""
    setup, speeds = load_model(MODEL), sweeps.read_speeds(SPEEDS)
    for after, resume in ((3, False), (7, True)):
        with pytest.raises(KeyboardInterrupt):
            sweeps.run_sweep(setup, tmp_path, speeds, True, 1, resume, Stop(after))
        lines = (tmp_path / sweeps.PARTIAL).read_text().splitlines()
        assert len(lines) == 1 + after
        assert all(json.loads(line) for line in lines)
        assert len(rows(tmp_path / "sweep.csv")) == after
    with (tmp_path / sweeps.PARTIAL).open("a") as stream:
        stream.write('{"direction": "down", "pinion_sp')
    result = call(tmp_path, "--speeds", SPEEDS, "--both-ways", "--workers", 1, "--resume")
    assert result.exit_code == 0, result.output
    for name in ("sweep.csv", "sweep_spectrum.csv"):
        assert (tmp_path / name).read_bytes() == (swept[0] / name).read_bytes()
    assert not (tmp_path / sweeps.PARTIAL).exists()


def test_another_model_or_other_speeds_are_not_gone_on_with(tmp_path):
    setup, speeds = load_model(MODEL), sweeps.read_speeds(SPEEDS)
    with pytest.raises(KeyboardInterrupt):
        sweeps.run_sweep(setup, tmp_path, speeds, False, 1, False, Stop(2))
    for words in (
        ("--speeds", SPEEDS, "--both-ways"),
        ("--speeds", "400:800:6"),
        ("--speeds", SPEEDS, "--set", "operation.damping_ratio=0.1"),
    ):
        result = call(tmp_path, *words, "--resume")
        assert result.exit_code == 2
        assert "--resume" in result.stderr
    assert len((tmp_path / sweeps.PARTIAL).read_text().splitlines()) == 3


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--both-ways",), "--speeds"),
        (("--resume",), "--speeds"),
        (("--speeds", "400:800"), "FIRST:LAST:COUNT"),
        (("--speeds", "800:400:5"), "FIRST:LAST:COUNT"),
        (("--speeds", "0:400:5"), "FIRST:LAST:COUNT"),
        (("--speeds", "400:nan:5"), "FIRST:LAST:COUNT"),
        (("--speeds", "400:400:5"), "FIRST:LAST:COUNT"),
        (("--speeds", SPEEDS, "--resume"), "no "),
    ],
)
def test_what_cannot_be_swept_ends_in_one_line(tmp_path, words, said):
    result = call(tmp_path / "out", *words)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert said in result.stderr
    assert not (tmp_path / "out").exists()


def test_speeds_are_rpm():
    assert (sweeps.read_speeds("1000:1000:1") / RPM).tolist() == pytest.approx([1000.0])
    with pytest.raises(InputError, match="1:2:3:4"):
        sweeps.read_speeds("1:2:3:4")


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_interrupting_the_real_program_keeps_whole_lines(tmp_path, workers):
    """Ctrl-C in the middle of a long sweep: status 130, a table of the finished speeds, and --resume ends it."""
    words = [
        sys.executable,
        "-m",
        "gearfem",
        "dynamics",
        MODEL,
        "--out",
        str(tmp_path),
        "--speeds",
        "100:3000:600",
        "--workers",
        str(workers),
    ]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    partial = tmp_path / sweeps.PARTIAL
    with subprocess.Popen(
        words,
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
        start_new_session=True,
        preexec_fn=obey_interrupts,
    ) as process:
        limit = time.monotonic() + 120.0
        while time.monotonic() < limit and not (partial.exists() and partial.read_text().count("\n") > 20):
            time.sleep(0.02)
        # A terminal sends it to all processes of the group.
        os.killpg(process.pid, signal.SIGINT)
        _, complaint = process.communicate(timeout=60)
    assert (process.returncode, complaint) == (130, "interrupted\n")
    finished = len(rows(tmp_path / "sweep.csv"))
    assert 20 <= finished < 600
    assert len(partial.read_text().splitlines()) == finished + 1
    done = subprocess.run([*words, "--resume"], capture_output=True, text=True, env=environment, timeout=300, check=True)
    assert "largest dynamic factor" in done.stdout
    table = rows(tmp_path / "sweep.csv")
    assert [float(row["pinion_speed_rpm"]) for row in table] == pytest.approx(np.linspace(100.0, 3000.0, 600).tolist())
