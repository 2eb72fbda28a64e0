"""Reading of models: overrides, hashes, assumptions, and random sane models that pass from keys to a setup."""

from __future__ import annotations

import copy
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gearfem.definition.model_file import model_hash
from gearfem.foundation import InputError, digest
from gearfem.foundation.units import DEG, MM, RPM
from gearfem.model import load_model, make_setup

MODEL = Path(__file__).parents[2] / "studies" / "coal_combine" / "model.toml"


def test_the_file_and_the_same_keys_in_python_are_one_model():
    with MODEL.open("rb") as stream:
        keys = tomllib.load(stream)
    assert digest(make_setup(keys)) == digest(load_model(MODEL))


def test_numbers_of_numpy_and_integers_are_numbers():
    keys = tomllib.loads(MODEL.read_text())
    keys["pair"]["face_width_mm"] = np.float64(75.0)
    keys["pinion"]["teeth"] = np.int64(16)
    keys["pair"]["module_mm"] = 8
    assert model_hash(make_setup(keys)) == model_hash(load_model(MODEL))


def test_making_a_setup_leaves_the_mapping_as_it_was():
    keys = tomllib.loads(MODEL.read_text()) | {"effect": []}
    before = copy.deepcopy(keys)
    make_setup(keys)
    assert keys == before


def test_overrides_replace_add_and_reach_new_tables():
    setup = load_model(MODEL, ["pair.face_width_mm=60", " wheel.material.density_kg_per_m3 = 7000.0 ", 'name="other"'])
    assert setup.pair.face_width == pytest.approx(0.06, rel=1e-15, abs=0.0)
    assert (setup.pair.pinion.material.density, setup.pair.wheel.material.density) == (7850.0, 7000.0)
    assert setup.name == "other"


@pytest.mark.parametrize(
    ("override", "where"),
    [
        ("pair.face_width_mm", "override"),
        ("=60", "override"),
        ("pair..face_width_mm=60", "override"),
        ("pair.face_width_mm=", "override of pair.face_width_mm"),
        ("pair.face_width_mm=60 mm", "override of pair.face_width_mm"),
        ("name=other", "override of name"),
        ("pair.face_width_mm=60\npinion = 3", "override of pair.face_width_mm"),
        ("pair.face_width_mm.x=60", "override of pair.face_width_mm.x"),
        ("pair.fase_width_mm=60", "pair.fase_width_mm"),
        ("pair.face_width_mm=-60", "pair.face_width_mm"),
        ("pair.face_width_mm='60'", "pair.face_width_mm"),
    ],
)
def test_overrides_that_cannot_be_used_are_refused_in_one_line(override, where):
    with pytest.raises(InputError) as refusal:
        load_model(MODEL, [override])
    assert refusal.value.where == where
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("override", "where"),
    # The first is found at the flank stage; the second blames a key of the file, the fourth one inside a table given as a whole.
    [
        ("rack.tip_radius=0.6", "rack.tip_radius"),
        ("pinion.profile_shift=2.5", "pair.centre_distance_mm"),
        ("pair.face_width_mm=-1", "pair.face_width_mm"),
        ("material={poissons_ratio=0.7}", "material.poissons_ratio"),
    ],
)
def test_a_refusal_says_whether_an_override_gave_the_key(override, where):
    with pytest.raises(InputError) as refusal:
        load_model(MODEL, iter([override]))
    assert refusal.value.where == where
    given = where.startswith(override.partition("=")[0])
    assert str(refusal.value).startswith(f"{MODEL} with overrides: " if given else f"{MODEL}: ")


def test_every_key_changes_the_hash_and_no_two_changes_share_one():
    changes = [
        'name="b"',
        "pair.module_mm=8.001",
        "pair.pressure_angle_deg=20.001",
        "pair.centre_distance_mm=281.571",
        "pair.face_width_mm=76",
        "pair.normal_backlash_mm=0.23",
        "operation.pinion_torque_Nm=1606",
        "operation.wheel_torque_Nm=4912",
        "operation.efficiency=0.97",
        "operation.pinion_speed_rpm=507",
        "operation.pinion_inertia_kg_m2=10.2",
        "operation.wheel_inertia_kg_m2=6.8",
        "operation.friction_coefficient=0.11",
        "operation.damping_ratio=0.19",
        "rack.addendum=0.99",
        "rack.dedendum=1.26",
        "rack.tip_radius=0.29",
    ]
    for table, values in {"": (), "pinion.": (17, 0.81, 76.1, 60.3), "wheel.": (52, 1.17, 219.1, 203.3)}.items():
        changes += [f"{table}material.{key}" for key in ("youngs_modulus_MPa=2e5", "poissons_ratio=0.29", "density_kg_per_m3=7800.0")]
        changes.append(f"{table}material.yield_strength_MPa=1100.0")
        if values:
            teeth, shift, tip, root = values
            changes += [f"{table}teeth={teeth}", f"{table}profile_shift={shift}", f"{table}tip_radius_mm={tip}"]
            changes += [f"{table}root_radius_mm={root}", f"{table}bore_radius_mm=31.0", f"{table}tip_edge_radius_mm=0.17"]
    # Two changes that jam the pair or part it get the remedy beside them; the key itself still differs.
    remedy = {
        "pair.module_mm=8.001": ["pair.centre_distance_mm=281.7"],
        "pinion.teeth=17": ["pair.centre_distance_mm=285.6"],
        "wheel.teeth=52": ["pair.centre_distance_mm=285.6"],
    }
    hashes = {model_hash(load_model(MODEL))}
    for change in changes:
        hashes.add(model_hash(load_model(MODEL, [change, *remedy.get(change, [])])))
    assert len(hashes) == len(changes) + 1
    assert all(len(value) == 64 for value in hashes)


def test_the_hash_does_not_depend_on_layout_or_order():
    keys = tomllib.loads(MODEL.read_text())
    turned = {name: dict(reversed(table.items())) if isinstance(table, dict) else table for name, table in reversed(keys.items())}
    assert model_hash(make_setup(turned)) == model_hash(make_setup(keys))


def test_a_setup_built_from_records_has_a_hash_too(coal_combine):
    assert model_hash(coal_combine) == digest(coal_combine)


def test_a_given_value_is_not_listed_as_assumed():
    words = "\n".join(load_model(MODEL).assumptions)
    assert "Inertia" not in words
    assert "Bore" not in words
    assert "shortened by 2.2300 mm to keep the clearance of 2 mm" in words


def test_a_distance_within_the_rounding_of_the_shifts_is_accepted_and_said():
    setup = load_model(MODEL, ["pair.centre_distance_mm=281.568", "pair.normal_backlash_mm=0.0"])
    assert any("taken as rounding" in sentence for sentence in setup.assumptions)
    assert setup.pair.centre_distance == pytest.approx(281.568e-3, abs=1e-15)


SANE = st.fixed_dictionaries(
    {
        "module": st.floats(0.3, 20.0),
        "teeth": st.tuples(st.integers(18, 60), st.integers(18, 150)),
        "shifts": st.tuples(st.floats(-0.05, 0.4), st.floats(-0.05, 0.4)),
        "backlash": st.floats(0.0, 0.03),
        "width": st.floats(3.0, 20.0),
        "torque": st.floats(1e-3, 1e5),
        "speed": st.floats(1e-3, 3e4),
    }
)


@settings(max_examples=60, deadline=None)
@given(SANE)
def test_sane_models_pass_unchanged_from_keys_to_a_setup(case):
    module, (z1, z2), (x1, x2) = case["module"], case["teeth"], case["shifts"]
    keys = {
        "pair": {"module_mm": module, "face_width_mm": case["width"] * module, "normal_backlash_mm": case["backlash"] * module},
        "pinion": {"teeth": z1, "profile_shift": x1},
        "wheel": {"teeth": z2, "profile_shift": x2},
        "operation": {"pinion_torque_Nm": case["torque"], "pinion_speed_rpm": case["speed"]},
    }
    setup = make_setup(keys)
    pair = setup.pair
    assert (pair.pinion.teeth, pair.wheel.teeth, pair.pinion.profile_shift, pair.wheel.profile_shift) == (z1, z2, x1, x2)
    assert pair.pinion.module == module * MM
    assert pair.pinion.pressure_angle == 20.0 * DEG
    assert setup.operation.pinion_speed == case["speed"] * RPM
    assert 1.0 <= pair.contact_ratio < 2.5
    assert math.isclose(setup.operation.wheel_torque, case["torque"] * z2 / z1, rel_tol=1e-14)
    # Making the file's numbers from the resolved ones and reading again must end at the same pair; rounding alone differs.
    full = copy.deepcopy(keys)
    full["pair"]["centre_distance_mm"] = pair.centre_distance / MM
    for name, gear in (("pinion", pair.pinion), ("wheel", pair.wheel)):
        full[name] |= {f"{key}_mm": getattr(gear, key) / MM for key in ("bore_radius", "tip_radius", "root_radius", "tip_edge_radius")}
    again = make_setup(full).pair
    assert math.isclose(again.contact_ratio, pair.contact_ratio, rel_tol=1e-9)
