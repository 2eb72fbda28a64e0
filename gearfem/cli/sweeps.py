"""The sweep of the dynamics command: its speeds, what it keeps on disk while it runs, and going on from there."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import time
from pathlib import Path
from types import TracebackType
from typing import Any, TextIO

import numpy as np

from gearfem.assumptions import even
from gearfem.cli.notices import MOVING, unseen
from gearfem.cli.steps import Done
from gearfem.definition.setup import Setup
from gearfem.dynamics.record import DriveTrain
from gearfem.dynamics.sweep import Found, sweep
from gearfem.dynamics.sweep_record import Direction, Failure, Sweep, SweepPoint
from gearfem.dynamics.turns_plan import moving
from gearfem.engagement.engage import mesh_force
from gearfem.engagement.record import MeshForce
from gearfem.engagement.turns import Turns
from gearfem.foundation import Array, InputError, SolveError, digest
from gearfem.foundation.progress import Progress
from gearfem.foundation.units import RPM
from gearfem.pipeline import run as run_chain
from gearfem.report.motion_plots import write_sweep_pictures
from gearfem.report.summary import model_sha256
from gearfem.report.sweep_table import write_sweep

PARTIAL = "sweep.partial.jsonl"
MOST_SPEEDS = 100_000
# A process takes some three seconds to start, as long as six hundred speeds take; fewer than these gain nothing by it.
WORTH_A_PROCESS = 1000
# Drives of more than two inertias, and teeth that differ, take tenths of a second or more a speed.
LARGE_WORTH_A_PROCESS = 10
EVERY = 2.0
UP_AND_DOWN: tuple[Direction, Direction] = ("up", "down")
APART = 1e-3
ARRAYS = ("harmonic_amplitude", "harmonic_phase", "line_order", "line_amplitude", "multiplier_magnitude", "state")


def read_speeds(text: str) -> Array:
    """Return pinion speeds [rad/s] of FIRST:LAST:COUNT in rpm.

    Parameters
    ----------
    text : str
        As "500:3000:200".

    Returns
    -------
    ndarray, shape (n,)

    Raises
    ------
    InputError
        If the text is anything else.

    Examples
    --------
    >>> (read_speeds("100:300:3") / RPM).round(6).tolist()
    [100.0, 200.0, 300.0]
    """
    try:
        first, last, count = (kind(word) for kind, word in zip((float, float, int), text.split(":"), strict=True))
    except ValueError:
        first, last, count = math.nan, math.nan, 0
    if not (0.0 < first <= last < math.inf and 1 <= count <= MOST_SPEEDS and (first < last) == (count > 1)):
        raise InputError("--speeds", text, f"FIRST:LAST:COUNT in rpm, as 500:3000:200, rising, at most {MOST_SPEEDS} speeds")
    return np.linspace(first, last, count) * RPM


class Partial:
    """Finished points of a sweep on disk, one JSON line each, behind a line that says which sweep it is.

    Parameters
    ----------
    out : Path
        Folder.
    setup : Setup
        Model.
    speeds : ndarray
        Speeds of the sweep [rad/s].
    both_ways : bool
        Whether up and down.
    resume : bool
        Whether the points of an interrupted run are read, or dropped.

    Raises
    ------
    InputError
        If there is nothing to go on from, or it belongs to another model or sweep.

    Notes
    -----
    A line is written and handed to the system in one piece as soon as its speed is finished; a last line torn by a crash is
    dropped. Numbers are written with all their digits, so that a resumed sweep is the uninterrupted one to the last bit.
    """

    def __init__(self, out: Path, setup: Setup, speeds: Array, both_ways: bool, resume: bool) -> None:
        self.path = out / PARTIAL
        self._identity = {"model_sha256": model_sha256(setup), "speeds": digest(speeds), "both_ways": both_ways}
        self.points = self._read() if resume else []
        self._stream: TextIO | None = None

    def __enter__(self) -> Partial:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        temporary = self.path.with_suffix(".new")
        temporary.write_text("".join(f"{json.dumps(line)}\n" for line in [self._identity, *map(_plain, self.points)]))
        temporary.replace(self.path)
        self._stream = self.path.open("a", encoding="utf-8")
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._stream is not None:
            self._stream.close()

    def add(self, point: Found) -> None:
        """Put one finished point on disk."""
        assert self._stream is not None
        self.points.append(point)
        self._stream.write(json.dumps(_plain(point), allow_nan=False) + "\n")
        self._stream.flush()
        os.fsync(self._stream.fileno())

    def done(self) -> None:
        """Remove the file: the sweep is whole."""
        self.path.unlink()

    def _read(self) -> list[Found]:
        if not self.path.is_file():
            raise InputError("--resume", f"no {self.path}", "a folder with an interrupted sweep; without --resume it starts anew")
        text = self.path.read_text(encoding="utf-8")
        lines = text[: text.rfind("\n") + 1].splitlines()
        if not lines or json.loads(lines[0]) != self._identity:
            raise InputError(
                "--resume",
                f"{self.path} of another model or other speeds",
                "the model, --set, --speeds and --both-ways that it was begun with",
            )
        return [_point(json.loads(line)) for line in lines[1:]]


def _plain(point: Found) -> dict[str, Any]:
    values = {field.name: getattr(point, field.name) for field in dataclasses.fields(point)}
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in values.items()}


def _point(values: dict[str, Any]) -> Found:
    typed: dict[str, Any] = {name: np.array(value, float) if name in ARRAYS else value for name, value in values.items()}
    return Failure(**typed) if "reason" in typed else SweepPoint(**typed)


def run_sweep(setup: Setup, out: Path, speeds: Array, both_ways: bool, workers: int | None, resume: bool, progress: Progress) -> Done:
    """Run a sweep, keeping what is finished on disk, and write its tables and pictures.

    Parameters
    ----------
    setup : Setup
        Model.
    out : Path
        Folder.
    speeds : ndarray
        [rad/s].
    both_ways, resume : bool
        As the options.
    workers : int, optional
        Processes; by default as many as pay, at most one per core.
    progress : Progress
        Listener.

    Returns
    -------
    Done

    Raises
    ------
    SolveError
        If every speed fails.
    """
    partial = Partial(out, setup, speeds, both_ways, resume)
    forces, drive = _excitation(setup, progress)
    written = time.monotonic()
    worth = WORTH_A_PROCESS if drive.two_inertias and isinstance(forces, MeshForce) else LARGE_WORTH_A_PROCESS
    processes = workers or min(os.cpu_count() or 1, 1 + speeds.size * (1 + both_ways) // worth)

    def keep() -> None:
        there = Sweep.of(partial.points)
        if there.points:
            write_sweep(there, setup, out)

    def finished(point: Found) -> None:
        nonlocal written
        partial.add(point)
        if time.monotonic() - written > EVERY:
            keep()
            written = time.monotonic()

    try:
        with partial:
            whole = sweep(
                forces,
                drive,
                speeds,
                both_ways=both_ways,
                workers=processes,
                known=tuple(partial.points),
                finished=finished,
                progress=progress,
            )
    except BaseException:
        keep()
        raise
    if not whole.points:
        raise SolveError(f"no speed of the sweep has a motion; the first: {whole.failures[0].reason}")
    files = list(write_sweep(whole, setup, out))
    progress("pictures", 0, 1)
    files += write_sweep_pictures(whole, setup, out)
    progress("pictures", 1, 1)
    partial.done()
    return Done([*_lines(setup, whole), *unseen(setup, MOVING)], files)


def _excitation(setup: Setup, progress: Progress) -> tuple[MeshForce | Turns, DriveTrain]:
    """Return what the teeth do, and the drive with all effects: over one pitch if all are alike, no torque ripples and no effect gives
    the gears supports on which their masses show."""
    system = run_chain(setup, "compliance", progress=progress).system
    assert system is not None
    mesh, drive = moving(system.mesh, system.drive)
    before = system.drive.pinion_support, system.drive.wheel_support
    if even(system) and not drive.ripples and (drive.pinion_support, drive.wheel_support) == before:
        return mesh_force(mesh, drive.pinion_torque), drive
    return Turns(mesh=system.mesh), system.drive


def _lines(setup: Setup, whole: Sweep) -> list[str]:
    first = whole.points[0]
    full = first.pinion_speed / first.tuning / RPM
    lines = [f"{setup.name}: natural frequency {first.natural_frequency:.1f} Hz, mesh frequency reaches it at {full:.0f} rpm"]
    for direction in whole.directions:
        branch = whole.branch(direction)
        top = max(branch, key=lambda point: point.dynamic_factor_max)
        lost = sum(point.contact_loss > 0.0 for point in branch)
        wild = sum(point.period_cycles == 0 for point in branch)
        lines.append(
            f"{direction}: largest dynamic factor {top.dynamic_factor_max:.3f} at {top.pinion_speed / RPM:.1f} rpm; "
            f"contact is lost at {lost} of {len(branch)} speeds, {wild} motions do not repeat"
        )
    up, down = ({point.pinion_speed: point.dynamic_factor_max for point in whole.branch(name)} for name in UP_AND_DOWN)
    if up:
        lines.append(f"up and down differ at {sum(abs(up[speed] - down[speed]) > APART for speed in up.keys() & down.keys())} speeds")
    lines += [f"{one.direction}, {one.pinion_speed / RPM:.1f} rpm: {one.reason}" for one in whole.failures]
    return lines
