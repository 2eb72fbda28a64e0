"""The body's share of a tooth's compliance, scaled."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gearfem.compliance import Compliance, FiniteElements, Root, body_compliance, body_share, make_compliance, scale_body
from gearfem.effects.body_compliance import LEAST
from gearfem.flank import Outline, make_flanks
from gearfem.foundation import Array, InputError
from gearfem.foundation.record import digest
from gearfem.model import make_setup

METHOD = FiniteElements(resolution=1.0)


@pytest.fixture(scope="module")
def compliance(coal_combine) -> Compliance:
    made = make_compliance(make_flanks(coal_combine), METHOD, 20)
    return dataclasses.replace(made, wheel_odd=((3, dataclasses.replace(made.wheel, deflection=1.2 * made.wheel.deflection)),))


def test_share_is_whole_gear_less_tooth_and_all_below_the_root(compliance: Compliance) -> None:
    tooth = compliance.wheel
    share = body_share(tooth, METHOD)
    parts = body_compliance(tooth.outline, tooth.u, METHOD)
    above = np.isin(tooth.u, parts.u)
    assert 0 < (~above).sum() < len(share) / 2
    assert share[above] == pytest.approx(parts.body, rel=1e-9, abs=0.0)
    assert np.array_equal(share[~above], tooth.deflection[~above])


def test_share_runs_on_where_the_crossing_passes_the_root_circle(compliance: Compliance) -> None:
    outline = compliance.wheel.outline
    u = np.linspace(2.0, 2.4, 401)
    tooth = METHOD.tooth(outline, u, (1,))
    held = tooth.deflection - body_share(tooth, METHOD)
    first = np.flatnonzero(held)[0]
    assert 0 < first < len(u)
    # What the tooth held at its root does grows from 0: no step against its value half a flank higher.
    assert abs(held[first]) < 0.01 * FiniteElements(resolution=1.0, support=Root()).curve(outline, [2.9]).deflection[0]


def test_scaled_body_leaves_the_tooth_alone(compliance: Compliance) -> None:
    scaled = scale_body(compliance, 1.5, METHOD)
    for sound, tooth in ((compliance.pinion, scaled.pinion), (compliance.wheel, scaled.wheel)):
        share = body_share(sound, METHOD)
        assert body_share(tooth, METHOD) == pytest.approx(1.5 * share, rel=1e-12, abs=0.0)
        assert tooth.deflection - sound.deflection == pytest.approx(0.5 * share, rel=1e-9, abs=0.0)
        assert tooth.coupling == pytest.approx(1.5 * sound.coupling, rel=1e-12, abs=0.0)
        assert np.array_equal(tooth.local_depth, sound.local_depth)
    # A weaker tooth stands on the same body as the others.
    added = scaled.wheel_odd[0][1].deflection - compliance.wheel_odd[0][1].deflection
    assert added == pytest.approx(0.5 * body_share(compliance.wheel, METHOD), rel=1e-9, abs=0.0)


def test_scale_1_is_the_baseline_and_factors_multiply(compliance: Compliance) -> None:
    assert digest(scale_body(compliance, 1.0, METHOD)) == digest(compliance)
    once, twice = scale_body(compliance, 1.5, METHOD), scale_body(scale_body(compliance, 1.2, METHOD), 1.25, METHOD)
    assert twice.pinion.deflection == pytest.approx(once.pinion.deflection, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), float("inf")])
def test_refuses_scales_that_no_body_has(compliance: Compliance, scale: float) -> None:
    with pytest.raises(InputError, match="scale"):
        scale_body(compliance, scale, METHOD)


def test_refuses_the_compliance_of_another_method(compliance: Compliance) -> None:
    other = dataclasses.replace(compliance, pinion=dataclasses.replace(compliance.pinion, method="castigliano"))
    with pytest.raises(InputError, match="method"):
        scale_body(other, 1.1)


@pytest.mark.parametrize(
    ("teeth", "reach", "least", "most"), [(23, 0.8, LEAST, 0.80), (60, 0.8, LEAST, 0.80), (23, 0.9, 0.34, 0.50), (60, 0.9, 0.42, 0.66)]
)
def test_only_a_hub_beyond_eight_tenths_of_the_root_circle_leaves_less_than_half(
    teeth: int, reach: float, least: float, most: float
) -> None:
    """What a diagnosis calls the least that bodies may yield."""
    half, hub = (_body_on(teeth, share) for share in (0.5, reach))
    assert ((hub / half > least) & (hub / half < most)).all()


def _body_on(teeth: int, share: float) -> Array:
    bore = share * 2.5 * (teeth / 2.0 - 1.25)
    setup = make_setup(
        {
            "name": "held at its bore",
            "pair": {"module_mm": 2.5, "face_width_mm": 20.0},
            "pinion": {"teeth": teeth, "bore_radius_mm": bore},
            "wheel": {"teeth": 41},
            "operation": {"pinion_torque_Nm": 100.0, "pinion_speed_rpm": 1000.0},
        }
    )
    outline = Outline(gear=setup.pair.pinion)
    return body_compliance(outline, np.linspace(*outline.parameter([outline.flank_start, outline.flank_end]), 5)).body
