"""Tongues of instability of the pulsating stiffness against Mathieu's equation, contact loss left out."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import mathieu_a, mathieu_b

from gearfem.dynamics import DriveTrain, uniform_transport
from gearfem.dynamics.cycle import Cycle, Piece, propagator
from gearfem.dynamics.relative import RelativeMotion

RADIUS, TEETH, STIFFNESS, INERTIA = 0.0705, 50, 4e8, 0.0076
NATURAL = math.sqrt(STIFFNESS / (0.5 * INERTIA / RADIUS**2))
DRIVE = DriveTrain(
    pinion_inertia=INERTIA,
    wheel_inertia=INERTIA,
    pinion_torque=150.0,
    wheel_torque=150.0,
    efficiency=1.0,
    pinion_speed=1.0,
    friction_coefficient=0.0,
    damping_ratio=0.0,
)


@pytest.fixture
def monodromy(mesh_factory):
    """The matrix over one mesh cycle of x'' + 2 zeta x' + (1 + depth cos(W t)) x, teeth always on the working flank."""

    def make(tuning, depth, damping=0.0):
        mesh = mesh_factory(TEETH, (RADIUS, RADIUS), lambda phi: STIFFNESS * (1.0 + depth * np.cos(TEETH * phi)), angles=256)
        drive = dataclasses.replace(DRIVE, pinion_speed=tuning * NATURAL / TEETH, damping_ratio=damping)
        system = RelativeMotion(mesh, drive, uniform_transport(mesh, drive))
        steps = np.linspace(0.0, system.length, 201)
        piece = Piece(lambda times: np.ones((4, np.size(times))), steps, 1, 0.0, np.eye(4))
        return propagator(system, Cycle((piece,), 1.0, np.zeros(4)))[:2, :2]

    return make


def boundary(number, depth, which):
    """Return W of one side of a tongue: a = 4/W^2 and q = depth a/2 on Mathieu's characteristic curve."""
    curve = mathieu_a if which == "a" else mathieu_b
    return brentq(lambda w: 4.0 / w**2 - curve(number, 2.0 * depth / w**2), 1.7 / number, 2.6 / number)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_tongues_lie_where_mathieus_do(monodromy, number):
    """On a boundary the trace is 2 (-1)^k; inside beyond it, outside within; the tongue near W = 2/k."""
    depth, sign = 0.4, (-1.0) ** number
    low, high = sorted(boundary(number, depth, which) for which in "ab")
    traces = [sign * np.trace(monodromy(w, depth)) for w in (low, high, 0.5 * (low + high), low - (high - low), high + (high - low))]
    print(f"tongue {number}: W from {low:.5f} to {high:.5f}, trace at the edges less 2: {traces[0] - 2.0:.1e}, {traces[1] - 2.0:.1e}")
    # Tables over 256 angles and 200 steps, both of fourth order; the trace is flat beside an edge of a narrow tongue.
    assert np.allclose(traces[:2], 2.0, atol=1e-7)
    assert traces[2] > 2.0
    assert max(traces[3:]) < 2.0


def test_first_tongue_is_as_wide_as_the_pulsation(monodromy):
    """First order: W = 2 -+ depth/2, found by the trace alone."""
    for depth in (0.03, 0.08):
        edges = [brentq(lambda w, depth=depth: np.trace(monodromy(w, depth)) + 2.0, 2.0, 2.0 + side * depth, xtol=1e-7) for side in (-1, 1)]
        # The next terms are depth^2 of the place and depth^3 of the width.
        assert edges[1] - edges[0] == pytest.approx(depth, rel=depth**2, abs=0.0)
        assert 0.5 * (edges[0] + edges[1]) == pytest.approx(2.0, abs=depth**2)


def test_damping_lifts_the_tongue(monodromy):
    """At W = 2 the growth is exp((depth/4 - zeta) pi) per cycle to first order: no instability below depth = 4 zeta."""
    for depth, zeta in ((0.12, 0.02), (0.04, 0.02)):
        growth = np.abs(np.linalg.eigvals(monodromy(2.0, depth, zeta))).max()
        # Of second order: depth^2, zeta^2.
        assert math.log(growth) == pytest.approx((0.25 * depth - zeta) * math.pi, abs=depth**2)
        assert (growth > 1.0) == (depth > 4.0 * zeta)
