"""Wrong units and wrong speeds: records whose size or mesh lines belong to another power of ten, or to another speed."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearfem.diagnosis.modelling.bench import Bench, Oscillator, neutral
from gearfem.diagnosis.modelling.mesh_lines import HARMONICS, lines_and_beside, mesh_lines
from gearfem.diagnosis.modelling.system_bench import STRIDE
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.diagnosis.reading.measurement import Measurement
from gearfem.diagnosis.reading.noise import measure_noise, roughness
from gearfem.diagnosis.reading.quantities import QUANTITIES
from gearfem.foundation import Array, InputError, SolveError
from gearfem.foundation.units import RPM

# Decades below and above the model's lines. Heavy wear makes them a hundredfold at low torque, relief at its design load a tenth.
FAR = (1.85, 2.5)
# Soft supports leave a seventh of a stiffness; a wrong unit leaves an eighth of a healthy one at most.
FAR_STIFFNESS = (0.87, 0.6)
# What a wrong unit of speed multiplies it by: rad/s, Hz or degrees per second taken for rpm and back, a decade, the other shaft.
SPEEDS = {"rad/s": 30.0 / math.pi, "Hz": 60.0, "a tenth": 10.0, "ten times": 0.1, "rpm for rad/s": math.pi / 30.0}
# Effects move lines by factors up to e or so; a speed is refused only where they fit no better than by e^1.2, and another one within e^0.5,
# or a quarter of the logarithm: of 331 right speeds, some far from any fit, none is refused; of 1655 wrong ones 57 % are.
MISFIT, FIT, FITS = 1.2, 0.5, 0.25
# Lines that are compared stand out of noise, are no crumbs of the model's, and are more than what single teeth and noise leave beside them:
# random amplitudes are more than 2.5 times their root mean square once in 500. At speeds far above resonance teeth make more than the mesh.
PLAIN, CRUMB, ALONE = 5.0, 0.02, 2.5
# Decades by which noise is too small or too large for the stated one, where the mesh lines are off by as many parts of a decade as well: of
# 363 records that say their noise, coloured or not, it is 0.26 to 2.4 times that.
NOISE, LINES = (0.8, 0.7), 0.5
# Least torque of a record, in parts of the rated one: next to nothing deflects under less.
LIGHTEST = 1e-5
# Part of its resonance that the mesh may meet in a slow record; and steps of a motion at most: a fit asks for some thousand motions.
SLOW, STEPS = 0.1, 5e5


def refuse_magnitudes(campaign: Campaign, bench: Bench) -> None:
    """Refuse records that the model cannot have been asked for, those far from it by their size, or nearer to it at another unit of speed.

    Parameters
    ----------
    campaign : Campaign
        All records of a loaded pair are looked at, held-out ones too: they must be in the units that they say, whatever they hold.
    bench : Bench
        The model.

    Raises
    ------
    InputError
        Naming the record, its column or key, and the power of ten or the speed that would fit.
    """
    for number, record in enumerate(campaign.records, 1):
        if record.quantity.of_gear:
            continue
        try:
            _check_load(record, bench, campaign.setup.operation.pinion_torque)
            if record.quantity.axis != "angle":
                continue
            # A wrong speed changes the size of accelerations by its square: it is asked about first.
            if record.quantity.moving:
                _check_speed(record, bench)
            _check_size(record, bench, Path(campaign.path).parent)
        except InputError as error:
            # Keys that the model has too are those of the record here.
            key = error.where.removeprefix("operation.")
            where = f"record[{number}] ({record.file}).{key}"
            raise error if error.file else InputError(where, error.found, error.allowed, campaign.path) from None


def _check_load(record: Measurement, bench: Bench, rated: float) -> None:
    """Refuse a torque that the model does not bear, and a speed at which a slow record is no slow one, or a motion takes for ever."""
    torque, settings = record.pinion_torque, neutral(bench.pair)
    if torque < LIGHTEST * rated:
        least = f"from {LIGHTEST * rated:.3g} N m on, a hundred-thousandth of the {rated:g} N m of the model"
        raise InputError("pinion_torque_Nm", f"{torque:g} N m", least)
    try:
        bench.weights(np.zeros(1), torque, settings)
        oscillator = bench.oscillator(torque, settings) if record.quantity.moving or record.pinion_speed else None
    except SolveError as error:
        raise InputError("pinion_torque_Nm", f"{torque:g} N m, under which the model has no loads ({error})", "a torque in N m") from None
    if oscillator is None:
        return
    if not record.quantity.moving:
        meets = bench.pair.pinion.teeth * record.pinion_speed / oscillator.frequency
        if meets > SLOW:
            found = f"{record.pinion_speed / RPM:g} rpm, at which the mesh meets {meets:.2g} of its resonance"
            raise InputError("pinion_speed_rpm", found, f"0 or a slow speed for {record.quantity.name}, or a quantity taken at speed")
        return
    rpm = (record.pinion_speed if record.quantity.is_motion else float(record.axis.min())) / RPM
    span = float(np.ptp(record.axis)) if record.quantity.is_motion else 2.0 * math.pi
    slowest = span * oscillator.fastest / STRIDE / STEPS / RPM
    if rpm < slowest:
        allowed = f"from {slowest:.3g} rpm on: below, take a slow record (static_transmission_error)"
        raise InputError("pinion_speed_rpm", f"{rpm:g} rpm, at which the gears swing more than {STEPS:g} times", allowed)


def _check_size(record: Measurement, bench: Bench, folder: Path) -> None:
    predicted = bench.predict(record, neutral(bench.pair))
    if record.quantity.name == "mesh_stiffness":
        ratio = float(np.median(np.abs(record.value[record.keep]))) / float(np.median(predicted))
    else:
        ratio = _size(record, record.value, bench) / _size(record, predicted, bench)
    decades = math.log10(max(ratio, 1e-12))
    column, allowed, file = record.quantity.columns[1], f"values in {record.quantity.unit}", str(folder / record.file)
    below, above = FAR_STIFFNESS if record.quantity.name == "mesh_stiffness" else FAR
    if not -below < decades < above:
        power = round(decades) or int(math.copysign(1, decades))
        found = f"mesh lines of {ratio:.3g} times those of the model, as if the unit were wrong by 10^{power}"
        raise InputError(f"column {column}", found, f"{allowed}, or a model of this pair", file)
    rough = roughness(record)
    off = math.log10(rough / record.noise_std) if record.noise_std and rough else 0.0
    if not -NOISE[0] < off < NOISE[1] and math.copysign(decades, off * decades) > LINES:
        found = f"noise of {10.0**off:.3g} times noise_std and mesh lines of {ratio:.3g} times those of the model"
        raise InputError(f"column {column}", found, f"{allowed}, as noise_std", file)


def _size(record: Measurement, value: Array, bench: Bench) -> float:
    return float(np.linalg.norm(_lines(record, value, bench)))


def _lines(record: Measurement, value: Array, bench: Bench) -> Array:
    return np.abs(mesh_lines(record.axis[record.keep], value[record.keep], bench.pair.pinion.pitch_angle))


def _check_speed(record: Measurement, bench: Bench) -> None:
    """Refuse a speed at which the lines do not fit, where another unit of it fits well.

    The lines of the slow transmission error pass the oscillator of the mean stiffness: within a factor of two of the motion itself, which
    is enough to tell speeds ten times apart.
    """
    misfits = speed_misfits(record, bench)
    own = misfits.pop("rpm")
    word = min(misfits, key=lambda key: misfits[key])
    if own > MISFIT and misfits[word] < max(FIT, FITS * own):
        rpm = record.pinion_speed / RPM
        found = f"{rpm:g}, at which no mesh line fits; all do at {rpm * SPEEDS[word]:.4g} rpm (given in {word}?)"
        raise InputError("pinion_speed_rpm", found, "the speed at which the record was taken, in rpm")


def speed_misfits(record: Measurement, bench: Bench) -> dict[str, float]:
    """Return how far the mesh lines are from the model's, as the root mean square of their logarithms' ratio, for units of the speed.

    Parameters
    ----------
    record : Measurement
        Taken at speed.
    bench : Bench
        The model.

    Returns
    -------
    dict
        By unit, "rpm" for the speed as it is; 0 where no line stands out of the noise.
    """
    settings = neutral(bench.pair)
    slow = dataclasses.replace(record, quantity=QUANTITIES["static_transmission_error"])
    unknown = dict.fromkeys(("rpm", *SPEEDS), 0.0)
    try:
        lines = _lines(record, bench.predict(slow, settings), bench)
    except InputError:
        # A ripple above the mean torque: the slow gears would part, and the lines at speed are no image of theirs.
        return unknown
    oscillator = bench.oscillator(record.pinion_torque, settings)
    noise = measure_noise(record, bench.pair).std * math.sqrt(2.0 / len(record.axis))
    found, beside = lines_and_beside(record.axis[record.keep], record.value[record.keep], bench.pair.pinion.pitch_angle)
    measured = np.abs(found)
    plain = (measured > PLAIN * noise) & (measured > ALONE * beside) & (lines > CRUMB * lines.max())
    if not plain.any():
        return unknown
    out = {}
    for word, scale in {"rpm": 1.0, **SPEEDS}.items():
        rate = bench.pair.pinion.teeth * record.pinion_speed * scale * np.arange(1.0, HARMONICS + 1.0)
        predicted: Array = lines * _response(rate, oscillator, record.quantity.name == "pinion_angular_acceleration")
        out[word] = float(np.sqrt(np.mean(np.log(measured[plain] / predicted[plain]) ** 2)))
    return out


def _response(rate: NDArray[Any], oscillator: Oscillator, acceleration: bool) -> Array:
    part = rate / oscillator.frequency
    gain = 1.0 / np.abs(1.0 - part**2 + 2j * oscillator.ratio * part)
    return np.asarray(gain * (oscillator.acceleration * rate**2 if acceleration else 1.0))
