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
PACKAGE = Path(gearfem.__file__).parent
MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def room(path: Path) -> str:
    """Return the name of the package or single-file package that holds a module."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(path: Path) -> set[str]:
    """Return the rooms of gearfem that a module imports, at its top or late."""
    rooms = set()
    for node in ast.walk(ast.parse(path.read_text())):
        names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        rooms |= {name.split(".")[1] for name in names if name.startswith("gearfem.")}
    return rooms


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_upward(path: Path) -> None:
    here = room(path)
    assert here in LINE, f"{here} has no place in the line {LINE}"
    late = {other for other in imported(path) if LINE.index(other) > LINE.index(here)}
    assert not late, f"{path.name} of {here} imports {late}, which come after it"


@pytest.mark.parametrize("path", [*MODULES, PACKAGE / "__init__.py"], ids=lambda path: str(path.relative_to(PACKAGE)))
def test_public_names_explain_themselves(path: Path) -> None:
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree), f"{path.name} has no docstring"
    kinds = (ast.FunctionDef, ast.ClassDef)
    public = [node for node in tree.body if isinstance(node, kinds) and not node.name.startswith("_")]
    silent = [node.name for node in public if not ast.get_docstring(node)]
    assert not silent, f"{path.name}: {silent} have no docstring"
