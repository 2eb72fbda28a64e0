"""Imports point one way: a package knows only those before it in the line."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import gearfem

LINE = (
    "foundation",
    "definition",
    "flank",
    "compliance",
    "placement",
    "contact",
    "engagement",
    "dynamics",
    "sensing",
    "effects",
    "variants",
    "model",
    "assembly",
    "assumptions",
    "pipeline",
    "templates",
    "wear",
    "diagnosis",
    "rig",
    "report",
    "cli",
    "__main__",
)
# The same within the diagnosis.
STEPS = (
    "reading",
    "modelling",
    "fitting",
    "comparing",
    "localising",
    "ranking",
    "naming",
    "proving",
    "suggest",
    "diagnose",
    "updated",
    "write",
)
PACKAGE = Path(gearfem.__file__).parent
MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")
OF_DIAGNOSIS = [path for path in MODULES if "diagnosis" in path.parts and path != PACKAGE / "diagnosis" / "__init__.py"]


def room(path: Path, house: Path) -> str:
    """Return the name of the package or single-file package within a package that holds a module."""
    return path.relative_to(house).parts[0].removesuffix(".py")


def imported(path: Path, house: str) -> set[str]:
    """Return the rooms of a package that a module imports, at its top or late."""
    rooms = set()
    for node in ast.walk(ast.parse(path.read_text())):
        names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        rooms |= {name.removeprefix(house).split(".")[0] for name in names if name.startswith(house)}
    return rooms


def late(path: Path, line: tuple[str, ...], house: str) -> set[str]:
    """Return the rooms that a module of a package imports and that do not come before its own in a line; its own too if it has no place."""
    here = room(path, PACKAGE.parent.joinpath(*house.split(".")))
    return (imported(path, house) | {here}) - set(line[: line.index(here) + 1] if here in line else ())


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_upward(path: Path) -> None:
    assert late(path, LINE, "gearfem.") == set()


@pytest.mark.parametrize("path", OF_DIAGNOSIS, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_within_the_diagnosis_point_upward(path: Path) -> None:
    assert late(path, STEPS, "gearfem.diagnosis.") == set()


@pytest.mark.parametrize("path", [*MODULES, PACKAGE / "__init__.py"], ids=lambda path: str(path.relative_to(PACKAGE)))
def test_public_names_explain_themselves(path: Path) -> None:
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree), f"{path.name} has no docstring"
    kinds = (ast.FunctionDef, ast.ClassDef)
    public = [node for node in tree.body if isinstance(node, kinds) and not node.name.startswith("_")]
    silent = [node.name for node in public if not ast.get_docstring(node)]
    assert not silent, f"{path.name}: {silent} have no docstring"
