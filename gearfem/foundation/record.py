"""Frozen records with locked arrays, and a digest of their content."""

from __future__ import annotations

import dataclasses
import hashlib
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

# Items of a tuple that a record shows when it is printed.
MOST_SHOWN = 6


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Record:
    """Base of all records: arrays are locked on construction, so that sharing and caching are safe.

    Subclasses are dataclasses with ``frozen=True, eq=False, kw_only=True``; two records are compared
    by `digest`. NaN and infinity are refused: a missing number is a missing row, not a NaN.
    """

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                if value.dtype.kind == "f" and not np.isfinite(value).all():
                    raise FloatingPointError(f"{type(self).__name__}.{field.name} holds a value that is not finite")
                if value.flags.writeable:
                    value = value.copy()
                    value.flags.writeable = False
                    object.__setattr__(self, field.name, value)

    @cached_property
    def _digest(self) -> str:
        sha = hashlib.sha256(type(self).__name__.encode() + b":")
        for field in dataclasses.fields(self):
            sha.update(field.name.encode())
            _feed(sha, getattr(self, field.name))
        return sha.hexdigest()

    def __init_subclass__(cls, **options: Any) -> None:
        # Here, before dataclass looks for one: all numbers of a record would fill pages.
        super().__init_subclass__(**options)
        cls.__repr__ = Record.__repr__  # type: ignore[method-assign]

    def __repr__(self) -> str:
        """Return the fields in brief, on one line."""
        fields = (f"{field.name}: {_brief(getattr(self, field.name))}" for field in dataclasses.fields(self))
        return f"{type(self).__name__}({', '.join(fields)})"

    def __str__(self) -> str:
        """Return the fields in brief, a line each: of arrays shape and range, of other records their sentence or name."""
        return "\n".join(
            [type(self).__name__, *(f"  {field.name}: {_brief(getattr(self, field.name))}" for field in dataclasses.fields(self))]
        )

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """Show the same in a notebook."""
        printer.text("..." if cycle else str(self))

    def brief(self) -> str:
        """Return in words what another record shows of this one: its sentence, if it has any, or its kind."""
        return str(getattr(self, "sentence", "")) or type(self).__name__


def _brief(value: Any) -> str:
    if isinstance(value, np.ndarray):
        numbers = value.size and value.dtype.kind in "iuf"
        return f"array {value.shape}" + (f", {value.min():.4g} to {value.max():.4g}" if numbers else "")
    if isinstance(value, Record):
        return value.brief()
    if isinstance(value, (tuple, list)):
        shown = [_brief(item) for item in value[:MOST_SHOWN]]
        return f"{len(value)}: " + "; ".join([*shown, *(["..."] if len(value) > len(shown) else [])]) if value else "none"
    return f"{value:.6g}" if isinstance(value, float) else str(value) if isinstance(value, (str, int, bool)) else type(value).__name__


def digest(value: Any) -> str:
    """Return the SHA-256 of the content of records, arrays, numbers, text and containers of them.

    Parameters
    ----------
    value : object
        A `Record`, array, number, string, None, or a tuple, list or dict of them.

    Returns
    -------
    str
        64 hexadecimal digits; equal for equal content, whatever object holds it.

    Raises
    ------
    TypeError
        If a part is of another type, since its content is then unknown.
    """
    if isinstance(value, Record):
        return value._digest
    sha = hashlib.sha256()
    _feed(sha, value)
    return sha.hexdigest()


def _feed(sha: Any, value: Any) -> None:
    sha.update(type(value).__name__.encode() + b":")
    if isinstance(value, Record):
        sha.update(value._digest.encode())
    elif isinstance(value, np.ndarray):
        sha.update(repr((value.dtype.str, value.shape)).encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, (list, tuple)):
        sha.update(str(len(value)).encode())
        for item in value:
            _feed(sha, item)
    elif isinstance(value, dict):
        _feed(sha, sorted(value.items()))
    elif value is None or isinstance(value, (bool, int, float, str, np.number)):
        sha.update(repr(value).encode())
    else:
        raise TypeError(f"no digest for {type(value).__name__}")
