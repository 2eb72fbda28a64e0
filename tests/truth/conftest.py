"""What several tests of motions over turns share."""

from __future__ import annotations

import dataclasses

import pytest

from gearfem.compliance import make_compliance
from gearfem.contact import EdgedLine
from gearfem.engagement import Mesh
from gearfem.engagement.turns import Turns
from gearfem.flank import make_flanks
from gearfem.placement import make_placement


@pytest.fixture(scope="module")
def mesh(small_pair) -> Mesh:
    """The small pair with play."""
    flanks, pair = make_flanks(small_pair), small_pair.pair
    law = EdgedLine(pinion=pair.pinion.material, wheel=pair.wheel.material)
    placement = dataclasses.replace(make_placement(small_pair), normal_backlash=50e-6)
    return Mesh(flanks=flanks, placement=placement, compliance=make_compliance(flanks), law=law)


@pytest.fixture(scope="module")
def turns(mesh) -> Turns:
    """The same over any number of turns."""
    return Turns(mesh=mesh)
