"""Several steady motions at one speed: what a kick at the beginning leads to, and the one that a record shows."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gearfem.assembly import assemble
from gearfem.definition.model_file import read_tables
from gearfem.diagnosis.comparing.branches import FAR, NEARER, nearest
from gearfem.diagnosis.modelling.calibrate import left_of
from gearfem.diagnosis.reading.measurement import Measurement, make_record
from gearfem.diagnosis.updated import _record
from gearfem.dynamics.turns import march_turns
from gearfem.engagement.turns import Turns
from gearfem.foundation import Array, SolveError
from gearfem.foundation.toml import write_toml
from gearfem.foundation.units import RPM
from gearfem.model import load_model
from gearfem.sensing import observe
from tests.unit.shell import MODEL

PITCH = 2.0 * math.pi / 16.0
ANGLE = np.linspace(0.0, 2.0 * PITCH, 97)
# Below the resonance at 1584 rpm, damping a fifth of the model's: flanks stay in contact, or are apart for a third of the time.
SPEED, TORQUE, DAMPING = 1450.0 * RPM, 1605.0, 0.02
KICK = (-1.0, 0.0)


@pytest.fixture(scope="module")
def lightly_damped():
    setup = load_model(MODEL)
    calibration = dataclasses.replace(setup.calibration, damping_scale=DAMPING / assemble(setup).drive.damping_ratio)
    return dataclasses.replace(setup, calibration=calibration)


@pytest.fixture(scope="module")
def record(lightly_damped) -> Measurement:
    """Of a rig that came down through the resonance."""
    kicked = dataclasses.replace(lightly_damped, calibration=dataclasses.replace(lightly_damped.calibration, kicks=(("dte.csv", KICK),)))
    empty = make_record("dynamic_transmission_error", ANGLE, file="dte.csv", pinion_torque=TORQUE, pinion_speed=SPEED)
    return dataclasses.replace(empty, value=observe(assemble(kicked), empty.request(kick=None)))


def test_a_kick_leads_to_the_motion_that_a_run_down_leads_to(lightly_damped) -> None:
    system = assemble(lightly_damped)
    turns = Turns(mesh=system.mesh)

    def moved(**begun: object) -> Array:
        motion = march_turns(turns, system.drive, ANGLE, speed=SPEED, torque=TORQUE, loads=False, **begun)  # type: ignore[arg-type]
        return motion.transmission_error - motion.transmission_error.mean()

    start = None
    for speed in np.linspace(1550.0, 1460.0, 10) * RPM:
        start = march_turns(turns, system.drive, ANGLE, speed=speed, torque=TORQUE, start=start, loads=False).end
    from_rest, kicked, down = moved(), moved(kick=KICK), moved(start=start)
    assert kicked.std() > 2.0 * from_rest.std()
    assert np.abs(kicked - down).max() < 0.02 * kicked.std()


def test_a_record_is_met_by_the_motion_that_it_shows(lightly_damped, record) -> None:
    system = assemble(lightly_damped)

    def left(one: Measurement) -> Array:
        return left_of(one, system)[0]

    found = nearest(record, 1e-6, left(record), left)
    assert any(found.kick)
    assert float(np.std(left(found))) < 0.02 * float(np.std(left(record)))


@pytest.mark.parametrize(
    ("first", "other", "taken"),
    [(1.01 * FAR, 0.99 * NEARER * FAR, True), (1.01 * FAR, 1.1 * NEARER * FAR, False), (0.99 * FAR, 0.1, False)],
)
def test_another_motion_is_taken_only_where_the_first_is_far_off_and_it_leaves_half(first: float, other: float, taken: bool) -> None:
    """Errors beyond what can be expected are something else as a rule; where a motion cannot be computed the next one is tried."""
    record = make_record("dynamic_transmission_error", ANGLE)

    def left(one: Measurement) -> Array:
        if one.kick[0] < -1.0:
            raise SolveError("grows without bound")
        return np.full(ANGLE.size, other if one.kick == (0.0, 3.0) else first)

    assert nearest(record, FAR, left(record), left).kick == ((0.0, 3.0) if taken else (0.0, 0.0))


def test_how_a_motion_begins_goes_with_the_model_that_a_diagnosis_writes(tmp_path, record) -> None:
    kicked: Any = SimpleNamespace(measurement=dataclasses.replace(record, kick=KICK), offset=0.0)
    setup = load_model(MODEL)
    tables = read_tables(Path(MODEL)) | {"calibration": {"record": [_record(setup.calibration, kicked, setup.pair)]}}
    write_toml(tmp_path / "updated.toml", tables)
    again = load_model(tmp_path / "updated.toml")
    assert again.calibration.kick("dte.csv") == KICK
    assert again.calibration.kick("other.csv") == (0.0, 0.0)


def test_slow_records_have_one_motion() -> None:
    record = make_record("static_transmission_error", ANGLE)
    far = np.full(ANGLE.size, 100.0)
    assert nearest(record, 1.0, far, lambda one: 0.0 * far) is record


def motion_of(system: Any, kick: tuple[float, float]) -> Measurement:
    """Return a record over sixteen pitches."""
    empty = make_record("dynamic_transmission_error", PITCH * np.arange(384) / 24.0, pinion_torque=TORQUE, pinion_speed=SPEED, kick=kick)
    return dataclasses.replace(empty, value=observe(system, empty.request()))


@pytest.mark.parametrize(("jump", "kick"), [(290, (0.0, 0.0)), (110, KICK)])
def test_a_record_that_shows_two_motions_is_cut_to_the_longer_part(lightly_damped, jump: int, kick: tuple[float, float]) -> None:
    """Single teeth may lead from flanks in contact to flanks apart amid a record."""
    system, rows = assemble(lightly_damped), np.arange(384)
    from_rest, apart = (motion_of(system, begun) for begun in ((0.0, 0.0), KICK))
    both = dataclasses.replace(from_rest, value=np.where(rows < jump, from_rest.value, apart.value), keep=rows != 200)

    def left(one: Measurement) -> Array:
        return left_of(one, system)[0]

    assert nearest(both, 1e-6, left(both), left).axis.size == rows.size
    found = nearest(both, 1e-6, left(both), left, PITCH)
    first, last = (0, jump - 96) if kick == (0.0, 0.0) else (jump + 96, 383)
    assert abs(found.line[0] - first) <= 1
    assert abs(found.line[-1] - last) <= 2
    for name in ("axis", "value", "keep"):
        assert np.array_equal(getattr(found, name), getattr(both, name)[found.line])
    assert found.rms(left(found)) < 0.05 * both.rms(left(both))
    assert any(found.kick) == any(kick)


def test_a_constant_that_jumps_is_no_other_motion(lightly_damped) -> None:
    system = assemble(lightly_damped)
    record = motion_of(system, KICK)
    stepped = dataclasses.replace(record, value=record.value + 2e-5 * (np.arange(384) > 200))

    def left(one: Measurement) -> Array:
        return left_of(one, system)[0]

    assert nearest(stepped, 1e-6, left(stepped), left, PITCH) is stepped
