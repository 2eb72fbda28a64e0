"""An encoder whose reading swings twice a turn: nothing of the gears, and nothing that any effect stands for."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gearfem.diagnosis import choose, compare, name, read_campaign
from gearfem.diagnosis.fitting.fit import Fit
from gearfem.diagnosis.fitting.index_errors import turns_often
from gearfem.diagnosis.fitting.problem import Problem
from gearfem.diagnosis.naming.name import NOTHING_SOUGHT
from gearfem.diagnosis.naming.naming import Naming
from gearfem.effects.catalogue import catalogue
from gearfem.effects.effect import Effect
from tests.recovery.rig import PLAN, on_the_rig


def _swinging(campaign: Path, amplitude: float, order: int) -> Path:
    """Add a wave of the pinion to all that a campaign measures [um]."""
    for file in campaign.parent.glob("te_*.csv"):
        *words, head = (line for line in file.read_text().splitlines() if not line[0].isdigit())
        angle, error = np.loadtxt(file, delimiter=",", skiprows=len(words) + 1).T
        swung = np.column_stack([angle, error + amplitude * np.cos(order * angle + 0.4)])
        np.savetxt(file, swung, fmt="%.9g", delimiter=",", header="\n".join([*words, head]), comments="")
    return campaign


def test_a_reading_that_swings_twice_a_turn_is_explained_by_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And nothing of all teeth is sought: it stays under whatever they have, and would mislead."""
    plan = PLAN | {"record": [record for record in PLAN["record"] if record["pinion_torque_Nm"] in (40.0, 120.0)]}
    comparison = compare(read_campaign(_swinging(on_the_rig(tmp_path, {}, plan), 25.0, 2)))
    assert turns_often(comparison.problem, comparison.alone)
    sought, module = [], sys.modules["gearfem.diagnosis.naming.name"]
    select: Any = module.select

    def watched(problem: Problem, alone: Fit, kinds: Mapping[str, type[Effect]], *other: Any) -> Naming:
        sought.extend(kinds)
        return select(problem, alone, kinds, *other)

    monkeypatch.setattr(module, "select", watched)
    naming = name(comparison.problem, comparison.alone, choose(catalogue(), ["tip_relief", "runout", "sensor_gain"]))
    assert naming.verdict == "unexplained"
    assert not naming.fit.effects
    assert sought == ["runout"]
    assert f"All teeth: {NOTHING_SOUGHT}" in naming.reasons
    assert not any(reason.startswith("All teeth: The best explanation gains") for reason in naming.reasons)
    assert any("a wave of the index errors of the pinion" in reason for reason in naming.reasons)
