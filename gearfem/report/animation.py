"""The two gears in engagement, moving, with their contact points, as an animated GIF."""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.animation import PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from gearfem.definition.setup import Member
from gearfem.engagement.engage import engage
from gearfem.engagement.record import Engagement
from gearfem.flank import Outline
from gearfem.foundation import Array
from gearfem.foundation.files import whole
from gearfem.foundation.units import MM
from gearfem.pipeline import Results
from gearfem.report import style
from gearfem.report.summary import need

# Two seconds over one pitch, which repeats without a seam where teeth are alike.
FRAMES, PER_SECOND, DOTS = 48, 24, 110
NEIGHBOURS = 2


def write_animation(results: Results, out: Path, frames: int = FRAMES) -> Path:
    """Write engagement.gif: both gears over one pitch, the contact points of all pairs that carry, and their way.

    Parameters
    ----------
    results : Results
        With its compliance stage.
    out : Path
        Folder.
    frames : int
        Pictures to the pitch.

    Returns
    -------
    Path
        The file. The wheel stands as rigid teeth touch; the deflection, some micrometres, is not drawn.
    """
    mesh, pair = need(results.mesh, "mesh"), results.setup.pair
    # Pair 0 from before its first contact on: half a pitch before to half a pitch after the pitch point.
    angles = (np.arange(frames) / frames - 0.5) * pair.pinion.pitch_angle
    engagement = engage(mesh, angles, results.setup.operation.pinion_torque)
    lag = engagement.contacts.gap.min(axis=1) / pair.wheel.base_radius
    path = Path(out) / "engagement.gif"
    with matplotlib.rc_context(style.LOOK):
        figure, axis = _stage(results, engagement)
        drawn = {member: axis.fill([], [], facecolor=f"{colour}28", edgecolor=colour, linewidth=1.4)[0] for member, colour in _colours()}
        marks = axis.scatter(np.zeros(0), np.zeros(0), color=style.INK, zorder=5)
        teeth = {member: [_tooth(results, member, number) for number in range(-NEIGHBOURS, NEIGHBOURS + 1)] for member, _ in _colours()}
        with whole(path) as temporary:
            writer = PillowWriter(fps=PER_SECOND)
            with writer.saving(figure, str(temporary), DOTS):
                for row, angle in enumerate(angles):
                    turned = {"pinion": angle, "wheel": angle / pair.ratio - lag[row]}
                    for member, shape in drawn.items():
                        _turn(shape, results, member, teeth[member], float(turned[member]))
                    held = engagement.force[row] > 0.0
                    marks.set_offsets(engagement.contacts.point[row, held] / MM)
                    marks.set_sizes(12.0 + 60.0 * engagement.load_share[row, held])
                    writer.grab_frame()
    return path


def _colours() -> tuple[tuple[Member, str], tuple[Member, str]]:
    return ("pinion", style.BLUE), ("wheel", style.VERMILION)


def _stage(results: Results, engagement: Engagement) -> tuple[Figure, Axes]:
    """Return the axes about the pitch point, with the way of the contact points on them."""
    pair, mesh = results.setup.pair, need(results.mesh, "mesh")
    figure, (axis,) = style.make_figure((5.0, 4.8))
    held = engagement.force > 0.0
    axis.plot(*(engagement.contacts.point[held] / MM).T, ".", color=style.GREY, markersize=2.0)
    reach = 1.3 * math.pi * pair.pinion.module / MM
    centre = mesh.placement.centre_distance / (1.0 + pair.ratio) / MM
    axis.set_xlim(centre - reach, centre + reach)
    axis.set_ylim(-reach, reach)
    axis.set_aspect("equal")
    axis.grid(False)
    axis.set_xlabel("x from the pinion's axis, mm")
    axis.set_ylabel("y, mm")
    axis.set_title("contacts: the larger, the more load")
    return figure, axis


def _tooth(results: Results, member: Member, number: int) -> Array:
    """Return one tooth about its own axis: working side as it is, idle side without wear."""
    gear = getattr(results.setup.pair, member)
    outline = results.flanks.odd(member).get(number % gear.teeth, results.flanks.of(member))
    u = np.linspace(0.0, 5.0, 251)
    idle = Outline(gear=outline.gear).point(u)
    return np.concatenate([idle[:-1] * (1.0, -1.0), outline.point(u)[::-1]])


def _turn(drawn: Polygon, results: Results, member: Member, teeth: list[Array], turned: float) -> None:
    """Set the teeth of a gear to where they stand at its angle [rad]; they are counted against its sense of rotation."""
    mesh = need(results.mesh, "mesh")
    placement, pitch = mesh.placement, getattr(results.setup.pair, member).pitch_angle
    numbers = range(-NEIGHBOURS, NEIGHBOURS + 1)
    parts = []
    for number, tooth in zip(numbers, teeth, strict=True):
        own = turned - number * pitch
        axis = own + placement.pinion_start if member == "pinion" else math.pi - own - placement.wheel_start
        cosine, sine = math.cos(axis), math.sin(axis)
        parts.append(tooth @ np.array([[cosine, sine], [-sine, cosine]]))
    # Each tooth runs from its idle to its working side, so they join in the order in which polar angles grow.
    ordered = parts[::-1] if member == "pinion" else parts
    points = np.concatenate(ordered)
    centre = 0.0 if member == "pinion" else placement.centre_distance
    drawn.set_xy(np.concatenate([points, np.zeros((1, 2))]) / MM + (centre / MM, 0.0))
