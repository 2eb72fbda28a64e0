"""Derivatives of records over the errors of the model, against differences over steps four times smaller to either side."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gearfem.assembly import assemble
from gearfem.definition.setup import Setup
from gearfem.diagnosis.modelling.bench import neutral
from gearfem.diagnosis.modelling.model_form import error_slope
from gearfem.diagnosis.modelling.system_bench import SystemBench
from gearfem.diagnosis.reading.measurement import make_record

TORQUE, TURN, SMALL = 50.0, 2.0 * math.pi, 0.005


@pytest.mark.parametrize("quantity", ["static_transmission_error", "dynamic_transmission_error", "pinion_angular_acceleration"])
def test_errors_of_the_model_act_as_their_columns_say(small_pair: Setup, quantity: str) -> None:
    """Near a resonance, which errors of the model shift: what a whole deviation does says little of what a tenth does."""
    bench = SystemBench(system=assemble(small_pair))
    stands = tuple(0.4 for _ in bench.errors)
    settings = dataclasses.replace(neutral(small_pair.pair), errors=stands)
    speed = 0.8 * bench.oscillator(TORQUE, settings).frequency / small_pair.pair.pinion.teeth
    record = make_record(quantity, np.arange(600) / 600 * TURN, pinion_torque=TORQUE, pinion_speed=speed)
    here = bench.predict(record, settings)
    for place, variant in enumerate(bench.errors):
        around = ((*stands[:place], stands[place] + way * SMALL, *stands[place + 1 :]) for way in (1.0, -1.0))
        ahead, behind = (bench.predict(record, dataclasses.replace(settings, errors=errors)) for errors in around)
        exact = (ahead - behind) / (2.0 * SMALL)
        off = np.std(error_slope(record, bench, settings, here, bench.errors, place) - exact) / np.std(exact)
        print(f"{quantity}, {variant.name}: off by {off:.3f}")
        assert off < 0.1
