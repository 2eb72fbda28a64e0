"""Files that are whole or absent: written under a temporary name in the same folder, then renamed."""

from __future__ import annotations

import csv
import errno
import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Hand out a temporary path beside `path`; rename it to `path` on success, remove it otherwise.

    Parameters
    ----------
    path : Path
        File to be written; missing folders are made.

    Yields
    ------
    Path
        Temporary path with the same suffix.

    Raises
    ------
    OSError
        Naming `path`, if it is a folder or cannot be written.
    """
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    with _named(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
        os.close(handle)
        temporary = Path(name)
    try:
        yield temporary
        with _named(path):
            temporary.chmod(0o644)
            temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def together(folder: Path) -> Iterator[Path]:
    """Hand out a temporary folder within `folder`; move its files there on success, drop them otherwise: old ones and new do not mix.

    Parameters
    ----------
    folder : Path
        Where they belong; made if it is missing.

    Yields
    ------
    Path
        Temporary folder.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".", dir=folder) as name:
        yield Path(name)
        for file in sorted(Path(name).iterdir()):
            file.replace(folder / file.name)


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Let errors of the temporary file name the file that was asked for."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None


def write_csv(path: Path, columns: Mapping[str, ArrayLike], comments: tuple[str, ...] = ()) -> None:
    """Write columns of equal length as CSV: comment lines, one header line, then rows.

    Parameters
    ----------
    path : Path
        Target file.
    columns : mapping of str to array_like, shape (n,)
        Names that end in their unit, and their values in that unit; text columns are allowed.
    comments : tuple of str
        Written first, each behind "# ".

    Raises
    ------
    ValueError
        If the columns differ in length.
    """
    arrays = [np.asarray(values) for values in columns.values()]
    if len({array.shape for array in arrays}) > 1:
        raise ValueError(f"columns of {path} differ in length: {[array.shape for array in arrays]}")
    with whole(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as stream:
        stream.writelines(f"# {line}\n" for line in comments)
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*(map(_text, array) for array in arrays), strict=True))


def _text(value: Any) -> str:
    return f"{value:.10g}" if isinstance(value, (float, np.floating)) else str(value)


def write_json(path: Path, values: Mapping[str, Any]) -> None:
    """Write a mapping as indented JSON; NaN and infinity are refused.

    Parameters
    ----------
    path : Path
        Target file.
    values : mapping
        JSON types, numpy numbers and arrays.
    """
    text = json.dumps(values, indent=2, allow_nan=False, default=lambda value: value.tolist())
    with whole(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")
