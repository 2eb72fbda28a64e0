"""A picture of the deformed, loaded tooth by pyvista without a display, or by matplotlib where OpenGL is missing."""

from __future__ import annotations

import functools
import importlib
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearfem.compliance.field import Field
from gearfem.flank import Outline
from gearfem.foundation import Array, InputError
from gearfem.foundation.files import whole
from gearfem.foundation.units import MM, MPA, N_PER_MM, UM
from gearfem.report.outlines import teeth_around

PACKAGES = "libegl1 libgl1-mesa-dri"
NO_OPENGL = (
    "Off-screen OpenGL is not available here, so matplotlib drew this picture instead of pyvista; all results are the same. "
    f"On Debian or Ubuntu, 'apt-get install {PACKAGES}' provides it."
)
_PROBE = "import pyvista; p = pyvista.Plotter(off_screen=True, window_size=(32, 32)); p.add_mesh(pyvista.Sphere()); p.screenshot()"
WINDOW = (1400, 1250)
# Under a line load displacement and stress grow as the mesh is refined: what a picture states is taken from so many modules away.
AWAY = 0.4
# Part of the reach, from the middle of the picture up, that title and note leave free.
HIGHEST = 0.68


class Rendering(NamedTuple):
    """A picture and what a reader must know about it."""

    path: Path
    title: str
    renderer: str
    notice: str


class _Scene(NamedTuple):
    """Everything that both renderers draw, in mm and MPa, the tooth upright and its loaded side to the left."""

    moved: Array
    quads: NDArray[Any]
    stress: Array
    limit: float
    outline: Array
    load_tip: Array
    load_direction: Array
    centre: Array
    reach: float
    arrow: float
    bar: tuple[float, float]
    title: str


def parts(quads: NDArray[Any]) -> NDArray[Any]:
    """Return four bilinear cells for each biquadratic element, which keep its curved sides and all its nodes."""
    own = ((0, 4, 8, 7), (4, 1, 5, 8), (8, 5, 2, 6), (7, 8, 6, 3))
    return np.concatenate([quads[:, part] for part in own])


def loops(quads: NDArray[Any]) -> NDArray[Any]:
    """Return the nodes around each biquadratic element, corners and mid-sides, closed."""
    return quads[:, (0, 4, 1, 5, 2, 6, 3, 7, 0)]


@functools.cache
def opengl_works() -> bool:
    """Return whether pyvista can draw off screen here; tried once per process, in a process of its own.

    Notes
    -----
    Without libEGL, VTK ends the process by a segmentation fault rather than an exception, hence the subprocess.
    """
    choose_window()
    try:
        done = subprocess.run([sys.executable, "-c", _PROBE], capture_output=True, timeout=120, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


def choose_window() -> None:
    """Make VTK draw without a display where there is none."""
    # Read by VTK when it makes its first window; a display that exists keeps VTK's own choice.
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")


def write_render(
    field: Field,
    out_png: Path,
    *,
    outline: Outline,
    scale: float | None = None,
    opengl: bool | None = None,
    body: bool = False,
) -> Rendering:
    """Draw the deformed tooth, coloured by von Mises stress, over its undeformed outline.

    Parameters
    ----------
    field : Field
        Displacement and stress of the gear.
    out_png : Path
        Target file.
    outline : Outline
        Outline of the undeformed tooth.
    scale : float, optional
        Factor by which displacements are enlarged; by default the number of the form 1, 2 or 5 times a power
        of ten that draws the largest at no more than 5 % of the module, or 20 % with the body.
    opengl : bool, optional
        True for pyvista, False for matplotlib; by default whichever works.
    body : bool
        Whether the picture reaches down to the bore and shows all sectors of the field, instead of the tooth with its root.

    Returns
    -------
    Rendering
        The file, its title, ``pyvista`` or ``matplotlib``, and a notice (empty, or what to install).

    Raises
    ------
    InputError
        If the scale is not positive.
    """
    scene = _compose(field, outline, scale, body)
    works = opengl_works() if opengl is None else opengl
    with whole(Path(out_png)) as temporary:
        if works:
            _draw_pyvista(scene, temporary)
        else:
            _draw_matplotlib(scene, temporary)
    return Rendering(Path(out_png), scene.title, "pyvista" if works else "matplotlib", "" if works else NO_OPENGL)


def write_vtu(field: Field, path: Path) -> Path:
    """Write the field as VTU for ParaView: lengths in mm, stress in MPa, on the biquadratic elements.

    Parameters
    ----------
    field : Field
        Displacement and stress of the gear.
    path : Path
        Target file.

    Returns
    -------
    Path
        The same path.
    """
    import meshio

    flat = np.zeros((len(field.nodes), 1))
    mesh = meshio.Mesh(
        np.hstack([field.nodes / MM, flat]),
        [("quad9", field.quads)],
        point_data={"displacement_mm": np.hstack([field.displacement / MM, flat]), "von_mises_MPa": field.von_mises / MPA},
    )
    with whole(Path(path)) as temporary:
        mesh.write(temporary, file_format="vtu")
    return Path(path)


def _compose(field: Field, outline: Outline, scale: float | None, body: bool = False) -> _Scene:
    module = outline.gear.module
    far = np.hypot(*(field.nodes - field.load_point).T) > AWAY * module
    largest = float(np.hypot(*field.displacement[far].T).max())
    scale = drawn_scale(scale, 4.0 * module if body else module, largest)
    polar = np.arctan2(field.nodes[:, 1], field.nodes[:, 0])
    neighbours = max((round(float(np.ptp(polar)) / outline.gear.pitch_angle) - 1) // 2, 0)
    middle = np.array([0.5 * (outline.gear.root_radius + outline.gear.tip_radius) - 0.15 * module, 0.0])
    arrow, bar = 0.95 * module, (0.77, 0.62)
    highest = max(outline.gear.tip_radius, float(field.load_point[0] - arrow * field.load_direction[0]))
    # Nothing that is drawn may reach the title and the note, which take a sixth of the height.
    reach = max(2.1 * module, (highest - middle[0]) / HIGHEST)
    if body:
        low, high = field.nodes.min(axis=0), field.nodes.max(axis=0)
        reach = 0.5 * max((high[0] - low[0]) / 0.82, (high[1] - low[1]) / 0.95 * WINDOW[1] / WINDOW[0])
        # The title takes the top left; a fan of sectors leaves the top right to the colour bar.
        middle, bar = 0.5 * (low + high) + (0.12 * reach, 0.0), (0.84, 0.64)
    return _Scene(
        moved=_upright(field.nodes + scale * field.displacement) / MM,
        quads=field.quads,
        stress=field.von_mises / MPA,
        limit=float(field.von_mises[far].max()) / MPA,
        outline=_upright(teeth_around(outline, neighbours)) / MM,
        load_tip=_upright(field.load_point) / MM,
        load_direction=_upright(field.load_direction),
        centre=_upright(middle) / MM,
        reach=reach / MM,
        arrow=arrow / MM,
        bar=bar,
        title=describe(field.force_per_width, largest, scale),
    )


def drawn_scale(scale: float | None, module: float, largest: float) -> float:
    """Return the factor of the displacements, by default a round one that draws the largest at 5 % of the module or less."""
    if scale is None:
        return _round_down(0.05 * module / largest)
    if not (math.isfinite(scale) and scale > 0.0):
        raise InputError("scale", scale, "a factor above 0")
    return scale


def describe(force_per_width: float, largest: float, scale: float) -> str:
    """Return the title of a picture: load, true displacement away from it and the scale at which it is drawn."""
    drawn = "at its true scale" if scale == 1.0 else f"{scale:g} times larger"
    return f"Line load {force_per_width / N_PER_MM:.4g} N/mm; largest displacement away from the load {largest / UM:.4g} µm, drawn {drawn}"


def _round_down(value: float) -> float:
    power = 10.0 ** math.floor(math.log10(value))
    return float(max(digit for digit in (1.0, 2.0, 5.0) if digit * power <= value * (1.0 + 1e-12)) * power)


def _upright(vectors: Array) -> Array:
    """Turn the tooth's axis from x to up; its described side y > 0 comes to lie on the left."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


BAR = "von Mises stress, MPa"
LIMIT = (
    f"Away from the load: by more than {AWAY:g} modules. Under a line load\n"
    "displacement and stress have no limit. Colours end at the largest away."
)


def _draw_pyvista(scene: _Scene, path: Path) -> None:
    choose_window()
    # Loaded by name: the decorators of pyvista hide the signatures of its own methods from a type check.
    pyvista: Any = importlib.import_module("pyvista")

    mesh = pyvista.PolyData(_lift(scene.moved, 0.0), faces=counted(parts(scene.quads)))
    mesh.point_data[BAR] = scene.stress
    plotter = pyvista.Plotter(off_screen=True, window_size=WINDOW)
    plotter.set_background("white")
    # Upright in the space between two teeth, the one place that is white for every gear seen so near.
    bar = {
        "title": BAR.replace(", ", ",\n") + "\n",
        "vertical": True,
        "position_x": scene.bar[0],
        "position_y": scene.bar[1],
        "width": 0.08,
        "height": 0.27,
    }
    bar |= {"color": "black", "n_labels": 5, "fmt": "%.0f", "title_font_size": 28, "label_font_size": 28}
    plotter.add_mesh(mesh, scalars=BAR, cmap="viridis", clim=(0.0, scene.limit), lighting=False, scalar_bar_args=bar)
    edges = pyvista.PolyData(_lift(scene.moved, 0.005 * scene.reach), lines=counted(loops(scene.quads)))
    plotter.add_mesh(edges, color="white", opacity=0.35, line_width=1.0, lighting=False)
    plotter.add_lines(_lift(scene.outline, 0.01 * scene.reach), color="black", width=3, connected=True)
    length = scene.arrow
    tail = scene.load_tip - length * scene.load_direction
    arrow = pyvista.Arrow(
        start=_lift(tail, 0.02 * scene.reach),
        direction=_lift(scene.load_direction, 0.0),
        scale=length,
        tip_length=0.28,
        tip_radius=0.07,
        shaft_radius=0.022,
    )
    plotter.add_mesh(arrow, color="#D55E00", lighting=False)
    title = scene.title.replace("; ", "\n").replace("largest", "Largest")
    plotter.add_text(title, position=(40, WINDOW[1] - 100), font_size=17, color="black")
    plotter.add_text(LIMIT, position=(40, WINDOW[1] - 175), font_size=12, color="#555555")
    middle = _lift(scene.centre, 0.0)
    plotter.camera_position = [_lift(scene.centre, 10.0 * scene.reach), middle, (0.0, 1.0, 0.0)]
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = scene.reach
    plotter.screenshot(str(path))
    plotter.close()


def counted(cells: NDArray[Any]) -> NDArray[Any]:
    """Put the number of its nodes before each cell, as VTK wants."""
    return np.hstack([np.full((len(cells), 1), cells.shape[1]), cells]).ravel()


def _lift(points: Array, height: float) -> Array:
    return np.concatenate([points, np.full((*points.shape[:-1], 1), height)], axis=-1)


def _draw_matplotlib(scene: _Scene, path: Path) -> None:
    from matplotlib.collections import LineCollection
    from matplotlib.tri import Triangulation

    from gearfem.report import style

    figure, (axis,) = style.styled(style.make_figure)(style.SQUARE)
    cells = parts(scene.quads)
    triangles = np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    surface = Triangulation(scene.moved[:, 0], scene.moved[:, 1], triangles)
    colours = axis.tripcolor(surface, scene.stress, shading="gouraud", cmap="viridis", vmin=0.0, vmax=scene.limit)
    edges = LineCollection(list(scene.moved[loops(scene.quads)]), colors=(1.0, 1.0, 1.0, 0.35), linewidths=0.4)
    axis.add_collection(edges)
    axis.plot(*scene.outline.T, color="black", linewidth=1.2)
    tail = scene.load_tip - scene.arrow * scene.load_direction
    arrow = {"color": style.VERMILION, "width": 3, "headwidth": 10, "headlength": 10, "shrink": 0.0}
    axis.annotate("", xy=tuple(scene.load_tip), xytext=tuple(tail), arrowprops=arrow)
    axis.set_xlim(scene.centre[0] - 1.1 * scene.reach, scene.centre[0] + 1.1 * scene.reach)
    axis.set_ylim(scene.centre[1] - 0.85 * scene.reach, scene.centre[1] + 0.85 * scene.reach)
    axis.set_aspect("equal")
    axis.set_axis_off()
    axis.set_title(f"{scene.title}\n{LIMIT}", fontsize=7.5)
    figure.colorbar(colours, ax=axis, orientation="horizontal", shrink=0.7, pad=0.02, extend="max", label=BAR)
    style.save(figure, path)
