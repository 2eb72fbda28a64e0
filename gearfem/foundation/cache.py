"""Steps remembered by the content they depend on, within one process."""

from __future__ import annotations

import functools
from collections import OrderedDict
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from gearfem.foundation.record import digest

P = ParamSpec("P")
R = TypeVar("R")

KEPT = 32


def remembered(step: Callable[P, R], kept: int = KEPT) -> Callable[P, R]:
    """Make a pure function of records return its earlier result where the content of its arguments is the same.

    Parameters
    ----------
    step : callable
        Takes and returns records, arrays and plain values.
    kept : int
        Number of results that are kept, the last ones; 32 by default.

    Returns
    -------
    callable
        The same function, with the attribute `forget`, which empties its memory.
    """
    memory: OrderedDict[str, R] = OrderedDict()

    @functools.wraps(step)
    def recall(*args: P.args, **kwargs: P.kwargs) -> R:
        key = digest((args, kwargs))
        if key not in memory:
            memory[key] = step(*args, **kwargs)
        memory.move_to_end(key)
        if len(memory) > kept:
            memory.popitem(last=False)
        return memory[key]

    recall.forget = memory.clear  # type: ignore[attr-defined]
    return recall
