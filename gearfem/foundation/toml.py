"""Writing of TOML: nested tables and lists of tables, as model and campaign files have them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from gearfem.foundation.files import whole


def to_toml(tables: Mapping[str, Any]) -> str:
    """Return nested mappings as TOML, values before tables.

    Parameters
    ----------
    tables : mapping
        Text, booleans, numbers, lists of them, mappings and lists of mappings.

    Returns
    -------
    str

    Examples
    --------
    >>> print(to_toml({"name": "rig 7", "pair": {"module_mm": 3.0}, "effect": [{"name": "runout"}]}), end="")
    name = "rig 7"
    <BLANKLINE>
    [pair]
    module_mm = 3.0
    <BLANKLINE>
    [[effect]]
    name = "runout"
    """
    return "\n".join(_lines(tables, "")).lstrip("\n") + "\n"


def write_toml(path: Path, tables: Mapping[str, Any]) -> None:
    """Write nested mappings as a TOML file; values as in `to_toml`."""
    with whole(path) as temporary:
        temporary.write_text(to_toml(tables), encoding="utf-8")


def _lines(table: Mapping[str, Any], prefix: str) -> Iterator[str]:
    inner = {key: value for key, value in table.items() if _holds_tables(value)}
    for key, value in table.items():
        if key not in inner:
            yield f"{_key(key)} = {_value(value)}"
    for key, value in inner.items():
        name = f"{prefix}{_key(key)}"
        for entry in value if isinstance(value, list) else [value]:
            yield ""
            yield f"[[{name}]]" if isinstance(value, list) else f"[{name}]"
            yield from _lines(entry, f"{name}.")


def _holds_tables(value: Any) -> bool:
    return isinstance(value, Mapping) or (isinstance(value, list) and bool(value) and all(isinstance(entry, Mapping) for entry in value))


def _key(key: str) -> str:
    plain = key and all(letter.isascii() and (letter.isalnum() or letter in "-_") for letter in key)
    return key if plain else json.dumps(key, ensure_ascii=False)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        # JSON escapes are TOML's, but for DEL, which JSON leaves bare.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_value(entry) for entry in value)}]"
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"no TOML for {type(value).__name__}")
