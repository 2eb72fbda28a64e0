"""Every way in which a model file can be refused: the key that is named, in one line that says what is wrong."""

from __future__ import annotations

import copy
import datetime
import math
from pathlib import Path

import pytest

from gearfem.foundation import InputError
from gearfem.model import load_model, make_setup

BASE = {
    "name": "20/30",
    "pair": {"module_mm": 2.0, "face_width_mm": 20.0},
    "pinion": {"teeth": 20},
    "wheel": {"teeth": 30},
    "operation": {"pinion_torque_Nm": 50.0, "pinion_speed_rpm": 1000.0},
}
REMOVED = object()


def changed(changes: dict[str, object]) -> dict[str, object]:
    """Return the base model with dotted keys set, or taken out."""
    model = copy.deepcopy(BASE)
    for name, value in changes.items():
        *folders, key = name.split(".")
        table = model
        for folder in folders:
            table = table.setdefault(folder, {})
        if value is REMOVED:
            del table[key]
        else:
            table[key] = value
    return model


NUMBERS = [
    "pair.module_mm",
    "pair.pressure_angle_deg",
    "pair.centre_distance_mm",
    "pair.face_width_mm",
    "pair.normal_backlash_mm",
    "pinion.teeth",
    "wheel.profile_shift",
    "pinion.bore_radius_mm",
    "wheel.tip_radius_mm",
    "pinion.root_radius_mm",
    "wheel.tip_edge_radius_mm",
    "rack.addendum",
    "rack.dedendum",
    "rack.tip_radius",
    "material.youngs_modulus_MPa",
    "pinion.material.poissons_ratio",
    "wheel.material.density_kg_per_m3",
    "material.yield_strength_MPa",
    "operation.pinion_torque_Nm",
    "operation.wheel_torque_Nm",
    "operation.efficiency",
    "operation.pinion_speed_rpm",
    "operation.pinion_inertia_kg_m2",
    "operation.wheel_inertia_kg_m2",
    "operation.friction_coefficient",
    "operation.damping_ratio",
]
NOT_NUMBERS = [True, "8", math.nan, math.inf, -math.inf, [8.0], {"mm": 8.0}, datetime.date(2003, 1, 1), 10**400]


@pytest.mark.parametrize("value", NOT_NUMBERS, ids=lambda value: repr(value)[:12])
@pytest.mark.parametrize("key", NUMBERS)
def test_what_is_no_finite_number_is_refused_everywhere(key, value):
    with pytest.raises(InputError) as refusal:
        make_setup(changed({key: value}))
    assert refusal.value.where == key
    assert "\n" not in str(refusal.value)
    assert "number" in refusal.value.allowed or "integer" in refusal.value.allowed


RANGES = [
    ("pair.module_mm", 0.0, "a number from 0.01 and up to 1000 mm"),
    ("pair.module_mm", -8.0, "mm"),
    ("pair.face_width_mm", 0, "a number above 0"),
    ("pair.face_width_mm", -75.0, "a number above 0"),
    ("pair.pressure_angle_deg", 0.0, "deg"),
    ("pair.pressure_angle_deg", 60.0, "deg"),
    ("pair.centre_distance_mm", -50.0, "mm"),
    ("pair.normal_backlash_mm", -0.1, "from 0"),
    ("pinion.teeth", 4, "from 5 and up to 1000"),
    ("wheel.teeth", 1001, "from 5 and up to 1000"),
    ("pinion.teeth", 0, "integer"),
    ("pinion.teeth", 20.0, "an integer"),
    ("pinion.teeth", 20.5, "an integer"),
    ("pinion.bore_radius_mm", 0.0, "above 0"),
    ("wheel.tip_edge_radius_mm", 0.0, "above 0"),
    ("rack.tip_radius", 0.0, "above 0"),
    ("material.poissons_ratio", 0.5, "below 0.5"),
    ("wheel.material.poissons_ratio", 0.5, "below 0.5"),
    ("material.poissons_ratio", -1.0, "above -1"),
    ("material.youngs_modulus_MPa", 0.0, "MPa"),
    ("material.density_kg_per_m3", -7850.0, "kg/m3"),
    ("operation.efficiency", 0.0, "above 0 and up to 1"),
    ("operation.efficiency", 1.01, "above 0 and up to 1"),
    ("operation.friction_coefficient", -0.1, "from 0 and below 1"),
    ("operation.friction_coefficient", 1.0, "from 0 and below 1"),
    ("operation.damping_ratio", 1.0, "from 0 and below 1"),
    ("operation.pinion_torque_Nm", 0.0, "above 0"),
    ("operation.pinion_torque_Nm", -1605.0, "above 0"),
    ("operation.pinion_speed_rpm", 0.0, "above 0"),
    ("operation.wheel_inertia_kg_m2", 0.0, "kg m2"),
    ("name", 3, "text"),
    ("name", "two\nlines", "one line of text"),
    ("pair", 3.0, "a table [pair]"),
    ("pinion.material", "steel", "a table [pinion.material]"),
]
MISSING = [
    ("pair", "a table [pair]"),
    ("pinion", "a table [pinion]"),
    ("wheel", "a table [wheel]"),
    ("operation", "a table [operation]"),
    ("pair.module_mm", "mm"),
    ("pair.face_width_mm", "mm"),
    ("pinion.teeth", "an integer"),
    ("operation.pinion_torque_Nm", "Nm"),
    ("operation.pinion_speed_rpm", "rpm"),
]
UNKNOWN = [
    ("pair.face_widht_mm", "face_width_mm (the nearest"),
    ("pair.module", "module_mm (the nearest"),
    ("pinion.bore_mm", "bore_radius_mm (the nearest"),
    ("pinion.module_mm", "pair.module_mm (the nearest"),
    ("materials", "material (the nearest"),
    ("wheel.material.young", "youngs_modulus_MPa"),
    ("operation.zzz", "pinion_torque_Nm, wheel_torque_Nm"),
    ("Pair", "pair (the nearest"),
]
OTHER_GEARS = [
    ("pair.helix_angle_deg", 15.8, "helical gears are not supported"),
    ("helix_angle_deg", math.nan, "helical gears are not supported"),
    ("pinion.beta", -10, "helical gears are not supported"),
    ("pair.helical", True, "helical gears are not supported"),
    ("pair.kind", "helical", "helical gears are not supported"),
    ("wheel.teeth", -51, "internal gears are not supported"),
    ("wheel.internal", True, "internal gears are not supported"),
    ("internal_wheel", "yes", "internal gears are not supported"),
]
SURFACES = [
    ("material.surface_yield_pressure_MPa", 200.0, "several times its tensile yield strength"),
    ("wheel.material.surface_yield_pressure_MPa", 200.0, "several times its tensile yield strength"),
]


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [*RANGES, *((key, REMOVED, words) for key, words in MISSING), *((key, 1.0, words) for key, words in UNKNOWN), *OTHER_GEARS, *SURFACES],
)
def test_a_key_is_refused_by_name_in_one_line(key, value, words):
    with pytest.raises(InputError) as refusal:
        make_setup(changed({key: value}))
    assert refusal.value.where == key
    assert words in refusal.value.allowed
    assert "\n" not in str(refusal.value)


GEOMETRY = {
    "bore outside the root": ({"pinion.bore_radius_mm": 19.0}, "pinion.bore_radius_mm", "root radius of 17.5000 mm"),
    "bore that leaves no rim": ({"wheel.bore_radius_mm": 27.0}, "wheel.bore_radius_mm", "half a module"),
    "pointed tip of the rack's height": ({"pinion.teeth": 10, "pinion.profile_shift": 1.0}, "pinion.tip_radius_mm", "pointed"),
    "pointed tip as given": (
        {"pinion.teeth": 12, "pinion.profile_shift": 0.7, "pinion.tip_radius_mm": 15.75},
        "pinion.tip_radius_mm",
        "pointed",
    ),
    "tip below the root": ({"wheel.tip_radius_mm": 27.0}, "wheel.tip_radius_mm", "above 28"),
    "tip below its own edge round": ({"wheel.tip_edge_radius_mm": 5.0}, "wheel.tip_radius_mm", "tip edge radius"),
    "edge round without a land": ({"wheel.tip_edge_radius_mm": 1.2}, "wheel.tip_edge_radius_mm", "tip land"),
    "tip in the mate's root": ({"pinion.tip_radius_mm": 22.6}, "pinion.tip_radius_mm", "root of its mate"),
    "contact ratio, centres apart": ({"pair.centre_distance_mm": 51.9}, "pair.centre_distance_mm", "contact ratio is at least 1"),
    "contact ratio, short teeth": ({"pinion.tip_radius_mm": 20.3}, "pinion.tip_radius_mm", "contact ratio is at least 1"),
    "contact ratio, short rack": ({"rack.addendum": 0.5}, "rack.addendum", "contact ratio is at least 1"),
    "centres beyond the tips": ({"pair.centre_distance_mm": 60.0}, "pair.centre_distance_mm", "contact ratio is at least 1"),
    "jamming": ({"pair.centre_distance_mm": 49.9}, "pair.centre_distance_mm", "from 50.0000 mm"),
    "jamming in spite of backlash": (
        {"pair.centre_distance_mm": 49.8, "pair.normal_backlash_mm": 0.05},
        "pair.centre_distance_mm",
        "from 49.9",
    ),
    "centres inside the base circles": ({"pair.centre_distance_mm": 40.0}, "pair.centre_distance_mm", "from 50.0000 mm"),
    "interference": ({"rack.addendum": 1.2, "wheel.teeth": 90}, "pinion.profile_shift", "interference"),
    "undercut that leaves too short a path": ({"pinion.teeth": 6, "wheel.teeth": 60}, "pinion.profile_shift", "contact ratio"),
    "no clearance": ({"rack.dedendum": 0.9}, "rack.dedendum", "at least the addendum"),
    "rack tip too round": ({"rack.tip_radius": 0.6}, "rack.tip_radius", "no land left"),
    "rack pointed": ({"rack.dedendum": 2.2}, "rack.dedendum", "pointed"),
    "root too deep": ({"pinion.root_radius_mm": 15.0}, "pinion.root_radius_mm", "pointed"),
    "shifts without working angle": ({"pinion.profile_shift": -1.5, "wheel.profile_shift": -1.5}, "pinion.profile_shift", "larger sum"),
    "teeth thinned to a point": ({"pair.normal_backlash_mm": 4.5}, "pair.normal_backlash_mm", "pointed at the tip circle"),
    "root that shortens the mate": ({"pinion.root_radius_mm": 20.5}, "pinion.root_radius_mm", "contact ratio is at least 1"),
    "edge as sharp as a blade": ({"pinion.tip_edge_radius_mm": 1e-6}, "pinion.tip_edge_radius_mm", "from 0.002 mm"),
    "bore of a needle": ({"pinion.bore_radius_mm": 1e-3}, "pinion.bore_radius_mm", "from 0.3500 mm"),
    "inertia of a grain": ({"operation.wheel_inertia_kg_m2": 1e-12}, "operation.wheel_inertia_kg_m2", "of a solid disc"),
    "no root": ({"pinion.teeth": 5, "pinion.profile_shift": -1.0}, "pinion.profile_shift", "a root radius above"),
}


@pytest.mark.parametrize("case", GEOMETRY)
def test_impossible_geometry_names_the_key_that_decides_it(case):
    changes, where, words = GEOMETRY[case]
    with pytest.raises(InputError) as refusal:
        make_setup(changed(changes))
    assert refusal.value.where == where
    assert words in refusal.value.allowed
    assert "\n" not in str(refusal.value)


def test_what_says_that_something_is_absent_is_accepted():
    absent = {"pair.helix_angle_deg": 0.0, "wheel.internal": False, "effect": [], "pinion.flank": [], "calibration": {}}
    assert make_setup(changed(absent)).source == make_setup(BASE).source


@pytest.mark.parametrize("name", ["a helical gear's spur cousin", "internal no. 7"])
def test_the_name_of_a_model_is_free(name):
    assert make_setup(changed({"name": name})).name == name


FILES = {
    "syntax": (b"[pair]\nmodule_mm 8\n", "line 2, column 11", "TOML syntax"),
    "open end": (b"name = 'a", "", "TOML syntax"),
    "key twice": (b"name = 'a'\nname = 'b'\n", "line 2", "TOML syntax"),
    "not UTF-8": (b"# \nname = '\xff'\n", "line 2: found the byte 0xff", "UTF-8"),
    "empty": (b"", "pair", "must be given"),
    "NaN": (b"[pair]\nmodule_mm = nan\n", "pair.module_mm", "a number"),
}


@pytest.mark.parametrize("case", FILES)
def test_files_that_cannot_be_read_are_named(tmp_path: Path, case):
    content, where, words = FILES[case]
    path = tmp_path / "model.toml"
    path.write_bytes(content)
    with pytest.raises(InputError) as refusal:
        load_model(path)
    assert str(refusal.value).startswith(f"{path}: {where}")
    assert words in refusal.value.allowed
    assert "\n" not in str(refusal.value)


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path):
    for path in (tmp_path / "none.toml", tmp_path):
        with pytest.raises(InputError, match=r"the file: found .*; allowed: ") as refusal:
            load_model(path)
        assert str(refusal.value).startswith(f"{path}: ")
