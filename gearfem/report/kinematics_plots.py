"""Pictures of the kinematics of worn teeth: outlines, line of action, gear ratios, velocities, specific sliding, pressure."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearfem.definition.setup import GearPair, Member
from gearfem.engagement.record import Engagement
from gearfem.flank import Outline
from gearfem.foundation import Array
from gearfem.foundation.units import MM, MPA, UM
from gearfem.pipeline import Results
from gearfem.placement import Placement
from gearfem.report import style
from gearfem.report.summary import need

MEMBERS: tuple[Member, Member] = ("pinion", "wheel")
# Wear is drawn this large in modules, or true to scale where it is deeper.
SHOWN = 0.12
STEPS = (1.0, 2.0, 5.0)


def enlargement(depth: float, module: float) -> float:
    """Return the round factor (1, 2, 5, 10 ...) by which a depth [m] is drawn some tenth of a module large.

    Examples
    --------
    >>> enlargement(2e-4, 8e-3), enlargement(0.0, 8e-3), enlargement(2e-3, 8e-3)
    (2.0, 1.0, 1.0)
    """
    if depth <= 0.0:
        return 1.0
    wanted = max(SHOWN * module / depth, 1.0)
    power = 10.0 ** math.floor(math.log10(wanted) + 1e-12)
    return power * max(step for step in STEPS if step * power <= wanted * (1.0 + 1e-12))


def has_worn_flanks(results: Results) -> bool:
    """Whether metal is missing from any flank of an engagement, so that its kinematics are more than an involute's."""
    flanks = results.flanks
    teeth = [outline for member in MEMBERS for outline in (flanks.of(member), *flanks.odd(member).values())]
    return results.engagement is not None and any(outline.worn for outline in teeth)


def away_from_line(results: Results) -> float:
    """Return how far the contact point of a pair that carries leaves the straight line of action, at most [m]."""
    engagement, mesh = need(results.engagement, "engagement"), need(results.mesh, "mesh")
    place = _along_line(results.setup.pair, mesh.placement, engagement.contacts.point)
    return float(np.abs(place[..., 1])[engagement.force > 0.0].max())


def _along_line(pair: GearPair, placement: Placement, point: Array) -> Array:
    """Return places along the straight line of action from the pitch point, and across it towards the wheel's axis [m]."""
    angle = placement.working_pressure_angle
    along = np.array([math.sin(angle), math.cos(angle)])
    across = np.array([along[1], -along[0]])
    places: Array = (point - np.array([placement.centre_distance / (1.0 + pair.ratio), 0.0])) @ np.stack([along, across], axis=-1)
    return places


@style.styled
def plot_outlines(results: Results) -> Figure:
    """Draw the working side of a tooth of both gears without and with what is missing from it, enlarged.

    Parameters
    ----------
    results : Results
        With its flanks; teeth that differ are drawn too, the first two of each gear.

    Returns
    -------
    Figure
    """
    figure, axes = style.make_figure((9.0, 5.0), columns=2)
    for axis, member in zip(axes, MEMBERS, strict=True):
        odd = sorted(results.flanks.odd(member).items())[:2]
        teeth = [("all teeth" if not odd else "other teeth", results.flanks.of(member)), *((f"tooth {number}", one) for number, one in odd)]
        factor = enlargement(max(one.deepest for _, one in teeth), results.setup.pair.pinion.module)
        gear = teeth[0][1].gear
        _side(axis, Outline(gear=gear).point(np.linspace(0.0, 5.0, 401)), style.GREY, "without wear")
        for (name, outline), colour in zip(teeth, (style.BLUE, style.VERMILION, style.GREEN), strict=False):
            if outline.worn:
                scale = f"missing metal {factor:g} times" if factor > 1.0 else "to scale"
                _side(axis, _enlarged(outline, factor), colour, f"{name}, {scale}")
        deepest = ", ".join(f"up to {one.deepest / UM:.4g} µm" for _, one in teeth if one.worn) or "nothing missing"
        axis.set_title(f"{member}, z = {gear.teeth}: {deepest}")
        axis.set_aspect("equal")
        axis.set_xlabel("across the tooth, mm")
        axis.legend(loc="lower left")
    axes[0].set_ylabel("from the gear's centre, mm")
    return figure


def _enlarged(outline: Outline, factor: float) -> Array:
    """Return the flank with its deviation enlarged, up to the tip form circle and without fillet."""
    nominal = Outline(gear=outline.gear)
    assert outline.deviation is not None
    roll = np.linspace(nominal.flank_start, nominal.flank_end, 401)
    u = nominal.parameter(roll)
    points: Array = nominal.point(u) - factor * outline.deviation.at(roll)[:, None] * nominal.normal(u)
    return points


def _side(axis: Axes, points: Array, colour: str, label: str) -> None:
    axis.plot(points[:, 1] / MM, points[:, 0] / MM, color=colour, label=label)


@style.styled
def plot_line_of_action(results: Results) -> Figure:
    """Draw the way of the contact point of each pair in the fixed frame, by the number of pairs that carry, and how far it is from
    the straight line of action.

    Parameters
    ----------
    results : Results
        With its engagement stage.

    Returns
    -------
    Figure
    """
    engagement, pair = need(results.engagement, "engagement"), results.setup.pair
    mesh = need(results.mesh, "mesh")
    figure, (left, right) = style.make_figure((9.6, 4.6), columns=2)
    radius = mesh.placement.centre_distance / (1.0 + pair.ratio)
    contacts = engagement.contacts
    along = np.array([math.sin(mesh.placement.working_pressure_angle), math.cos(mesh.placement.working_pressure_angle)])
    reach = max(pair.approach_length, pair.recess_length) * 1.1
    ends = np.array([radius, 0.0]) + np.array([[-reach], [reach]]) * along
    left.plot(*(ends / MM).T, color=style.GREY, linewidth=0.9, linestyle="--", label="straight line of action")
    left.plot(radius / MM, 0.0, "o", color="white", markeredgecolor=style.INK, markersize=5, label="pitch point")
    several = engagement.pairs_in_contact > 1
    for pairs_carry, colour, label in ((False, style.BLUE, "one pair carries"), (True, style.VERMILION, "two pairs or more")):
        for column in range(len(contacts.pairs)):
            rows = (engagement.force[:, column] > 0.0) & (several == pairs_carry)
            if not rows.any():
                continue
            point = contacts.point[rows, column]
            place = _along_line(pair, mesh.placement, point)
            left.plot(*(point / MM).T, ".", color=colour, markersize=2.5, label=label)
            right.plot(place[:, 0] / MM, place[:, 1] / UM, ".", color=colour, markersize=2.5)
            label = "_"
    left.set_aspect("equal", adjustable="datalim")
    left.set_xlabel("x from the pinion's axis towards the wheel's, mm")
    left.set_ylabel("y, mm")
    right.axhline(0.0, color=style.GREY, linewidth=0.9, linestyle="--")
    right.set_xlabel("place along the straight line, mm (0: pitch point)")
    right.set_ylabel("distance from it, µm, towards the wheel's axis")
    if max(abs(limit) for limit in right.get_ylim()) < 1.0:
        right.set_ylim(-1.0, 1.0)
    style.legend_below(figure, left, columns=4)
    return figure


@style.styled
def plot_four_ratios(results: Results) -> Figure:
    """Draw the four gear ratios over the pinion angle: of the pair by its normal, unloaded, under load, and of the forces.

    Parameters
    ----------
    results : Results
        With its engagement stage.

    Returns
    -------
    Figure
    """
    engagement = need(results.engagement, "engagement")
    figure, (axis,), x = _over_angle(results, engagement, "gear ratio i")
    contacts = engagement.contacts
    for column in range(len(contacts.first.pairs)):
        held = engagement.force[:, column] > 0.0
        if held.any():
            ratio = np.where(held, contacts.arm2[:, column] / contacts.arm1[:, column], np.nan)
            first = "_" if axis.get_legend_handles_labels()[1] else "of one pair, $O_2P/O_1P$ (eq. 10)"
            axis.plot(x, ratio, color=style.GREEN, linewidth=3.0, alpha=0.45, label=first)
    axis.plot(x, engagement.gear_ratio_unloaded, color=style.INK, linestyle=":", label="rigid, unloaded")
    axis.plot(x, engagement.gear_ratio, color=style.BLUE, label="under load, $dφ_1/dφ_2$")
    axis.plot(x, engagement.gear_ratio_force, color=style.VERMILION, linestyle="--", label="of the forces (eq. 11)")
    nominal = results.setup.pair.ratio
    beside = axis.secondary_yaxis("right", functions=(_per_cent(nominal), _ratio(nominal)))
    beside.set_ylabel("away from $z_2/z_1$, %")
    style.legend_below(figure, axis, columns=2)
    return figure


def _per_cent(nominal: float) -> Callable[[Any], Any]:
    return lambda ratio: 100.0 * (ratio / nominal - 1.0)


def _ratio(nominal: float) -> Callable[[Any], Any]:
    return lambda per_cent: nominal * (1.0 + per_cent / 100.0)


@style.styled
def plot_rolling(results: Results) -> Figure:
    """Draw the velocities of the contact point along both flanks (eq. 12), of the bodies' own points, and their difference, of one pair.

    Parameters
    ----------
    results : Results
        With its engagement stage.

    Returns
    -------
    Figure
    """
    engagement, speed = need(results.engagement, "engagement"), results.setup.operation.pinion_speed
    figure, (axis,), x = _over_angle(results, engagement, f"velocity of pair {middle_pair(engagement)}, m/s")
    contacts = engagement.contacts
    axis.axhline(0.0, color=style.GREY, linewidth=0.7)
    curves = (
        ("contact point along the pinion", contacts.rolling_velocity1, style.BLUE, "-", 1.5),
        ("along the wheel", contacts.rolling_velocity2, style.VERMILION, "-", 1.5),
        ("the pinion's own point", contacts.material_velocity1, style.BLUE, ":", 1.0),
        ("the wheel's own point", contacts.material_velocity2, style.VERMILION, ":", 1.0),
        ("sliding", contacts.sliding_velocity, style.INK, "-.", 1.5),
    )
    for label, values, colour, line, width in curves:
        axis.plot(x, _of_middle(engagement, values) * speed, color=colour, linestyle=line, linewidth=width, label=label)
    # Where the contact jumps over a hollow its velocity has no bound; the picture keeps to that of the bodies.
    sane = np.nan_to_num(
        np.concatenate([_of_middle(engagement, contacts.material_velocity1), _of_middle(engagement, contacts.sliding_velocity)])
    )
    axis.set_ylim(max(axis.get_ylim()[0], 1.6 * sane.min() * speed), min(axis.get_ylim()[1], 1.6 * sane.max() * speed))
    style.legend_below(figure, axis, columns=3)
    return figure


@style.styled
def plot_specific_sliding(results: Results) -> Figure:
    """Draw the specific sliding of both flanks of one pair.

    Parameters
    ----------
    results : Results
        With its engagement stage.

    Returns
    -------
    Figure
    """
    engagement = need(results.engagement, "engagement")
    figure, (axis,), x = _over_angle(results, engagement, f"specific sliding of pair {middle_pair(engagement)}")
    axis.axhline(0.0, color=style.GREY, linewidth=0.7)
    contacts = engagement.contacts
    axis.plot(x, _of_middle(engagement, contacts.specific_sliding1), color=style.BLUE, label="pinion")
    axis.plot(x, _of_middle(engagement, contacts.specific_sliding2), color=style.VERMILION, linestyle="--", label="wheel")
    style.legend_below(figure, axis)
    return figure


@style.styled
def plot_pressure(results: Results) -> Figure:
    """Draw largest contact pressure and equivalent radius of curvature of one pair.

    Parameters
    ----------
    results : Results
        With its engagement stage.

    Returns
    -------
    Figure
    """
    engagement = need(results.engagement, "engagement")
    figure, (upper, lower), x = _over_angle(results, engagement, f"contact pressure of\npair {middle_pair(engagement)}, MPa", rows=2)
    flanks = engagement.contacts.on_flanks[:, engagement.contacts.pairs.index(middle_pair(engagement))]
    own = np.equal(engagement.contacts.pairs, middle_pair(engagement))
    # Of a pair that touches on both sides of a hollow the larger pressure.
    pressure = np.where(own, engagement.contact_pressure[:, own].max(axis=1, keepdims=True), engagement.contact_pressure)
    for axis, values, unit in ((upper, pressure, MPA), (lower, engagement.contacts.equivalent_radius, MM)):
        whole = _of_middle(engagement, values) / unit
        axis.plot(x, np.where(flanks, whole, np.nan), color=style.BLUE, label="on the flanks")
        axis.plot(x, np.where(flanks, np.nan, whole), color=style.VERMILION, linestyle="--", label="on a tip edge")
        axis.set_ylim(bottom=0.0)
    upper.set_xlabel("")
    lower.set_ylabel("equivalent\nradius, mm")
    figure.align_ylabels()
    style.legend_below(figure, upper)
    return figure


def _over_angle(results: Results, engagement: Engagement, label: str, rows: int = 1) -> tuple[Figure, list[Axes], Array]:
    pitch = results.setup.pair.pinion.pitch_angle
    figure, axes = style.make_figure((6.6, 4.0 if rows == 1 else 4.8), rows=rows)
    x = engagement.contacts.pinion_angle / pitch
    for number, axis in enumerate(axes):
        style.shade_zones(axis, engagement, pitch, labels=number == 0)
        style.over_pitches(axis, label, float(x[0]), float(x[-1]))
    return figure, axes, x


def middle_pair(engagement: Engagement) -> int:
    """Return the number of the pair in the middle; pairs reach equally far beyond both ends of the angles."""
    pairs = engagement.contacts.first.pairs
    return pairs[len(pairs) // 2]


def _of_middle(engagement: Engagement, values: Array) -> Array:
    """Return the values of the middle pair's first touch while the pair carries, gaps elsewhere."""
    own = np.equal(engagement.contacts.pairs, middle_pair(engagement))
    return np.where((engagement.force[:, own] > 0.0).any(axis=1), values[:, np.argmax(own)], np.nan)


PICTURES: dict[str, Callable[[Results], Figure]] = {
    "flank_outlines": plot_outlines,
    "line_of_action": plot_line_of_action,
    "gear_ratios": plot_four_ratios,
    "rolling": plot_rolling,
    "specific_sliding": plot_specific_sliding,
    "contact_pressure": plot_pressure,
}


def write_kinematics_pictures(results: Results, out: Path) -> tuple[Path, ...]:
    """Write a PNG of each picture of the kinematics.

    Parameters
    ----------
    results : Results
        With its engagement stage.
    out : Path
        Folder.

    Returns
    -------
    tuple of Path
    """
    return tuple(style.save(draw(results), Path(out) / f"{name}.png") for name, draw in PICTURES.items())
