"""The same work on many items, on all cores where processes can share what is already in memory."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, TypeVar

from gearfem.foundation.progress import Progress
from gearfem.foundation.threads import one_thread

Item = TypeVar("Item")
Result = TypeVar("Result")

# What the children of a fork find in their memory; functions and tables need not travel.
_shared: dict[str, Callable[[Any], Any]] = {}


def _begin() -> None:
    """Let a child end at once where it is told to, and keep to one core: threads of linear algebra would take that of another child."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    one_thread()


def _call(item: Any) -> Any:
    return _shared["work"](item)


def side_by_side(work: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
    """Return the results of a function of each item, in their order, as they are ready.

    Parameters
    ----------
    work : callable
        A pure function; it may hold large arrays, which are not copied.
    items : sequence
        Its arguments.

    Yields
    ------
    object
        What the function returns; it must be able to travel between processes.

    Notes
    -----
    Needs the fork of Unix; elsewhere, on one core, inside a child and for a single item the work is done here, one after the other. Where
    an item fails, or the program is interrupted, the children end at once.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    alone = multiprocessing.parent_process() is not None or "fork" not in multiprocessing.get_all_start_methods()
    if alone or cores < 2 or len(items) < 2:
        yield from map(work, items)
        return
    _shared["work"] = work
    others = multiprocessing.active_children()
    fork, workers = multiprocessing.get_context("fork"), min(cores, len(items))
    with ProcessPoolExecutor(workers, mp_context=fork, initializer=_begin) as pool:
        try:
            results = pool.map(_call, items)
            # The children have it by now; it may hold much that nobody else does.
            _shared.clear()
            yield from results
        except BaseException:
            # Nobody waits for the rest: an interrupt may reach this process alone.
            for child in multiprocessing.active_children():
                if child not in others:
                    child.terminate()
            raise


def counted(work: Callable[[Item], Result], items: Sequence[Item], progress: Progress, words: str) -> Iterator[Result]:
    """Yield the same, and tell a listener how many are done."""
    for number, result in enumerate(side_by_side(work, items)):
        progress(words, number, len(items))
        yield result
    progress(words, max(len(items), 1), max(len(items), 1))
