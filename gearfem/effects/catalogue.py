"""Which effects there are: one module of this package each, those of installed packages, and classes given by hand."""

from __future__ import annotations

import dataclasses
import functools
import importlib
import importlib.metadata
import importlib.util
import inspect
import math
import pkgutil
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

import gearfem.effects
from gearfem.definition.setup import Setup
from gearfem.definition.validate import shown
from gearfem.effects.effect import HISTORY, MEMBERS, STAGES, Effect
from gearfem.foundation import InputError, digest
from gearfem.foundation.errors import nearest
from gearfem.foundation.units import factor

ENTRY_POINTS = "gearfem.effects"


def catalogue(extra: Iterable[type[Effect]] = ()) -> Mapping[str, type[Effect]]:
    """Return all known effects by name.

    Parameters
    ----------
    extra : iterable of type
        Classes from elsewhere, beside those of this package and of entry points of the group ``gearfem.effects``.

    Returns
    -------
    mapping of str to type

    Raises
    ------
    InputError
        If two effects share a name, or a class leaves out what an effect must state.

    Examples
    --------
    >>> "tip_relief" in catalogue()
    True
    """
    classes = dict(_installed())
    for kind in extra:
        _enter(classes, kind)
    return MappingProxyType(classes)


@functools.cache
def _installed() -> Mapping[str, type[Effect]]:
    classes: dict[str, type[Effect]] = {}
    for module in pkgutil.iter_modules(gearfem.effects.__path__):
        for kind in effects_of(importlib.import_module(f"gearfem.effects.{module.name}")):
            _enter(classes, kind)
    for point in importlib.metadata.entry_points(group=ENTRY_POINTS):
        _enter(classes, point.load())
    return MappingProxyType(classes)


def effects_of(module: ModuleType) -> list[type[Effect]]:
    """Return the effects that a module defines."""
    kinds = (kind for kind in vars(module).values() if isinstance(kind, type) and issubclass(kind, Effect))
    return [kind for kind in kinds if kind.__module__ == module.__name__ and "name" in vars(kind)]


def effects_from(path: str | Path) -> list[type[Effect]]:
    """Return the effects that a Python file defines.

    Parameters
    ----------
    path : str or Path
        The file; it is run.

    Raises
    ------
    InputError
        If it cannot be read or defines no effect.
    """
    path = Path(path).resolve()
    name = f"gearfem_effect_{digest(str(path))[:16]}"
    spec = importlib.util.spec_from_file_location(name, path)
    if not path.is_file() or spec is None or spec.loader is None:
        raise InputError("effect file", str(path), "a Python file (*.py) that can be read")
    if name not in sys.modules:
        # Dataclasses look their module up here; a file read twice gives the same classes.
        sys.modules[name] = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(sys.modules[name])
        except Exception as error:
            del sys.modules[name]
            found = " ".join(f"{type(error).__name__}: {error}".split())
            raise InputError("effect file", found, "a Python file that runs", str(path)) from error
    kinds = effects_of(sys.modules[name])
    if not kinds:
        raise InputError("effect file", f"{path} without an effect", "a file with a subclass of gearfem.effects.Effect that has a name")
    return kinds


def _enter(classes: dict[str, type[Effect]], kind: type[Effect]) -> None:
    """Add a class, complete and under a name of its own."""
    stated = ("name", "stage", "repeats", "sentence", "source")
    missing = [word for word in stated if not isinstance(getattr(kind, word, None), str)]
    if missing:
        raise InputError(f"effect {kind.__qualname__}", f"no {', '.join(missing)}", f"a class that states {', '.join(stated)}")
    if kind.stage not in STAGES or kind.history not in HISTORY:
        found = f"stage {kind.stage!r}, history {kind.history!r}"
        raise InputError(f"effect {kind.name}", found, f"a stage of {', '.join(STAGES)} and a history of {', '.join(HISTORY)}")
    undeclared = inspect.get_annotations(kind) and "__dataclass_fields__" not in vars(kind)
    if undeclared or kind.__abstractmethods__:
        found = "no method act" if kind.__abstractmethods__ else "no dataclass"
        raise InputError(f"effect {kind.name}", found, "a frozen dataclass (@dataclasses.dataclass(frozen=True, ...)) with a method act")
    bare = [field.name for field in dataclasses.fields(kind) if "parameter" not in field.metadata and field.name not in ("gear", "tooth")]
    if bare:
        raise InputError(f"effect {kind.name}", f"the field {bare[0]}", "gear, tooth, and fields declared by `parameter`")
    if classes.setdefault(kind.name, kind) is not kind:
        raise InputError(f"effect {kind.name}", "a second class of this name", "a name of its own for each effect")


def read_effects(tables: Sequence[Mapping[str, Any]], setup: Setup, extra: Iterable[type[Effect]] = ()) -> tuple[Effect, ...]:
    """Return the effects that the [[effect]] tables of a model file name.

    Parameters
    ----------
    tables : sequence of mapping
        Keys as in the file.
    setup : Setup
        The pair they act on.
    extra : iterable of type
        Effects from outside the catalogue.

    Returns
    -------
    tuple of Effect

    Raises
    ------
    InputError
        With the place in the file, what was found, what is allowed and the nearest valid name.
    """
    known = catalogue(extra)
    effects = []
    for place, table in enumerate(tables):
        try:
            effect = _read(table, known)
            effect.check(setup)
        except InputError as error:
            raise InputError(f"effect[{place + 1}].{error.where}", error.found, error.allowed) from None
        effects.append(effect)
    return tuple(effects)


def _read(table: Mapping[str, Any], known: Mapping[str, type[Effect]]) -> Effect:
    name = table.get("name")
    if not isinstance(name, str) or name not in known:
        found = "nothing" if name is None else shown(name)
        raise InputError("name", found, nearest(str(name), known))
    kind = known[name]
    keys = kind.keys()
    for key in table:
        if key != "name" and key not in keys:
            raise InputError(key, "an unknown key", nearest(key, keys))
    values: dict[str, Any] = {}
    for key, field in keys.items():
        if key not in table:
            raise InputError(key, "nothing", f"{_kind_of(kind, field)}; {name} needs this key")
        values[field] = _value(kind, field, key, table[key])
    return kind(**values)


def _value(kind: type[Effect], field: str, key: str, value: Any) -> Any:
    whole = isinstance(value, int) and not isinstance(value, bool)
    if field == "gear":
        good = value in MEMBERS
    elif field == "tooth":
        good = whole
    else:
        good = (whole and abs(value) < 1e300) or (isinstance(value, float) and math.isfinite(value))
    if not good:
        raise InputError(key, shown(value), _kind_of(kind, field))
    return value * factor(key) if field in kind.parameters() else value


def _kind_of(kind: type[Effect], field: str) -> str:
    if field == "gear":
        return '"pinion" or "wheel"'
    return "an integer, the number of a tooth" if field == "tooth" else f"a number ({kind.parameters()[field].words})"


def in_history(effects: Iterable[Effect]) -> tuple[Effect, ...]:
    """Return effects in the order of the pair's life: made, mounted, worn, running; within each as they are given.

    Parameters
    ----------
    effects : iterable of Effect
        In any order.

    Returns
    -------
    tuple of Effect
        Of those that replace a value of the model, only the last of each name.
    """
    ordered = sorted(effects, key=lambda effect: HISTORY.index(effect.history))
    last = {effect.name: effect for effect in ordered}
    return tuple(effect for effect in ordered if not effect.replaces or last[effect.name] is effect)
