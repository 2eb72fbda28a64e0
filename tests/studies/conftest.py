"""The studies import each other by name, as they do when they are run as scripts."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

STUDIES = Path(__file__).parents[2] / "studies"


@pytest.fixture(autouse=True)
def studies_importable(monkeypatch):
    """Put the folder of the studies on the path for the length of a test."""
    monkeypatch.syspath_prepend(str(STUDIES))
    yield
    for name in [name for name, module in sys.modules.items() if str(getattr(module, "__file__", "")).startswith(str(STUDIES))]:
        del sys.modules[name]
