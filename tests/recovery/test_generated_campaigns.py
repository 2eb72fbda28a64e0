"""Campaigns of the blind generator: every effect shows, files and labels are exact, and the seed fixes all of it."""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from .generator import make_case, write_case
from .generator.campaign import Case
from .generator.design import draw_model, draw_pair, draw_specs, draw_truth, nominal_system
from .generator.effects import APPLY, Effect
from .generator.hidden import HIDDEN
from .generator.observe import COLUMNS, STATIC_OF_ONE_GEAR, Spec, axis, measure
from .generator.sizes import SINGLE, draw, equivalent
from .generator.strength import Scale
from .generator.system import System

TORQUE = 74.0
PARAMETERS = {
    "profile_wear": {"gear", "tip_um", "root_um", "pitch_um"},
    "tip_relief": {"gear", "amount_um", "length_mm"},
    "profile_slope": {"gear", "amount_um"},
    "pitch_error": {"gear", "tooth", "amount_um"},
    "runout": {"gear", "eccentricity_um", "angle_rad"},
    "root_crack": {"gear", "tooth", "depth_mm"},
    "pitting": {"gear", "tooth", "depth_um", "centre_mm", "width_mm"},
    "lead_misalignment": {"slope_um"},
    "crowning": {"gear", "amount_um"},
    "end_relief": {"gear", "amount_um", "length_mm"},
    "body_compliance": {"scale"},
    "support_compliance": {"pinion_um_per_kN", "wheel_um_per_kN"},
    "contact_compliance": {"scale"},
    "centre_distance": {"amount_um"},
    "friction": {"coefficient"},
    "damping": {"ratio"},
    "torque_ripple": {"gear", "order", "amplitude_Nm", "phase_rad"},
    "sensor_gain": {"scale"},
    "sensor_lag": {"delay_s"},
    "sensor_resonance": {"frequency_Hz", "ratio"},
}


class TestEffects:
    def test_every_effect_has_its_parameters_and_shows(self, healthy: System) -> None:
        specs = [
            Spec("a", "static_transmission_error", TORQUE, turns=1.2, samples=24),
            Spec("b", "dynamic_transmission_error", TORQUE, 500.0, turns=1.2, samples=24),
        ]
        base = [measure(healthy, s) for s in specs]
        assert set(SINGLE) | {"backlash"} == set(APPLY)
        for name in SINGLE:
            params, _, most = draw(name, healthy, specs, np.random.default_rng(2))
            effect = Effect(name, params(0.5 * most), 9)
            assert set(effect.params) == PARAMETERS[name]
            changed = [measure(effect.apply(healthy), s) for s in specs]
            assert max(np.std(c - b) for c, b in zip(changed, base, strict=True)) > 0.03, name

    def test_shapes_are_not_the_catalogues(self, healthy: System) -> None:
        """The nearest parabola still misses a drawn relief by a few per cent of its depth, yet follows it."""
        params = {"gear": "pinion", "amount_um": 10.0, "length_mm": 2.5}
        tip = healthy.pair.pinion.tip_roll
        s = np.linspace(healthy.pair.lowest_roll(0), tip, 200)
        for shape in range(6):
            depth = Effect("tip_relief", params, shape).apply(healthy).profiles[-1].depth
            near = equivalent("tip_relief", healthy, params, depth)
            parabola = near["amount_um"] * np.maximum(1.0 - (tip - s) * 1e3 / near["length_mm"], 0.0) ** 2
            miss = np.sqrt(np.mean((depth(s) * 1e6 - parabola) ** 2))
            assert 0.02 < miss < 0.8
            assert float(depth(np.array([tip]))[0]) == pytest.approx(10e-6, rel=1e-9, abs=0.0)

    def test_hidden_causes_show(self, healthy: System) -> None:
        spec = Spec("a", "static_transmission_error", TORQUE, turns=1.2, samples=24)
        fast = Spec("b", "dynamic_transmission_error", TORQUE, 500.0, turns=1.2, samples=24)
        for name, cause in HIDDEN.items():
            make, _, most = cause(healthy, np.random.default_rng(1))
            system = make(0.3 * most)
            shown = max(float(np.std(measure(system, s) - measure(healthy, s))) for s in (spec, fast))
            assert shown > 0.1, name

    def test_strength_grows_with_size_and_not_from_nuisances(self, healthy: System) -> None:
        specs = [Spec(str(t), "static_transmission_error", t, noise=0.2, turns=1.2) for t in (8.0, 30.0, 74.0)]
        scale = Scale(healthy, specs)
        one, two = (
            scale.of(Effect("runout", {"gear": "pinion", "eccentricity_um": e, "angle_rad": 1.0}).apply(healthy)) for e in (2.0, 4.0)
        )
        assert two / one == pytest.approx(2.0, rel=0.05, abs=0.0)
        assert two > 5.0
        assert scale.of(replace(healthy, torque_gain=1.01, angle_offset=0.005 * healthy.pair.pitch)) < 1.5


class TestCases:
    def test_seed_fixes_everything(self) -> None:
        first, second, other = (make_case(seed, "twins") for seed in ((3, 4), (3, 4), (3, 5)))
        assert first.label == second.label
        for a, b in zip(first.series, second.series, strict=True):
            assert np.array_equal(a[0], b[0])
            assert np.array_equal(a[1], b[1])
        assert other.model != first.model

    def test_files_are_exact(self, mixed: Case, tmp_path: Path) -> None:
        write_case(mixed, tmp_path, "case_0000")
        folder = tmp_path / "case_0000"
        campaign = tomllib.loads((folder / "campaign.toml").read_text())
        assert set(campaign) == {"name", "model", "angle_zero", "record"}
        assert campaign["angle_zero"] in ("unknown", "pitch_point")
        model = tomllib.loads((folder / "nominal.toml").read_text())
        assert set(model) == {"name", "pair", "pinion", "wheel", "material", "operation"}
        names = [r["file"] for r in campaign["record"]]
        assert len(names) == len(set(names)) == len(list(folder.glob("*.csv")))
        for record in campaign["record"]:
            quantity = record["quantity"]
            slow = quantity in STATIC_OF_ONE_GEAR
            wanted = {"file", "quantity"} | ({"gear"} if slow else {"pinion_torque_Nm"})
            wanted |= set() if slow or quantity == "dynamic_factor" else {"pinion_speed_rpm"}
            assert wanted <= set(record) <= wanted | {"noise_std", "role", "tooth", "tooth_zero"}
            header, *rows = (folder / record["file"]).read_text().splitlines()
            assert header == ",".join(COLUMNS[quantity])
            values = np.array([[float(x) for x in row.split(",")] for row in rows])
            assert np.isfinite(values).all()
            assert np.all(np.diff(values[:, 0]) > 0.0)

    def test_label_lies_apart_and_says_what_counts(self, mixed: Case, tmp_path: Path) -> None:
        write_case(mixed, tmp_path, "case_0000")
        assert not [p for p in (tmp_path / "case_0000").iterdir() if "label" in p.name or p.suffix == ".json"]
        label = json.loads((tmp_path / "labels" / "case_0000.json").read_text())
        assert label["kind"] == "single"
        assert label["accept"][0] == [{"name": "tip_relief", "gear": label["effects"][0]["parameters"]["gear"]}]
        assert 6.0 <= label["strengths"][0] <= 40.0
        for row in label["records"]:
            assert row["noise_rms"] <= row["floor_index_rms"] <= row["floor_rms"] * 1.2
        slow = [r for r in label["records"] if r["quantity"] == "static_transmission_error"]
        assert all(0.3 < r["floor_rms"] < 2.0 for r in slow)

    def test_every_quantity_can_be_read(self, shifted: System) -> None:
        for quantity in COLUMNS:
            spec = Spec("x", quantity, 200.0, 90.0, turns=1.0, samples=20, speeds=(100.0, 200.0))
            first, second = axis(shifted, spec), measure(shifted, spec)
            assert first.shape == second.shape
            assert np.isfinite(second).all()
            assert np.ptp(second) > 0.0 or quantity == "radial_runout"

    def test_pairs_and_campaigns_are_sound(self) -> None:
        pairs = set()
        for seed in range(12):
            rng = np.random.default_rng(seed)
            pair = draw_pair(rng)
            truth, values = draw_truth(nominal_system(pair, draw_model(pair, rng)), False, rng)
            specs = draw_specs(truth, rng)
            pairs.add((pair.pinion.teeth, pair.wheel.teeth, pair.pinion.module))
            assert 1.2 < pair.contact_ratio < 1.85
            assert abs(values["angle_offset_rad"]) < 0.5 * pair.pitch
            slow = [s for s in specs if s.quantity == "static_transmission_error"]
            assert len(slow) >= 4
            assert 0.05 <= slow[0].torque / truth.torque <= 0.151
            assert sum(s.role == "holdout" for s in slow) == 1
            assert all(1.5 <= s.turns <= 4.2 for s in slow)
        assert len(pairs) > 9

    def test_a_twin_is_one_and_its_record_decides(self) -> None:
        case = make_case((2, 3), "twins", "slope_of_either_gear")
        alone, left, decided = case.label["strengths"]
        assert left < 0.5 * alone
        assert decided > 2.0 * left
        assert case.label["verdicts"] == ["ambiguous"]
        assert len(case.label["accept"]) == 2
        again = case.measure_more(case.deciding[0])
        assert np.array_equal(again[1], case.measure_more(case.deciding[0])[1])
