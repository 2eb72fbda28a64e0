"""Standard deviations of parameters as they are stated."""

from __future__ import annotations

import copy
import dataclasses
import json
import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gearfem.diagnosis import Diagnosis, read_campaign
from gearfem.diagnosis.comparing import averages
from gearfem.diagnosis.fitting import parameters
from gearfem.diagnosis.fitting.inexact import inexact, stated
from gearfem.diagnosis.write import write_diagnosis
from gearfem.effects.effect import Effect
from gearfem.effects.pitting import Pitting
from gearfem.effects.profile_slope import ProfileSlope
from gearfem.effects.sensor_resonance import SensorResonance
from gearfem.effects.support_compliance import SupportCompliance
from gearfem.effects.torque_ripple import TorqueRipple
from gearfem.foundation import Array, SolveError
from gearfem.foundation.units import MM, UM, factor
from gearfem.report.diagnosis_html import _parameters

NO_LOAD = 20.0 * UM


def stands(campaign: Path, effect: Effect, does: Callable[[Any], list[float]], deviation: float = 0.0) -> dict[str, float]:
    """Return what is stated of an effect of which it is known what it does, and its parameters as well but for its form."""

    def of(effects: tuple[Effect, ...]) -> Array:
        return np.sum([does(one) for one in effects], axis=0) if effects else np.zeros(2)

    problem: Any = SimpleNamespace(
        campaign=read_campaign(campaign),
        stand_ins=(),
        change=lambda point, effects, stood: of(effects) - of(point.effects),
        response=lambda point, others: of(point.effects) - of(others),
        freed=lambda point: lambda vectors: (vectors.T @ vectors, None),
    )
    known = {field: math.hypot(deviation, form) for field, form in inexact(effect, problem).items()}
    fit: Any = SimpleNamespace(
        effects=(effect,),
        deviations=(known,),
        point=SimpleNamespace(effects=(effect,), stood=np.zeros(1)),
    )
    (found,) = stated(problem, fit)
    return found


def test_what_acts_in_proportion_is_known_to_a_tenth_beside_what_records_tell(campaign: Path) -> None:
    slope = ProfileSlope(gear="wheel", amount=-8.0 * UM)
    for deviation in (0.1 * UM, 3.0 * UM):
        found = stands(campaign, slope, lambda one: [one.amount, 2.0 * one.amount], deviation)
        assert found == {"amount": pytest.approx(math.hypot(deviation, 0.8 * UM), rel=1e-3, abs=0.0)}


def test_a_pit_that_takes_all_load_off_its_part_of_a_flank_may_be_deeper(campaign: Path) -> None:
    """What it does goes by its depth until that is much more than the flanks approach; where it lies stays known."""
    shares = []
    for depth in (2.0 * UM, 60.0 * UM):
        pit = Pitting(gear="pinion", tooth=3, depth=depth, centre=7.0 * MM, width=1.5 * MM)
        found = stands(
            campaign, pit, lambda one: [1.0 - math.exp(-one.depth / NO_LOAD), one.centre / MM - 7.0 + one.width / MM - 1.5], 1e-9
        )
        shares.append(found["depth"] / depth)
    # Nearly in proportion; and 0.3 (1 - e^-3) / (e^-1.5 - e^-3) of half.
    assert shares == pytest.approx([0.3, 0.15 * (1.0 - math.exp(-3.0)) / (math.exp(-1.5) - math.exp(-3.0))], rel=0.06)


def test_of_a_hollow_with_a_flat_bottom_the_best_bell_leaves_as_much_as_is_stated() -> None:
    x = np.linspace(-2.0, 2.0, 4001)
    flat = (np.abs(x) <= 0.5).astype(float)
    bells = [0.5 + 0.5 * np.cos(2.0 * np.pi * np.clip(x / width, -0.5, 0.5)) for width in np.arange(1.0, 3.0, 0.05)]
    left = [1.0 - (flat @ bell) ** 2 / (bell @ bell) / (flat @ flat) for bell in bells]
    assert 1.0 + 0.05 * int(np.argmin(left)) == pytest.approx(1.7, abs=0.06)
    assert math.sqrt(min(left)) == pytest.approx(Pitting.form, rel=0.05)


def test_two_supports_that_do_nearly_the_same_are_known_by_what_they_do_together(campaign: Path) -> None:
    supports = SupportCompliance(pinion=2e-9, wheel=3e-9)
    found = stands(campaign, supports, lambda one: [one.pinion + one.wheel, 0.05 * (one.pinion - one.wheel)])
    # Any tenth of what they do, as it shifts the solution of two equations.
    solved = np.linalg.inv(np.array([[1.0, 1.0], [0.05, -0.05]]))
    off = 0.1 * math.hypot(5e-9, 0.05 * 1e-9) * np.linalg.norm(solved, axis=1)
    assert [found["pinion"], found["wheel"]] == pytest.approx(off.tolist(), rel=0.05)
    assert found["pinion"] > 2e-9


@pytest.mark.parametrize("apart", [1e-5, 1e-8, 0.0])
def test_what_nothing_tells_of_two_supports_may_be_anything_that_can_be(campaign: Path, apart: float) -> None:
    supports = SupportCompliance(pinion=2e-9, wheel=3e-9)
    found = stands(campaign, supports, lambda one: [one.pinion + one.wheel, apart * (one.pinion - one.wheel)])
    low, high = parameters.bounds((supports,), read_campaign(campaign).setup)
    # Their sum is known, so that both are off together.
    assert [found["pinion"], found["wheel"]] == pytest.approx(((high - low) / math.sqrt(2.0)).tolist(), rel=0.02)


@pytest.mark.parametrize("often", [1.0, 90.0], ids=["as it is", "in motions whose flanks part"])
def test_where_a_wave_begins_is_known_to_a_tenth_of_a_radian(campaign: Path, often: float) -> None:
    """Even where records seem to tell it to a thousandth."""

    def does(one: TorqueRipple) -> list[float]:
        return [one.amplitude * math.cos(often * one.phase), one.amplitude * math.sin(often * one.phase)]

    found = stands(campaign, TorqueRipple(gear="pinion", order=2, amplitude=5.0, phase=0.4), does, 1e-3)
    assert found["phase"] == pytest.approx(0.1, rel=1e-3)
    assert found["amplitude"] == pytest.approx(0.5, rel=0.01) if often == 1.0 else found["amplitude"] > 0.5


@pytest.mark.parametrize("error", [SolveError("no further"), np.linalg.LinAlgError("singular")], ids=lambda error: type(error).__name__)
def test_what_cannot_be_computed_leaves_what_is_known(campaign: Path, error: Exception) -> None:
    def fails(one: Effect) -> list[float]:
        raise error

    assert stands(campaign, ProfileSlope(gear="wheel", amount=8.0 * UM), fails, 0.2 * UM) == {"amount": math.hypot(0.2 * UM, 0.8 * UM)}


def test_what_is_smooth_in_its_reciprocal_is_stated_in_that(campaign: Path) -> None:
    """A frequency of an instrument, which is infinite where it does nothing."""
    found = stands(campaign, SensorResonance(frequency=1200.0, ratio=0.1), lambda one: [1.0 / one.frequency, 1e-4 * one.ratio])
    assert found["frequency"] == pytest.approx(0.1 / 1200.0, rel=0.01)


def test_a_depth_that_was_halved_is_known_to_a_factor_beside_what_all_teeth_have_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fit of all records row by row goes no round on, and halves nothing."""
    known = ({"depth": 0.33 * 60.0 * UM},)
    teeth = SimpleNamespace(prepare=lambda effects, unknown: unknown, fit=lambda *_, rounds: _Stands(({"depth": 6.0 * UM},)))
    monkeypatch.setattr(averages, "of_single_teeth", lambda *_: teeth)
    monkeypatch.setattr(averages, "stand", lambda problem, means, rows, single: single)
    means: Any = SimpleNamespace(settings=None, effects=())
    single: Any = SimpleNamespace(effects=(), point=SimpleNamespace(stood=np.zeros(2)), deviations=known)
    nothing: Any = None
    assert averages.whole(nothing, means, single).deviations == known


@dataclasses.dataclass(frozen=True)
class _Stands:
    deviations: tuple[dict[str, float], ...]


def test_a_diagnosis_states_what_its_fit_knows_and_the_form(found: Diagnosis, tmp_path: Path) -> None:
    """Of a relief, amount and length of which do much of the same, a tenth of what it does; and that is what is written."""
    (effect,), (fitted,), (said,) = found.naming.fit.effects, found.naming.fit.deviations, found.deviations
    assert set(said) == set(fitted) == set(effect.fitted())
    assert all(said[field] >= fitted[field] > 0.0 for field in said)
    # Other tests leave the problem prepared elsewhere.
    problem, fit = copy.copy(found.problem), found.naming.fit
    problem.prepare(fit.effects, fit.point.stood)
    (form,) = stated(problem, dataclasses.replace(fit, deviations=(dict.fromkeys(fitted, 0.0),)))
    counted = inexact(effect, problem)
    parts = {field: math.hypot(form[field], counted[field]) / counted[field] for field in form}
    assert all(1.0 <= part < 5.0 for part in parts.values()), parts
    assert max(parts.values()) > 1.1, parts
    wide = dataclasses.replace(found, deviations=({field: 2.0 * one for field, one in said.items()},))
    errors = []
    for number, one in enumerate((found, wide)):
        write_diagnosis(one, tmp_path / str(number))
        written = json.loads((tmp_path / str(number) / "diagnosis.json").read_text())["effects"][0]["parameters"]
        errors.append([written[effect.key(field)]["stderr"] for field in said])
    assert np.array(errors[1]) == pytest.approx(2.0 * np.array(errors[0]))


def test_an_interval_of_the_report_ends_where_the_parameter_does(found: Diagnosis) -> None:
    """A relief of less than nothing is none."""
    (effect,) = found.naming.fit.effects
    nothing_known = dataclasses.replace(found, deviations=(dict.fromkeys(effect.fitted(), 1.0),))
    shown = [row.interval for row in _parameters(nothing_known)]
    bounds = [known.bounds(found.campaign.setup, effect.member) for known in effect.fitted().values()]
    units = [factor(effect.key(field)) for field in effect.fitted()]
    assert shown == [f"{low / unit:.4g} to {high / unit:.4g}" for (low, high), unit in zip(bounds, units, strict=True)]
    assert shown[0].startswith("0 to ")
