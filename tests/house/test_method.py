"""The text on the method of the diagnosis states the limits that the code has, and knows all of its modules."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "gearfem" / "diagnosis"
TEXT = (FOLDER / "README.md").read_text(encoding="utf-8")
# Module and constant in the last cell of a row, a number and its unit at the beginning of the second one.
CONSTANT = re.compile(r"`([a-z_.]+)\.([A-Z][^`]*)`")
VALUE = re.compile(r"(\d+(?:\.\d+)?)\s*(%|um\b)?")
UNITS = {"%": 0.01, "um": 1e-6}
# To the digits that the text shows.
SHOWN = 2e-3


def limits() -> list[tuple[str, str]]:
    """Return second and last cell of each row of a table that ends in a constant."""
    rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in TEXT.splitlines() if line.startswith("|"))
    return [(row[1], row[-1]) for row in rows if CONSTANT.fullmatch(row[-1])]


def stated(cell: str) -> float:
    """Return the number at the beginning of a cell [SI]."""
    found = VALUE.match(cell)
    assert found, f'"{cell}" begins with no number'
    return float(found[1]) * UNITS.get(found[2], 1.0)


def in_code(constant: str) -> float:
    """Return the value of a constant, of a module of the diagnosis or else of gearfem."""
    found = CONSTANT.fullmatch(constant)
    assert found
    own = next((path.relative_to(FOLDER.parent).with_suffix("") for path in FOLDER.rglob(f"{found[1]}.py")), Path(found[1]))
    return float(eval(found[2], vars(importlib.import_module(".".join(("gearfem", *own.parts))))))


@pytest.mark.parametrize(("value", "constant"), limits(), ids=lambda cell: str(cell).strip("`"))
def test_method_states_the_limits_of_the_code(value: str, constant: str) -> None:
    assert stated(value) == pytest.approx(in_code(constant), rel=SHOWN, abs=0.0)


def test_method_finds_its_limits() -> None:
    assert len(limits()) >= 40


def test_method_knows_every_module() -> None:
    missing = [path.stem for path in FOLDER.rglob("*.py") if path.stem != "__init__" and f"`{path.stem}`" not in TEXT]
    assert not missing, f"the text has no place for {missing}"
