"""Derivatives where a model ends on one side."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.diagnosis.modelling.differences import one_sided, two_sided
from gearfem.foundation import Array, InputError, SolveError


@pytest.mark.parametrize("error", [SolveError("no loads"), InputError("ratio", 0.0, "more"), FloatingPointError("not finite")])
def test_a_model_that_ends_ahead_is_asked_behind(error: Exception) -> None:
    asked = []

    def quotient(step: float) -> Array:
        asked.append(step)
        if step > 0.0:
            raise error
        return np.array([(step**2 + 3.0 * step) / step])

    assert one_sided(quotient, 0.1) == pytest.approx([2.9], rel=1e-12, abs=0.0)
    assert one_sided(quotient, -0.1) == pytest.approx([2.9], rel=1e-12, abs=0.0)
    assert asked == [0.1, -0.1, -0.1]


def test_a_model_that_ends_on_both_sides_has_no_derivative() -> None:
    def quotient(step: float) -> Array:
        raise SolveError(f"none at {step}")

    for difference in (one_sided, two_sided):
        with pytest.raises(SolveError, match=r"none at -0\.1"):
            difference(quotient, 0.1)


@pytest.mark.parametrize(("ends", "found"), [((), 3.0), ((0.1,), 2.9), ((-0.1,), 3.1)], ids=["neither", "ahead", "behind"])
def test_both_sides_count_where_both_can_be_computed(ends: tuple[float, ...], found: float) -> None:
    def quotient(step: float) -> Array:
        if step in ends:
            raise SolveError("no loads")
        return np.array([(step**2 + 3.0 * step) / step])

    assert two_sided(quotient, 0.1) == pytest.approx([found], rel=1e-12, abs=0.0)
