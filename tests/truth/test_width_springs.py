"""Slices on separate springs against the closed forms of a tilted row of springs, which are those of K_Hbeta in ISO 6336-1."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gearfem.contact import Line
from gearfem.engagement.width import SlicedPair, largest
from gearfem.foundation import Array

LOAD = 2e5
SPRING = 4e-11


class LinearLaw:
    """A contact that yields in proportion to its load."""

    def approach(self, force: Array, *_: object) -> Array:
        return 1e-11 * force

    def respond(self, force: Array, *_: object) -> tuple[Array, Array]:
        return self.approach(force), np.full_like(force, 1e-11)


def tilted(slope: float, count: int) -> tuple[float, float, np.ndarray]:
    """Return load factor, approach and line loads of separate springs under a gap that opens by `slope` over the width."""
    pair = SlicedPair(matrix=(SPRING - 1e-11) * np.eye(count)[None], line=Line(*np.full((5, 1), 1e-3)))
    gap = slope * (np.arange(count) + 0.5) / count
    load, approach = pair.load(LinearLaw(), np.array([LOAD]), gap)
    return float(largest(load)[0] / LOAD), float(approach[0]), load[0]


@pytest.mark.parametrize("part", [0.0, 0.3, 1.0])
def test_whole_width_in_contact(part: float) -> None:
    """K = 1 + c F_beta/(2 F_m/b) up to 2, ISO 6336-1: exact at any number of slices."""
    slope = 2.0 * part * SPRING * LOAD
    factor, approach, load = tilted(slope, 8)
    assert factor == pytest.approx(1.0 + slope / (2.0 * SPRING * LOAD), rel=1e-11, abs=0.0)
    assert approach == pytest.approx(SPRING * LOAD + slope / 2.0, rel=1e-11, abs=0.0)
    assert load.min() > 0.0


@pytest.mark.parametrize("part", [2.0, 6.0])
def test_part_of_the_width_in_contact(part: float) -> None:
    """K = sqrt(2 c F_beta/(F_m/b)) above 2, the load a triangle over 2/K of the width."""
    slope = 2.0 * part * SPRING * LOAD
    exact = math.sqrt(2.0 * slope / (SPRING * LOAD))
    for count in (20, 40, 80):
        factor, approach, load = tilted(slope, count)
        touching = 2.0 / exact * count
        assert np.count_nonzero(load) == pytest.approx(touching, abs=1.0)
        # The edge of the contact lies within a slice: a triangle of m slices errs by at most 1/(8 m^2).
        assert factor == pytest.approx(exact, rel=0.125 / touching**2, abs=0.0)
        assert approach == pytest.approx(exact * SPRING * LOAD, rel=0.125 / touching**2, abs=0.0)
