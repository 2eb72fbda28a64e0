"""The pictures of the deformed tooth, in small mode, with and without OpenGL."""

from __future__ import annotations

import importlib

import numpy as np
import pytest
from matplotlib.image import imread

from gearfem.compliance import Root
from gearfem.compliance.solid import SolidElements
from gearfem.flank import Outline
from gearfem.report import render
from gearfem.report.render_solid import NO_OPENGL_3D, surface


@pytest.fixture
def study():
    return importlib.import_module("deformation_render")


@pytest.mark.slow
def test_pictures_state_scale_and_unit(study, tmp_path, capsys):
    if not render.opengl_works():
        pytest.skip("no off-screen OpenGL on this machine; the other test covers it")
    done = study.main(["--out", str(tmp_path), "--small"])
    assert [picture.path.name for picture in done] == [
        "pinion_2d_true.png",
        "pinion_2d_enlarged.png",
        "pinion_3d_enlarged.png",
    ]
    for picture in done:
        colours = imread(picture.path)[..., :3]
        # Anything but an empty page: the body covers at least a twentieth of it.
        assert (np.ptp(colours, axis=2) > 0.2).mean() > 0.05, picture.path.name
        assert "355.8 N/mm" in picture.title
        assert ("true scale" in picture.title) == ("true" in picture.path.name)
    assert render.BAR.endswith("MPa")
    # The torque over base radius and face width, 1605/(60.140 mm x 75 mm), by hand.
    assert "line load 355.8 N/mm" in capsys.readouterr().out


def test_without_opengl_plane_pictures_fall_back_and_solid_ones_are_left_out(study, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(render, "opengl_works", lambda: False)
    monkeypatch.setattr(study, "opengl_works", lambda: False)
    done = study.main(["--out", str(tmp_path), "--small"])
    assert {picture.renderer for picture in done} == {"matplotlib"}
    assert not list(tmp_path.glob("*3d*"))
    printed = capsys.readouterr().out
    assert printed.count(render.NO_OPENGL) == 1
    assert NO_OPENGL_3D in printed


def test_surface_of_a_solid_is_closed(coal_combine):
    mesh = SolidElements(support=Root(), resolution=0.5, layers=4).mesh(Outline(gear=coal_combine.pair.pinion), 0.02)
    faces = surface(mesh.hexes)
    # Every edge of a closed surface belongs to two faces, run in opposite directions: outward normals all round.
    edges = np.concatenate([faces[:, [i, (i + 1) % 4]] for i in range(4)])
    forward, back = {tuple(edge) for edge in edges}, {tuple(edge[::-1]) for edge in edges}
    assert len(forward) == len(edges)
    assert forward == back
    # Volume by the divergence theorem over the corners: positive if the normals point outwards.
    corner = mesh.nodes[faces[:, :4]]
    volume = np.einsum("ij,ij->", corner.mean(axis=1), 0.5 * np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])) / 3.0
    assert volume > 0.0
