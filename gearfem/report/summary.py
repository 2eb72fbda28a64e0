"""The numbers of a result, under the keys of summary.json."""

from __future__ import annotations

import importlib.metadata
from typing import Any, TypeVar

import numpy as np
from scipy.interpolate import PchipInterpolator

from gearfem.compliance import load_positions
from gearfem.compliance.record import ComplianceCurve
from gearfem.definition.model_file import model_hash
from gearfem.definition.setup import GearPair, Member, Setup
from gearfem.engagement.iso6336 import IsoStiffness, iso6336_stiffness
from gearfem.engagement.record import Engagement
from gearfem.flank import Flanks, Outline, path_of_contact
from gearfem.flank.outline import FLANK, ROUND
from gearfem.foundation import Array
from gearfem.foundation.units import factor
from gearfem.pipeline import Results

Part = TypeVar("Part")
MEMBERS: tuple[Member, ...] = ("pinion", "wheel")
model_sha256 = model_hash


def need(part: Part | None, name: str) -> Part:
    """Return a stage's record, or say which one is missing.

    Parameters
    ----------
    part : record or None
        Field of `Results`.
    name : str
        What to call it.

    Raises
    ------
    ValueError
        If the stage was not run.
    """
    if part is None:
        raise ValueError(f"these results hold no {name}: run the chain to a later stage")
    return part


def version() -> str:
    """Return the version of the installed gearfem."""
    return importlib.metadata.version("gearfem")


def identity(setup: Setup) -> str:
    """Return the line that says which program and which model a file comes from.

    Parameters
    ----------
    setup : Setup
        Definition of the model.

    Returns
    -------
    str
        One line, whatever the model's name holds.
    """
    return f"gearfem {version()}, model {model_hash(setup)}, {' '.join(setup.name.split())}"


def engagements_of(results: Results) -> tuple[Engagement, ...]:
    """Return the engagements of all torques that were run, at least one."""
    return (need(results.engagement, "engagement"),)


def summarise(results: Results) -> dict[str, Any]:
    """Return the keys of summary.json, each in the unit that its name ends in.

    Parameters
    ----------
    results : Results
        Of any stages; keys of stages that were not run are left out.

    Returns
    -------
    dict
        Numbers, lists of numbers per gear (pinion, wheel) and sentences.

    Notes
    -----
    c' of ISO 6336-1 method B includes C_M, C_R and C_B.
    """
    iso = iso_stiffness(results.setup)
    values = {**_geometry(results.setup.pair, results.flanks), **_iso(iso)}
    if results.engagement is not None:
        values |= _engagement(results.setup, results.engagement)
    values |= _dynamics(results)
    scaled = {name: np.asarray(value) / factor(name) for name, value in values.items()}
    ratios = castigliano_over_fe(results)
    if ratios is not None:
        scaled |= {"castigliano_over_fe_min": ratios.min(), "castigliano_over_fe_max": ratios.max()}
    return {
        "name": results.setup.name,
        **{name: _twelve_digits(value) for name, value in scaled.items()},
        **({"compliance_rows_left_out": left_out(results)} if results.compliance is not None or results.comparison else {}),
        "assumptions": list(dict.fromkeys((*results.assumptions, *iso.assumptions))),
        "version": version(),
        "model_sha256": model_hash(results.setup),
    }


def _twelve_digits(value: Any) -> Any:
    """Return numbers without the rounding of the change of units, which would show as 76.16999999999999."""
    values = np.asarray(value)
    return [_twelve_digits(item) for item in values] if values.ndim else float(f"{values.item():.12g}")


def _geometry(pair: GearPair, flanks: Flanks) -> dict[str, Any]:
    gears = (pair.pinion, pair.wheel)
    return {
        "contact_ratio": sum(path_of_contact(flanks, pair)) / pair.base_pitch,
        "working_pressure_angle_deg": pair.working_pressure_angle,
        "centre_distance_mm": pair.centre_distance,
        "face_width_mm": pair.face_width,
        "tip_radius_mm": [gear.tip_radius for gear in gears],
        "root_radius_mm": [gear.root_radius for gear in gears],
        "base_radius_mm": [gear.base_radius for gear in gears],
    }


def iso_stiffness(setup: Setup) -> IsoStiffness:
    """Return the tooth stiffness of ISO 6336-1 method B at the model's torque."""
    return iso6336_stiffness(setup.pair, setup.operation.pinion_torque)


def _iso(iso: IsoStiffness) -> dict[str, Any]:
    return {
        "iso6336_c_prime_N_per_mm_um": iso.single_stiffness,
        "iso6336_c_gamma_alpha_N_per_mm_um": iso.mesh_stiffness,
        "iso6336_c_prime_th_N_per_mm_um": iso.theoretical_stiffness,
        "iso6336_C_M": iso.correction_factor,
        "iso6336_C_R": iso.blank_factor,
        "iso6336_C_B": iso.rack_factor,
    }


def _engagement(setup: Setup, engagement: Engagement) -> dict[str, Any]:
    width = setup.pair.face_width
    pitch = setup.pair.pinion.pitch_angle
    angle = engagement.contacts.pinion_angle
    return {
        "pinion_torque_Nm": engagement.pinion_torque,
        "normal_force_N": engagement.pinion_torque / setup.pair.pinion.base_radius,
        "single_stiffness_max_N_per_mm_um": engagement.single_stiffness.max() / width,
        "mesh_stiffness_mean_N_per_mm_um": mean_over_pitches(angle, engagement.mesh_stiffness, pitch) / width,
        "gear_ratio_nominal": setup.pair.ratio,
        "gear_ratio_min": engagement.gear_ratio.min(),
        "gear_ratio_max": engagement.gear_ratio.max(),
        "gear_ratio_mean": mean_gear_ratio(setup.pair, engagement),
        "transmission_error_peak_to_peak_um": np.ptp(engagement.transmission_error),
    }


def mean_over_pitches(angle: Array, values: Array, pitch: float) -> float:
    """Return the mean of a periodic quantity over the largest whole number of pitches from the first angle.

    Parameters
    ----------
    angle, values : ndarray, shape (n,)
        Increasing angles [rad] and the values there.
    pitch : float
        Angular pitch [rad].

    Returns
    -------
    float
        By the trapezoidal rule, second order in the step for values with kinks.

    Raises
    ------
    ValueError
        If the angles cover less than one pitch.
    """
    end = _last_whole_pitch(angle, pitch)
    inside = angle < end
    x = np.append(angle[inside], end)
    y = np.append(values[inside], np.interp(end, angle, values))
    return float(np.trapezoid(y, x) / (end - angle[0]))


def _last_whole_pitch(angle: Array, pitch: float) -> float:
    # One part in a million of a pitch forgives the rounding of an angle that should end on a whole pitch.
    pitches = int((angle[-1] - angle[0]) / pitch + 1e-6)
    if pitches < 1:
        raise ValueError(f"angles over {(angle[-1] - angle[0]) / pitch:.3f} pitches, where a mean needs at least one whole pitch")
    return float(min(angle[0] + pitches * pitch, angle[-1]))


def mean_gear_ratio(pair: GearPair, engagement: Engagement) -> float:
    """Return the mean of the gear ratio under load over the wheel's angle, for whole pitches.

    Parameters
    ----------
    pair : GearPair
        The gears.
    engagement : Engagement
        One torque.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If the angles cover less than one pitch.

    Notes
    -----
    With i = dphi1/dphi2 the integral of i dphi2 is the pinion's turn, so the mean is the quotient of both turns;
    the wheel's is phi1 z1/z2 less its lag e/r_b2. It is z2/z1 if and only if the transmission error is periodic.
    """
    angle, lag = engagement.contacts.pinion_angle, engagement.transmission_error
    end = _last_whole_pitch(angle, pair.pinion.pitch_angle)
    turn = end - angle[0]
    change = float(np.interp(end, angle, lag)) - lag[0]
    return float(turn / (turn / pair.ratio - change / pair.wheel.base_radius))


def _dynamics(results: Results) -> dict[str, Any]:
    values: dict[str, Any] = {}
    if results.rigid is not None:
        values["dynamic_factor_rigid"] = results.rigid.dynamic_factor.max()
    if results.elastic is not None:
        values["dynamic_factor_elastic"] = results.elastic.largest_dynamic_factor
        values["contact_loss"] = results.elastic.contact_loss
    if results.classical is not None:
        values["dynamic_factor_classical"] = results.classical.largest_dynamic_factor
    return values


def left_out(results: Results) -> list[dict[str, Any]]:
    """Return how many load positions the compliance curves leave out because their load line crosses the centreline too low.

    Parameters
    ----------
    results : Results
        Of any stages.

    Returns
    -------
    list of dict
        ``gear``, ``method``, ``support`` and ``count`` of each curve that leaves some of the standard positions out: those
        below its first one, where the crossing lies under the clamp or under the trapezoid's base.
    """
    rows = []
    for member in MEMBERS:
        outline = results.flanks.pinion if member == "pinion" else results.flanks.wheel
        wanted = load_positions(outline)
        stage = [results.compliance.of(member)] if results.compliance is not None else []
        for curve in (*stage, *(curve for owner, curve in results.comparison if owner == member)):
            # Solids are computed at fewer positions of their own, which leave nothing out of the standard ones.
            count = int((wanted < curve.u[0]).sum()) if curve.method != "fe_3d" else 0
            if count:
                rows.append({"gear": member, "method": curve.method, "support": curve.support, "count": count})
    return rows


def castigliano_over_fe(results: Results) -> Array | None:
    """Return the ratios of Castigliano's to the finite elements' compliance over the active flanks of both gears.

    Parameters
    ----------
    results : Results
        Whose comparison holds both methods for the tooth held at its root, in plane strain.

    Returns
    -------
    ndarray, shape (k,), or None
        At the load points of both curves and at both ends of the part of the active flank that they share;
        None where a method is missing for both gears.
    """
    ratios = [ratio for member in ("pinion", "wheel") if (ratio := _ratio_of(results, member)) is not None]
    return np.concatenate(ratios) if ratios else None


def _ratio_of(results: Results, member: str) -> Array | None:
    curves = {curve.method: curve for owner, curve in results.comparison if owner == member and curve.support == "root"}
    if "castigliano" not in curves or "fe_plane_strain" not in curves:
        return None
    beam, solid = curves["castigliano"], curves["fe_plane_strain"]
    low, high = active_flank(results.setup.pair, results.flanks, member)
    low, high = max(low, beam.u[0], solid.u[0]), min(high, beam.u[-1], solid.u[-1])
    u = np.unique(np.concatenate([beam.u, solid.u, [low, high]]))
    u = u[(u >= low) & (u <= high)]
    ratio: Array = _at(beam, u) / _at(solid, u)
    return ratio


def _at(curve: ComplianceCurve, u: Array) -> Array:
    values: Array = PchipInterpolator(curve.u, curve.deflection)(u)
    return values


def active_flank(pair: GearPair, flanks: Flanks, member: str) -> tuple[float, float]:
    """Return the outline parameters u of the lowest contact point and of the tip end of a flank.

    Parameters
    ----------
    pair : GearPair
        How the gears are mounted.
    flanks : Flanks
        Their outlines.
    member : str
        ``pinion`` or ``wheel``.

    Returns
    -------
    tuple of float
        Of [2, 3]. The mate's tip reaches down to the roll length a sin(alpha_w) - s_tip (ISO 21771).
    """
    outline: Outline = flanks.pinion if member == "pinion" else flanks.wheel
    mate: Outline = flanks.wheel if member == "pinion" else flanks.pinion
    roll = pair.centre_distance * np.sin(pair.working_pressure_angle) - mate.flank_end
    return max(float(outline.parameter(roll)), FLANK), ROUND
