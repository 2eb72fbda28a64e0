"""From a nested mapping of file keys to a validated `Model`, or to one line that says what is wrong with it."""

from __future__ import annotations

import json
import math
import typing
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from gearfem.definition.schema import REASONS, Model, field_of, valid_names
from gearfem.foundation import InputError
from gearfem.foundation.errors import nearest
from gearfem.foundation.units import SUFFIXES

HELICAL = "spur gears only: helical gears are not supported: gearfem computes spur gears"
INTERNAL = "external gears only: internal gears are not supported: gearfem computes external spur gears"

Path = tuple[str, ...]


def validate(mapping: Mapping[str, Any]) -> Model:
    """Return the validated model of a nested mapping with the keys of a model file.

    Parameters
    ----------
    mapping : mapping
        Tables as mappings; numbers in the units that end their names. numpy's numbers are taken as Python's.

    Returns
    -------
    Model

    Raises
    ------
    InputError
        On the first thing that is wrong, with its dotted key. Gears that this program does not compute come
        first, then unknown keys, since a misspelt key also leaves a missing one behind.
    """
    tables = _plain(mapping)
    for path, table in list(_entries(tables)):
        _refuse_other_gears(path, table)
    try:
        return Model.model_validate(tables)
    except ValidationError as error:
        problems = error.errors(include_url=False, include_context=False)
    first = min(problems, key=lambda problem: problem["type"] != "extra_forbidden")
    raise _refusal(first["type"], tuple(map(str, first["loc"])), first["input"]) from None


def canonical(model: Model) -> str:
    """Return the model's given values as JSON with sorted keys: equal for equal content, whatever the layout of the file."""
    return json.dumps(_filled(model.model_dump(exclude_unset=True, exclude_none=True)), sort_keys=True, allow_nan=False)


def _filled(tables: dict[str, Any]) -> dict[str, Any]:
    """Return the tables without empty ones, innermost first."""
    inner = {key: _filled(value) if isinstance(value, dict) else value for key, value in tables.items()}
    return {key: value for key, value in inner.items() if value not in ({}, [])}


def shown(value: object) -> str:
    """Return a found value as a short single line, spelt as in TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        return "a table"
    try:
        text = json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
    except ValueError:
        return "a number of thousands of digits"
    return " ".join(text[:60].split()) + ("..." if len(text) > 60 else "")


def _plain(value: Any) -> Any:
    """Return a deep copy in plain containers, with the numbers of numpy as those of Python."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    return value.item() if type(value).__module__ == "numpy" and getattr(value, "shape", None) == () else value


def _entries(table: dict[str, Any], prefix: Path = ()) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Walk over all keys of all tables, each with the table that holds it."""
    for key, value in table.items():
        yield (*prefix, key), table
        if isinstance(value, dict):
            yield from _entries(value, (*prefix, key))


def _refuse_other_gears(path: Path, table: dict[str, Any]) -> None:
    """Refuse helical and internal gears; a key that says 0 or false says a spur or external gear and is taken out."""
    value = table[path[-1]]
    key = path[-1].lower()
    word = value.lower() if isinstance(value, str) and path != ("name",) else ""
    helix = any(part in key for part in ("helix", "helical", "beta"))
    inside = "internal" in key
    if (helix or inside) and (value is None or (isinstance(value, (bool, int, float)) and value == 0)):
        del table[path[-1]]
        return
    if helix or "helical" in word:
        raise InputError(".".join(path), shown(value), HELICAL)
    negative_teeth = key == "teeth" and isinstance(value, (int, float)) and -math.inf < value < 0
    if inside or "internal" in word or negative_teeth:
        raise InputError(".".join(path), shown(value), INTERNAL)


# ---- one line for each problem ----------------------------------------------------------------------


def _refusal(kind: str, place: Path, found: object) -> InputError:
    """Return the refusal of a key; a place in a list is counted from 1 and has no part in the key's meaning."""
    where = "".join(f"[{int(part) + 1}]" if part.isdigit() else f".{part}" for part in place).lstrip(".")
    path = tuple(part for part in place if not part.isdigit())
    if place[-1:] != path[-1:]:
        return InputError(where, shown(found), _entry(path))
    if kind == "extra_forbidden":
        return InputError(where, "an unknown key" if _written(path) else "a key that is not text", _nearest(path))
    if kind == "missing":
        return InputError(where, "nothing", f"{allowed(path)}; this key must be given")
    return InputError(where, shown(found), allowed(path))


def _of_tables(field: FieldInfo) -> bool:
    """Return whether a list holds tables rather than numbers."""
    return typing.get_origin(typing.get_args(field.annotation)[0]) is not typing.Annotated


def _entry(path: Path) -> str:
    """Return what one entry of a list may be."""
    field: FieldInfo = field_of(path)
    if _of_tables(field):
        return f"a table [[{'.'.join(path)}]]"
    metadata = [item for part in typing.get_args(typing.get_args(field.annotation)[0])[1:] for item in getattr(part, "metadata", [part])]
    return f"a number{_bounds(metadata)} {_unit(path[-1])}".rstrip()


def _written(path: Path) -> bool:
    return bool(path[-1].strip())


def _nearest(path: Path) -> str:
    """Return the nearest valid name: in the same table, the same word in another table, or the table's whole list."""
    names = valid_names()
    table, key = ".".join(path[:-1]), path[-1]
    here = names.get(table, ())
    elsewhere = [f"{other}.{key}" if other else key for other, keys in names.items() if key in keys]
    return f"{elsewhere[0]} (the nearest valid name)" if elsewhere else nearest(key, here)


def allowed(path: Path) -> str:
    """Return what a key may hold, from its type, its bounds and the unit at the end of its name."""
    field: FieldInfo = field_of(path)
    if typing.get_origin(field.annotation) is list:
        if _of_tables(field):
            return f"tables [[{'.'.join(path)}]]"
        most = next((item.max_length for item in field.metadata if hasattr(item, "max_length")), None)
        return f"a list{f' of {most}' if most else ''}, each {_entry(path)}"
    if typing.get_origin(field.annotation) is typing.Literal:
        return " or ".join(json.dumps(word) for word in typing.get_args(field.annotation))
    kinds = {int: "an integer", float: "a number", str: "text"}
    parts = [part for part in (field.annotation, *typing.get_args(field.annotation)) if part is not type(None)]
    metadata: list[Any] = list(field.metadata)
    for part in parts:
        metadata += [item for extra in getattr(part, "__metadata__", ()) for item in getattr(extra, "metadata", [extra])]
    plain = [typing.get_args(part)[0] if hasattr(part, "__metadata__") else part for part in parts]
    kind = next((kinds[part] for part in plain if part in kinds), None)
    if kind is None:
        return f"a table [{'.'.join(path)}]"
    unit = _unit(path[-1])
    reason = REASONS.get(path[-1])
    return kind + _bounds(metadata) + (f" {unit}" if unit else "") + (f" ({reason})" if reason else "")


def _bounds(metadata: list[Any]) -> str:
    signs = {"gt": "above", "ge": "from", "lt": "below", "le": "up to"}
    words = [f"{word} {getattr(item, sign):g}" for item in metadata for sign, word in signs.items() if hasattr(item, sign)]
    return " " + " and ".join(words) if words else ""


def _unit(key: str) -> str:
    """Return the unit that ends a key, as in "kg/m3"; empty for a key without one."""
    suffix = next((suffix for suffix in SUFFIXES if key.endswith(suffix)), "")
    return suffix[1:].replace("_per_", "/").replace("_", " ")
