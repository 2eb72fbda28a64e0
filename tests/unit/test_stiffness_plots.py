"""Zones of contact and the carpet of the transmission error: what is drawn is what was computed."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.engagement.carpet import error_carpet
from gearfem.engagement.engage import engage
from gearfem.pipeline import run
from gearfem.report.stiffness_plots import plot_carpet, plot_zones, write_stiffness_pictures

TORQUE = 50.0


@pytest.fixture(scope="module")
def mesh(small_pair):
    return run(small_pair, until="compliance").mesh


@pytest.fixture(scope="module")
def angle(mesh):
    return np.linspace(-1.0, 1.0, 201) * mesh.placement.pair.pinion.pitch_angle


@pytest.fixture(scope="module")
def carpet(mesh, angle):
    return error_carpet(mesh, angle, TORQUE)


def test_carpet_runs_from_no_torque_through_the_engagement(mesh, angle, carpet) -> None:
    assert carpet.pinion_torque[0] == 0.0
    assert carpet.pinion_torque[-1] == pytest.approx(75.0, rel=1e-12, abs=0.0)
    assert carpet.transmission_error.shape == carpet.pairs_in_contact.shape == (25, 201)
    assert (carpet.transmission_error[0] == 0.0).all()
    row = 16
    assert carpet.pinion_torque[row] == pytest.approx(TORQUE, rel=1e-12, abs=0.0)
    loaded = engage(mesh, angle, TORQUE)
    assert carpet.transmission_error[row] == pytest.approx(loaded.transmission_error, rel=1e-10, abs=0.0)
    assert (carpet.pairs_in_contact[row] == (loaded.force > 0.0).sum(axis=1)).all()


def test_carpet_ends_where_the_theory_does(mesh, angle) -> None:
    most = 500.0
    assert engage(mesh, angle, most).transmission_error.max() < 0.1e-3
    wide = error_carpet(mesh, angle, most)
    assert most < wide.pinion_torque[-1] < 1.5 * most
    assert 0.09e-3 < wide.transmission_error.max() <= 0.1e-3


def test_bars_are_the_angles_at_which_each_pair_carries(small_pair, mesh, angle) -> None:
    loaded = engage(mesh, angle, TORQUE)
    upper, lower = plot_zones(small_pair, [loaded, engage(mesh, angle, 20.0)]).axes
    assert [line.get_label() for line in upper.lines][:2] == ["slope dF/dδ, 50 N m", "secant F/δ, 50 N m"]
    step = 0.01
    drawn = dict.fromkeys(range(-2, 3), 0.0)
    ticks = [int(text.get_text()) for text in lower.get_yticklabels()]
    for bars in lower.collections:
        for path in bars.get_paths():
            low, high = path.vertices.min(axis=0), path.vertices.max(axis=0)
            drawn[ticks[round((low[1] + high[1]) / 2.0)]] += float(high[0] - low[0])
    for number in (-1, 0, 1):
        carried = step * (loaded.force[:, loaded.contacts.pairs.index(number)] > 0.0).sum()
        # Single samples, as at an end of the picture, are left out.
        assert drawn[number] == pytest.approx(carried, abs=2.5 * step)


def test_carpet_shows_the_change_over_the_pitch(small_pair, carpet) -> None:
    left, right = plot_carpet(small_pair, carpet).axes[:2]
    assert len(left.lines) == 9
    shown = np.asarray(right.collections[0].get_array()).reshape(carpet.transmission_error.shape)
    assert np.abs(shown.mean(axis=1)).max() < 1e-9
    assert np.ptp(shown[-1]) == pytest.approx(1e6 * np.ptp(carpet.transmission_error[-1]), rel=1e-9, abs=0.0)


def test_both_pictures_are_written(small_pair, mesh, angle, carpet, tmp_path) -> None:
    files = write_stiffness_pictures(small_pair, [engage(mesh, angle, TORQUE)], carpet, tmp_path)
    assert [path.name for path in files] == ["mesh_stiffness.png", "transmission_error_carpet.png"]
    assert all(path.stat().st_size > 20_000 for path in files)
