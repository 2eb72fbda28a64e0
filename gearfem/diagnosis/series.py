"""Two columns of numbers from a CSV file, read strictly: every refusal names row and column."""

from __future__ import annotations

import csv
import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.definition.validate import shown
from gearfem.foundation import Array, InputError, Record


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
    """Read two columns of numbers under a header, comments left out.

    Parameters
    ----------
    path : Path
        CSV file: lines that start with "#" are comments, then one header line, then numbers.
    columns : (str, str)
        The only headings allowed, in this order.

    Returns
    -------
    Series

    Raises
    ------
    InputError
        If the file cannot be read, the header differs, a row has more or fewer cells, or a cell is no finite number.
    """
    lines = [(number, text) for number, text in enumerate(_text(path).splitlines(), 1) if text.strip() and not text.startswith("#")]
    allowed = f"the header {','.join(columns)}"
    if not lines:
        raise InputError("header", "nothing", allowed, str(path))
    number, header = lines[0]
    if tuple(cell.strip() for cell in next(csv.reader([header]))) != columns:
        raise InputError(f"header (line {number})", shown(header.strip()), allowed, str(path))
    if len(lines) == 1:
        raise InputError(f"line {number + 1}", "no row of numbers", "at least one", str(path))
    rows = [_row(path, index, number, text, columns) for index, (number, text) in enumerate(lines[1:], 1)]
    table = np.array(rows)
    return Series(axis=table[:, 0], value=table[:, 1], line=np.array([number for number, _ in lines[1:]]))


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError("record file", "no such file", "the path of a CSV file, relative to the campaign file", str(path)) from None
    except UnicodeDecodeError as error:
        raise InputError(f"byte {error.start}", "a character that is not UTF-8", "CSV text in UTF-8", str(path)) from None
    except OSError as error:
        raise InputError("record file", (error.strerror or "an error").lower(), "a file that can be read", str(path)) from None


def _row(path: Path, index: int, line: int, text: str, columns: tuple[str, str]) -> tuple[float, float]:
    cells = next(csv.reader([text]))
    place = f"row {index} (line {line})"
    if len(cells) != len(columns):
        found = f"{len(cells)} cell" + ("s" if len(cells) != 1 else "")
        raise InputError(place, found, f"{len(columns)} cells: {', '.join(columns)}", str(path))
    first, second = (_number(path, place, column, cell) for column, cell in zip(columns, cells, strict=True))
    return first, second


def _number(path: Path, place: str, column: str, cell: str) -> float:
    try:
        value = float(cell) if "_" not in cell else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        found = shown(cell.strip()) if cell.strip() else "an empty cell"
        raise InputError(f"{place}, column {column}", found, "a finite number; leave out the row where nothing was measured", str(path))
    return value
