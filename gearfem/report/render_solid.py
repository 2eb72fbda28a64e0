"""Pictures of the deformed, loaded tooth in three dimensions, still or turning, by pyvista without a display."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearfem.compliance.solid_field import SolidField
from gearfem.flank import Outline
from gearfem.foundation import Array, SolveError
from gearfem.foundation.files import whole
from gearfem.foundation.units import MM, MPA
from gearfem.report.outlines import teeth_around
from gearfem.report.render import (
    AWAY,
    BAR,
    LIMIT,
    PACKAGES,
    WINDOW,
    Rendering,
    choose_window,
    counted,
    describe,
    drawn_scale,
    loops,
    opengl_works,
    parts,
)

NO_OPENGL_3D = (
    "Off-screen OpenGL is not available here, so the pictures in three dimensions were left out; all results are the same. "
    f"On Debian or Ubuntu, 'apt-get install {PACKAGES}' provides it."
)
# Faces of VTK's triquadratic hexahedron (cell type 29): corners, mid-sides, centre.
FACES = np.array(
    [
        (0, 3, 2, 1, 11, 10, 9, 8, 24),
        (4, 5, 6, 7, 12, 13, 14, 15, 25),
        (0, 1, 5, 4, 8, 17, 12, 16, 22),
        (1, 2, 6, 5, 9, 18, 13, 17, 21),
        (2, 3, 7, 6, 10, 19, 14, 18, 23),
        (3, 0, 4, 7, 11, 16, 15, 19, 20),
    ]
)
HELD = {
    "bore": "whole gear held at its bore, one sector shown",
    "root": "tooth held at its root arc",
    "root_chord": "tooth held at its root chord",
}
# Towards the viewer from the tooth: the loaded flank, to the left, and the front end of the face are both in sight.
VIEW = np.array([-1.0, 0.55, 1.25])
ARROWS, FRAMES, GIF_WINDOW = 7, 36, (700, 625)


class _Scene(NamedTuple):
    """What is drawn, in mm and MPa, the tooth upright, the face width towards the viewer."""

    nodes: Array
    faces: NDArray[Any]
    stress: Array
    limit: float
    outlines: tuple[Array, Array]
    load_tips: Array
    load_direction: Array
    module: float
    title: str


def write_solid_render(
    field: SolidField, out_png: Path, *, outline: Outline, scale: float | None = None, turning: Path | None = None
) -> Rendering:
    """Draw the deformed tooth in three dimensions, coloured by von Mises stress, with its undeformed outline at both ends.

    Parameters
    ----------
    field : SolidField
        Displacement and stress.
    out_png : Path
        Target file.
    outline : Outline
        Outline of the undeformed tooth.
    scale : float, optional
        Factor by which displacements are enlarged; by default as for `write_render`.
    turning : Path, optional
        GIF of the same tooth turning once about its axis.

    Returns
    -------
    Rendering
        The picture, its title and the renderer.

    Raises
    ------
    InputError
        If the scale is not positive.
    SolveError
        If off-screen OpenGL is missing; `opengl_works` tells beforehand.
    """
    if not opengl_works():
        raise SolveError(NO_OPENGL_3D)
    scene = _compose(field, outline, scale)
    plotter = _plotter(scene, WINDOW)
    with whole(Path(out_png)) as temporary:
        plotter.screenshot(str(temporary))
    plotter.close()
    if turning is not None:
        _turn(scene, Path(turning))
    return Rendering(Path(out_png), scene.title, "pyvista", "")


def surface(hexes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the faces that belong to one hexahedron only, shape (k, 9): corners, mid-sides, centre."""
    faces = hexes[:, FACES].reshape(-1, 9)
    _, first, count = np.unique(np.sort(faces[:, :4], axis=1), axis=0, return_index=True, return_counts=True)
    outside: NDArray[np.int64] = faces[first[count == 1]]
    return outside


def _compose(field: SolidField, outline: Outline, scale: float | None) -> _Scene:
    module, places = outline.gear.module, field.mesh.nodes
    far = np.hypot(*(places[:, :2] - field.load_line[0, :2]).T) > AWAY * module
    largest = float(np.linalg.norm(field.displacement[far], axis=1).max())
    scale = drawn_scale(scale, module, largest)
    start, stop = places[:, 2].min(), places[:, 2].max()
    profile = teeth_around(outline, 0)
    # A hair outside each end, or the surface would cover the line.
    ends = [np.column_stack([profile, np.full(len(profile), z)]) for z in (start - 1e-3 * module, stop + 1e-3 * module)]
    tips = np.linspace(field.load_line[0], field.load_line[1], ARROWS)
    width = f"face width {(stop - start) / MM:.4g} mm, {HELD.get(field.mesh.support, field.mesh.support)}"
    return _Scene(
        nodes=_upright(places + scale * field.displacement) / MM,
        faces=surface(field.mesh.hexes),
        stress=field.von_mises / MPA,
        limit=float(field.von_mises[far].max()) / MPA,
        outlines=(_upright(ends[0]) / MM, _upright(ends[1]) / MM),
        load_tips=_upright(tips) / MM,
        load_direction=_upright(field.load_direction),
        module=module / MM,
        title=f"{describe(field.force_per_width, largest, scale)}; {width}",
    )


def _upright(vectors: Array) -> Array:
    """Turn the tooth's axis from x to up; its described side y > 0 comes to lie on the left."""
    return np.stack([-vectors[..., 1], vectors[..., 0], vectors[..., 2]], axis=-1)


def _plotter(scene: _Scene, window: tuple[int, int]) -> Any:
    choose_window()
    pyvista: Any = importlib.import_module("pyvista")
    size = window[1] / WINDOW[1]
    plotter = pyvista.Plotter(off_screen=True, window_size=window)
    plotter.set_background("white")
    mesh = pyvista.PolyData(scene.nodes, faces=counted(parts(scene.faces)))
    mesh.point_data[BAR] = scene.stress
    bar = {"title": BAR.replace(", ", ",\n") + "\n", "vertical": True, "position_x": 0.87, "position_y": 0.55, "width": 0.07, "height": 0.3}
    bar |= {"color": "black", "n_labels": 5, "fmt": "%.0f", "title_font_size": int(26 * size), "label_font_size": int(26 * size)}
    actor = plotter.add_mesh(
        mesh, scalars=BAR, cmap="viridis", clim=(0.0, scene.limit), ambient=0.75, diffuse=0.3, specular=0.0, scalar_bar_args=bar
    )
    # Pushes the surface behind its own edges, which would else flicker through it.
    actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
    actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(2.0, 2.0)
    edges = pyvista.PolyData(scene.nodes, lines=counted(loops(scene.faces)))
    plotter.add_mesh(edges, color="white", opacity=0.4, line_width=1.2 * size, lighting=False)
    for line in scene.outlines:
        plotter.add_lines(line, color="black", width=3.0 * size, connected=True)
    length = 0.9 * scene.module
    for tip in scene.load_tips:
        tail = tip - length * scene.load_direction
        arrow = pyvista.Arrow(start=tail, direction=scene.load_direction, scale=length, tip_length=0.3, tip_radius=0.09, shaft_radius=0.03)
        plotter.add_mesh(arrow, color="#D55E00", lighting=False)
    title = scene.title.replace("; ", "\n").replace("largest", "Largest").replace("face", "Face")
    plotter.add_text(title, position=(40 * size, window[1] - 140 * size), font_size=int(16 * size), color="black")
    plotter.add_text(LIMIT, position=(40 * size, window[1] - 210 * size), font_size=max(6, int(11 * size)), color="#555555")
    _look(plotter, scene)
    return plotter


def _look(plotter: Any, scene: _Scene) -> None:
    """Aim at the middle of the body and fit what is drawn, arrows included, under the title."""
    towards = VIEW / np.linalg.norm(VIEW)
    right = np.cross([0.0, 1.0, 0.0], towards)
    right /= np.linalg.norm(right)
    up = np.cross(towards, right)
    seen = np.concatenate([scene.nodes, scene.load_tips - 0.9 * scene.module * scene.load_direction])
    across, high = seen @ right, seen @ up
    middle = 0.5 * (across.min() + across.max()) * right + 0.5 * (high.min() + high.max()) * up
    half = max(0.5 * np.ptp(high) / 0.80, 0.5 * np.ptp(across) / 0.86 * WINDOW[1] / WINDOW[0])
    # The title and the colour bar take the top and the right edge: the body stands lower and to the left of the middle.
    middle = middle + 0.10 * half * up + 0.06 * half * right
    plotter.camera_position = [tuple(middle + 20.0 * half * towards), tuple(middle), (0.0, 1.0, 0.0)]
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = half
    plotter.reset_camera_clipping_range()


def _turn(scene: _Scene, path: Path) -> None:
    from PIL import Image

    plotter = _plotter(scene, GIF_WINDOW)
    # About the vertical through the middle of the body, with room for the ends of the face, which swing out sideways.
    low, high = scene.nodes.min(axis=0), scene.nodes.max(axis=0)
    reach = 0.5 * np.hypot(high[0] - low[0] + 1.8 * scene.module, high[2] - low[2]) / 0.8
    half = max(reach, 0.75 * (high[1] - low[1]))
    middle = 0.5 * (low + high) + (0.0, 0.15 * half, 0.0)
    plotter.camera_position = [tuple(middle + 20.0 * half * VIEW / np.linalg.norm(VIEW)), tuple(middle), (0.0, 1.0, 0.0)]
    plotter.camera.parallel_scale = half
    plotter.reset_camera_clipping_range()
    frames = []
    for _ in range(FRAMES):
        frames.append(Image.fromarray(plotter.screenshot(return_img=True)).quantize(256))
        plotter.camera.Azimuth(360.0 / FRAMES)
        plotter.reset_camera_clipping_range()
        plotter.render()
    plotter.close()
    with whole(path) as temporary:
        frames[0].save(temporary, format="GIF", save_all=True, append_images=frames[1:], duration=100, loop=0)
