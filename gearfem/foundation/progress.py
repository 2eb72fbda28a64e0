"""How long steps say how far they are, without knowing who listens."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Called with a label and counts of steps; a listener shows a bar, a log or nothing."""

    def __call__(self, label: str, done: int, total: int) -> None:
        """Report that `done` of `total` steps of the work named `label` are finished."""


def quiet(label: str, done: int, total: int) -> None:
    """Listen to nothing; the default everywhere."""
