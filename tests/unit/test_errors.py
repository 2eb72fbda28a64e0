"""What refusals offer in the place of a name that is none."""

import pytest

from gearfem.diagnosis import choose
from gearfem.effects.catalogue import catalogue
from gearfem.foundation import InputError
from gearfem.foundation.errors import nearest

NAMES = ("tip_relief", "runout", "pitting")


@pytest.mark.parametrize(
    ("word", "allowed"),
    [
        ("runnout", "runout (the nearest valid name)"),
        ("relief", "tip_relief (the nearest valid name)"),
        ("tip", "tip_relief (the nearest valid name)"),
        ("nothing", "tip_relief, runout, pitting"),
        ("", "tip_relief, runout, pitting"),
    ],
)
def test_a_name_that_is_near_is_offered_and_all_where_none_is(word, allowed):
    assert nearest(word, NAMES) == allowed


def test_a_word_like_no_effect_is_answered_by_all_effects():
    with pytest.raises(InputError, match=r"backlash, body_compliance, .*, torque_ripple"):
        choose(catalogue(), only="nothing")
