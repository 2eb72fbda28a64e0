"""What a diagnosis found reads the same from its model file as it did on the bench."""

from __future__ import annotations

import dataclasses
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gearfem.assembly import assemble
from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.modelling.calibrate import calibrated
from gearfem.diagnosis.modelling.system_bench import STRIDE, SystemBench
from gearfem.diagnosis.reading.measurement import Measurement, make_record
from gearfem.diagnosis.updated import effect_table, write_updated
from gearfem.effects.catalogue import catalogue, read_effects
from gearfem.foundation import Array
from gearfem.foundation.toml import write_toml
from gearfem.model import load_model, make_setup
from gearfem.sensing import observe, requests

TABLES: dict[str, Any] = {
    "pair": {"module_mm": 3.0, "face_width_mm": 20.0, "normal_backlash_mm": 0.1},
    "pinion": {"teeth": 17},
    "wheel": {"teeth": 22},
    "operation": {"pinion_torque_Nm": 100.0, "pinion_speed_rpm": 1000.0},
    "effect": [{"name": "profile_slope", "gear": "pinion", "amount_um": 3.0}],
    "calibration": {
        "torque_scale": 1.01,
        "gain": 1.02,
        "contact_evenness": 0.3,
        "angle_offset_rad": 0.02,
        "record": [{"file": "a.csv", "offset_um": 3.0}],
    },
}
# Each acts on a stage of its own, or overrules what a scale multiplies.
EFFECTS = ("tip_relief", "runout", "support_compliance", "torque_ripple", "damping", "friction", "sensor_gain", "sensor_lag")
ANGLE = np.linspace(0.0, 7.0, 150)


def settings() -> Settings:
    """Return nuisances none of which is neutral."""
    random = np.random.default_rng(3)
    return Settings(
        pinion_late=1e-6 * random.standard_normal(17),
        wheel_late=1e-6 * random.standard_normal(22),
        angle_offset=0.07,
        torque_scale=1.02,
        stiffness_scale=1.09,
        inertia_scale=1.04,
        damping_scale=0.7,
        gain=0.97,
        series_compliance=-8e-11,
        coupling_scale=0.6,
        tip_edge_scale=0.3,
        evenness=0.6,
        errors=(0.8, -1.2, 0.5, 1.1, 0.0, -0.7),
    )


def measurement(quantity: str, axis: Array, speed: float = 0.0) -> Measurement:
    """Return a record without values."""
    gear = "pinion" if quantity == "pitch_deviation" else None
    return make_record(quantity, axis, file="a.csv", pinion_torque=80.0, pinion_speed=speed, gear=gear)


RECORDS = (
    measurement("static_transmission_error", ANGLE),
    measurement("mesh_stiffness", ANGLE),
    measurement("dynamic_transmission_error", ANGLE, 150.0),
    measurement("pinion_angular_acceleration", ANGLE, 150.0),
    measurement("dynamic_factor", np.array([200.0])),
    measurement("pitch_deviation", np.arange(17.0)),
)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, SystemBench]:
    """Write a model, put effects and nuisances into it, and return the new file beside the bench that holds the same."""
    folder = tmp_path_factory.mktemp("updated")
    write_toml(folder / "nominal.toml", TABLES)
    setup = load_model(folder / "nominal.toml")
    effects = tuple(catalogue()[name].example(setup, "wheel") for name in EFFECTS)
    campaign: Any = types.SimpleNamespace(model=str(folder / "nominal.toml"), setup=setup)
    fit: Any = types.SimpleNamespace(effects=effects, settings=settings())
    proof: Any = types.SimpleNamespace(records=[types.SimpleNamespace(measurement=RECORDS[0], offset=4e-6)])
    (folder / "out").mkdir()
    path = write_updated(campaign, fit, proof, folder / "out" / "updated.toml")
    return path, SystemBench(system=assemble(setup, effects))


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.quantity.name)
def test_the_file_reads_what_the_bench_predicts(written: tuple[Path, SystemBench], record: Measurement) -> None:
    path, bench = written
    system = assemble(load_model(path))
    request = requests()[record.quantity.name](
        axis=record.axis,
        pinion_torque=record.pinion_torque,
        pinion_speed=record.pinion_speed,
        gear=record.gear or "pinion",
        file="a.csv",
        stride=STRIDE,
    )
    predicted = bench.predict(record, settings())
    if record.quantity.free_constant:
        # The bench holds the model's own constant, under its gain where there is one.
        gain = settings().gain if record.quantity.axis == "angle" else 1.0
        predicted = predicted + 4e-6 + 3e-6 * (1.0 - gain)
    # Tables of both stiffnesses hold the same numbers, so that little but rounding is left.
    np.testing.assert_allclose(observe(system, request), predicted, rtol=0.0, atol=1e-8 * max(np.ptp(predicted), np.abs(predicted).max()))


def test_a_fitted_misalignment_is_read_as_the_bench_has_it(written: tuple[Path, SystemBench]) -> None:
    _, bench = written
    setup, record = bench.system.setup, RECORDS[0]
    fitted = dataclasses.replace(settings(), errors=(0.0, 0.0, 0.0, 0.0, 0.9, 0.0))
    request = requests()[record.quantity.name](axis=record.axis, pinion_torque=80.0, file="b.csv")
    read = observe(calibrated(setup, fitted), request)
    aligned = observe(calibrated(setup, dataclasses.replace(fitted, errors=())), request)
    predicted = SystemBench(system=assemble(setup)).predict(record, fitted)
    error = read - predicted - np.mean(read - predicted)
    # Loads over the width are tabulated, to 2e-4 (see `static`); a stiffness scale moves their knots.
    assert np.abs(error).max() < 2e-4 * np.ptp(predicted) < 0.1 * np.abs(read - aligned).max()


def test_the_keys_of_the_owner_stay(written: tuple[Path, SystemBench]) -> None:
    setup = load_model(written[0])
    assert [effect.table()["name"] for effect in setup.effects if hasattr(effect, "table")] == ["profile_slope", *EFFECTS]
    assert setup.operation.damping_ratio == pytest.approx(0.06)
    assert setup.calibration.torque_scale == pytest.approx(1.01 * 1.02)
    # Each leaves its share of what the edges yield.
    assert 1.0 - setup.calibration.evenness == pytest.approx(0.7 * 0.4)
    assert setup.calibration.angle_offset == pytest.approx(0.09)
    assert setup.calibration.offset("a.csv") == pytest.approx(7e-6, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("edge", [0, 1])
@pytest.mark.parametrize("name", sorted(catalogue()))
def test_parameters_at_a_bound_are_read_again(name: str, edge: int) -> None:
    setup = make_setup(TABLES)
    kind = catalogue()[name]
    effect = kind.example(setup, "wheel")
    at_edge = {field: known.bounds(setup, effect.member)[edge] for field, known in kind.parameters().items()}
    table = effect_table(dataclasses.replace(effect, **at_edge), setup)
    (read,) = read_effects([table], setup)
    for field, value in at_edge.items():
        assert getattr(read, field) == pytest.approx(min(value, 1e15), rel=1e-14, abs=0.0)
