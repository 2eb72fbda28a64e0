"""Commands run in this process, and what they wrote or refused."""

from __future__ import annotations

import csv
import functools
import signal
from pathlib import Path

from click.testing import CliRunner, Result

from gearfem.cli import main

MODEL = str(Path(__file__).parents[2] / "studies" / "coal_combine" / "model.toml")

# To run in a child before it starts: whoever runs the tests may have been told to ignore interrupts, and children inherit that.
obey_interrupts = functools.partial(signal.signal, signal.SIGINT, signal.SIG_DFL)


def call(*words: object) -> Result:
    """Run one command in this process."""
    return CliRunner().invoke(main, [str(word) for word in words])


def rows(path: Path) -> list[dict[str, str]]:
    """Return the rows of a table, its comments left out."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


def assert_refused(result: Result, *words: str) -> None:
    """Check that a command ended by one line on stderr with status 2 and computed nothing."""
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith("error: ")
    assert "Traceback" not in result.output
    for word in words:
        assert word in result.stderr
