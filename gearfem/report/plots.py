"""Pictures of compliance, engagement and motion; each function returns a matplotlib figure."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gearfem.definition.setup import Member
from gearfem.dynamics.record import ElasticMotion, RigidMotion
from gearfem.foundation import Array
from gearfem.foundation.units import MM, N_PER_UM, UM, UM_PER_N_PER_MM
from gearfem.pipeline import Results
from gearfem.report import style
from gearfem.report.drawing import plot_pair
from gearfem.report.effect_plots import has_effects, plot_effects
from gearfem.report.flank_plots import plot_measured_flanks
from gearfem.report.kinematics_plots import has_worn_flanks, plot_four_ratios, plot_line_of_action, plot_outlines
from gearfem.report.summary import iso_stiffness, need
from gearfem.report.tables import compliance_curves, share_of

METHODS = {
    "fe_plane_strain": ("FE, plane strain", style.BLUE),
    "fe_plane_stress": ("FE, plane stress", style.GREEN),
    "fe_3d": ("FE, three-dimensional", style.PURPLE),
    "castigliano": ("Castigliano", style.VERMILION),
}
SUPPORTS = {"bore": ("whole gear", "-"), "root": ("clamped at root", "--"), "root_chord": ("clamped on root chord", ":")}


@style.styled
def plot_compliance(results: Results) -> Figure:
    """Draw compliance over the load radius: both gears, every method and support, +-10 % around the root FE.

    Parameters
    ----------
    results : Results
        With its compliance stage.

    Returns
    -------
    Figure
    """
    figure, axes = style.make_figure(style.WIDE, columns=2)
    members: tuple[Member, Member] = ("pinion", "wheel")
    for axis, member in zip(axes, members, strict=True):
        _compliance_of(axis, results, member)
    axes[0].set_ylabel("deflection per line load, µm per N/mm")
    style.legend_below(figure, axes[0], columns=4)
    return figure


def _compliance_of(axis: Axes, results: Results, member: Member) -> None:
    for owner, curve in compliance_curves(results):
        if owner != member:
            continue
        radius, deflection = curve.radius / MM, curve.deflection / UM_PER_N_PER_MM
        method, colour = METHODS.get(curve.method, (curve.method, style.INK))
        support, line = SUPPORTS.get(curve.support, (curve.support, "-."))
        axis.plot(radius, deflection, color=colour, linestyle=line, label=f"{method}, {support}")
        if (curve.method, curve.support) == ("fe_plane_strain", "root"):
            low, high = 0.9 * deflection, 1.1 * deflection
            axis.fill_between(radius, low, high, color=colour, alpha=0.15, linewidth=0, label="±10 % of FE, clamped at root")
    gear = getattr(results.setup.pair, member)
    axis.set_title(f"{member}, z = {gear.teeth}")
    axis.set_xlabel("radius of the load point, mm")
    axis.set_ylim(bottom=0.0)


@style.styled
def plot_stiffness(results: Results) -> Figure:
    """Draw slope and secant of the mesh stiffness over the pinion angle, with c_gamma_alpha b of ISO 6336-1.

    Parameters
    ----------
    results : Results
        With its engagement stage.

    Returns
    -------
    Figure
    """
    engagement = need(results.engagement, "engagement")
    figure, (axis,) = _over_angle(results, "mesh stiffness, N/µm")
    x = engagement.contacts.pinion_angle / results.setup.pair.pinion.pitch_angle
    axis.plot(x, engagement.mesh_stiffness / N_PER_UM, color=style.BLUE, label="slope dF/dδ")
    axis.plot(x, engagement.secant_stiffness / N_PER_UM, color=style.VERMILION, linestyle="--", label="secant F/δ")
    iso = iso_stiffness(results.setup).mesh_stiffness * results.setup.pair.face_width / N_PER_UM
    axis.axhline(iso, color=style.INK, linewidth=0.9, linestyle=":", label=r"ISO 6336-1 B, $c_{\gamma\alpha}\,b$")
    axis.set_ylim(bottom=0.0)
    style.legend_below(figure, axis)
    return figure


def _over_angle(results: Results, label: str, rows: int = 1, size: tuple[float, float] = style.SINGLE) -> tuple[Figure, list[Axes]]:
    """Return a figure over the pinion angle, the zones shaded where an engagement is known."""
    figure, axes = style.make_figure(size, rows=rows)
    for number, axis in enumerate(axes):
        if results.engagement is not None:
            style.shade_zones(axis, results.engagement, results.setup.pair.pinion.pitch_angle, labels=number == 0)
        style.over_pitches(axis, label)
    for axis in axes[:-1]:
        axis.set_xlabel("")
    return figure, axes


@style.styled
def plot_load_share(results: Results) -> Figure:
    """Draw the load share of every pair that carries, over the pinion angle.

    Parameters
    ----------
    results : Results
        With its engagement stage.

    Returns
    -------
    Figure
    """
    engagement = need(results.engagement, "engagement")
    figure, (axis,) = _over_angle(results, "share of the normal force")
    x = engagement.contacts.pinion_angle / results.setup.pair.pinion.pitch_angle
    carrying = sorted({pair for pair, force in zip(engagement.contacts.pairs, engagement.force.T, strict=True) if force.any()})
    styles = zip((style.GREEN, style.BLUE, style.VERMILION, style.PURPLE, style.ORANGE), ("--", "-", "-.", ":", "--"), strict=True)
    for pair, (colour, line) in zip(carrying, styles, strict=False):
        axis.plot(x, share_of(engagement, pair), color=colour, linestyle=line, label=f"pair {pair:+d}" if pair else "pair 0")
    axis.set_ylim(0.0, 1.05)
    style.legend_below(figure, axis, columns=5)
    return figure


@style.styled
def plot_transmission_error(results: Results) -> Figure:
    """Draw the loaded transmission error over the pinion angle.

    Parameters
    ----------
    results : Results
        With its engagement stage.

    Returns
    -------
    Figure
    """
    engagement = need(results.engagement, "engagement")
    figure, (axis,) = _over_angle(results, "lag of the wheel along\nthe line of action, µm")
    x = engagement.contacts.pinion_angle / results.setup.pair.pinion.pitch_angle
    axis.plot(x, engagement.transmission_error / UM, color=style.BLUE)
    return figure


@style.styled
def plot_gear_ratio(results: Results) -> Figure:
    """Draw the gear ratio under load, of the rigid gears and of the forces, beside z2/z1.

    Parameters
    ----------
    results : Results
        With its engagement stage.

    Returns
    -------
    Figure
    """
    engagement = need(results.engagement, "engagement")
    figure, (axis,) = _over_angle(results, "gear ratio i")
    x = engagement.contacts.pinion_angle / results.setup.pair.pinion.pitch_angle
    axis.plot(x, engagement.gear_ratio, color=style.BLUE, label="under load, $dφ_1/dφ_2$")
    axis.plot(x, engagement.gear_ratio_force, color=style.VERMILION, linestyle="--", label="of the forces, $Σ P l_2/Σ P l_1$")
    axis.plot(x, engagement.gear_ratio_unloaded, color=style.INK, linestyle=":", label="rigid, unloaded")
    style.legend_below(figure, axis)
    return figure


@style.styled
def plot_velocities(results: Results) -> Figure:
    """Draw rolling and sliding velocity of pair 0 while it carries, at the nominal speed.

    Parameters
    ----------
    results : Results
        With its engagement stage.

    Returns
    -------
    Figure
    """
    engagement = need(results.engagement, "engagement")
    contacts, speed = engagement.contacts, results.setup.operation.pinion_speed
    figure, (axis,) = _over_angle(results, "velocity of pair 0, m/s")
    column = contacts.pairs.index(0)
    x = contacts.pinion_angle / results.setup.pair.pinion.pitch_angle
    held, straight = engagement.force[:, column] > 0.0, contacts.on_flanks[:, column]
    # At a corner the contact stands still on the tip and runs along the mate: parts of their own, not a curve with jumps.
    parts = ((held & straight, 1.5), (held & ~straight & (x < 0.0), 0.8), (held & ~straight & (x > 0.0), 0.8))
    axis.axhline(0.0, color=style.GREY, linewidth=0.7)
    for name, velocity, colour, line in (
        ("rolling, pinion", contacts.rolling_velocity1, style.BLUE, "-"),
        ("rolling, wheel", contacts.rolling_velocity2, style.VERMILION, "--"),
        ("sliding", contacts.sliding_velocity, style.INK, "-."),
    ):
        for part, width in parts:
            label = name if width > 1.0 else None
            axis.plot(x[part], velocity[part, column] * speed, color=colour, linestyle=line, linewidth=width, label=label)
    style.legend_below(figure, axis)
    return figure


@style.styled
def plot_rigid_motion(results: Results) -> Figure:
    """Draw speed and acceleration of the pinion in the rigid model over two pitches.

    Parameters
    ----------
    results : Results
        With its rigid motion.

    Returns
    -------
    Figure
    """
    return _speed_and_acceleration(results, need(results.rigid, "rigid motion"))


@style.styled
def plot_elastic_motion(results: Results) -> Figure:
    """Draw speed and acceleration of the pinion in the elastic model over two pitches.

    Parameters
    ----------
    results : Results
        With its elastic motion.

    Returns
    -------
    Figure
    """
    return _speed_and_acceleration(results, need(results.elastic, "elastic motion"))


def _speed_and_acceleration(results: Results, motion: RigidMotion | ElasticMotion) -> Figure:
    pitch = results.setup.pair.pinion.pitch_angle
    figure, (upper, lower) = _over_angle(results, "", rows=2)
    upper.plot(*style.two_pitches(motion.pinion_angle, motion.pinion_speed, pitch), color=style.BLUE)
    upper.set_ylabel("speed, rad/s")
    lower.plot(*style.two_pitches(motion.pinion_angle, motion.pinion_acceleration, pitch), color=style.BLUE)
    lower.set_ylabel("acceleration,\nrad/s²")
    figure.align_ylabels()
    return figure


@style.styled
def plot_dynamic_factor(results: Results) -> Figure:
    """Draw the dynamic factor over two pitches for the rigid, the elastic and the classical model.

    Parameters
    ----------
    results : Results
        With at least one motion.

    Returns
    -------
    Figure
    """
    pitch = results.setup.pair.pinion.pitch_angle
    figure, (axis,) = _over_angle(results, "dynamic factor $K_w$", size=style.WIDE)
    models = (
        ("classical", results.classical, style.INK, ":"),
        ("rigid", results.rigid, style.VERMILION, "--"),
        ("elastic", results.elastic, style.BLUE, "-"),
    )
    for name, motion, colour, line in models:
        if motion is not None:
            largest = float(motion.dynamic_factor.max())
            x, y = style.two_pitches(motion.pinion_angle, motion.dynamic_factor, pitch)
            axis.plot(x, y, color=colour, linestyle=line, label=f"{name}, largest {largest:.3f}")
    _keep_readable(axis, [motion.dynamic_factor for motion in (results.elastic, results.classical) if motion is not None])
    style.legend_below(figure, axis)
    return figure


def _keep_readable(axis: Axes, shown: list[Array]) -> None:
    """Let spikes of the rigid model leave the picture, and say so, where they would flatten the other curves."""
    low, high = axis.get_ylim()
    if not shown:
        return
    least, largest = min(values.min() for values in shown), max(values.max() for values in shown)
    room = 1.5 * (largest - least) + 0.2
    if low < least - room or high > largest + room:
        axis.set_ylim(max(low, least - room), min(high, largest + room))
        note = "spikes of the rigid model leave the picture"
        box = {"facecolor": "white", "edgecolor": "none", "pad": 2.0}
        axis.text(0.99, 0.03, note, transform=axis.transAxes, ha="right", fontsize=8.0, color=style.GREY, bbox=box)


PICTURES: dict[str, tuple[Callable[[Results], Figure], Callable[[Results], bool]]] = {
    "pair": (plot_pair, lambda results: True),
    "measured_flanks": (plot_measured_flanks, lambda results: bool(results.setup.flanks_given)),
    "effects": (plot_effects, has_effects),
    "compliance": (plot_compliance, lambda results: results.compliance is not None),
    "mesh_stiffness": (plot_stiffness, lambda results: results.engagement is not None),
    "load_share": (plot_load_share, lambda results: results.engagement is not None),
    "transmission_error": (plot_transmission_error, lambda results: results.engagement is not None),
    "flank_outlines": (plot_outlines, has_worn_flanks),
    "line_of_action": (plot_line_of_action, has_worn_flanks),
    "gear_ratios": (plot_four_ratios, has_worn_flanks),
    "gear_ratio": (plot_gear_ratio, lambda results: results.engagement is not None and not has_worn_flanks(results)),
    "velocities": (plot_velocities, lambda results: results.engagement is not None),
    "rigid_motion": (plot_rigid_motion, lambda results: results.rigid is not None),
    "elastic_motion": (plot_elastic_motion, lambda results: results.elastic is not None),
    "dynamic_factor": (plot_dynamic_factor, lambda results: results.elastic is not None),
}


def write_pictures(results: Results, out: Path) -> dict[str, Path]:
    """Write a PNG of every picture that the results allow.

    Parameters
    ----------
    results : Results
        Of any stages.
    out : Path
        Folder.

    Returns
    -------
    dict of str to Path
        Names of the pictures and their files.
    """
    return {name: style.save(draw(results), Path(out) / f"{name}.png") for name, (draw, able) in PICTURES.items() if able(results)}
