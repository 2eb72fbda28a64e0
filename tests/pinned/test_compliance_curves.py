"""Compliance curves of the coal combine as they were: our own past, no truth. `truth`, `limits` and `convergence` outrank them.

``python tests/pinned/test_compliance_curves.py`` writes the tables anew; say in the commit why they changed.
"""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest

from gearfem import load_model
from gearfem.compliance import Bore, Castigliano, FiniteElements, PlaneStrain, PlaneStress, Root, RootChord
from gearfem.flank import make_flanks
from gearfem.foundation.files import write_csv
from gearfem.foundation.units import MM, UM_PER_N_PER_MM

HERE = Path(__file__).parent
MODEL = HERE.parents[1] / "studies" / "coal_combine" / "model.toml"
U = np.linspace(2.0, 3.0, 12)
METHODS = (
    *(
        FiniteElements(plane=plane, support=support)
        for plane in (PlaneStrain(), PlaneStress())
        for support in (Bore(), Root(), RootChord())
    ),
    Castigliano(),
)
COMMENTS = (
    "Our own past, no truth: what gearfem gave when this was written. Written by tests/pinned/test_compliance_curves.py.",
    "tolerance_fe = 1e-3 of the value plus 1e-4 of the largest: the error of the default mesh is below 1e-3, so that a better mesh "
    "may move a value by so much; more means that the model has changed.",
    "tolerance_castigliano = 1e-9: closed integrals, written with ten digits.",
)


def curves(member: str) -> dict[str, np.ndarray]:
    """Return the columns of a table."""
    flanks = make_flanks(load_model(str(MODEL)))
    outline = flanks.pinion if member == "pinion" else flanks.wheel
    found = [method.curve(outline, U) for method in METHODS]
    return {
        "method": np.concatenate([np.full(curve.u.size, curve.method) for curve in found]),
        "support": np.concatenate([np.full(curve.u.size, curve.support) for curve in found]),
        "radius_mm": np.concatenate([curve.radius for curve in found]) / MM,
        "deflection_um_per_N_per_mm": np.concatenate([curve.deflection for curve in found]) / UM_PER_N_PER_MM,
    }


@pytest.mark.parametrize("member", ["pinion", "wheel"])
def test_curves_are_what_they_were(member: str) -> None:
    lines = (HERE / f"compliance_{member}.csv").read_text(encoding="utf-8").splitlines()
    share, floor = (float(text) for text in re.search(r"tolerance_fe = (\S+) of the value plus (\S+) of", "\n".join(lines)).groups())
    exact = float(re.search(r"tolerance_castigliano = ([^:]+):", "\n".join(lines))[1])
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    now = curves(member)
    names = [(row["method"], row["support"]) for row in rows]
    assert names == list(zip(now["method"].tolist(), now["support"].tolist(), strict=True))
    then = {name: np.array([float(row[name]) for row in rows]) for name in ("radius_mm", "deflection_um_per_N_per_mm")}
    assert now["radius_mm"] == pytest.approx(then["radius_mm"], rel=exact, abs=0.0)
    for name in dict.fromkeys(names):
        own = np.array([other == name for other in names])
        old, new = then["deflection_um_per_N_per_mm"][own], now["deflection_um_per_N_per_mm"][own]
        allowed = exact * old if name[0] == "castigliano" else share * old + floor * old.max()
        print(member, *name, f"largest change {np.abs(new / old - 1.0).max():.1e}")
        assert np.all(np.abs(new - old) <= allowed), name


if __name__ == "__main__":
    for gear in ("pinion", "wheel"):
        write_csv(HERE / f"compliance_{gear}.csv", curves(gear), COMMENTS)
