"""The keys of [[drive.inertia]] and [drive.support]: what they become in SI, and how each wrong one is refused."""

from __future__ import annotations

import math

import pytest

from gearfem.dynamics import make_drive
from gearfem.foundation import InputError
from gearfem.model import load_model, make_setup

BASE = {
    "pair": {"module_mm": 3.0, "face_width_mm": 30.0},
    "pinion": {"teeth": 35},
    "wheel": {"teeth": 36},
    "operation": {"pinion_torque_Nm": 75.4, "pinion_speed_rpm": 1500.0},
}
MOTOR = {"name": "motor", "side": "pinion", "inertia_kg_m2": 0.4, "shaft_stiffness_Nm_per_rad": 2e4}
LOAD = {"name": "load", "side": "wheel", "inertia_kg_m2": 0.9, "shaft_stiffness_Nm_per_rad": 3e4, "shaft_damping_Nms_per_rad": 1.5}


def setup_of(drive):
    return make_setup({**BASE, "drive": drive})


def test_tables_become_a_chain_in_si():
    setup = setup_of({"inertia": [LOAD, MOTOR], "support": {"wheel_um_per_kN": 2.0, "wheel_damping_Ns_per_m": 700.0}})
    drive = make_drive(setup)
    (motor,), (load,) = drive.pinion_chain, drive.wheel_chain
    assert (motor.name, motor.inertia, motor.stiffness, motor.damping) == ("motor", 0.4, 2e4, 0.0)
    assert (load.name, load.damping) == ("load", 1.5)
    assert drive.pinion_support is None
    assert drive.wheel_support.compliance == pytest.approx(2e-9, rel=1e-12, abs=0.0)
    wheel = setup.pair.wheel
    assert drive.wheel_support.mass == pytest.approx(
        7850.0 * math.pi * (wheel.reference_radius**2 - wheel.bore_radius**2) * 0.03, rel=1e-12, abs=0.0
    )
    assert drive.pinion_side_inertia == pytest.approx(drive.pinion_inertia + 0.4)
    assert not drive.two_inertias
    texts = " ".join(setup.assumptions)
    assert 'Damping of the shaft of "motor" not given' in texts
    assert '"load" not given' not in texts
    assert "Mass on the support of the wheel not given" in texts


def test_without_tables_there_are_two_inertias():
    one, two = make_setup(BASE), setup_of({"inertia": [], "support": {"pinion_um_per_kN": 0.0}})
    assert make_drive(one).two_inertias
    assert make_drive(two).two_inertias
    assert one.assumptions == two.assumptions
    assert setup_of({"inertia": []}).source == one.source


@pytest.mark.parametrize(
    ("drive", "where", "allowed"),
    [
        (5, "drive:", r"a table \[drive\]"),
        ({"inertia": MOTOR}, "drive.inertia:", r"tables \[\[drive.inertia\]\]"),
        ({"inertia": [7]}, r"drive.inertia\[1\]:", r"a table \[\[drive.inertia\]\]"),
        ({"inertia": [MOTOR, MOTOR]}, r"drive.inertia\[2\].name", "a name of its own"),
        ({"inertia": [{**MOTOR, "side": "left"}]}, r"drive.inertia\[1\].side", '"pinion" or "wheel"'),
        ({"inertia": [LOAD, {**MOTOR, "inertia_kg_m2": 0.0}]}, r"drive.inertia\[2\].inertia_kg_m2", "a number above 0"),
        ({"inertia": [{**MOTOR, "shaft_stiffness_Nm_per_rad": math.nan}]}, "shaft_stiffness_Nm_per_rad", "Nm/rad"),
        ({"inertia": [{**MOTOR, "shaft_stiffness": 1.0}]}, r"drive.inertia\[1\].shaft_stiffness", "shaft_stiffness_Nm_per_rad"),
        ({"inertia": [{"name": "x", "side": "wheel"}]}, r"drive.inertia\[1\].inertia_kg_m2", "must be given"),
        ({"support": {"pinion_mass_kg": 3.0}}, "drive.support.pinion_mass_kg", "only beside pinion_um_per_kN"),
        ({"support": {"pinion_um_per_kN": -1.0}}, "drive.support.pinion_um_per_kN", "from 0"),
        ({"suport": {}}, "drive.suport", "support"),
    ],
)
def test_refusals_name_key_and_remedy(drive, where, allowed):
    with pytest.raises(InputError, match=where) as caught:
        setup_of(drive)
    assert "\n" not in str(caught.value)
    caught.match(allowed)


def test_a_file_and_an_override(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text(
        "[pair]\nmodule_mm = 3.0\nface_width_mm = 30.0\n[pinion]\nteeth = 35\n[wheel]\nteeth = 36\n"
        "[operation]\npinion_torque_Nm = 75.4\npinion_speed_rpm = 1500.0\n"
        '[[drive.inertia]]\nname = "motor"\nside = "pinion"\ninertia_kg_m2 = 0.4\nshaft_stiffness_Nm_per_rad = 20000.0\n'
    )
    setup = load_model(path, ["drive.support.pinion_um_per_kN=4"])
    assert setup.operation.pinion_chain[0].stiffness == 2e4
    assert setup.operation.pinion_support.compliance == pytest.approx(4e-9, rel=1e-12, abs=0.0)
