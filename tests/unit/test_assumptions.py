"""What the report says is taken for granted holds for the system that was computed."""

from __future__ import annotations

import pytest

from gearfem.assembly import assemble
from gearfem.assumptions import EVEN, SLICED, UNIFORM, of_system
from gearfem.effects.crowning import Crowning
from gearfem.effects.pitch_error import PitchError
from gearfem.effects.support_compliance import SupportCompliance


def test_a_plain_pair_is_rigid_even_and_evenly_loaded(coal_combine) -> None:
    sentences = of_system(assemble(coal_combine))
    assert UNIFORM in sentences
    assert EVEN in sentences
    assert any("bearings are rigid." in sentence for sentence in sentences)


@pytest.mark.parametrize(
    ("effect", "said", "unsaid"),
    [
        (Crowning(gear="wheel", amount=1e-5), SLICED, UNIFORM),
        (PitchError(gear="wheel", tooth=3, amount=1e-5), UNIFORM, EVEN),
        (SupportCompliance(pinion=1e-9, wheel=0.0), "yield wherever there is load, at speed with the masses of the gears", "are rigid"),
    ],
)
def test_an_effect_takes_back_what_it_breaks(coal_combine, effect, said, unsaid) -> None:
    text = " ".join(of_system(assemble(coal_combine, [effect])))
    assert said in text
    assert unsaid not in text
