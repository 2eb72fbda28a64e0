"""What instruments read from a true system: one function per quantity, in the units of the files."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import cont2discrete, lfilter, lfilter_zi

from .gear import Array
from .mesh import deviation, static
from .motion import masses, run, settle, tabulate
from .system import Sensor, System

COLUMNS = {
    "static_transmission_error": ("pinion_angle_rad", "transmission_error_um"),
    "dynamic_transmission_error": ("pinion_angle_rad", "transmission_error_um"),
    "pinion_angular_acceleration": ("pinion_angle_rad", "angular_acceleration_rad_per_s2"),
    "dynamic_factor": ("pinion_speed_rpm", "dynamic_factor"),
    "mesh_stiffness": ("pinion_angle_rad", "mesh_stiffness_N_per_um"),
    "flank_profile": ("roll_length_mm", "deviation_um"),
    "radial_runout": ("tooth", "radial_deviation_um"),
    "pitch_deviation": ("tooth", "pitch_deviation_um"),
}
STATIC_OF_ONE_GEAR = ("flank_profile", "radial_runout", "pitch_deviation")


@dataclass(frozen=True)
class Spec:
    """One record to be taken; angles are the record's own, `noise` in the unit of the measured column."""

    file: str
    quantity: str
    torque: float = 0.0
    speed: float = 0.0  # rad/s
    role: str | None = "fit"
    noise: float = 0.0
    stated: bool = True
    start: float = 0.0
    turns: float = 2.0
    samples: int = 50  # per mesh cycle
    speeds: tuple[float, ...] = ()
    gear: int = 0
    tooth: int = 0
    tooth_zero_unknown: bool = False
    first_tooth: int = 0

    @property
    def constant(self) -> bool:
        """Whether the record has an unknown constant."""
        return self.quantity in ("static_transmission_error", "dynamic_transmission_error", "radial_runout", "pitch_deviation")


def axis(system: System, spec: Spec) -> Array:
    """First column of the record."""
    pair = system.pair
    if spec.quantity == "dynamic_factor":
        return np.array(spec.speeds) * 30.0 / math.pi
    if spec.quantity == "flank_profile":
        return np.linspace(pair.lowest_roll(spec.gear), pair.gears[spec.gear].tip_roll, 121) * 1e3
    if spec.quantity in STATIC_OF_ONE_GEAR:
        return np.arange(int(spec.turns * pair.gears[spec.gear].teeth), dtype=float)
    count = int(spec.turns * pair.pinion.teeth * spec.samples)
    return spec.start + np.arange(count) * pair.pitch / spec.samples


def measure(system: System, spec: Spec) -> Array:
    """Second column of the record without noise and without its unknown constant."""
    values = axis(system, spec)
    sensor = system.sensor
    if spec.quantity == "dynamic_factor":
        return _factor(system, spec)
    if spec.quantity == "flank_profile":
        tooth = np.full(len(values), spec.tooth % system.pair.gears[spec.gear].teeth)
        return deviation(system, spec.gear, tooth, values * 1e-3) * 1e6
    if spec.quantity in STATIC_OF_ONE_GEAR:
        return _teeth(system, spec, values.astype(int) + spec.first_tooth)
    angle = values + system.angle_offset
    if spec.quantity in ("static_transmission_error", "mesh_stiffness"):
        short = angle if system.uneven else angle[: spec.samples]
        result = static(system, short, spec.torque)
        take = np.arange(len(angle)) % len(short)
        if spec.quantity == "mesh_stiffness":
            return sensor.gain * result.slope[take] * 1e-6
        return (sensor.gain * result.lag[take] + encoder(sensor, angle)) * 1e6
    return _at_speed(system, spec, angle)


def encoder(sensor: Sensor, angle: Array) -> Array:
    total = np.zeros_like(angle)
    for order, amplitude, phase in sensor.once:
        total += amplitude * np.cos(order * angle + phase)
    return total


def _at_speed(system: System, spec: Spec, angle: Array) -> Array:
    step = system.pair.pitch / spec.samples
    guess = 16e9 * system.pair.width
    lead = (settle(system, spec.torque, spec.speed, guess) + 1) * spec.samples
    even = not system.uneven and not system.sensor.once
    body = spec.samples if even else len(angle)
    # a periodic system repeats after one mesh cycle, so the settled one is enough
    course = angle[0] + step * np.arange(-lead, body)
    motion = run(system, tabulate(system, course, spec.torque, spec.speed), spec.torque, spec.speed)
    accelerates = spec.quantity == "pinion_angular_acceleration"
    series = motion.acceleration if accelerates else motion.lag * 1e6
    if not accelerates:
        series = series + encoder(system.sensor, course) * 1e6
    series = sense(system.sensor, series, step / spec.speed)[lead:]
    return series[np.arange(len(angle)) % body]


def sense(sensor: Sensor, series: Array, dt: float) -> Array:
    """Gain, delay and resonance of an angle sensor on a series in time."""
    if sensor.resonance is not None:
        frequency, ratio = sensor.resonance
        w = 2.0 * math.pi * frequency
        fine = 4
        time = np.arange(fine * (len(series) - 1) + 1) / fine
        top, bottom, _ = cont2discrete(([w * w], [1.0, 2.0 * ratio * w, w * w]), dt / fine, "foh")
        dense = np.interp(time, np.arange(len(series)), series)
        start = lfilter_zi(top.ravel(), bottom) * dense[0]
        series = lfilter(top.ravel(), bottom, dense, zi=start)[0][::fine]
    if sensor.delay:
        at = np.arange(len(series)) * dt
        series = np.interp(at - sensor.delay, at, series)
    return sensor.gain * series


def _factor(system: System, spec: Spec) -> Array:
    samples = min(spec.samples, 40)
    step = system.pair.pitch / samples
    guess = 16e9 * system.pair.width
    leads = [(settle(system, spec.torque, speed, guess) + 1) * samples for speed in spec.speeds]
    body = system.pair.pinion.teeth * samples if system.uneven else samples
    course = step * np.arange(-max(leads), body) + system.angle_offset
    table = tabulate(system, course, spec.torque, spec.speeds[-1])
    peaks = []
    for speed, lead in zip(spec.speeds, leads, strict=True):
        cut = max(leads) - lead
        part = type(table)(course[cut:], table.lag[cut:], table.force, table.extra1[cut:], table.extra2[cut:], table.mean)
        acceleration = sense(system.sensor, run(system, part, spec.torque, speed).acceleration, step / speed)[lead:]
        peaks.append(float(np.max(1.0 - system.inertias[0] * acceleration / (spec.torque * system.torque_gain))))
    return np.array(peaks)


def _teeth(system: System, spec: Spec, tooth: Array) -> Array:
    gear = system.pair.gears[spec.gear]
    size, where = abs(system.runout[spec.gear]), cmath.phase(system.runout[spec.gear] or 1.0)
    turn = 2.0 * math.pi * tooth / gear.teeth
    if spec.quantity == "radial_runout":
        return np.asarray(size * np.cos(turn - where) * 1e6)
    alpha = system.pair.alpha
    half = float(gear.half_angle(gear.base_radius / math.cos(alpha)))
    # the flank's shift along its normal when the tooth stands at the pitch point, late counted positive
    direction = turn - half - where if spec.gear == 0 else math.pi - half + where - turn
    late = size * np.sin(direction + alpha) * (-1.0 if spec.gear == 0 else 1.0)
    total = late + system.scatter.late[spec.gear][tooth % gear.teeth]
    own = system.late[spec.gear]
    if own is not None:
        total = total + own[tooth % gear.teeth]
    return np.asarray(total * 1e6)


def natural_speed(system: System, stiffness: float) -> float:
    """Pinion speed (rad/s) at which the mesh frequency meets the natural one."""
    return math.sqrt(stiffness / masses(system)[2]) / system.pair.pinion.teeth
