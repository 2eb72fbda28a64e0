"""`python -m tests.recovery.generator --out FOLDER --seed N --cases M [--kind KIND] [--effect NAME] [--level LEVEL]`."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from . import make_case, write_case
from .campaign import KINDS
from .hidden import HIDDEN
from .sizes import SINGLE
from .twins import TWINS

# One round of a mixed campaign: kind and level.
MIX = (
    ("single", "easy"),
    ("single", "medium"),
    ("none", None),
    ("single", "easy"),
    ("hidden", None),
    ("double", None),
    ("single", "medium"),
    ("twins", None),
    ("weak", None),
    ("single", "easy"),
)


def main() -> None:
    """Write cases, numbered from 0; the same seed and number give the same files however many are asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.recovery.generator", description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--cases", type=int, required=True)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--kind", choices=("mix", *KINDS), default="mix")
    parser.add_argument("--effect", choices=sorted({*SINGLE, *HIDDEN, *TWINS}))
    parser.add_argument("--level", choices=("easy", "medium"))
    asked = parser.parse_args()
    names = {"single": list(SINGLE), "hidden": list(HIDDEN), "twins": list(TWINS), "weak": list(SINGLE)}
    for number in range(asked.first, asked.first + asked.cases):
        kind, level = (asked.kind, asked.level) if asked.kind != "mix" else MIX[number % len(MIX)]
        turn = number if asked.kind != "mix" else number // len(MIX) * sum(k == kind for k, _ in MIX) + _before(kind, number)
        effect = asked.effect or (names[kind][turn % len(names[kind])] if kind in names else None)
        start = time.perf_counter()
        case = make_case((asked.seed, number), kind, effect, level)
        write_case(case, asked.out, f"case_{number:04d}")
        print(f"case_{number:04d}  {kind:7s} {case.label['level']:7s} {time.perf_counter() - start:5.1f} s", flush=True)


def _before(kind: str, number: int) -> int:
    return sum(k == kind for k, _ in MIX[: number % len(MIX)])


if __name__ == "__main__":
    main()
