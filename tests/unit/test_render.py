"""The picture of the deformed tooth by both renderers, the notice without OpenGL, and the field as VTU."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import meshio
import numpy as np
import pytest
from matplotlib.image import imread
from matplotlib.path import Path as Polygon

from gearfem.compliance import FiniteElements
from gearfem.compliance.field import Field
from gearfem.definition.setup import Rack
from gearfem.flank import Outline, make_flanks
from gearfem.foundation import InputError
from gearfem.pipeline import Results
from gearfem.report import render, write_render, write_vtu
from gearfem.report.outlines import engaged_outlines

# Biquadratic element in VTK's order: corners, mid-sides, centre, as (across, up) on a lattice of nodes.
LATTICE = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1))


@pytest.fixture(scope="module")
def outline(coal_combine):
    return Outline(gear=coal_combine.pair.pinion)


@pytest.fixture(scope="module")
def field(outline) -> Field:
    """A strip of four elements up the tooth that bends by 10 um at its tip, made by hand."""
    gear, columns, rows = outline.gear, 3, 9
    x, y = np.meshgrid(np.linspace(gear.root_radius, gear.tip_radius, rows), np.linspace(-5e-3, 5e-3, columns), indexing="ij")
    nodes = np.stack([x.ravel(), y.ravel()], axis=-1)
    height = (nodes[:, 0] - gear.root_radius) / (gear.tip_radius - gear.root_radius)
    quads = [[(row + up) * columns + across for across, up in LATTICE] for row in range(0, rows - 1, 2)]
    return Field(
        nodes=nodes,
        quads=np.array(quads),
        displacement=np.stack([np.zeros_like(height), -10e-6 * height**2], axis=-1),
        von_mises=200e6 * (1.0 - height),
        load_point=outline.point(2.9),
        load_direction=-outline.normal(2.9),
        force_per_width=350e3,
    )


def test_fallback_draws_and_says_what_to_install(field, outline, tmp_path):
    done = write_render(field, tmp_path / "tooth.png", outline=outline, opengl=False)
    assert done.renderer == "matplotlib"
    assert "libegl1 libgl1-mesa-dri" in done.notice
    picture = imread(done.path)
    assert picture.std() > 0.05
    # By hand: 5 % of 8 mm over 10 um is 40, the next smaller of 1, 2, 5 x 10^k is 20.
    assert done.title == "Line load 350 N/mm; largest displacement away from the load 10 µm, drawn 20 times larger"


def test_pyvista_draws_where_opengl_works(field, outline, tmp_path):
    if not render.opengl_works():
        pytest.skip(render.NO_OPENGL)
    done = write_render(field, tmp_path / "tooth.png", outline=outline)
    assert (done.renderer, done.notice) == ("pyvista", "")
    assert imread(done.path).std() > 0.05


def test_a_renderer_that_dies_is_noticed_without_dying(monkeypatch, field, outline, tmp_path):
    monkeypatch.setattr(render, "_PROBE", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
    render.opengl_works.cache_clear()
    try:
        assert write_render(field, tmp_path / "tooth.png", outline=outline).renderer == "matplotlib"
    finally:
        render.opengl_works.cache_clear()


def test_probe_does_not_run_twice(monkeypatch):
    calls = []
    done = subprocess.CompletedProcess([], 0)
    monkeypatch.setattr(render.subprocess, "run", lambda *args, **kwargs: calls.append(args) or done)
    render.opengl_works.cache_clear()
    try:
        assert render.opengl_works()
        assert render.opengl_works()
    finally:
        render.opengl_works.cache_clear()
    assert len(calls) == 1


def test_without_a_display_vtk_is_told_to_use_egl():
    code = "import os; from gearfem.report import render; render.choose_window(); print(os.environ.get('VTK_DEFAULT_OPENGL_WINDOW'))"
    bare = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "VTK_DEFAULT_OPENGL_WINDOW")}
    for environment, answer in ((bare, "vtkEGLRenderWindow"), ({**bare, "DISPLAY": ":0"}, "None")):
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
        assert done.stdout.strip() == answer


def test_the_stated_displacement_does_not_know_the_mesh_under_the_load(outline):
    shallow, fine = (FiniteElements(resolution=size).field(outline, 2.8, 350e3) for size in (1.5, 6.0))

    def stated(field):
        return float(re.search(r"load ([\d.]+) µm", render._compose(field, outline, 1.0).title)[1])

    def dented(field):
        return np.hypot(*field.displacement.T).max()

    # Both meshes have nodes elsewhere, so that the largest value is met within a few per mille; the dent grows by a tenth.
    assert stated(fine) == pytest.approx(stated(shallow), rel=5e-3, abs=0.0)
    assert dented(fine) > 1.03 * dented(shallow)


def test_long_teeth_stay_below_title_and_note(gear_factory):
    gear = gear_factory(40, 3e-3, 64.8e-3, rack=Rack(addendum=1.6, dedendum=1.85, tip_radius=0.15))
    outline = Outline(gear=gear)
    scene = render._compose(FiniteElements(resolution=1.0).field(outline, 2.98, 1e5), outline, 1.0)
    tail = scene.load_tip - scene.arrow * scene.load_direction
    top = max(scene.outline[:, 1].max(), tail[1])
    # The title and three lines under it end 200 pixels below the upper edge.
    assert (scene.centre[1] + scene.reach - top) / (2.0 * scene.reach) * render.WINDOW[1] >= 199.0


def test_vtu_is_in_millimetres_and_megapascals(field, tmp_path):
    mesh = meshio.read(write_vtu(field, tmp_path / "field.vtu"))
    assert mesh.points[:, 0].max() == pytest.approx(76.17)
    assert mesh.cells[0].type == "quad9"
    assert mesh.point_data["von_mises_MPa"].max() == pytest.approx(200.0)
    # 10 um = 0.01 mm.
    assert mesh.point_data["displacement_mm"][:, 1].min() == pytest.approx(-0.01)


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan")])
def test_impossible_scale_is_refused(field, outline, tmp_path, scale):
    with pytest.raises(InputError, match="a factor above 0"):
        write_render(field, tmp_path / "tooth.png", outline=outline, scale=scale, opengl=False)
    assert not list(tmp_path.iterdir())


def test_smaller_cells_cover_the_element_once(field, outline):
    scene = render._compose(field, outline, 1.0)
    corners = scene.moved[render.parts(scene.quads)]
    ahead = np.roll(corners, -1, axis=1)
    area = 0.5 * np.sum(corners[..., 0] * ahead[..., 1] - corners[..., 1] * ahead[..., 0], axis=1)
    assert (np.sign(area) == np.sign(area[0])).all()
    # The strip is 10 mm wide from 60.4 to 76.17 mm; its displacement shears it and keeps the area.
    assert abs(area.sum()) == pytest.approx(10.0 * (76.17 - field.nodes[:, 0].min() * 1e3), rel=1e-9, abs=0.0)


def test_drawn_gears_touch_at_the_pitch_point_and_nowhere_overlap(coal_combine):
    results = Results(setup=coal_combine, flanks=make_flanks(coal_combine))
    pinion, wheel = engaged_outlines(results)
    pitch_point = np.array([281.57e-3 * 16.0 / 67.0, 0.0])
    for drawn in (pinion, wheel):
        # Half the distance of neighbouring points, which lie 0.34 mm apart on the longer flank.
        assert np.hypot(*(drawn - pitch_point).T).min() < 0.2e-3
    solid = Polygon(np.concatenate([pinion, [[0.0, 0.0]]]))
    near = wheel[np.hypot(*(wheel - pitch_point).T) < 30e-3]
    # The chords of the drawing cut 0.5 um off; the polygon moved in by 2 um must stay clear.
    assert len(near) > 100
    assert not solid.contains_points(near, radius=-2e-6 * orientation(pinion)).any()


def orientation(points: np.ndarray) -> float:
    """Return +1 for a polygon that runs counter-clockwise around the origin, else -1."""
    ahead = np.roll(points, -1, axis=0)
    return float(np.sign(np.sum(points[:-1, 0] * ahead[:-1, 1] - points[:-1, 1] * ahead[:-1, 0])))
