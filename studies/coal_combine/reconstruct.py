"""Reconstruct the worn flanks of Table 2 in Wojnarowski & Onishchenko (2003), whose curves exist only as pictures.

What is known of a case: volume of metal worn off one flank of pinion and wheel (Table 2), hours of operation, depths of 0.1 to
0.7 mm where the flank works, unequal along its height, 30 to 40 measured points per flank. Assumed: Archard's law under the operation
torque, at constant speed, contacts and load sharing following the wear; dirt in the oil, which wears what is rolled over by a part
ROLLING of what it wears in sliding (without it the pitch point would wear too little for 0.1 mm); one coefficient of wear for each gear,
found so that both volumes come out. All teeth of a gear alike. Not known and not assumed: what the teeth of these machines looked like.

    python studies/coal_combine/reconstruct.py --out studies/coal_combine

writes case_0.toml, case_1.toml, case_2.toml and their flanks, in about five minutes.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gearfem import Setup, load_model
from gearfem.definition.measured_points import read_flank
from gearfem.flank import Deviation, Outline, make_flanks
from gearfem.flank.measured import fit_flank
from gearfem.foundation import Array
from gearfem.foundation.files import whole, write_csv
from gearfem.foundation.units import MM, UM
from gearfem.wear import Archard, Life, removed_volume, wear_over

HERE = Path(__file__).parent
MEMBERS = ("pinion", "wheel")
MM3 = MM**3
ROLLING = 0.6
POINTS = 40


class Case(NamedTuple):
    """A row of Table 2: machine, hours, and volumes worn off one flank of pinion and wheel [m3]."""

    machine: int
    hours: float
    volumes: tuple[float, float]


CASES = {1: Case(342, 3000.0, (242.0 * MM3, 142.0 * MM3)), 2: Case(2224, 12000.0, (642.0 * MM3, 328.0 * MM3))}


def live(setup: Setup, case: Case, rolling: float, rounds: int = 2) -> Life:
    """Return the life whose volumes are nearest those of a case: a short one gives the first guess of the coefficients."""
    turns = case.hours * 3600.0 * setup.operation.pinion_speed / (2.0 * math.pi)
    coefficients, part = np.full(2, 1e-17), 0.01
    for _ in range(rounds + 1):
        law = Archard(pinion_coefficient=coefficients[0], wheel_coefficient=coefficients[1], rolling=rolling)
        life = wear_over(setup, law, part * turns)
        found = np.array([life.pinion_volume[-1], life.wheel_volume[-1]])
        coefficients, part = coefficients * part * np.array(case.volumes) / found, 1.0
    return life


def points(setup: Setup, life: Life, member: str, volume: float, path: Path) -> tuple[Array, Array]:
    """Return measured points [m] of one flank, scaled so that the fit to them lacks the volume; writes them to a file."""
    outline = make_flanks(setup).of(member)
    nodes = Deviation.none(outline.gear).roll
    worn = Outline(gear=outline.gear, deviation=Deviation(roll=nodes, depth=life.depth(member)[-1]))
    roll, scale = np.linspace(worn.flank_start, worn.flank_end, POINTS), 1.0
    for _ in range(4):
        depth = scale * worn.deviation.at(roll)
        header = f"Reconstruction, no measurement: see {path.name.rpartition('_')[0]}.toml."
        write_csv(path, {"roll_length_mm": np.round(roll / MM, 4), "deviation_um": np.round(depth / UM, 2)}, (header,))
        fit = fit_flank(read_flank(path, path.name, member, None, outline.gear), outline.gear)
        scale *= volume / removed_volume(Outline(gear=outline.gear, deviation=fit.deviation), setup.pair.face_width)
    return roll, depth


def model_text(base: str, number: int, case: Case | None, life: Life | None, depths: dict[str, Array], rolling: float) -> str:
    """Return the model file of a case: the pair of Table 1 with the flanks of Table 2."""
    body = base[base.index("[pair]") :]
    if case is None or life is None:
        title = "# Case 0 of Table 2 in Wojnarowski & Onishchenko (2003): the pair of model.toml, without wear."
        return f'{title}\nname = "coal combine pair, case 0"\n\n{body}'
    law = life.law
    ranges = ", ".join(f"{member} {depth.min() / MM:.2f} to {depth.max() / MM:.2f} mm" for member, depth in depths.items())
    volumes, factors = (volume / MM3 for volume in case.volumes), (law.pinion_coefficient, law.wheel_coefficient)
    pinion, wheel = (f"{volume:g}" for volume in volumes)
    k1, k2 = (f"{factor:.3g}" for factor in factors)
    lines = [
        f"Case {number} of Table 2 in Wojnarowski & Onishchenko (2003): machine {case.machine} after {case.hours:g} h.",
        "A RECONSTRUCTION: the measured curves exist only as a picture (Fig. 6). Made by reconstruct.py beside this file. From the paper:",
        f"  volumes worn off one flank: pinion {pinion}, wheel {wheel} mm3 (metal between involute and fitted flank);",
        "  depths of 0.1 to 0.7 mm, unequal along the height; in heavy wear the least need not lie at the pitch point; 30 to 40 points.",
        "Assumed:",
        "  Archard's law at constant speed under the operation torque, contacts and load sharing following the wear;",
        f"  dirt in the oil: rolling wears as {rolling:g} of sliding; without it the pitch point would hardly wear;",
        f"  one coefficient of wear for each gear, k = {k1} (pinion) and {k2} 1/Pa (wheel), from the volumes;",
        "  all teeth of a gear alike; no wear below what the mate's tip reaches.",
        f"Depths where the flank works: {ranges}.",
    ]
    text = "\n".join(f"# {line}" for line in lines)
    for member in MEMBERS:
        start = body.index(f"[{member}]")
        end = body.index("\n\n", start)
        body = f'{body[:end]}\n\n[[{member}.flank]]\nfile = "case_{number}_{member}.csv"{body[end:]}'
    name = f"coal combine pair, case {number}: machine {case.machine} after {case.hours:g} h, wear reconstructed"
    return f'{text}\nname = "{name}"\n\n{body}'


def working(setup: Setup, member: str, roll: Array, depth: Array) -> Array:
    """Return the depths between the lowest contact point of the unworn pair and the tip."""
    pair, flanks = setup.pair, make_flanks(setup)
    mate = flanks.of("wheel" if member == "pinion" else "pinion")
    lowest = pair.centre_distance * math.sin(pair.working_pressure_angle) - mate.flank_end
    inside = np.linspace(lowest, flanks.of(member).flank_end, 400)
    return np.interp(inside, roll, depth)


def main(arguments: list[str] | None = None) -> dict[int, dict[str, Array]]:
    """Reconstruct the cases and write their models and flanks; return the depths where the flanks work."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder for the models and flanks")
    parser.add_argument("--cases", type=int, nargs="+", choices=tuple(CASES), default=list(CASES))
    parser.add_argument("--rolling", type=float, default=ROLLING, help="part of rolling that wears as sliding does")
    options = parser.parse_args(arguments)
    source = HERE / "model.toml"
    base, setup = source.read_text(encoding="utf-8"), load_model(source)
    texts, found = {0: model_text(base, 0, None, None, {}, 0.0)}, {}
    for number in options.cases:
        case = CASES[number]
        life, depths = live(setup, case, options.rolling), {}
        for member, volume in zip(MEMBERS, case.volumes, strict=True):
            roll, depth = points(setup, life, member, volume, options.out / f"case_{number}_{member}.csv")
            depths[member] = working(setup, member, roll, depth)
            print(f"case {number}, {member}: {depths[member].min() / MM:.3f} to {depths[member].max() / MM:.3f} mm where the flank works")
        texts[number], found[number] = model_text(base, number, case, life, depths, options.rolling), depths
    for number, text in texts.items():
        with whole(options.out / f"case_{number}.toml") as temporary:
            temporary.write_text(text, encoding="utf-8")
    return found


if __name__ == "__main__":
    main()
