"""A late tooth that meets one other only: either gear may have it, and it is no chance."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.diagnosis import read_campaign
from gearfem.diagnosis.comparing.averages import teeth_under
from gearfem.diagnosis.comparing.compare import compare
from gearfem.diagnosis.naming.naming import Naming
from gearfem.diagnosis.naming.select import select
from gearfem.effects.pitch_error import PitchError
from tests.recovery.rig import PLAN, TORQUES, on_the_rig

LATE = {"name": "pitch_error", "gear": "wheel", "tooth": 5, "amount_um": 7.0}


@pytest.fixture(scope="module")
def naming(tmp_path_factory: pytest.TempPathFactory) -> Naming:
    """Search records of less than a turn for one late tooth."""
    records = [record | {"turns": 0.88} for record in PLAN["record"]]
    campaign = read_campaign(on_the_rig(tmp_path_factory.mktemp("once"), {"effect": [LATE]}, PLAN | {"record": records[: len(TORQUES)]}))
    found = compare(campaign)
    return select(*teeth_under(found.problem, found.alone.settings, ()), {"pitch_error": PitchError})


def test_either_gear_may_have_a_tooth_that_meets_one_other_only(naming: Naming) -> None:
    assert naming.verdict == "ambiguous"
    near = [rival.effects for rival in naming.rivals if rival.near]
    assert {(effect.gear, effect.tooth) for (effect,) in (naming.fit.effects, *near) if isinstance(effect, PitchError)} == {
        ("pinion", 5),
        ("wheel", 5),
    }


def test_a_fit_knows_half_of_either_tooth(naming: Naming) -> None:
    """Of the sum of two errors known exactly each is known to the root of a half, and what no record meets not at all."""
    told = naming.alone.told
    assert told[[5, 13 + 5]] == pytest.approx(np.sqrt(0.5), rel=0.1, abs=0.0)
    assert told[13 + 15] < 0.1
