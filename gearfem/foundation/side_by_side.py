"""The same work on many items, on all cores where processes can share what is already in memory."""

from __future__ import annotations

import contextlib
import ctypes
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing.synchronize import Semaphore
from typing import Any, NamedTuple, TypeVar

from gearfem.foundation.progress import Progress
from gearfem.foundation.threads import one_thread

Item = TypeVar("Item")
Result = TypeVar("Result")

# Of Linux: the signal that a process gets when the one it came from ends.
SIGNAL_OF_PARENT = 1


class _Task(NamedTuple):
    """What a child works at, found in the memory of the fork, so that functions and tables need not travel, and the cores that are free."""

    work: Callable[[Any], Any]
    free: Semaphore | None


# That of this process, if it is a child.
_tasks: list[_Task] = []


def _begin(task: _Task) -> None:
    """Let a child end at once where it is told to, or its parent ends, and keep to one core: threads would take that of another child."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(SIGNAL_OF_PARENT, signal.SIGTERM)
    one_thread()
    _tasks[:] = [task]


def _call(item: Any) -> Any:
    work, free = _tasks[0]
    with free or contextlib.nullcontext():
        return work(item)


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
    Needs the fork of Unix; elsewhere, on one core and for a single item the work is done here, one after the other. Inside a child it is
    shared out over those cores that the children have left free, if there are any. Where an item fails, or the program is interrupted,
    the children end at once.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    most = min(cores, len(items)) if "fork" in multiprocessing.get_all_start_methods() else 1
    if most < 2:
        yield from map(work, items)
        return
    if multiprocessing.parent_process() is None:
        yield from _shared_out(work, items, most, multiprocessing.get_context("fork").Semaphore(cores))
        return
    # A child uses one core already; its own children have none to share out.
    free = _tasks[0].free if _tasks else None
    with contextlib.ExitStack() as taken:
        workers = 1
        while free and workers < most and free.acquire(block=False):
            taken.callback(free.release)
            workers += 1
        yield from _shared_out(work, items, workers, None) if workers > 1 else map(work, items)


def _shared_out(work: Callable[[Item], Result], items: Sequence[Item], workers: int, free: Semaphore | None) -> Iterator[Result]:
    """Yield the results of so many children, which share the cores that are free out among theirs."""
    others = multiprocessing.active_children()
    fork = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(workers, mp_context=fork, initializer=_begin, initargs=(_Task(work, free),)) as pool:
        try:
            yield from pool.map(_call, items)
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
