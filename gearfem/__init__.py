"""gearfem: stiffness and dynamics of spur gears, worn ones above all."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gearfem.definition.setup import Setup
    from gearfem.foundation.errors import InputError, SolveError
    from gearfem.model import load_model, make_setup
    from gearfem.pipeline import Results, run

__all__ = ["InputError", "Results", "Setup", "SolveError", "__version__", "load_model", "make_setup", "run"]

_HOMES = {
    "InputError": "gearfem.foundation.errors",
    "Results": "gearfem.pipeline",
    "Setup": "gearfem.definition.setup",
    "SolveError": "gearfem.foundation.errors",
    "load_model": "gearfem.model",
    "make_setup": "gearfem.model",
    "run": "gearfem.pipeline",
}


def __getattr__(name: str) -> Any:
    """Return a public name from its home, imported on first use: importing gearfem alone costs nothing."""
    if name == "__version__":
        version: str = import_module("importlib.metadata").version("gearfem")
        return version
    if name not in _HOMES:
        raise AttributeError(f"module 'gearfem' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
