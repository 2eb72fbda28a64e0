"""What the law of contact over a tip edge refuses, and the shapes it takes."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.contact import EdgedLine, Line
from gearfem.definition.setup import Material
from gearfem.foundation import InputError

LAW = EdgedLine(pinion=Material(), wheel=Material())
GOOD = Line(*map(np.array, (0.029, 3e-3, 2e-3, 1e-5, 0.16e-3)))


@pytest.mark.parametrize(
    ("force", "changed"),
    [
        (-1.0, {"force_per_width": None}),
        (np.nan, {"force_per_width": None}),
        (1e5, {"radius": 0.0}),
        (1e5, {"radius": np.inf}),
        (1e5, {"edge_radius": 0.0}),
        (1e5, {"edge_radius": -1e-4}),
        (1e5, {"edge": np.nan}),
        (1e5, {"edge": np.inf}),
        (1e5, {"depth1": -1e-3}),
        (1e5, {"depth2": np.nan}),
    ],
)
def test_impossible_contacts_are_refused(force, changed):
    (name,) = changed
    line = GOOD if name == "force_per_width" else GOOD._replace(**{name: np.array(changed[name])})
    for law in (LAW.approach, LAW.compliance):
        with pytest.raises(InputError, match=f"^{name}: "):
            law(force, line)


def test_lines_broadcast_against_loads():
    line = GOOD._replace(edge=np.array([-1e-5, 0.0, 1e-3]))
    approach = LAW.approach(np.array([0.0, 1e5])[:, None], line)
    assert approach.shape == (2, 3)
    assert approach[1, 0] == LAW.approach(1e5, GOOD._replace(edge=np.array(-1e-5)))


def test_a_blunter_edge_is_stiffer():
    radii = np.array([1e-5, 1e-4, 1e-3, 1e-2])
    approach = LAW.approach(3e5, GOOD._replace(edge=np.array(0.0), edge_radius=radii))
    assert (np.diff(approach) < 0.0).all()
