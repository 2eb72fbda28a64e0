"""Progress on the terminal: a bar on stderr for steps that take longer than two seconds."""

from __future__ import annotations

import sys
import threading
from types import TracebackType
from typing import Any

PATIENCE = 2.0


class Bars:
    """Listens to the steps of a computation; silent where stderr is no terminal.

    Parameters
    ----------
    patience : float
        Seconds after which a step that is still running gets a bar.

    Notes
    -----
    A step may report nothing for a long time, so a timer opens the bar, not the step's next report.
    """

    def __init__(self, patience: float = PATIENCE) -> None:
        self._patience = patience
        self._on = sys.stderr.isatty()
        self._lock = threading.RLock()
        self._label = ""
        self._state = (0, 1)
        self._timer: threading.Timer | None = None
        self._bar: Any = None

    def __enter__(self) -> Bars:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        with self._lock:
            self._close()

    def __call__(self, label: str, done: int, total: int) -> None:
        """Take note that `done` of `total` steps of the work named `label` are finished."""
        if not self._on:
            return
        with self._lock:
            if label != self._label:
                self._open(label)
            self._state = (done, total)
            if self._bar is not None:
                self._bar.update(self._bar.task_ids[0], completed=done, total=total)
            if done >= total:
                self._close()

    def _open(self, label: str) -> None:
        self._close()
        self._label = label
        self._timer = threading.Timer(self._patience, self._show, (label,))
        self._timer.daemon = True
        self._timer.start()

    def _close(self) -> None:
        self._label = ""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def _show(self, label: str) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        with self._lock:
            # The timer may fire while its step ends.
            if label != self._label:
                return
            columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
            self._bar = Progress(*columns, console=Console(stderr=True), transient=True)
            done, total = self._state
            self._bar.add_task(label, completed=done, total=total)
            self._bar.start()
