"""Threads of dense algebra."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

from threadpoolctl import threadpool_limits


def one_thread() -> AbstractContextManager[Any]:
    """Let dense algebra keep to one thread from now on, and return a context at whose end it need not any more.

    Notes
    -----
    SuperLU calls it on blocks so small that starting threads costs more than they save: on two cores that are shared, the compliance of
    one gear pair took 0.7 to 5 s with two threads and 0.4 s with one. Where every core has a process, threads take each other's: a
    diagnosis took more than 330 s with two threads in each of two processes and 190 s with one.
    """
    context: AbstractContextManager[Any] = threadpool_limits(1, user_api="blas")
    return context
