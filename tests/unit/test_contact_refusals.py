"""What the laws of contact refuse, and the sign of friction."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.contact import Coulomb, HertzLine
from gearfem.definition.setup import Material
from gearfem.foundation import InputError

LAW = HertzLine(pinion=Material(), wheel=Material())


@pytest.mark.parametrize(
    ("arguments", "where"),
    [
        ((-1.0, 0.02, 0.01, 0.01), "force_per_width"),
        ((np.nan, 0.02, 0.01, 0.01), "force_per_width"),
        ((1e5, 0.0, 0.01, 0.01), "radius"),
        ((1e5, -0.02, 0.01, 0.01), "radius"),
        ((1e5, np.inf, 0.01, 0.01), "radius"),
        ((1e5, 0.02, -0.01, 0.01), "depth1"),
        ((1e5, 0.02, 0.01, -0.01), "depth2"),
    ],
)
def test_impossible_contacts_are_refused(arguments, where):
    for law in (LAW.approach, LAW.compliance):
        with pytest.raises(InputError, match=f"^{where}: "):
            law(*arguments)


def test_arguments_broadcast():
    approach = LAW.approach(np.array([0.0, 1e5])[:, None], [0.01, 0.02, 0.03], 0.01, [0.01, 0.01, 0.02])
    assert approach.shape == (2, 3)
    assert (approach[0] == 0.0).all()
    assert approach[1, 2] == LAW.approach(1e5, 0.03, 0.01, 0.02)


def test_a_point_on_the_surface_does_not_approach():
    """The part of a body above depth 0 is nothing."""
    assert LAW.approach(1e5, 0.02, 0.0, 0.0) == 0.0


def test_friction_has_the_sign_of_the_sliding():
    force = Coulomb().force([100.0, 100.0, 0.0], [-2.0, 3.0, 1.0], 0.08)
    np.testing.assert_allclose(force, [-8.0, 8.0, 0.0], rtol=1e-15)


@pytest.mark.parametrize(
    ("arguments", "where"), [((-1.0, 1.0, 0.1), "normal_force"), ((1.0, np.nan, 0.1), "sliding"), ((1.0, 1.0, -0.1), "coeff")]
)
def test_impossible_friction_is_refused(arguments, where):
    with pytest.raises(InputError, match=f"^{where}"):
        Coulomb().force(*arguments)
