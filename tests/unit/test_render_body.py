"""The picture that reaches down to the bore, and the scale that a picture states."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.compliance import FiniteElements
from gearfem.flank import Outline
from gearfem.foundation import InputError
from gearfem.report import render, write_render


def test_body_picture_shows_bore_and_all_sectors(coal_combine, tmp_path):
    outline = Outline(gear=coal_combine.pair.pinion)
    field = FiniteElements(resolution=1.0).field(outline, 2.8, 350e3, neighbours=2)
    scene = render._compose(field, outline, None, body=True)
    across, up = np.abs(scene.moved - scene.centre).max(axis=0)
    # Everything lies inside the window, whose half height is the reach; in the picture of the tooth it does not.
    assert up < scene.reach
    assert across < scene.reach * render.WINDOW[0] / render.WINDOW[1]
    near = render._compose(field, outline, None)
    assert np.abs(near.moved - near.centre).max() > near.reach
    assert write_render(field, tmp_path / "body.png", outline=outline, opengl=False, body=True).path.stat().st_size > 10_000


def test_titles_state_the_scale():
    # By hand: 16 um at 5 % of 8 mm would be 25, the next smaller of 1, 2, 5 x 10^k is 20.
    assert render.drawn_scale(None, 8e-3, 16e-6) == 20.0
    assert render.describe(350e3, 16e-6, 20.0) == "Line load 350 N/mm; largest displacement away from the load 16 µm, drawn 20 times larger"
    assert (
        render.describe(350e3, 16e-6, 1.0) == "Line load 350 N/mm; largest displacement away from the load 16 µm, drawn at its true scale"
    )
    with pytest.raises(InputError, match="scale"):
        render.drawn_scale(-1.0, 8e-3, 16e-6)
