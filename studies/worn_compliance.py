"""What wear changes in the stiffness of a tooth pair: contact much, bending little? And when it needs finite elements of its own.

Wojnarowski & Onishchenko (2003) say that wear changes the rigidity of the contact much and that of bending little. Both gears of a
pair are worn by depths of their range, 0.1 to 0.7 mm, in three assumed shapes over the height of the flank, and
the yield of the pair under its operating load is taken apart into that of the teeth and bodies (finite elements of the worn
teeth) and that of the contact (curvature and depth of the worn flanks). Besides, the transmission error is computed with
the compliance of teeth without wear, with that in proportion to the depth, and with that of the worn teeth.

    python studies/worn_compliance.py --out results
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from common import print_table, write_rows

from gearfem import load_model
from gearfem.compliance import FiniteElements, flank_response, make_compliance
from gearfem.compliance.record import Compliance
from gearfem.compliance.worn import LITTLE
from gearfem.contact import EdgedLine
from gearfem.definition.setup import Setup
from gearfem.engagement.engage import Mesh, engage
from gearfem.flank import Deviation, Flanks, Outline, make_flanks
from gearfem.foundation.units import MM
from gearfem.placement import make_placement

HERE = Path(__file__).parent
MEMBERS = ("pinion", "wheel")
# Depth over the largest one, on the part of the flank from its start (0) to its end (1).
SHAPES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "even": lambda part: np.ones_like(part),
    "root_and_tip": lambda part: 0.2 + 0.8 * (2.0 * part - 1.0) ** 2,
    "tip": lambda part: 0.2 + 0.8 * part**2,
}


def wear(flanks: Flanks, depth: float, shape: Callable[[np.ndarray], np.ndarray]) -> Flanks:
    """Return the flanks of both gears with a largest depth [m] missing."""

    def worn(outline: Outline) -> Outline:
        def missing(roll: np.ndarray) -> np.ndarray:
            part = (roll - outline.flank_start) / (outline.flank_end - outline.flank_start)
            # Past its ends the flank wears as it does there and a little more, as its own ends move.
            return depth * shape(np.clip(part, -0.1, 1.1))

        return Outline(gear=outline.gear, deviation=Deviation.none(outline.gear).plus(missing))

    return Flanks(pinion=worn(flanks.pinion), wheel=worn(flanks.wheel))


def parts(mesh: Mesh, angles: np.ndarray, torque: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the yield of pair 0 alone under the whole load: of teeth and bodies, and of the contact [m]."""
    contacts = mesh.contacts(angles)
    column = contacts.pairs.index(0)
    system = mesh.system(contacts)
    force = torque / system.arm
    bending = np.einsum("ajj->aj", system.linear) * force
    return bending[:, column], mesh.law.approach(force, system.line)[:, column]


def _change(new: np.ndarray, old: np.ndarray) -> np.ndarray:
    return 100.0 * (new / old - 1.0)


class Pair:
    """A gear pair whose flanks wear, with all that does not."""

    def __init__(self, setup: Setup, angles: int) -> None:
        self.setup, self.flanks = setup, make_flanks(setup)
        self.law = EdgedLine(pinion=setup.pair.pinion.material, wheel=setup.pair.wheel.material)
        pitch = setup.pair.pinion.pitch_angle
        # About the pitch point pair 0 carries the load alone.
        self.single = np.linspace(-0.3, 0.3, angles) * pitch
        self.pitch = np.arange(angles) / angles * pitch
        self.sound = make_compliance(self.flanks)

    def mesh(self, flanks: Flanks, compliance: Compliance) -> Mesh:
        """Return the engagement of these flanks with these teeth."""
        return Mesh(flanks=flanks, placement=make_placement(self.setup), compliance=compliance, law=self.law)

    def solved(self, flanks: Flanks) -> Compliance:
        """Return the compliance of worn teeth by finite elements of their own, whatever their depth."""
        teeth = {name: FiniteElements().tooth(getattr(flanks, name), getattr(self.sound, name).u) for name in MEMBERS}
        return dataclasses.replace(self.sound, **teeth)

    def in_proportion(self, flanks: Flanks) -> Compliance:
        """Return the compliance of worn teeth as the response to what is missing, whatever its depth."""
        sound = {name: getattr(self.sound, name) for name in MEMBERS}
        teeth = {name: flank_response(FiniteElements(), one.outline, one.u).at(getattr(flanks, name)) for name, one in sound.items()}
        return dataclasses.replace(self.sound, **teeth)

    def row(self, name: str, depth: float) -> dict[str, Any]:
        """Return what wear of one shape and depth [m] changes, in per cent."""
        worn, torque = wear(self.flanks, depth, SHAPES[name]), self.setup.operation.pinion_torque
        exact = self.solved(worn)
        before = parts(self.mesh(self.flanks, self.sound), self.single, torque)
        after = parts(self.mesh(worn, exact), self.single, torque)
        bending, contact = (_change(new, old) for new, old in zip(after, before, strict=True))
        same = _change(parts(self.mesh(self.flanks, exact), self.single, torque)[0], before[0])
        compliances = {"exact": exact, "sound": self.sound, "response": self.in_proportion(worn)}
        error = {key: engage(self.mesh(self.flanks, one), self.pitch, torque).transmission_error for key, one in compliances.items()}
        return {
            "shape": name,
            "depth_mm": depth / MM,
            "depth_modules": depth / self.setup.pair.pinion.module,
            "contact_share_percent": 100.0 * (before[1] / sum(before)).mean(),
            "bending_same_points_percent": np.abs(same).max(),
            "bending_least_percent": bending.min(),
            "bending_most_percent": bending.max(),
            "contact_least_percent": contact.min(),
            "contact_most_percent": contact.max(),
            "both_most_percent": np.abs(_change(sum(after), sum(before))).max(),
            "error_without_wear_percent": np.abs(_change(error["sound"], error["exact"])).max(),
            "error_in_proportion_percent": np.abs(_change(error["response"], error["exact"])).max(),
        }


def study(setup: Setup, depths: tuple[float, ...], angles: int = 41) -> list[dict[str, Any]]:
    """Return the rows of all shapes and depths [m]."""
    pair = Pair(setup, angles)
    return [pair.row(name, depth) for name in SHAPES for depth in depths]


def sentences(rows: list[dict[str, Any]]) -> tuple[str, ...]:
    """Return what the rows say."""
    deepest = max(row["depth_mm"] for row in rows)
    said = []
    for row in rows:
        if row["depth_mm"] == deepest:
            said.append(
                f"{row['shape']}, {deepest:g} mm on both gears: teeth and bodies yield up to "
                f"{row['bending_same_points_percent']:.1f} % more or less at the same points, {row['bending_least_percent']:+.1f} to "
                f"{row['bending_most_percent']:+.1f} % where worn flanks touch; the contact, {row['contact_share_percent']:.0f} % of "
                f"the yield, {row['contact_least_percent']:+.1f} to {row['contact_most_percent']:+.1f} %"
            )
    worst = max(row["error_without_wear_percent"] / row["depth_modules"] for row in rows)
    said.append(
        f"compliance of teeth without wear misses the transmission error by up to {worst:.0f} % per module of depth: "
        f"by 0.1 % from {0.1 / worst:.2g} modules on"
    )
    little = [row["error_in_proportion_percent"] for row in rows if row["depth_modules"] <= LITTLE * (1.0 + 1e-9)]
    if little:
        said.append(f"compliance in proportion to the depth misses it by up to {max(little):.2g} % up to {LITTLE:g} modules")
    return tuple(said)


def main(arguments: list[str] | None = None) -> list[dict[str, Any]]:
    """Run the study, print its table and write it to a folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", type=Path, default=HERE / "coal_combine" / "model.toml")
    parser.add_argument("--out", type=Path, default=Path("results"))
    parser.add_argument("--depths", type=float, nargs="+", default=[0.01, 0.05, 0.1, 0.16, 0.3, 0.5, 0.7], help="largest depths [mm]")
    parser.add_argument("--angles", type=int, default=41, help="pinion angles")
    options = parser.parse_args(arguments)
    rows = study(load_model(options.model), tuple(depth * MM for depth in options.depths), options.angles)
    print_table("change by wear of both gears", rows)
    for sentence in sentences(rows):
        print(sentence)
    path = options.out / "worn_compliance.csv"
    write_rows(path, rows, sentences(rows))
    print(f"wrote {path}")
    return rows


if __name__ == "__main__":
    main()
