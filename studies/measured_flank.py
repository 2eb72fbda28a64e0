"""Tangent and curvature of a flank measured with error: which way of taking them from the points errs least.

The pinion of the coal combine pair wears by a known closed form that is no polynomial: 0.1 mm at the pitch point, up to
0.6 mm at both ends of the flank. It is sampled as the paper's authors did (35 points, 0.05 mm) and as a gear measuring
machine does (2000 points, 1 um), many times. The curve through the points is a cubic spline through every one of them, or the
fit of gearfem (polynomials of degree 4 to 6 by cross-validation, then a cubic spline). Tangent and curvature of either are taken
by derivatives, or by the circle through three points of it no farther apart than the half width of the Hertz contact, as
Wojnarowski & Onishchenko (2003) do; for the fit, besides, from the polynomials themselves.

    python studies/measured_flank.py --out results [--points FILE_OR_FOLDER] [--small]

With a file of points of that pinion, or a folder of campaign files with records of flank profiles, those are fitted too.
"""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from common import HERE, print_table, write_rows
from scipy.interpolate import CubicSpline

from gearfem import load_model
from gearfem.contact import HertzLine
from gearfem.definition.measured_flank import MeasuredFlank
from gearfem.definition.measured_points import read_flank, to_points
from gearfem.definition.setup import Gear, GearPair, Setup
from gearfem.flank import FittedFlank, Outline
from gearfem.flank.measured import fit_flank
from gearfem.foundation import Array
from gearfem.foundation.units import MM, UM
from gearfem.report import style
from gearfem.report.flank_plots import MOST_DRAWN, plot_flanks

MODEL = HERE / "coal_combine/model.toml"
DEEPEST, PITCH_DEPTH, SPREAD = 0.65e-3, 0.1e-3, 9e-3
# Errors are taken where neighbours stand on both sides: this share of the measured length is left out at each end.
ENDS = 0.05
PLACES = 181
COLUMNS = (
    "tangent_rms_mrad, tangent_worst_mrad: error of the direction of the tangent over places and draws, and its largest",
    "curvature_rms_1_per_m, curvature_rms_share: error of the curvature, and over the mean curvature of the worn flank",
    "curvature_bias_1_per_m: the same error for points without noise",
)


class Sampling(NamedTuple):
    """How a flank is measured: number of points, standard deviation of their depth [m], draws of the noise."""

    points: int
    noise: float
    draws: int


class Shape(NamedTuple):
    """Depth over roll length with its first two derivatives."""

    depth: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    bend: Callable[[Array], Array]


FULL = (Sampling(35, 50e-6, 400), Sampling(2000, 1e-6, 40))
SMALL = (Sampling(35, 50e-6, 40), Sampling(2000, 1e-6, 3))


def worn_shape(pair: GearPair) -> Shape:
    """Return the known wear of the pinion: least at the pitch point, a bell around it."""
    middle, height = pair.pinion.base_radius * np.tan(pair.working_pressure_angle), DEEPEST - PITCH_DEPTH

    def bell(roll: Array) -> Array:
        return height * np.exp(-(((roll - middle) / SPREAD) ** 2))

    return Shape(
        depth=lambda roll: DEEPEST - bell(roll),
        slope=lambda roll: 2.0 * (roll - middle) / SPREAD**2 * bell(roll),
        bend=lambda roll: (2.0 - 4.0 * ((roll - middle) / SPREAD) ** 2) / SPREAD**2 * bell(roll),
    )


def by_derivatives(shape: Shape, roll: Array, gear: Gear, width: float) -> tuple[Array, Array]:
    """Return direction of the tangent [rad] and curvature [1/m] from the derivatives of the depth.

    The point is T + (s - d) e, e the nominal normal, so P' = -d' e - (s - d)/r_b t; the rest is the curvature of any plane curve.
    """
    base = gear.base_radius
    normal = gear.base_half_angle - roll / base + np.pi / 2.0
    inner, slope, bend = roll - shape.depth(roll), shape.slope(roll), shape.bend(roll)
    # Components along e and along e turned on by a right angle; e itself turns by -1/r_b per roll length.
    ahead, aside = -slope, -inner / base
    ahead2, aside2 = -bend + aside / base, -(1.0 - slope) / base - ahead / base
    speed = np.hypot(ahead, aside)
    return normal + np.arctan2(aside, ahead), -(ahead * aside2 - aside * ahead2) / speed**3


def by_circle(shape: Shape, roll: Array, gear: Gear, width: float) -> tuple[Array, Array]:
    """Return direction of the tangent [rad] and curvature [1/m] of the circle through a point and two neighbours at a distance."""
    step = width * gear.base_radius / roll
    before, here, after = (to_points(place, shape.depth(place), gear) for place in (roll - step, roll, roll + step))
    first, second, chord = here - before, after - here, after - before
    one, two, whole = (np.hypot(*part.T) for part in (first, second, chord))
    cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    # Metal lies to the right of the way up the flank, so a right turn is convex; both chords turn by half of their arcs.
    turn = np.arcsin(np.clip(cross / (one * two), -1.0, 1.0))
    direction = np.arctan2(first[:, 1], first[:, 0]) + turn * one / (one + two)
    return direction, -2.0 * cross / (one * two * whole)


def spline_through(roll: Array, depth: Array) -> Shape:
    curve = CubicSpline(roll, depth)
    return Shape(curve, curve.derivative(1), curve.derivative(2))


def spline_of(fit: FittedFlank) -> Shape:
    return Shape(fit.deviation.at, fit.deviation.slope, fit.deviation.bend)


def polynomials_of(fit: FittedFlank) -> Shape:
    return Shape(*(lambda roll, order=order: fit.curve.at(roll, order) for order in range(3)))


def measured(roll: Array, depth: Array) -> MeasuredFlank:
    rows = np.arange(1, roll.size + 1)
    return MeasuredFlank(member="pinion", tooth=None, file="drawn", system="roll length", row=rows, roll=roll, depth=depth, below=rows[:0])


def ways(roll: Array, depth: Array, gear: Gear) -> Iterator[tuple[str, Shape, Callable[..., tuple[Array, Array]]]]:
    """Yield all ways of taking tangent and curvature from points."""
    through, fit = spline_through(roll, depth), fit_flank(measured(roll, depth), gear)
    yield "spline through the points, derivatives", through, by_derivatives
    yield "spline through the points, circle", through, by_circle
    yield "spline of the fit, derivatives", spline_of(fit), by_derivatives
    yield "spline of the fit, circle", spline_of(fit), by_circle
    yield "polynomials of the fit, derivatives", polynomials_of(fit), by_derivatives


class Study(NamedTuple):
    """The pinion, its true wear, tangents and curvatures at the places compared, and the half width of the contact [m]."""

    gear: Gear
    wear: Shape
    ends: tuple[float, float]
    places: Array
    tangent: Array
    curvature: Array
    width: float


def prepare(setup: Setup) -> Study:
    pair = setup.pair
    gear, wear = pair.pinion, worn_shape(pair)
    outline = Outline(gear=gear)
    # Worn points between form circle and tip form circle; the deepest wear moves them up by no more than itself.
    ends = (outline.flank_start + DEEPEST, outline.flank_end)
    margin = ENDS * (ends[1] - ends[0])
    places = np.linspace(ends[0] + margin, ends[1] - margin, PLACES)
    law = HertzLine(pinion=gear.material, wheel=pair.wheel.material)
    flanks = np.array([part.base_radius for part in (gear, pair.wheel)]) * np.tan(pair.working_pressure_angle)
    load = setup.operation.pinion_torque / gear.base_radius / pair.face_width
    width = float(law.half_width(load, 1.0 / (1.0 / flanks).sum()))
    return Study(gear, wear, ends, places, *by_derivatives(wear, places, gear, width), width)


def errors(study: Study, roll: Array, depth: Array) -> dict[str, tuple[Array, Array]]:
    """Return the errors of tangent [rad] and curvature [1/m] at the places, by way."""
    found = {}
    for name, shape, method in ways(roll, depth, study.gear):
        tangent, curvature = method(shape, study.places, study.gear, study.width)
        found[name] = (np.angle(np.exp(1j * (tangent - study.tangent))), curvature - study.curvature)
    return found


def compare(study: Study, samplings: tuple[Sampling, ...]) -> list[dict[str, Any]]:
    """Return one row for each sampling and way."""
    rng = np.random.default_rng(2003)
    rows = []
    for sampling in samplings:
        roll = np.linspace(*study.ends, sampling.points)
        exact = study.wear.depth(roll)
        drawn = [errors(study, roll, exact + sampling.noise * rng.standard_normal(roll.size)) for _ in range(sampling.draws)]
        bias = errors(study, roll, exact)
        for name in bias:
            tangent, curvature = (np.array([one[name][part] for one in drawn]) for part in (0, 1))
            rows.append(
                {
                    "points": sampling.points,
                    "noise_um": sampling.noise / UM,
                    "way": name,
                    "tangent_rms_mrad": 1e3 * _rms(tangent),
                    "tangent_worst_mrad": 1e3 * float(np.abs(tangent).max()),
                    "curvature_rms_1_per_m": _rms(curvature),
                    "curvature_rms_share": _rms(curvature) / float(np.abs(study.curvature).mean()),
                    "curvature_bias_1_per_m": _rms(bias[name][1]),
                }
            )
    return rows


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def conclude(rows: list[dict[str, Any]], study: Study) -> list[str]:
    """Return what the numbers say, in sentences."""
    lines = [f"Half width of the Hertz contact at the pitch point: {study.width / MM:.3f} mm."]
    for points in dict.fromkeys(row["points"] for row in rows):
        mine = {row["way"]: row for row in rows if row["points"] == points}
        noise = next(iter(mine.values()))["noise_um"]
        for key, words in (("tangent_rms_mrad", "tangent"), ("curvature_rms_1_per_m", "curvature")):
            order = sorted(mine, key=lambda way: mine[way][key])
            close = [way for way in order if mine[way][key] < 1.02 * mine[order[0]][key]]
            lines.append(
                f"{points} points, {noise:g} um: least error of the {words}: {' and '.join(close)} ({mine[order[0]][key]:.3g} "
                f"{key.split('_rms_')[1].replace('_per_', '/')}); most: {order[-1]} ({mine[order[-1]][key]:.3g})."
            )
        twice, circle, fit = (
            mine[f"spline {name}"]["curvature_rms_1_per_m"]
            for name in ("through the points, derivatives", "through the points, circle", "of the fit, derivatives")
        )
        lines.append(
            f"  On the spline through the points the circle has {circle / twice:.3g} of the curvature error of differentiating twice; "
            f"the fit, differentiated twice, has {fit / twice:.3g} of it, and the circle on the fit "
            f"{mine['spline of the fit, circle']['curvature_rms_1_per_m'] / fit:.3f} of the fit's."
        )
    return lines


@style.styled
def draw(study: Study, sampling: Sampling, out: Path) -> None:
    """Draw one set of points: curvature over the roll length by all ways, and the true one."""
    rng = np.random.default_rng(1)
    roll = np.linspace(*study.ends, sampling.points)
    depth = study.wear.depth(roll) + sampling.noise * rng.standard_normal(roll.size)
    found = errors(study, roll, depth)
    figure, axes = style.make_figure(style.WIDE, columns=2)
    colours = (style.VERMILION, style.ORANGE, style.BLUE, style.GREEN, style.PURPLE)
    for axis, part, truth, label in zip(axes, (0, 1), (0.0, study.curvature), ("tangent, error in mrad", "curvature, 1/m"), strict=True):
        scale = 1e3 if part == 0 else 1.0
        for (name, error), colour in zip(found.items(), colours, strict=True):
            axis.plot(study.places / MM, scale * (error[part] + truth), color=colour, linewidth=1.0, label=name)
        axis.plot(study.places / MM, np.broadcast_to(truth, study.places.shape), color=style.INK, linewidth=2.0, label="true", zorder=0)
        calm = np.concatenate([found[name][part] for name in found if "fit" in name])
        room = 3.0 * np.abs(scale * calm).max()
        axis.set_ylim(float(np.min(scale * truth)) - room, float(np.max(scale * truth)) + room)
        axis.set_xlabel("roll length, mm")
        axis.set_ylabel(label)
    axes[0].set_title(f"{sampling.points} points, {sampling.noise / UM:g} µm; lines through the points leave the picture")
    style.legend_below(figure, axes[0])
    style.save(figure, out / f"curvature_{sampling.points}_points.png")


# ---- points of others ----------------------------------------------------------------------------------


def fits_of(source: Path) -> list[FittedFlank]:
    """Return the fits of a file of points of the pinion, or of every flank profile of the campaigns in a folder."""
    if source.is_file():
        gear = load_model(MODEL).pair.pinion
        return [fit_flank(read_flank(source, source.name, "pinion", None, gear), gear)]
    found = []
    for path in sorted(source.glob("*.toml")):
        campaign = tomllib.loads(path.read_text(encoding="utf-8"))
        for record in campaign.get("record", []):
            if record.get("quantity") == "flank_profile":
                pair = load_model(path.parent / campaign["model"]).pair
                gear = pair.gear(record["gear"])
                points = read_flank(path.parent / record["file"], record["file"], record["gear"], record.get("tooth"), gear)
                found.append(fit_flank(points, gear))
    return found


def show_fits(fits: list[FittedFlank], out: Path) -> list[dict[str, Any]]:
    """Print, table and draw fits of measured flanks."""
    rows = [
        {
            "file": fit.points.file,
            "points": fit.roll.size,
            "fragments": len(fit.curve.coefficients),
            "degrees": " ".join(map(str, fit.curve.degrees)),
            "outliers": len(fit.outliers),
            "aside": int(fit.aside.size),
            "residual_std_um": fit.residual_std / UM,
            "cross_validation_um": fit.cross_validation / UM,
            "longest_gap_mm": fit.largest_gap / MM,
        }
        for fit in fits
    ]
    write_rows(out / "fits.csv", rows, tuple(fit.sentence for fit in fits))
    print_table("measured flanks", rows)
    for first in range(0, len(fits), MOST_DRAWN):
        style.save(plot_flanks(fits[first : first + MOST_DRAWN]), out / f"fits_{first // MOST_DRAWN + 1}.png")
    return rows


def main(arguments: list[str] | None = None) -> dict[str, Any]:
    """Run the study; write tables and pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="folder for the results")
    parser.add_argument("--points", type=Path, help="CSV of points of the coal combine's pinion, or a folder of campaigns")
    parser.add_argument("--small", action="store_true", help="few draws of the noise")
    given = parser.parse_args(arguments)
    samplings = SMALL if given.small else FULL
    study = prepare(load_model(MODEL))
    rows = compare(study, samplings)
    print_table("errors of tangent and curvature, rms over the flank and all draws", rows)
    lines = conclude(rows, study)
    print("\n" + "\n".join(lines))
    write_rows(given.out / "tangent_and_curvature.csv", rows, COLUMNS)
    (given.out / "conclusion.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    for sampling in samplings:
        draw(study, sampling, given.out)
    fits = show_fits(fits_of(given.points), given.out) if given.points else []
    return {"rows": rows, "conclusion": lines, "fits": fits}


if __name__ == "__main__":
    main()
