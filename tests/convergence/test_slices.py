"""Loads along the face width converge with the number of slices."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gearfem.compliance import Root, SolidElements
from gearfem.engagement.engage import engage
from gearfem.engagement.width import FaceSlices
from gearfem.engagement.width_load import load_over_width
from gearfem.flank.lead import Lead
from gearfem.pipeline import run


@pytest.mark.slow
def test_error_and_load_factor_converge(small_pair) -> None:
    """A tilt that leaves the end of the face unloaded: its edge moves by parts of a slice, so the order is not even."""
    mesh = run(small_pair, until="compliance").mesh
    angle = np.array([0.0, 0.5]) * mesh.placement.pair.pinion.pitch_angle
    flanks = dataclasses.replace(mesh.flanks, lead=Lead().plus(lambda place: 20e-6 * (place + 0.5)))
    error, factor = [], []
    for count in (4, 8, 16):
        slices = FaceSlices(count=count, positions=2, method=SolidElements(support=Root(), resolution=0.5, layers=4))
        tilted = dataclasses.replace(mesh, flanks=flanks, slices=slices)
        loaded = engage(tilted, angle, 50.0)
        error.append(loaded.transmission_error)
        factor.append(load_over_width(tilted, loaded).face_load_factor)
    off = {name: [np.abs(one / values[-1] - 1.0).max() for one in values[:-1]] for name, values in (("TE", error), ("K_Hbeta", factor))}
    print(f"against 16 slices: {off}")
    assert off["TE"][1] < 0.5 * off["TE"][0]
    assert off["TE"][1] < 3e-3
    assert off["K_Hbeta"][1] < 0.5 * off["K_Hbeta"][0]
    assert off["K_Hbeta"][1] < 0.03
