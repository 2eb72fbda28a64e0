"""The unknowns of a fit and the settings of the model say the same."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gearfem.diagnosis.modelling.bench import Settings
from gearfem.diagnosis.modelling.teeth import Scatter
from gearfem.diagnosis.modelling.unknowns import unknowns_of
from gearfem.diagnosis.reading.campaign import Campaign
from gearfem.diagnosis.reading.measurement import Measurement, make_record
from gearfem.model import make_setup
from gearfem.variants import VARIANTS

SETUP = make_setup(
    {
        "pair": {"module_mm": 2.5, "face_width_mm": 25.0},
        "pinion": {"teeth": 13},
        "wheel": {"teeth": 17},
        "operation": {"pinion_torque_Nm": 100.0, "pinion_speed_rpm": 1000.0},
    }
)


def record(quantity: str) -> Measurement:
    return make_record(quantity, np.linspace(0.0, 1.0, 50), pinion_torque=50.0, pinion_speed=100.0)


def test_settings_are_found_again_from_their_unknowns() -> None:
    rng = np.random.default_rng(3)
    records = (record("pinion_angular_acceleration"), record("static_transmission_error"))
    campaign = Campaign(name="a", path="a.toml", model="m.toml", setup=SETUP, angle_known=False, records=records)
    unknowns = unknowns_of(campaign, records, Scatter(terms=3))
    settings = Settings(
        pinion_late=rng.normal(0.0, 1e-6, 13),
        wheel_late=rng.normal(0.0, 1e-6, 17),
        angle_offset=-0.02,
        torque_scale=1.02,
        stiffness_scale=0.9,
        inertia_scale=1.01,
        damping_scale=1.4,
        gain=0.98,
        series_compliance=-3e-11,
        coupling_scale=0.4,
        tip_edge_scale=1.3,
        evenness=0.9,
    )
    unknown = unknowns.of(settings)
    again = unknowns.settings(unknown)
    for field in dataclasses.fields(Settings):
        assert getattr(again, field.name) == pytest.approx(getattr(settings, field.name), rel=1e-12, abs=0.0), field.name
    # Five scales and three of the build, the zero, the compliance in series, one constant, and four unknowns of each
    # tooth, the index error first.
    assert (unknowns.outer, unknowns.first_tooth, unknowns.first_form) == (10, 11, 11 + 4 * 30)
    assert unknown[11:15] == pytest.approx([settings.pinion_late[0] / 1e-6, 0.0, 0.0, 0.0], rel=1e-12, abs=0.0)
    assert sorted([*range(unknowns.first_form)[unknowns.late], *unknowns.wavy]) == [*range(11, 131)]


def test_what_motions_alone_say_much_of_can_be_put_back_by_itself() -> None:
    records = (record("pinion_angular_acceleration"), record("static_transmission_error"))
    campaign = Campaign(name="a", path="a.toml", model="m.toml", setup=SETUP, angle_known=False, records=records)
    unknowns = unknowns_of(campaign, records, Scatter(), VARIANTS)
    unknown = np.ones(unknowns.wrong.stop)
    back = unknowns.resting(unknown)
    moved = [unknowns.nuisances[place].name for place in np.flatnonzero(back != unknown)]
    assert moved == ["inertia_scale", "damping_scale", "series_compliance"]
    assert unknowns_of(campaign, records[1:], Scatter()).moving == []


def test_only_records_with_an_unknown_constant_have_one() -> None:
    records = (record("pinion_angular_acceleration"), record("static_transmission_error"))
    campaign = Campaign(name="a", path="a.toml", model="m.toml", setup=SETUP, angle_known=True, records=records)
    unknowns = unknowns_of(campaign, records, Scatter())
    unknown = np.arange(float(unknowns.first_form))
    assert unknowns.constant(0, unknown) == 0.0
    assert unknowns.constant(1, unknown) == unknown[unknowns.outer]


def test_predictions_hold_errors_of_the_model_as_far_as_it_can_follow() -> None:
    records = (record("static_transmission_error"),)
    campaign = Campaign(name="a", path="a.toml", model="m.toml", setup=SETUP, angle_known=True, records=records)
    unknowns = unknowns_of(campaign, records, Scatter(), VARIANTS)
    unknown = unknowns.of(Settings(pinion_late=np.zeros(13), wheel_late=np.zeros(17)))
    unknown[unknowns.first_form :] = 5.0, 0.5, -3.0, -1.0, 1.0, 0.0
    held = (4.0, 0.5, -2.0, 0.0, 1.0, 0.0)
    assert unknowns.settings(unknown).errors == held
    assert unknowns.within(unknown)[-6:].tolist() == list(held)
    assert unknowns.at_limits(unknown)[-6:].tolist() == [True, False, True, True, False, False]
    # Those before them, of the teeth, are never at one.
    assert not unknowns.at_limits(unknown)[:-6].any()
    assert unknowns.of(unknowns.settings(unknown))[unknowns.held] == pytest.approx(unknowns.within(unknown))
