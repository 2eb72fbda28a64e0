"""Records: what they show when printed, and digests of their content."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gearfem.effects.centre_distance import CentreDistance
from gearfem.effects.effect import Effect
from gearfem.effects.pitch_error import PitchError
from gearfem.foundation import Array, Record, digest


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Trace(Record):
    """A record with some of everything."""

    file: str
    torque: float
    values: Array
    empty: Array
    parts: tuple[Record, ...] = ()

    @property
    def sentence(self) -> str:
        """The trace in words."""
        return f"trace {self.file}"


def trace(file: str = "a.csv", parts: tuple[Record, ...] = ()) -> Trace:
    return Trace(file=file, torque=12.5, values=np.linspace(-1.0, 3.0, 50), empty=np.empty(0), parts=parts)


def test_a_printed_record_is_brief() -> None:
    words = str(trace(parts=tuple(trace(f"{number}.csv") for number in range(9))))
    assert words.splitlines() == [
        "Trace",
        "  file: a.csv",
        "  torque: 12.5",
        "  values: array (50,), -1 to 3",
        "  empty: array (0,)",
        "  parts: 9: trace 0.csv; trace 1.csv; trace 2.csv; trace 3.csv; trace 4.csv; trace 5.csv; ...",
    ]
    assert str(trace()).endswith("parts: none")


def test_a_digest_is_that_of_the_content_whoever_holds_it() -> None:
    one = trace(parts=(trace("b.csv"),))
    before = digest(one)
    assert digest(one) == before == digest(trace(parts=(trace("b.csv"),)))
    assert digest(dataclasses.replace(one, torque=12.6)) != before
    assert digest(dataclasses.replace(one, parts=(trace("c.csv"),))) != before


@pytest.mark.parametrize(
    ("effect", "words"),
    [
        (PitchError(gear="wheel", tooth=3, amount=-4e-6), "Pitch error of tooth 3 of the wheel: 4 um early"),
        (PitchError(gear="wheel", tooth=3, amount=4e-6), "Pitch error of tooth 3 of the wheel: 4 um late"),
        (CentreDistance(amount=-20e-6), "Centre distance smaller by 20 um"),
    ],
)
def test_effects_are_told_in_words_that_go_by_their_sign(effect: Effect, words: str) -> None:
    assert effect.describe() == words
    assert f"parts: 1: {words}" in repr(trace(parts=(effect,)))
