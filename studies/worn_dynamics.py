"""What the paper says of worn teeth, statement by statement, beside what comes out here: Figs. 6, 7, 8 and 11, cases 0, 1 and 2.

Runs the three cases of Table 2 in Wojnarowski & Onishchenko (2003) (cases 1 and 2 are reconstructions: studies/coal_combine/case_*.toml)
from flanks to motions and sets the paper's statements beside our figures, agreed or not, with the reason.

    python studies/worn_dynamics.py --out results
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from worn_compliance import parts

from gearfem import Results, load_model, run
from gearfem.foundation.files import write_csv
from gearfem.foundation.units import MM, UM
from gearfem.report import style, write_kinematics_pictures
from gearfem.wear import removed_volume

HERE = Path(__file__).parent
VOLUMES = {0: (0.0, 0.0), 1: (242.0, 142.0), 2: (642.0, 328.0)}
COLOURS = {0: style.INK, 1: style.BLUE, 2: style.VERMILION}


class Figures(NamedTuple):
    """What a case comes to."""

    results: Results
    off_line: float
    two_pairs: float
    ratio_away: float
    ratio_mean: float
    rigid: float
    elastic: float
    single_rigid: float
    single_elastic: float
    classical: float
    elastic_with_plus: float


class Statement(NamedTuple):
    """A sentence of the paper, our figure, and whether they agree."""

    figure: str
    paper: str
    ours: str
    verdict: str
    reason: str


def off_the_line(results: Results) -> float:
    """Return how far contacts of flanks that carry lie from the straight line of action [m]."""
    engagement, placement = results.engagement, results.mesh.placement
    held = (engagement.force > 0.0) & engagement.contacts.on_flanks
    angle = placement.working_pressure_angle
    from_pitch = engagement.contacts.point[held] - (placement.centre_distance / (1.0 + results.setup.pair.ratio), 0.0)
    return float(np.abs(from_pitch @ (np.cos(angle), -np.sin(angle))).max())


def in_single(results: Results, angle: np.ndarray) -> np.ndarray:
    """Say at which pinion angles [rad] one pair carries the static load."""
    pitch = results.setup.pair.pinion.pitch_angle
    contacts = results.engagement.contacts
    single = results.engagement.pairs_in_contact == 1
    row = np.searchsorted(contacts.pinion_angle, (angle % pitch), side="right") - 1
    return single[np.clip(row, 0, single.size - 1)]


def case(number: int) -> Figures:
    """Run a case to its motions."""
    results = run(load_model(HERE / "coal_combine" / f"case_{number}.toml"))
    engagement, ratio, pitch = results.engagement, results.setup.pair.ratio, results.setup.pair.pinion.pitch_angle
    one = engagement.contacts.pinion_angle < -1e-9
    single = {name: in_single(results, getattr(results, name).pinion_angle) for name in ("rigid", "elastic")}
    lag = engagement.transmission_error
    turned = pitch / ratio - (lag[one.sum()] - lag[0]) / results.setup.pair.wheel.base_radius
    return Figures(
        results=results,
        off_line=off_the_line(results),
        two_pairs=float((engagement.pairs_in_contact > 1)[one].mean()),
        ratio_away=float(np.abs(engagement.gear_ratio / ratio - 1.0).max()),
        ratio_mean=pitch / turned / ratio - 1.0,
        rigid=float(results.rigid.dynamic_factor.max()),
        elastic=results.elastic.largest_dynamic_factor,
        single_rigid=float(results.rigid.dynamic_factor[single["rigid"]].max()),
        single_elastic=float(results.elastic.dynamic_factor[single["elastic"]].max()),
        classical=results.classical.largest_dynamic_factor,
        elastic_with_plus=float((2.0 - results.elastic.dynamic_factor).max()),
    )


def statements(found: dict[int, Figures]) -> list[Statement]:
    """Return the paper's statements beside ours."""
    figures = found[0], found[1], found[2]
    return [*of_contact(*figures), *of_ratio(*figures), *of_dynamics(*figures)]


def said(figure: str, paper: str, ours: str, agrees: bool, reason: str) -> Statement:
    """Return a statement with its verdict."""
    return Statement(figure, paper, ours, "agrees" if agrees else "differs", reason)


def of_contact(zero: Figures, one: Figures, two: Figures) -> list[Statement]:
    """Return what is said of stiffness, line of action and two-pair zone."""
    bending, contact = zip(*(yields(figures.results, zero.results) for figures in (one, two)), strict=True)
    return [
        said(
            "section 2",
            "wear changes the rigidity of the contact considerably, that of bending insignificantly",
            f"about the pitch point the contact yields {contact[0]} (case 1) and {contact[1]} (case 2) more or less than unworn, teeth and "
            f"bodies {bending[0]} and {bending[1]}",
            largest(contact) > 2.0 * largest(bending),
            "the contact's yield grows with the logarithm of its radius alone; that of the teeth with what is missing of them, and with "
            "where worn flanks touch",
        ),
        said(
            "Fig. 7",
            "the line of action is straight for unworn teeth, curved for worn ones",
            f"contacts lie up to {zero.off_line / MM:.2g}, {one.off_line / MM:.2f} and {two.off_line / MM:.2f} mm from the straight line",
            zero.off_line < 1e-9 and min(one.off_line, two.off_line) > 1e-4,
            "a slope of the worn flank turns the normal, and the contact moves along the flank to where both normals agree",
        ),
        said(
            "Fig. 7",
            "the zone of two pairs is considerably decreased by wear",
            f"two pairs carry over {100 * zero.two_pairs:.0f}, {100 * one.two_pairs:.0f} and {100 * two.two_pairs:.0f} % of the pitch",
            two.two_pairs < one.two_pairs < zero.two_pairs,
            "under load, teeth bent into early contact included; the pair that comes in or goes out has worn away from its mate",
        ),
    ]


def of_ratio(zero: Figures, one: Figures, two: Figures) -> list[Statement]:
    """Return what is said of the gear ratio."""
    means = max(abs(figures.ratio_mean) for figures in (zero, one, two))
    return [
        said(
            "Fig. 8",
            "the ratio varies near the ends of the two-pair zones even for unworn teeth, by deformation",
            f"unworn, it stays within {100 * zero.ratio_away:.2f} % of z2/z1, and differs from it only where pairs hand over",
            0.0 < zero.ratio_away < 0.02,
            "central difference of the loaded transmission error",
        ),
        said(
            "Fig. 8",
            "wear changes the ratio by no more than 5 %",
            f"case 1 {100 * one.ratio_away:.1f} %, case 2 {100 * two.ratio_away:.1f} % at most",
            max(one.ratio_away, two.ratio_away) <= 0.05,
            "where a contact moves over to the other side of a hollow both sides carry for a while, and the ratio has no spike",
        ),
        said(
            "Fig. 8",
            "the mean ratio is kept",
            f"mean over the wheel's angle away from z2/z1 by {means:.0e} at most",
            means < 1e-6,
            "an identity of the periodic transmission error",
        ),
    ]


def of_dynamics(zero: Figures, one: Figures, two: Figures) -> list[Statement]:
    """Return what is said of the dynamic factor."""
    where = {name: [peak_place(figures.results, name) for figures in (zero, one, two)] for name in ("rigid", "elastic")}
    single = {"rigid": two.single_rigid / zero.single_rigid, "elastic": two.single_elastic / zero.single_elastic}
    return [
        said(
            "Fig. 11",
            "already unworn teeth load themselves dynamically by the change of the ratio",
            f"largest Kw unworn: rigid {zero.rigid:.2f}, elastic {zero.elastic:.2f}",
            zero.rigid > 1.02,
            "the rigid model takes the ratio of the forces, whose hand-over has its physical width",
        ),
        said(
            "Fig. 11",
            "case 1: Kw is largest at the start and the end of engagement",
            f"case 1: rigid {one.rigid:.2f} at {where['rigid'][1]:+.2f} pitches from the pitch point, elastic {one.elastic:.2f} at "
            f"{where['elastic'][1]:+.2f}; unworn {where['rigid'][0]:+.2f} and {where['elastic'][0]:+.2f}",
            min(abs(where[name][1]) for name in where) > 0.25,
            "where pairs hand over the ratio changes fastest, but the elastic drive answers with its own vibration, some "
            f"{cycles(one.results)} swings to the pitch, whose largest one need not stand at the hand-over",
        ),
        said(
            "Fig. 11",
            "case 2: Kw grows two to three times through the one-pair zone",
            f"largest Kw there, case 2 over case 0: rigid {single['rigid']:.2f}, elastic {single['elastic']:.2f} "
            f"(whole cycle: {two.rigid / zero.rigid:.2f} and {two.elastic / zero.elastic:.2f}); what exceeds 1 in the "
            f"elastic model grows {(two.elastic - 1.0) / (zero.elastic - 1.0):.1f} times; with a plus in eq. 29 it would be "
            f"{two.elastic_with_plus / zero.elastic_with_plus:.2f}",
            2.0 <= single["elastic"] <= 3.0 or 2.0 <= single["rigid"] <= 3.0,
            "depends on the slopes of the worn flanks, of which the volumes of Table 2 fix none: a reconstruction by Archard's law with "
            "dirt wears more evenly than a picture may show, one without dirt less",
        ),
    ]


def yields(worn: Results, sound: Results) -> tuple[str, str]:
    """Return by how much wear changes the yield of teeth and bodies, and of the contact, of pair 0 under the whole load, in words."""
    angles = np.linspace(-0.3, 0.3, 61) * sound.setup.pair.pinion.pitch_angle
    torque = sound.setup.operation.pinion_torque
    after, before = (parts(results.mesh, angles, torque) for results in (worn, sound))
    changes = [100.0 * (new / old - 1.0) for new, old in zip(after, before, strict=True)]
    bending, contact = (f"{change.min():+.1f} to {change.max():+.1f} %" for change in changes)
    return bending, contact


def largest(words: tuple[str, ...]) -> float:
    """Return the largest change that `yields` put into words [%]."""
    return max(abs(float(part)) for text in words for part in text.removesuffix(" %").split(" to "))


def peak_place(results: Results, model: str) -> float:
    """Return where Kw of a model is largest, in pitches from the nearest pitch point."""
    motion = getattr(results, model)
    place = motion.pinion_angle[np.argmax(motion.dynamic_factor)] / results.setup.pair.pinion.pitch_angle
    return float((place + 0.5) % 1.0 - 0.5)


def cycles(results: Results) -> int:
    """Return how often the elastic Kw passes a maximum in a pitch."""
    values = results.elastic.dynamic_factor
    rising = np.diff(values) > 1e-6
    pitches = (results.elastic.pinion_angle[-1] - results.elastic.pinion_angle[0]) / results.setup.pair.pinion.pitch_angle
    return round(float((rising[:-1] & ~rising[1:]).sum() / pitches))


@style.styled
def plot_cases(found: dict[int, Figures]) -> Figure:
    """Draw Figs. 7, 8 and 11 of the three cases: how far contacts are from the straight line, ratio, and Kw of both models."""
    figure, axes = style.make_figure((11.0, 7.0), rows=2, columns=2)
    for axis in axes:
        axis.tick_params(labelbottom=True)
    for number, figures in found.items():
        results, colour = figures.results, COLOURS[number]
        pitch, engagement = results.setup.pair.pinion.pitch_angle, results.engagement
        label = f"case {number}"
        x = engagement.contacts.pinion_angle / pitch
        held = (engagement.force > 0.0) & engagement.contacts.on_flanks
        angle = results.mesh.placement.working_pressure_angle
        centre = results.mesh.placement.centre_distance / (1.0 + results.setup.pair.ratio)
        away = (engagement.contacts.point - (centre, 0.0)) @ (np.cos(angle), -np.sin(angle))
        column = engagement.contacts.pairs.index(0)
        axes[0].plot(x[held[:, column]], away[held[:, column], column] / MM, ".", markersize=3, color=colour, label=label)
        axes[1].plot(x, engagement.gear_ratio, color=colour, linewidth=1.1, label=label)
        for axis, motion in ((axes[2], results.rigid), (axes[3], results.elastic)):
            axis.plot(*style.two_pitches(motion.pinion_angle, motion.dynamic_factor, pitch), color=colour, linewidth=1.1)
    titles = ("Fig. 7: contacts of pair 0 off the straight line, mm", "Fig. 8: gear ratio under load")
    for axis, title in zip(axes, (*titles, "Fig. 11: Kw, rigid model", "Fig. 11: Kw, elastic model"), strict=True):
        style.over_pitches(axis, "")
        axis.set_title(title)
    style.legend_below(figure, axes[0])
    return figure


def rows(found: dict[int, Figures]) -> list[dict[str, Any]]:
    """Return the figures of the cases as a table."""
    table = []
    for number, figures in found.items():
        results = figures.results
        width = results.setup.pair.face_width
        volumes = [removed_volume(results.flanks.of(member), width) / MM**3 for member in ("pinion", "wheel")]
        values = {key: value for key, value in figures._asdict().items() if key != "results"}
        table.append(
            {
                "case": number,
                "pinion_volume_mm3": volumes[0],
                "wheel_volume_mm3": volumes[1],
                "pinion_deepest_um": results.flanks.pinion.deepest / UM,
                "wheel_deepest_um": results.flanks.wheel.deepest / UM,
                **values,
            }
        )
    return table


def main(arguments: list[str] | None = None) -> tuple[list[dict[str, Any]], list[Statement]]:
    """Run the cases, print and write what they say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder for tables and pictures")
    out = parser.parse_args(arguments).out
    found = {number: case(number) for number in VOLUMES}
    table, said = rows(found), statements(found)
    write_csv(out / "worn_cases.csv", {key: [row[key] for row in table] for key in table[0]}, ("cases 1 and 2 are reconstructions",))
    write_csv(out / "worn_statements.csv", {key: [getattr(one, key) for one in said] for key in Statement._fields})
    for number, figures in found.items():
        write_kinematics_pictures(figures.results, out / f"case_{number}")
    style.save(plot_cases(found), out / "worn_dynamics.png")
    for row in table:
        print("  ".join(f"{key} {value:.4g}" for key, value in row.items()))
    for one in said:
        print(f"\n{one.figure}: {one.paper}\n  ours: {one.ours}\n  {one.verdict}: {one.reason}")
    return table, said


if __name__ == "__main__":
    main()
