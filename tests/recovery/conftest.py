"""Pairs and campaigns: of the blind generator, and from the virtual rig."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gearfem.diagnosis import Diagnosis, choose, diagnose, read_campaign
from gearfem.effects.catalogue import catalogue

from .generator import make_case
from .generator.campaign import Case
from .generator.gear import make_pair
from .generator.system import Scatter, System
from .generator.tooth import ContactLaw
from .rig import HIDDEN, on_the_rig

TORQUE = 74.0


@pytest.fixture(scope="module")
def healthy() -> System:
    """A 23/41 pair of module 2.5 mm and 25 mm width at 74 N m: smooth teeth, solid discs."""
    pair = make_pair((23, 41), 2.5e-3, (0.0, 0.0), 25e-3, (0.5, 0.5), 0.1e-3)
    discs = (pair.pinion.disc_inertia(pair.width), pair.wheel.disc_inertia(pair.width))
    return System(pair, Scatter.none(pair), TORQUE, 0.06, discs)


@pytest.fixture(scope="module")
def shifted() -> System:
    """A shifted 19/50 pair with friction, scatter and the logarithmic contact law."""
    pair = make_pair((19, 50), 4e-3, (0.4, 0.1), 36e-3, (0.45, 0.4), 0.1e-3)
    discs = (pair.pinion.disc_inertia(pair.width), pair.wheel.disc_inertia(pair.width))
    scatter = Scatter.draw(pair, np.random.default_rng(4))
    return System(pair, scatter, 300.0, 0.06, discs, friction=0.08, contact=ContactLaw(None))


@pytest.fixture(scope="module")
def mixed() -> Case:
    """A campaign with one effect, the way the study asks for it."""
    return make_case((11, 2), "single", "tip_relief", "easy")


@pytest.fixture(scope="session")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Measure a pair with tip relief on the virtual rig; return the campaign file."""
    return on_the_rig(tmp_path_factory.mktemp("campaign"), {"effect": [HIDDEN], "calibration": {"stiffness_scale": 1.02}})


@pytest.fixture(scope="session")
def found(campaign: Path) -> Diagnosis:
    return diagnose(read_campaign(campaign), choose(catalogue(), ["tip_relief"]))
