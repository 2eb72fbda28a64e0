"""Reading of model files: TOML text and overrides in, a `Setup` out; every refusal is one line that names file and key."""

from __future__ import annotations

import hashlib
import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from gearfem.definition.resolve import EffectReader, resolve
from gearfem.definition.setup import Setup
from gearfem.definition.validate import shown, validate
from gearfem.foundation import InputError, digest
from gearfem.foundation.errors import not_utf8

KEY = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")


def define(mapping: Mapping[str, Any], effects: EffectReader, folder: Path = Path()) -> Setup:
    """Return the definition that a nested mapping with the keys of a model file describes.

    Parameters
    ----------
    mapping : mapping
        Tables and keys of the model file, in the units that end their names.
    effects : callable
        Makes the effects of the tables [[effect]].
    folder : Path
        Folder from which the files that it names are counted; by default the current one.

    Returns
    -------
    Setup

    Raises
    ------
    InputError
        On the first key that cannot be used.
    """
    return resolve(validate(mapping), folder, effects)


def read_tables(path: str | Path) -> dict[str, Any]:
    """Return the raw tables of a TOML file.

    Parameters
    ----------
    path : str or Path
        File in UTF-8.

    Raises
    ------
    InputError
        If the file is missing or is not TOML; syntax errors name line and column.
    """
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise InputError("the file", "no such file", "the path of a TOML file (*.toml)", str(path)) from None
    except OSError as error:
        raise InputError("the file", (error.strerror or "an error").lower(), "a file that can be read", str(path)) from None
    except UnicodeDecodeError as error:
        raise not_utf8(error, "TOML", str(path)) from None
    except (ValueError, RecursionError) as error:
        what, _, place = " ".join(str(error).split()).partition(" (at ")
        raise InputError(place.rstrip(")") or "the file", f"{what[:1].lower()}{what[1:]}", "TOML syntax", str(path)) from None


def with_overrides(tables: Mapping[str, Any], overrides: Iterable[str]) -> tuple[dict[str, Any], set[str]]:
    """Return a copy of the tables with single keys replaced, and the dotted names of those keys.

    Parameters
    ----------
    tables : mapping
        Raw tables of a model.
    overrides : iterable of str
        Each "dotted.key=value", the value spelt as in TOML, such as "pair.face_width_mm=60".

    Raises
    ------
    InputError
        If an override has no key or no TOML value, or leads through something that is not a table.
    """
    result = dict(tables)
    names = set()
    for text in overrides:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not KEY.fullmatch(name):
            raise InputError("override", shown(text), "key=value with a dotted key, such as pair.face_width_mm=60")
        names.add(name)
        *folders, key = name.split(".")
        table = result
        for folder in folders:
            inner = table.get(folder, {})
            if not isinstance(inner, dict):
                raise InputError(f"override of {name}", f"{folder} = {shown(inner)}", f"a table [{folder}]")
            table[folder] = dict(inner)
            table = table[folder]
        table[key] = _value(name, value)
    return result, names


def _value(name: str, text: str) -> Any:
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        table = {}
    if set(table) != {"value"} or "\n" in text:
        allowed = 'one value in TOML, such as 60, 20.5 or "text" (keep the quotes from the shell: --set \'name="text"\')'
        raise InputError(f"override of {name}", shown(text), allowed)
    return table["value"]


def read_model(path: str | Path, effects: EffectReader, overrides: Iterable[str] = ()) -> Setup:
    """Return the definition that a model file describes.

    Parameters
    ----------
    path : str or Path
        The model file.
    effects : callable
        Makes the effects of the tables [[effect]].
    overrides : iterable of str
        Keys that replace the file's, as in `with_overrides`.

    Returns
    -------
    Setup

    Raises
    ------
    InputError
        On the first thing that cannot be used, with the name of the file.
    """
    changes = tuple(overrides)
    tables, _ = with_overrides(read_tables(path), changes)
    try:
        return define(tables, effects, Path(path).parent)
    except InputError as error:
        raise error.in_file(origin(path, changes, error)) from None


def origin(path: str | Path, overrides: Iterable[str], error: InputError) -> str:
    """Return the name of the file, with a word about overrides where one of them gave the refused key.

    Parameters
    ----------
    path : str or Path
        The model file.
    overrides : iterable of str
        Each "dotted.key=value".
    error : InputError
        The refusal.

    Returns
    -------
    str
    """
    names = tuple(text.partition("=")[0].strip() for text in overrides)
    given = any(error.where == name or error.where.startswith(f"{name}.") for name in names)
    return f"{path} with overrides" if given else str(path)


def model_hash(setup: Setup) -> str:
    """Return the SHA-256 of the model as given, in 64 hexadecimal digits.

    Parameters
    ----------
    setup : Setup
        From a model file or from the same keys in Python, where layout, comments and the order of keys do not
        count; one that was built from records directly is hashed by its content.

    Returns
    -------
    str
    """
    return hashlib.sha256(setup.source.encode()).hexdigest() if setup.source else digest(setup)
