"""The three models and the sweep over whole turns: equal teeth are the limit, eccentric gears have the ratio of their centres."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem import make_setup, run
from gearfem.dynamics.record import Ripple
from gearfem.dynamics.sweep import sweep
from gearfem.dynamics.turns import march_turns
from gearfem.dynamics.uneven import MOST_PITCHES, repeats, uneven_classical, uneven_motion, uneven_rigid
from gearfem.effects.catalogue import catalogue
from gearfem.engagement.turns import Turns

KNOWN = catalogue()
MODEL = {
    "pair": {"module_mm": 3.0, "face_width_mm": 20.0, "normal_backlash_mm": 0.06},
    "pinion": {"teeth": 18},
    "wheel": {"teeth": 27},
    "operation": {"pinion_torque_Nm": 120.0, "pinion_speed_rpm": 9000.0, "friction_coefficient": 0.05, "damping_ratio": 0.12},
}


@pytest.fixture(scope="module")
def results():
    return run(make_setup(MODEL))


def placed(results, **changes) -> Turns:
    return Turns(mesh=dataclasses.replace(results.mesh, placement=dataclasses.replace(results.mesh.placement, **changes)))


def test_equal_teeth_give_the_models_of_one_pitch(results) -> None:
    turns, drive = Turns(mesh=results.mesh), results.system.drive
    assert repeats(turns, drive) == 1
    rigid = uneven_rigid(turns, drive)
    # Tables of pairs stand for the engagement to 1e-6.
    assert rigid.dynamic_factor.max() == pytest.approx(results.rigid.dynamic_factor.max(), rel=1e-4, abs=0.0)
    assert rigid.wheel_torque == pytest.approx(results.rigid.wheel_torque, rel=1e-9, abs=0.0)
    pair = results.setup.pair
    discs = [gear.disc_inertia(pair.face_width) for gear in (pair.pinion, pair.wheel)]
    for found, known in (
        (uneven_motion(turns, drive), results.elastic),
        (uneven_classical(turns, drive, *discs), results.classical),
    ):
        # The elastic model's tables of 240 angles err by some tenths of a percent beside the ends of the path.
        assert found.largest_dynamic_factor == pytest.approx(known.largest_dynamic_factor, rel=5e-3, abs=0.0)


def test_rigid_eccentric_gears_have_the_ratio_of_their_distances(results) -> None:
    """1/i = (r_b1 - g')/r_b2: inertias that no torque speeds up keep J1 omega^2 + J2 (omega/i)^2, so that omega swings with i."""
    base, drive = results.setup.pair.pinion.base_radius, results.system.drive
    turns = placed(results, pinion_runout=(20e-6, 0.0))
    motion = uneven_rigid(turns, drive)
    assert motion.period == pytest.approx(2.0 * math.pi, rel=1e-12, abs=0.0)
    even = uneven_rigid(Turns(mesh=results.mesh), drive)
    swing = np.fft.rfft(np.gradient(motion.wheel_angle, motion.pinion_angle))[1] * 2.0 / motion.wheel_angle.size
    assert np.ptp(even.wheel_angle) > 0.0
    # The gap of the runout is E cos(phi + ...): its slope has the amplitude E.
    assert abs(swing) == pytest.approx(20e-6 / base / results.setup.pair.ratio, rel=2e-3, abs=0.0)


def test_periods_are_as_short_as_what_differs_allows(results) -> None:
    turns, drive = Turns(mesh=results.mesh), results.system.drive
    late = np.zeros(18)
    late[3] = 5e-6
    assert repeats(placed(results, pinion_late=late), drive) == 18
    assert repeats(placed(results, pinion_late=np.full(18, 1e-6)), drive) == 1
    assert repeats(placed(results, wheel_runout=(0.0, 1e-5)), drive) == 27
    assert repeats(placed(results, pinion_late=late, wheel_runout=(0.0, 1e-5)), drive) == 54
    rippled = dataclasses.replace(drive, ripples=(Ripple(member="wheel", order=2.0, amplitude=1.0, phase=0.0),))
    assert repeats(turns, rippled) == 27
    long = run(make_setup({**MODEL, "pinion": {"teeth": 61}, "wheel": {"teeth": 97}}), until="compliance")
    both = placed(long, pinion_runout=(1e-5, 0.0), wheel_runout=(1e-5, 0.0))
    assert MOST_PITCHES < 61 * 97
    assert repeats(both, long.system.drive) == 2 * 61


def test_sweep_over_turns_holds_what_single_motions_do(results) -> None:
    turns, drive = placed(results, wheel_runout=(15e-6, 0.0)), results.system.drive
    told = []
    swept = sweep(turns, drive, [200.0, 500.0], both_ways=True, progress=lambda *step: told.append(step))
    assert [(point.direction, point.pinion_speed) for point in swept.points] == [
        ("up", 200.0),
        ("up", 500.0),
        ("down", 200.0),
        ("down", 500.0),
    ]
    assert told[-1] == ("sweep", 4, 4)
    place = np.arange(27 * 96) / 96 * results.setup.pair.pinion.pitch_angle
    motion = march_turns(turns, drive, place, speed=500.0)
    point = swept.branch("up")[1]
    assert point.period_cycles == 27
    # Another start is forgotten to 1e-4.
    assert point.dynamic_factor_max == pytest.approx(motion.dynamic_factor.max(), rel=1e-4, abs=0.0)
    assert point.error_rms == pytest.approx(motion.transmission_error.std(), rel=1e-4, abs=0.0)
    # The runout stands once a turn of the wheel: at 1/27 mesh orders, with its own size.
    wheel_turn = np.argmin(np.abs(point.line_order - 1.0 / 27.0))
    assert point.line_order[wheel_turn] == pytest.approx(1.0 / 27.0, rel=1e-12, abs=0.0)
    assert point.line_amplitude[wheel_turn] == pytest.approx(15e-6, rel=0.05, abs=0.0)


def test_equal_teeth_sweep_alike_by_both_ways(results) -> None:
    drive = results.system.drive
    one, other = (sweep(mesh, drive, [300.0]).points[0] for mesh in (results.mesh_force, Turns(mesh=results.mesh)))
    assert other.dynamic_factor_max == pytest.approx(one.dynamic_factor_max, rel=5e-3, abs=0.0)
    assert other.natural_frequency == pytest.approx(one.natural_frequency, rel=2e-3, abs=0.0)
    assert other.harmonic_amplitude[0] == pytest.approx(one.harmonic_amplitude[0], rel=0.02, abs=0.0)
    assert np.angle(np.exp(1j * (other.harmonic_phase[0] - one.harmonic_phase[0]))) == pytest.approx(0.0, abs=0.02)
