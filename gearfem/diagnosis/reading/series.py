"""A measured series as its file has it: two columns of numbers, each with the line that it comes from."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from gearfem.foundation import Array, Record
from gearfem.foundation.columns import read_columns


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Series(Record):
    """A measured series as its file has it.

    Parameters
    ----------
    axis, value : ndarray, shape (n,)
        The two columns, in the units of the file.
    line : ndarray of int, shape (n,)
        Line of the file that each row comes from, counted from 1.
    """

    axis: Array
    value: Array
    line: NDArray[Any]

    def row(self, index: int) -> str:
        """Return the name of a row for people: its place among the numbers and its line in the file."""
        return f"row {index + 1} (line {int(self.line[index])})"


def read_series(path: Path, columns: tuple[str, str]) -> Series:
    """Read two columns of numbers under the only header allowed.

    Raises
    ------
    InputError
        As `gearfem.foundation.columns.read_columns`.
    """
    found = read_columns(path, (columns,))
    return Series(axis=found.values[:, 0], value=found.values[:, 1], line=found.lines)
