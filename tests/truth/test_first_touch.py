"""What a damper does that acts on the flanks that touch first: against an integration of its own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gearfem.assembly import assemble
from gearfem.definition.setup import Setup
from gearfem.diagnosis.modelling.bench import Settings, neutral
from gearfem.diagnosis.modelling.first_touch import touched_first
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.modelling.teeth import ride_of
from gearfem.diagnosis.reading.measurement import make_record
from gearfem.effects.torque_ripple import TorqueRipple
from gearfem.foundation.units import UM

TORQUE = 50.0


# Measured: 0.0012 and 0.0005.
@pytest.mark.parametrize(("quantity", "limit"), [("dynamic_transmission_error", 0.005), ("pinion_angular_acceleration", 0.005)])
def test_damper_on_the_first_touch_acts_as_the_equation_of_motion_says(small_pair: Setup, quantity: str, limit: float) -> None:
    """m y'' + D (y' - e') + k(t) y = 0: e is the transmission error of late teeth without load, y what is added to that at speed."""
    bench, pair = SystemBench(system=assemble(small_pair), errors=()), small_pair.pair
    errors = 2.0 * UM * np.random.default_rng(7).normal(size=pair.pinion.teeth + pair.wheel.teeth)
    settings = Settings(pinion_late=errors[: pair.pinion.teeth], wheel_late=errors[pair.pinion.teeth :])
    oscillator = bench.oscillator(TORQUE, settings)
    speed = 1.4 * oscillator.frequency / pair.pinion.teeth
    record = make_record(quantity, np.linspace(0.0, 3.0, 1200), pinion_torque=TORQUE, pinion_speed=speed)
    ride = ride_of(record, bench, settings)
    found = touched_first(record, bench, settings, ride)

    base1, base2 = (gear.base_radius for gear in (pair.pinion, pair.wheel))
    drive = bench.system.drive
    mass1, mass2 = drive.pinion_inertia / base1**2, drive.wheel_inertia / base2**2
    mass = mass1 * mass2 / (mass1 + mass2)
    time = (ride.angle - ride.angle[0]) / speed
    unloaded = bench.predict(make_record("static_transmission_error", ride.angle, pinion_torque=0.01 * TORQUE), settings)
    rate = np.gradient(unloaded, time)

    def along(t: float, y: np.ndarray) -> list[float]:
        force = ride.swing.damping * (np.interp(t, time, rate) - y[1]) - np.interp(t, time, ride.swing.stiffness) * y[0]
        return [y[1], force / mass]

    there = time[0] + (record.axis - ride.angle[0]) / speed
    solved = solve_ivp(along, (0.0, float(time[-1])), [0.0, 0.0], t_eval=there, max_step=float(time[1]), rtol=1e-8, atol=1e-14)
    if quantity == "dynamic_transmission_error":
        expected = solved.y[0]
    else:
        expected = np.array([along(t, y)[1] for t, y in zip(there, solved.y.T, strict=True)]) * mass / mass1 / base1
    off = np.std(found - expected) / np.std(expected)
    print(f"{quantity}: off by {off:.4f}, {np.ptp(expected):.3g}")
    assert off < limit


def test_a_torque_that_swings_by_more_than_next_to_no_load_is_no_obstacle(small_pair: Setup) -> None:
    swinging = SystemBench(
        system=assemble(small_pair, (TorqueRipple(gear="pinion", order=2, amplitude=0.1 * TORQUE, phase=0.0),)), errors=()
    )
    record = make_record("dynamic_transmission_error", np.linspace(0.0, 1.0, 100), pinion_torque=TORQUE, pinion_speed=100.0)
    settings = neutral(small_pair.pair)
    assert np.isfinite(touched_first(record, swinging, settings, ride_of(record, swinging, settings))).all()
