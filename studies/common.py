"""What the studies share: both gears with their active flanks, and tables on paper and on disc."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from gearfem import Setup
from gearfem.flank import Outline, make_flanks
from gearfem.foundation.files import write_csv
from gearfem.report.summary import active_flank

HERE = Path(__file__).parent


def gears(setup: Setup) -> Iterator[tuple[str, Outline, tuple[float, float]]]:
    """Yield the name, the outline and the ends of the active flank (parameters u) of both gears."""
    flanks = make_flanks(setup)
    for member in ("pinion", "wheel"):
        yield member, getattr(flanks, member), active_flank(setup.pair, flanks, member)


def write_rows(path: Path, rows: list[dict[str, Any]], comments: tuple[str, ...] = ()) -> None:
    """Write rows of equal keys as CSV."""
    write_csv(path, {key: [row[key] for row in rows] for key in rows[0]}, comments)


def table_text(title: str, rows: list[dict[str, Any]]) -> str:
    """Return rows of equal keys in columns, under a title."""
    texts = [[f"{value:.4g}" if isinstance(value, float) else str(value) for value in row.values()] for row in rows]
    widths = [max(map(len, column)) for column in zip(rows[0], *texts, strict=True)]
    lines = ("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) for line in (list(rows[0]), *texts))
    return "\n".join(["", title, *(f"  {line}".rstrip() for line in lines)])


def print_table(title: str, rows: list[dict[str, Any]]) -> None:
    """Print rows of equal keys in columns."""
    print(table_text(title, rows))
