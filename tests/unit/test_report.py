"""Tables, summary, pictures and the report: names, units, refusals. The results are made by hand, without the chain."""

from __future__ import annotations

import csv
import dataclasses
import html
import json
import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from markupsafe import Markup

from gearfem.compliance import load_positions
from gearfem.compliance.record import Compliance, ComplianceCurve, ToothCompliance
from gearfem.dynamics.record import ElasticMotion, RigidMotion
from gearfem.engagement.contacts import find_contacts
from gearfem.engagement.record import Engagement
from gearfem.flank import make_flanks
from gearfem.pipeline import Results
from gearfem.placement import make_placement
from gearfem.report import (
    Rendering,
    summarise,
    write_compliance,
    write_dynamics,
    write_kinematics,
    write_pictures,
    write_report,
    write_stiffness,
    write_summary,
)
from gearfem.report.html import _micro

PAIR_STIFFNESS = 1.2e9


def make_curves(outline, scale=1.0):
    """A tooth curve that rises with the square of the height, twice for the gear held at its bore."""
    u = np.linspace(2.0, 4.0, 41)
    radius = np.hypot(*outline.point(u).T)
    root = 2e-12 * scale * (1.0 + 3.0 * ((radius - radius[0]) / (radius[-1] - radius[0])) ** 2)
    shape = {"u": u, "radius": radius, "depth": np.full_like(u, outline.gear.module)}
    bore = ToothCompliance(
        method="fe_plane_strain",
        support="bore",
        deflection=2.0 * root,
        outline=outline,
        offsets=(-1, 1),
        coupling=np.zeros((2, 41, 41)),
        local_depth=shape["depth"],
        **shape,
    )
    beam = ComplianceCurve(method="castigliano", support="root", deflection=1.05 * root, **shape)
    return bore, (ComplianceCurve(method="fe_plane_strain", support="root", deflection=root, **shape), beam)


def make_engagement(setup, flanks, torque):
    """Equal springs behind the gaps: one pair 1200 N/um, the load shared by gaps alone, at most pairs -1, 0, 1."""
    pair = setup.pair
    angle = np.linspace(-1.0, 1.0, 201) * pair.pinion.pitch_angle
    contacts = find_contacts(flanks, make_placement(setup), angle, (-2, -1, 0, 1, 2))
    touching = contacts.gap == 0.0
    count = touching.sum(axis=1)
    load = torque / pair.pinion.base_radius
    error = load / (PAIR_STIFFNESS * count)
    ratio = pair.ratio * (1.0 + 1e-3 * np.sin(2.0 * np.pi * angle / pair.pinion.pitch_angle))
    return Engagement(
        contacts=contacts,
        pinion_torque=torque,
        force=np.where(touching, load / count[:, None], 0.0),
        transmission_error=error,
        mesh_stiffness=PAIR_STIFFNESS * count * 1.0,
        secant_stiffness=0.95 * PAIR_STIFFNESS * count,
        single_stiffness=PAIR_STIFFNESS * touching,
        contact_pressure=1e9 * touching,
        gear_ratio=ratio,
        gear_ratio_unloaded=np.full(angle.size, pair.ratio),
        gear_ratio_force=np.full(angle.size, pair.ratio),
    )


def make_motion(setup, cycles, factor):
    pitch, speed = setup.pair.pinion.pitch_angle, setup.operation.pinion_speed
    angle = np.linspace(0.0, cycles * pitch, 100 * cycles + 1)
    wave = np.sin(2.0 * np.pi * angle / pitch)
    kw = 1.0 + (factor - 1.0) * wave
    torque, inertia = setup.operation.pinion_torque, setup.operation.pinion_inertia
    acceleration = (1.0 - kw) * torque / inertia
    return {
        "pinion_angle": angle,
        "time": angle / speed,
        "pinion_speed": speed * (1.0 + 1e-4 * wave),
        "pinion_acceleration": acceleration,
        "dynamic_factor": kw,
    }


def make_rigid(setup):
    motion = {name: values[:-1] for name, values in make_motion(setup, 1, 1.05).items()}
    pair = setup.pair
    return RigidMotion(
        period=pair.pinion.pitch_angle,
        wheel_angle=motion["pinion_angle"] / pair.ratio,
        wheel_acceleration=motion["pinion_acceleration"] / pair.ratio,
        wheel_torque=4911.0,
        step_error=1e-6,
        **motion,
    )


def make_elastic(setup, factor):
    motion = make_motion(setup, 4, factor)
    load = setup.operation.pinion_torque / setup.pair.pinion.base_radius
    return ElasticMotion(
        mesh_force=load * motion["dynamic_factor"],
        transmission_error=1e-5 * motion["dynamic_factor"],
        wheel_torque=5000.0,
        multipliers=np.array([0.1, 0.1], dtype=complex),
        closure=1e-9,
        periodic=True,
        contact_loss=0.0,
        **motion,
    )


@pytest.fixture(scope="module")
def results(coal_combine) -> Results:
    """Results of every stage, made by hand."""
    setup = dataclasses.replace(coal_combine, name="coal\ncombine", source="[pair]\n")
    flanks = make_flanks(setup)
    (pinion, pinion_others), (wheel, wheel_others) = make_curves(flanks.pinion), make_curves(flanks.wheel, 1.2)
    return Results(
        setup=setup,
        flanks=flanks,
        compliance=Compliance(pinion=pinion, wheel=wheel),
        comparison=(*(("pinion", curve) for curve in pinion_others), *(("wheel", curve) for curve in wheel_others)),
        engagement=make_engagement(setup, flanks, 1605.0),
        rigid=make_rigid(setup),
        elastic=make_elastic(setup, 1.4),
        classical=make_elastic(setup, 1.3),
        assumptions=("The gears are solid steel discs.", "Friction <none> & more."),
    )


def read(path: Path) -> tuple[str, list[str], dict[str, np.ndarray]]:
    """Return the comment, the header and the columns of a CSV."""
    lines = path.read_text(encoding="utf-8").splitlines()
    header, *rows = csv.reader(lines[1:])
    return lines[0], header, {name: np.array(values) for name, values in zip(header, zip(*rows, strict=True), strict=True)}


def test_compliance_columns_and_units(results, tmp_path):
    comment, header, columns = read(write_compliance(results, tmp_path))
    assert header == ["gear", "method", "support", "radius_mm", "deflection_um_per_N_per_mm"]
    assert re.fullmatch(r"# gearfem \S+, model [0-9a-f]{64}, coal combine", comment)
    assert set(columns["gear"]) == {"pinion", "wheel"}
    assert {*zip(columns["method"], columns["support"], strict=True)} == {
        ("fe_plane_strain", "bore"), ("fe_plane_strain", "root"), ("castigliano", "root")
    }  # fmt: skip
    # By hand: 4e-12 m per N/m = 4e-6 um per N/m = 4e-3 um per N/mm.
    assert float(columns["deflection_um_per_N_per_mm"][0]) == pytest.approx(4e-3, rel=1e-9, abs=0.0)


def test_compliance_of_chosen_methods_alone(results, tmp_path):
    alone = Results(setup=results.setup, flanks=results.flanks, comparison=results.comparison[:1])
    _, _, columns = read(write_compliance(alone, tmp_path))
    assert set(columns["support"]) == {"root"}
    with pytest.raises(ValueError, match="hold no compliance"):
        write_compliance(Results(setup=results.setup, flanks=results.flanks), tmp_path)


def test_stiffness_columns_and_units(results, tmp_path):
    _, header, columns = read(write_stiffness(results, tmp_path))
    assert header == [
        "pinion_torque_Nm", "pinion_angle_rad", "mesh_stiffness_N_per_um", "secant_stiffness_N_per_um", "transmission_error_um",
        "pairs_in_contact", "load_share_m1", "load_share_0", "load_share_p1",
        "contact_pressure_m1_MPa", "contact_pressure_0_MPa", "contact_pressure_p1_MPa",
    ]  # fmt: skip
    middle = 100
    assert [columns[f"contact_pressure_{name}_MPa"][middle] for name in ("m1", "0", "p1")] == ["0", "1000", "0"]
    assert columns["pairs_in_contact"][middle] == "1"
    # By hand: 1.2e9 N/m = 1200 N/um; 1605 N m / 60.14 mm / 1200 N/um = 22.24 um.
    assert float(columns["mesh_stiffness_N_per_um"][middle]) == pytest.approx(1200.0)
    assert float(columns["transmission_error_um"][middle]) == pytest.approx(22.24, abs=0.01)
    shares = np.stack([columns[f"load_share_{name}"].astype(float) for name in ("m1", "0", "p1")])
    # Ten digits are written.
    assert shares.sum(axis=0) == pytest.approx(np.ones(shares.shape[1]), abs=1e-9)
    assert shares[0, 0] > 0.0
    assert shares[2, 0] == 0.0


def test_a_pair_that_carries_gets_its_column(results, tmp_path):
    engagement = results.engagement
    force = np.array(engagement.force)
    force[-1, 4] = 1.0
    twice = (engagement, dataclasses.replace(engagement, force=force, pinion_torque=800.0))
    _, header, columns = read(write_stiffness(results, tmp_path, twice))
    assert header[-8:-4] == ["load_share_m1", "load_share_0", "load_share_p1", "load_share_p2"]
    assert header[-1] == "contact_pressure_p2_MPa"
    assert set(columns["pinion_torque_Nm"]) == {"1605", "800"}
    assert len(columns["pinion_torque_Nm"]) == 402


def test_kinematics_has_one_row_per_pair_in_contact(results, tmp_path):
    _, header, columns = read(write_kinematics(results, tmp_path))
    assert header == [
        "pinion_angle_rad", "pair", "gear_ratio", "gear_ratio_unloaded", "gear_ratio_force", "contact_x_mm", "contact_y_mm",
        "pressure_angle_deg", "rolling_velocity_1_m_per_s", "rolling_velocity_2_m_per_s", "sliding_velocity_m_per_s",
        "equivalent_radius_mm", "gear_ratio_pair", "material_velocity_1_m_per_s", "material_velocity_2_m_per_s",
        "specific_sliding_1", "specific_sliding_2", "contact_pressure_MPa", "normal_force_N",
    ]  # fmt: skip
    assert len(columns["pair"]) == int((results.engagement.force > 0.0).sum())
    at_pitch = np.flatnonzero((np.abs(columns["pinion_angle_rad"].astype(float)) < 1e-9) & (columns["pair"] == "0"))[0]
    # By hand at the pitch point: x = 281.57 x 16/67 mm; r_b1 tan(26.568 deg) x 53 rad/s; no sliding.
    assert float(columns["contact_x_mm"][at_pitch]) == pytest.approx(67.240, abs=1e-3)
    assert float(columns["pressure_angle_deg"][at_pitch]) == pytest.approx(26.568, abs=1e-3)
    assert float(columns["rolling_velocity_1_m_per_s"][at_pitch]) == pytest.approx(1.5939, abs=1e-3)
    assert abs(float(columns["sliding_velocity_m_per_s"][at_pitch])) < 1e-9


def test_dynamics_columns(results, tmp_path):
    rigid, elastic, classical = write_dynamics(results, tmp_path)
    assert [path.name for path in (rigid, elastic, classical)] == ["rigid.csv", "elastic.csv", "classical.csv"]
    motion = ["pinion_speed_rad_per_s", "pinion_acceleration_rad_per_s2", "dynamic_factor"]
    assert read(rigid)[1] == ["pinion_angle_rad", "time_s", *motion]
    _, header, columns = read(elastic)
    assert header == ["time_s", "pinion_angle_rad", "mesh_force_N", "transmission_error_um", *motion]
    assert float(columns["transmission_error_um"][0]) == pytest.approx(10.0)


def test_summary_has_every_key_as_finite_json(results, tmp_path):
    def refuse(constant):
        raise AssertionError(f"{constant} is not JSON")

    values = json.loads(write_summary(results, tmp_path).read_text(), parse_constant=refuse)
    keys = """contact_ratio working_pressure_angle_deg centre_distance_mm tip_radius_mm root_radius_mm base_radius_mm
        single_stiffness_max_N_per_mm_um mesh_stiffness_mean_N_per_mm_um iso6336_c_prime_N_per_mm_um iso6336_c_gamma_alpha_N_per_mm_um
        dynamic_factor_rigid dynamic_factor_elastic dynamic_factor_classical gear_ratio_min gear_ratio_max gear_ratio_mean
        castigliano_over_fe_min castigliano_over_fe_max assumptions version model_sha256"""
    assert set(keys.split()) <= set(values)
    assert values["tip_radius_mm"] == pytest.approx([76.17, 219.17])
    # By hand: 1.2e9 N/m over 75 mm = 16 N/(mm um).
    assert values["single_stiffness_max_N_per_mm_um"] == pytest.approx(16.0)
    assert values["dynamic_factor_elastic"] == pytest.approx(1.4)
    assert values["castigliano_over_fe_min"] == pytest.approx(1.05)
    assert values["castigliano_over_fe_max"] == pytest.approx(1.05)
    # The transmission error repeats, so both turns are in the ratio of the teeth to rounding error.
    assert values["gear_ratio_mean"] == pytest.approx(51.0 / 16.0, rel=1e-14, abs=0.0)
    assert values["assumptions"][:2] == list(results.assumptions)


def test_mean_gear_ratio_sees_a_wheel_that_falls_back(results):
    engagement = results.engagement
    angle = engagement.contacts.pinion_angle
    drift = np.linspace(0.0, 1e-4, angle.size)
    slipping = dataclasses.replace(engagement, transmission_error=engagement.transmission_error + drift)
    mean = summarise(dataclasses.replace(results, engagement=slipping))["gear_ratio_mean"]
    # By hand: two pitches of the pinion, pi/4 rad, and those of the wheel, 4 pi/51, less 0.1 mm on r_b2 = 191.697 mm.
    assert mean == pytest.approx((math.pi / 4.0) / (4.0 * math.pi / 51.0 - 0.1 / 191.697), rel=1e-6, abs=0.0)


def test_loads_on_the_tip_round_are_left_out(results, tmp_path):
    _, _, columns = read(write_compliance(results, tmp_path))
    # The involute ends above the inner circle of the tip round, 0.16 mm below the tip circle.
    largest = columns["radius_mm"][columns["gear"] == "pinion"].astype(float).max()
    assert 76.01 < largest < 76.17


def test_summary_of_part_of_the_chain(results):
    values = summarise(Results(setup=results.setup, flanks=results.flanks))
    assert "contact_ratio" in values
    assert "dynamic_factor_elastic" not in values


def test_model_hash_follows_the_content(results):
    def hash_of(setup):
        return summarise(Results(setup=setup, flanks=results.flanks))["model_sha256"]

    bare = dataclasses.replace(results.setup, source="")
    assert hash_of(results.setup) != hash_of(dataclasses.replace(results.setup, source="[pair]\n\n"))
    assert hash_of(bare) != hash_of(dataclasses.replace(bare, name="other"))


def test_a_missing_stage_is_named(results, tmp_path):
    with pytest.raises(ValueError, match="hold no engagement"):
        write_stiffness(Results(setup=results.setup, flanks=results.flanks), tmp_path)


def test_pictures_and_self_contained_report(results, tmp_path):
    pictures = write_pictures(results, tmp_path)
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in pictures.values())
    rows = [("largest dynamic factor", 1.4, 1.36, "", "the inertias are assumed")]
    page = write_report(results, tmp_path, published=rows).read_text(encoding="utf-8")
    assert len(pictures) == 10
    assert pictures["elastic_motion"].read_bytes() != pictures["rigid_motion"].read_bytes()
    assert page.count("data:image/png;base64,") == len(pictures)
    assert not re.search(r"""(?:src|href)\s*=\s*["']?\s*(?:https?:|//)|@import|url\(""", page)
    assert "Friction &lt;none&gt; &amp; more." in page
    assert "the inertias are assumed" in page
    assert summarise(results)["model_sha256"] in page


def test_the_words_of_the_report_say_what_the_numbers_are(results, tmp_path):
    page = html.unescape(write_report(results, tmp_path).read_text(encoding="utf-8"))
    for words in (
        "slope dF/dδ), that of a single pair at most",
        "(secant F/δ)",
        "report 0.9 to 1.1 for their gears",
        "no bound for these",
        "Kw = 1 - J₁ψ₁''/T₁",
        "ratio of the forces Σ P l₂/Σ P l₁",
        "the moment of the teeth on the pinion, friction included",
        "friction's, which reverses where a pair passes the pitch point",
    ):
        assert words in page
    assert "within 10 %" not in page
    smooth = dataclasses.replace(
        results, setup=dataclasses.replace(results.setup, operation=dataclasses.replace(results.setup.operation, friction_coefficient=0.0))
    )
    assert "reverses where" not in write_report(smooth, tmp_path).read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_picture_of_the_tooth_says_which_load_it_bears(results, tmp_path):
    picture = write_pictures(Results(setup=results.setup, flanks=results.flanks), tmp_path)["pair"]
    rendering = Rendering(picture, "Line load 350 N/mm", "matplotlib", "")

    def page(changed):
        return write_report(changed, tmp_path, rendering=rendering).read_text(encoding="utf-8")

    assert "the whole normal force, at the outer end of one-pair contact" in page(results)
    # As of gears of which two pairs always carry: half the force on each.
    force = np.array(results.engagement.force)
    force[:, :2] = force[:, 2:4] = force.sum(axis=1, keepdims=True) / 4.0
    force[:, 4] = 0.0
    assert "never carries more than 25 % of it" in page(
        dataclasses.replace(results, engagement=dataclasses.replace(results.engagement, force=force))
    )


def test_rows_left_out_are_counted(results, tmp_path):
    assert summarise(results)["compliance_rows_left_out"] == []
    owner, curve = results.comparison[1]
    shape = {name: getattr(curve, name)[5:] for name in ("u", "radius", "deflection", "depth")}
    cut = dataclasses.replace(results, comparison=((owner, dataclasses.replace(curve, **shape)),))
    wanted = load_positions(results.flanks.pinion)
    rows = [{"gear": "pinion", "method": "castigliano", "support": "root", "count": int((wanted < 2.25).sum())}]
    assert rows[0]["count"] > 1
    assert summarise(cut)["compliance_rows_left_out"] == rows
    page = write_report(cut, tmp_path).read_text(encoding="utf-8")
    assert f"{rows[0]['count']} of the pinion (castigliano, root)" in page
    assert "compliance_rows_left_out" not in summarise(Results(setup=results.setup, flanks=results.flanks))


def test_report_without_comparison_has_no_such_section(results, tmp_path):
    page = write_report(Results(setup=results.setup, flanks=results.flanks), tmp_path).read_text(encoding="utf-8")
    assert "published" not in page.lower()


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("-14.4 um missing, 20 N/(mm um)", "-14.4 µm missing, 20 N/(mm µm)"),
        ("data:image/png;base64,a/um+um=", "data:image/png;base64,a/um+um="),
        ("in column deviation_um", "in column deviation_um"),
        (Markup("<b> um</b>"), "<b> um</b>"),
    ],
)
def test_pages_write_micrometres_with_their_sign(text: str, shown: str) -> None:
    assert _micro(text) == shown


def test_importing_the_package_loads_no_picture_library():
    code = "import sys, gearfem.report; assert gearfem.report.write_compliance; print({'matplotlib', 'pyvista'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
