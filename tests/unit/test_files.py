"""Files that are whole or absent, and those that belong together."""

from __future__ import annotations

from pathlib import Path

import pytest

from gearfem.foundation.files import together


def interrupted(out: Path) -> None:
    """Begin to write a file again, and end at Ctrl-C."""
    with together(out) as draft:
        (draft / "a.png").write_text("new")
        raise KeyboardInterrupt


def test_files_that_belong_together_come_all_at_once_or_not_at_all(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with together(out) as draft:
        (draft / "a.png").write_text("old")
    with pytest.raises(KeyboardInterrupt):
        interrupted(out)
    assert [file.name for file in out.iterdir()] == ["a.png"]
    assert (out / "a.png").read_text() == "old"
