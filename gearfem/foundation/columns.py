"""Reading of CSV series: comment lines, one header line with exact names, then numbers; every fault names file, row and column."""

from __future__ import annotations

import csv
import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.foundation.errors import InputError, not_utf8
from gearfem.foundation.record import Array, Record

# Longer than any measured series of a gear; beyond it a wrong file is likelier than a long one.
MOST_ROWS = 5_000_000
# Larger numbers are no measurement in any unit that files use.
LARGEST = 1e15


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Columns(Record):
    """Numbers of a CSV file, in the units of the file.

    Parameters
    ----------
    names : tuple of str
        Header of the file.
    values : ndarray, shape (rows, columns)
        The numbers; row 1 is the first line below the header that is neither empty nor a comment.
    lines : ndarray of int, shape (rows,)
        Line of the file that each row comes from, counted from 1.
    """

    names: tuple[str, ...]
    values: Array
    lines: NDArray[Any]


def read_columns(path: str | Path, headers: tuple[tuple[str, ...], ...], fewest: int = 1) -> Columns:
    """Return the numbers of a CSV file whose header is one of those allowed.

    Parameters
    ----------
    path : str or Path
        File in UTF-8; lines that start with "#" are comments, empty lines count for nothing.
    headers : tuple of tuple of str
        Headers that are allowed.
    fewest : int
        Smallest number of rows.

    Returns
    -------
    Columns

    Raises
    ------
    InputError
        In one line with file, row and column: a file that cannot be read, another header, a row of another length,
        a field that is no number, a quote that is not closed, too few rows.
    """
    file = str(path)
    lines = [(number, line) for number, line in enumerate(_lines(path), 1) if line.strip() and not line.lstrip().startswith("#")]
    wanted = " or ".join(",".join(names) for names in headers)
    if not lines:
        raise InputError("header", "no line", wanted, file)
    names = tuple(_fields(lines[0][1], f"header (line {lines[0][0]})", file))
    if names not in headers:
        raise InputError(f"header (line {lines[0][0]})", _shown(lines[0][1]), wanted, file)
    if not fewest <= len(lines) - 1 <= MOST_ROWS:
        raise InputError("rows", f"{len(lines) - 1} of them", f"from {fewest} up to {MOST_ROWS}", file)
    rows = [_numbers(line, names, f"row {row} (line {number})", file) for row, (number, line) in enumerate(lines[1:], 1)]
    return Columns(names=names, values=np.array(rows), lines=np.array([number for number, _ in lines[1:]]))


def _lines(path: str | Path) -> list[str]:
    if Path(path).exists() and not Path(path).is_file():
        raise InputError("file", "no regular file", "a CSV file that can be read", str(path))
    try:
        # Lines end where text files end them: a form feed in a comment is no end.
        return Path(path).read_text(encoding="utf-8-sig").split("\n")
    except FileNotFoundError:
        raise InputError("file", "no such file", "the path of a CSV file", str(path)) from None
    except OSError as error:
        raise InputError("file", (error.strerror or "an error").lower(), "a CSV file that can be read", str(path)) from None
    except UnicodeDecodeError as error:
        raise not_utf8(error, "CSV", str(path)) from None


def _fields(line: str, where: str, file: str) -> list[str]:
    try:
        return [field.strip() for field in next(csv.reader([line], strict=True))]
    except csv.Error as error:
        raise InputError(where, str(error), "fields parted by commas, quotes in pairs", file) from None


def _numbers(line: str, names: tuple[str, ...], where: str, file: str) -> list[float]:
    fields = _fields(line, where, file)
    if len(fields) != len(names):
        raise InputError(where, f"{len(fields)} column{'s' if len(fields) > 1 else ''}", f"{len(names)} columns: {','.join(names)}", file)
    values = []
    for name, field in zip(names, fields, strict=True):
        try:
            value = float(field) if field.isascii() and "_" not in field else math.nan
        except ValueError:
            value = math.nan
        if not abs(value) < LARGEST:
            allowed = f"a finite number below {LARGEST:g}; leave out the row where nothing was measured"
            raise InputError(f"{where}, column {name}", _shown(field) or "an empty cell", allowed, file)
        values.append(value)
    return values


def _shown(text: str) -> str:
    return " ".join(text[:60].split()) + ("..." if len(text) > 60 else "")
