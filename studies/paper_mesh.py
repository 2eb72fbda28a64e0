"""What the coarse mesh of Wojnarowski & Onishchenko (2003) costs in accuracy, over the flanks of both gears.

Their tooth has 585 eight-node hexahedra and 896 nodes, 128 of them held, 8 in each of 16 sections; which eight is not said, so
both readings are computed. Each is set beside the same tooth, held in the same way, with its elements divided (what the
coarse elements cost), and beside the refined tooth held on the root circle (that and the clamp together).

    python studies/paper_mesh.py --out results
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from gearfem import load_model
from gearfem.compliance import Root
from gearfem.compliance.paper_mesh import Clamp, LayerAndSides, PaperMesh, TwoLayers
from gearfem.compliance.solid import SolidElements
from gearfem.definition.setup import Setup
from gearfem.flank import Outline
from gearfem.foundation.files import write_csv
from gearfem.foundation.units import MM, UM_PER_N_PER_MM

HERE = Path(__file__).parent
CLAMPS: tuple[Clamp, ...] = (TwoLayers(), LayerAndSides())
Table = dict[str, np.ndarray]


def compare(name: str, outline: Outline, face_width: float, refinement: int, resolution: float) -> list[Table]:
    """Return, for each clamp, deflections over the rows of the published mesh and what its coarseness costs.

    Parameters
    ----------
    name : str
        Of the gear.
    outline : Outline
        Outline of its tooth.
    face_width : float
        Face width [m].
    refinement : int
        Into how many each side of an element of the published mesh is divided.
    resolution : float
        Of the refined tooth held on the root circle.
    """
    root = SolidElements(support=Root(), resolution=resolution)
    tables = []
    for clamp in CLAMPS:
        paper = PaperMesh(clamp=clamp).curve(outline, face_width)
        divided = PaperMesh(clamp=clamp, refinement=refinement).curve(outline, face_width)
        refined = root.curve(outline, paper.u, face_width)
        # The refined tooth has no row where the load line meets the axis under the arc; the published one starts on its chord.
        rows = np.isin(paper.u, refined.u)
        published, same = paper.deflection[rows], divided.deflection[rows]
        tables.append(
            {
                "gear": np.full(rows.sum(), name),
                "held": np.full(rows.sum(), clamp.name),
                "radius_mm": refined.radius / MM,
                "paper_um_per_N_per_mm": published / UM_PER_N_PER_MM,
                "divided_um_per_N_per_mm": same / UM_PER_N_PER_MM,
                "refined_root_um_per_N_per_mm": refined.deflection / UM_PER_N_PER_MM,
                "coarse_elements_percent": 100.0 * (published / same - 1.0),
                "paper_over_root_percent": 100.0 * (published / refined.deflection - 1.0),
            }
        )
    return tables


def study(setup: Setup, refinement: int = 4, resolution: float = 1.5) -> list[Table]:
    """Return the tables of both gears and both clamps."""
    pair = setup.pair
    tables = []
    for name, gear in (("pinion", pair.pinion), ("wheel", pair.wheel)):
        tables += compare(name, Outline(gear=gear), pair.face_width, refinement, resolution)
    return tables


def sentence(table: Table) -> str:
    """Return what one table says."""
    upper = table["radius_mm"] >= table["radius_mm"].mean()
    parts = []
    for column, what in (
        ("coarse_elements_percent", "its own elements divided"),
        ("paper_over_root_percent", "the refined tooth on the root circle"),
    ):
        values = table[column]
        low, high = values[upper].min(), values[upper].max()
        parts.append(f"{low:+.1f} to {high:+.1f} % from {what} on the upper half of the flank ({values[0]:+.0f} % on its lowest row)")
    return f"{table['gear'][0]}, {table['held'][0]}: deflection " + "; ".join(parts)


def main(arguments: list[str] | None = None) -> list[Table]:
    """Run the study, print its tables and write them to a folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", type=Path, default=HERE / "coal_combine" / "model.toml")
    parser.add_argument("--out", type=Path, default=Path("results"))
    parser.add_argument("--refinement", type=int, default=4, help="into how many each side of an element is divided")
    parser.add_argument("--resolution", type=float, default=1.5, help="of the refined tooth on the root circle")
    options = parser.parse_args(arguments)
    tables = study(load_model(options.model), options.refinement, options.resolution)
    names = list(tables[0])
    for table in tables:
        print(f"{table['gear'][0]}, held {table['held'][0]}")
        print("  radius   paper's  divided  root circle [um per N/mm]  coarse elements  over root circle")
        for row in zip(*(table[name] for name in names[2:]), strict=True):
            print("  {:6.2f}  {:.3e} {:.3e} {:.3e}  {:+6.1f} %  {:+6.1f} %".format(*row))
    for table in tables:
        print(sentence(table))
    path = options.out / "paper_mesh.csv"
    write_csv(path, {name: np.concatenate([table[name] for table in tables]) for name in names}, tuple(map(sentence, tables)))
    print(f"wrote {path}")
    return tables


if __name__ == "__main__":
    main()
