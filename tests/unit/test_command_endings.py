"""How a command ends that is interrupted or fails on the way: one line, its own status, and no half a file."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time

import pytest

from gearfem.cli import steps as work
from gearfem.foundation import SolveError
from tests.unit.shell import MODEL, call, obey_interrupts


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (SolveError("no balance after\n60 steps"), 1, "error: no balance after 60 steps\n"),
        (SolveError("no balance in \x1b[31mred\x1b[0m"), 1, "error: no balance in \\x1b[31mred\\x1b[0m\n"),
        (FloatingPointError("Engagement.force holds a value that is not finite"), 1, "error: Engagement.force holds"),
        (MemoryError("Unable to allocate 95 GiB"), 1, "error: not enough memory (Unable to allocate 95 GiB)"),
        (KeyboardInterrupt(), 130, "interrupted\n"),
        (PermissionError(13, "Permission denied", "/there"), 1, "error: /there: permission denied\n"),
    ],
)
def test_what_fails_on_the_way_is_one_line_with_its_own_status(tmp_path, monkeypatch, error, status, line):
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(work, "kinematics", fail)
    result = call("kinematics", MODEL, "--out", tmp_path)
    assert (result.exit_code, result.stdout) == (status, "")
    assert result.stderr.startswith(line)
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("error", [ZeroDivisionError("a defect of the program"), RuntimeError("another one")])
def test_an_unforeseen_error_is_not_hidden(tmp_path, monkeypatch, error):
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(work, "kinematics", fail)
    assert call("kinematics", MODEL, "--out", tmp_path).exception is error


def test_an_interrupt_that_is_lost_in_a_callback_still_counts(tmp_path, monkeypatch):
    """As in the middle of a compilation: Python drops it there, and what was left undone fails later."""

    def interrupted() -> None:
        raise KeyboardInterrupt

    def fail(*_: object) -> None:
        ctypes.CFUNCTYPE(None)(interrupted)()
        raise RuntimeError("no compiled object yet")

    monkeypatch.setattr(work, "kinematics", fail)
    result = call("kinematics", MODEL, "--out", tmp_path)
    assert (result.exit_code, result.stdout, result.stderr) == (130, "", "interrupted\n")


@pytest.mark.parametrize(("number", "status", "line"), [(signal.SIGINT, 130, "interrupted\n"), (signal.SIGTERM, 143, "")])
def test_signals_end_a_command_however_they_come_out(tmp_path, monkeypatch, number, status, line):
    """As in the middle of an import, which makes an error of its own of an interrupt; whatever computes is left on the way."""
    left = []

    def fail(*_: object) -> None:
        try:
            os.kill(os.getpid(), number)
            time.sleep(5.0)
        except KeyboardInterrupt:
            raise ImportError("half imported") from None
        finally:
            left.append("left")

    monkeypatch.setattr(work, "kinematics", fail)
    before = signal.signal(number, signal.default_int_handler)
    try:
        result = call("kinematics", MODEL, "--out", tmp_path)
    finally:
        signal.signal(number, before)
    assert (result.exit_code, result.stderr, left) == (status, line, ["left"])


def test_interrupting_the_real_program_leaves_no_part_of_a_file(tmp_path):
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "gearfem", "run", MODEL, "--out", str(tmp_path)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment, preexec_fn=obey_interrupts) as process:
        # Long enough to be within the command, short against the whole run.
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=60)
    assert complaint == "interrupted\n"
    # Stopped within exec, as while dataclasses are imported, `python -m` ends by the signal itself; to a shell both are 130.
    assert process.returncode in (130, -signal.SIGINT)
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]
