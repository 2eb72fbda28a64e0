"""Stiffness beside ISO 6336-1, in small mode."""

from __future__ import annotations

import importlib

import numpy as np


def test_deviation_from_the_standard(tmp_path):
    rows = importlib.import_module("iso6336_stiffness").main(["--small", "--out", str(tmp_path)])
    assert (tmp_path / "iso6336_stiffness.csv").exists()
    single, slope = (np.array([row[f"{name}_deviation_pct"] for row in rows]) for name in ("single", "slope"))
    # The standard expects measured values from 8 % below to 5 % above; stubby teeth come out up to a tenth above that.
    assert single.min() > -8.0
    assert single.max() < 16.0
    assert np.abs(slope).max() < 11.0
    assert abs(slope.mean()) < 5.0
    # The mean slope lies above the mean secant, since contact stiffens with the load.
    assert all(row["mean_slope_N_per_mm_um"] > row["mean_secant_N_per_mm_um"] for row in rows)


def test_all_nine_pairs_lie_in_the_range_of_the_standard():
    study = importlib.import_module("iso6336_stiffness")
    assert len(study.PAIRS) >= 6
    for values in study.PAIRS:
        setup = study.define(*values)
        assert study.iso6336_stiffness(setup.pair, setup.operation.pinion_torque).warnings == ()
