"""compliance.csv with its error estimates, body.csv, and results that are not computed twice."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from gearfem import load_model
from gearfem.cli import main
from gearfem.compliance import Castigliano, FiniteElements, Root, load_positions, make_compliance
from gearfem.compliance import finite_elements as module
from gearfem.flank import Outline, make_flanks
from gearfem.pipeline import run
from tests.unit.shell import rows

MODEL = "studies/coal_combine/model.toml"


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("compliance")
    result = CliRunner().invoke(main, ["compliance", MODEL, "--out", str(out)])
    assert result.exit_code == 0, result.output
    assert "wind-up about the bore is" in result.output
    return out


def test_each_row_states_its_error_and_each_radius_stands_once(written: Path) -> None:
    table = rows(written / "compliance.csv")
    keys = [(row["gear"], row["method"], row["support"], row["radius_mm"]) for row in table]
    assert len(set(keys)) == len(keys)
    for row in table:
        error = float(row["error_estimate"])
        assert 0.0 < error < 0.002
        assert (error == 1e-14) == (row["method"] == "castigliano")


def test_error_column_is_the_methods_own_estimate(written: Path) -> None:
    outline = make_flanks(load_model(MODEL)).wheel
    u = load_positions(outline)
    expected = FiniteElements().error(outline, u[u <= 3.0])
    column = [
        float(r["error_estimate"]) for r in rows(written / "compliance.csv") if (r["gear"], r["method"]) == ("wheel", "fe_plane_strain")
    ]
    # Ten digits are written.
    assert column == pytest.approx(expected, rel=1e-9, abs=0.0)


def test_body_parts_add_up_and_agree_with_the_compliance(written: Path) -> None:
    table = rows(written / "body.csv")
    whole = {
        (r["gear"], r["radius_mm"]): float(r["deflection_um_per_N_per_mm"])
        for r in rows(written / "compliance.csv")
        if r["method"] == "fe_plane_strain"
    }
    assert {row["gear"] for row in table} == {"pinion", "wheel"}
    for row in table:
        total, tooth, body, wind_up = (float(row[f"{part}deflection_um_per_N_per_mm"]) for part in ("", "tooth_", "body_", "wind_up_"))
        # Ten digits are written.
        assert total == pytest.approx(whole[row["gear"], row["radius_mm"]], rel=1e-9, abs=0.0)
        assert tooth + body == pytest.approx(total, rel=1e-8, abs=0.0)
        assert float(row["wind_up_share"]) == pytest.approx(wind_up / total, rel=1e-8, abs=0.0)
        assert 0.0 < wind_up < body
    # By hand: 2.5416e-10 rad per N = 2.5416e-7 rad for 1 N m per mm; the base radius of the wheel is 191.697 mm.
    last = [row for row in table if row["gear"] == "wheel"][-1]
    assert float(last["wind_up_rotation_rad_per_Nm_per_mm"]) == pytest.approx(2.5416e-7, rel=1e-4, abs=0.0)
    assert float(last["wind_up_deflection_um_per_N_per_mm"]) == pytest.approx(2.5416e-10 * 0.191697**2 * 1e9, rel=1e-4, abs=0.0)


def test_rounding_is_all_the_error_a_closed_form_has(coal_combine) -> None:
    outline = Outline(gear=coal_combine.pair.wheel)
    u = load_positions(outline)
    assert len(Castigliano().error(outline, u)) == len(Castigliano().curve(outline, u).u) < len(u)


@pytest.fixture
def solves(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Grows by one with each stiffness matrix that is assembled."""
    seen: list[str] = []
    assemble = module.stiffness

    def counted(*args: object) -> object:
        seen.append("assembled")
        return assemble(*args)

    monkeypatch.setattr(module, "stiffness", counted)
    module._curve.forget()
    module._tooth.forget()
    return seen


def test_variations_of_load_and_drive_do_no_finite_elements(solves: list[str]) -> None:
    for torque in np.linspace(100.0, 2000.0, 20):
        setup = load_model(MODEL, (f"operation.pinion_torque_Nm={torque}", f"operation.pinion_inertia_kg_m2={torque / 100.0}"))
        run(setup, until="compliance")
        assert len(solves) == 2
    run(load_model(MODEL, ("pinion.bore_radius_mm=31.0",)), until="compliance")
    assert len(solves) == 3


def test_what_changes_the_result_is_solved_again(solves: list[str], small_pair) -> None:
    flanks = make_flanks(small_pair)
    method = FiniteElements(resolution=1.0)
    make_compliance(flanks, method, 12)
    make_compliance(flanks, method, 12)
    assert len(solves) == 2
    make_compliance(flanks, method, 14)
    make_compliance(flanks, FiniteElements(resolution=1.5), 12)
    FiniteElements(resolution=1.0, support=Root()).curve(flanks.pinion, [2.6, 2.9])
    FiniteElements(resolution=1.0).curve(flanks.pinion, [2.6, 2.9])
    assert len(solves) == 8
