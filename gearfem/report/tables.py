"""Series as CSV and results as JSON, in the units that the names of their columns and keys end in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gearfem.compliance.record import ComplianceCurve
from gearfem.definition.setup import Member
from gearfem.dynamics.record import ElasticMotion
from gearfem.engagement.record import Engagement
from gearfem.engagement.width_load import WidthLoad
from gearfem.flank.outline import ROUND
from gearfem.foundation import Array
from gearfem.foundation.files import write_csv, write_json
from gearfem.foundation.units import factor
from gearfem.pipeline import Results
from gearfem.report.summary import engagements_of, identity, need, summarise


def write_compliance(results: Results, out: Path) -> Path:
    """Write compliance.csv: deflection per line load over the load radius, both gears, all methods and supports.

    Parameters
    ----------
    results : Results
        With its compliance stage, or with curves in `comparison` alone.
    out : Path
        Folder.

    Returns
    -------
    Path
        The file. Loads on the tip round turn towards the tooth's axis within a few hundredths of a millimetre of
        radius; they are no function of the radius and left out, so that each radius stands once for a gear, method and support.

    Notes
    -----
    `error_estimate`, where every curve has one, is relative to the deflection of its row: the error of the mesh by comparison
    with a coarser one for finite elements, rounding (1e-14) for Castigliano's closed integrals. What a method leaves out (the
    body, the third dimension, a straight-sided tooth) is not in it; the methods differ by far more than these.
    """
    curves = compliance_curves(results)
    columns = {
        "gear": np.concatenate([np.full(curve.u.size, member) for member, curve in curves]),
        "method": np.concatenate([np.full(curve.u.size, curve.method) for _, curve in curves]),
        "support": np.concatenate([np.full(curve.u.size, curve.support) for _, curve in curves]),
        "radius_mm": np.concatenate([curve.radius for _, curve in curves]),
        "deflection_um_per_N_per_mm": np.concatenate([curve.deflection for _, curve in curves]),
    }
    errors = [curve.error for _, curve in curves if curve.error is not None]
    if len(errors) == len(curves):
        columns["error_estimate"] = np.concatenate(errors)
    return _write(results, Path(out) / "compliance.csv", columns)


def compliance_curves(results: Results) -> list[tuple[Member, ComplianceCurve]]:
    """Return each compliance curve of the results once, the pinion's before the wheel's.

    Parameters
    ----------
    results : Results
        With its compliance stage, or with curves in `comparison` alone.

    Returns
    -------
    list of (member, ComplianceCurve)
        The stage's own curves first, then those of `comparison` that differ from them in method or support; without the
        stage those of `comparison` alone.
    """
    stage = results.compliance if results.comparison else need(results.compliance, "compliance")
    members: tuple[Member, Member] = ("pinion", "wheel")
    curves: dict[tuple[str, str, str], tuple[Member, ComplianceCurve]] = {}
    for member in members:
        others = [curve for owner, curve in results.comparison if owner == member]
        for curve in (*([stage.of(member)] if stage is not None else []), *others):
            curves.setdefault((member, curve.method, curve.support), (member, on_flank(curve)))
    return list(curves.values())


def on_flank(curve: ComplianceCurve) -> ComplianceCurve:
    """Return the part of a compliance curve whose loads act on the involute, not on the tip round.

    Parameters
    ----------
    curve : ComplianceCurve
        Any curve, one with the coupling of neighbours included.

    Returns
    -------
    ComplianceCurve
    """
    kept = curve.u <= ROUND
    arrays = {name: getattr(curve, name)[kept] for name in ("u", "radius", "deflection", "depth")}
    error = None if curve.error is None else curve.error[kept]
    return ComplianceCurve(method=curve.method, support=curve.support, **arrays, error=error)


def write_stiffness(results: Results, out: Path, engagements: Sequence[Engagement] | None = None, widths: Sequence[WidthLoad] = ()) -> Path:
    """Write mesh_stiffness.csv: stiffness, transmission error, load shares and contact pressures over the pinion angle.

    Parameters
    ----------
    results : Results
        Model and, by default, the engagement.
    out : Path
        Folder.
    engagements : sequence of Engagement, optional
        One per torque; their rows follow each other.
    widths : sequence of WidthLoad
        Loads along the face width of the same engagements, or none of them.

    Returns
    -------
    Path
        The file, with the face load factor where loads along the width are given. Besides
        the pairs -1, 0 and 1 a pair has a column only if it ever carries load.
    """
    several = engagements_of(results) if engagements is None else tuple(engagements)
    columns: dict[str, Array] = {
        "pinion_torque_Nm": _stack(several, lambda one: np.full(one.contacts.pinion_angle.size, one.pinion_torque)),
        "pinion_angle_rad": _stack(several, lambda one: one.contacts.pinion_angle),
        "mesh_stiffness_N_per_um": _stack(several, lambda one: one.mesh_stiffness),
        "secant_stiffness_N_per_um": _stack(several, lambda one: one.secant_stiffness),
        "transmission_error_um": _stack(several, lambda one: one.transmission_error),
        "pairs_in_contact": _stack(several, lambda one: one.pairs_in_contact),
    }
    for pair in _loaded_pairs(several):
        columns[f"load_share_{_pair_name(pair)}"] = _stack(several, lambda one, pair=pair: share_of(one, pair))
    for pair in _loaded_pairs(several):
        columns[f"contact_pressure_{_pair_name(pair)}_MPa"] = _stack(
            several, lambda one, pair=pair: of_pair(one, one.contact_pressure, pair)
        )
    if widths:
        columns["face_load_factor"] = np.concatenate([one.face_load_factor for one in widths])
    return _write(results, Path(out) / "mesh_stiffness.csv", columns)


def _stack(engagements: Sequence[Engagement], values: Any) -> Array:
    return np.concatenate([values(one) for one in engagements])


def _loaded_pairs(engagements: Sequence[Engagement]) -> list[int]:
    loaded = {pair for one in engagements for pair, force in zip(one.contacts.pairs, one.force.T, strict=True) if force.any()}
    return sorted(loaded | {-1, 0, 1})


def _pair_name(pair: int) -> str:
    return f"m{-pair}" if pair < 0 else f"p{pair}" if pair > 0 else "0"


def share_of(engagement: Engagement, pair: int) -> Array:
    """Return the load share of one pair over the pinion angle, of all its contacts together; arguments as `of_pair`."""
    own = np.equal(engagement.contacts.pairs, pair)
    share: Array = engagement.load_share[:, own].sum(axis=1)
    return share


def of_pair(engagement: Engagement, values: Array, pair: int) -> Array:
    """Return the largest values of one pair's contacts over the pinion angle, zero for a pair that was not followed.

    Parameters
    ----------
    engagement : Engagement
        One torque.
    values : ndarray, shape (n, p)
        Of all its contacts, not negative.
    pair : int
        Number of the pair as in `Contacts.pairs`.

    Returns
    -------
    ndarray, shape (n,)
    """
    largest: Array = values[:, np.equal(engagement.contacts.pairs, pair)].max(axis=1, initial=0.0)
    return largest


def write_kinematics(results: Results, out: Path) -> Path:
    """Write kinematics.csv: one row per angle and pair in contact, velocities at the nominal pinion speed.

    Parameters
    ----------
    results : Results
        With its engagement stage.
    out : Path
        Folder.

    Returns
    -------
    Path
        The file. A worn pair that touches on both sides of a hollow has two rows.
        `gear_ratio_pair` is that of the common normal (Wojnarowski & Onishchenko 2003, eq. 10), which in contact of one
        rigid pair is the unloaded one; material velocities are those of the points of both gears in contact (footnote to eq. 12).
    """
    engagement = need(results.engagement, "engagement")
    contacts, speed = engagement.contacts, results.setup.operation.pinion_speed
    row, column = np.nonzero(engagement.force > 0.0)
    columns: dict[str, ArrayLike] = {
        "pinion_angle_rad": contacts.pinion_angle[row],
        "pair": np.asarray(contacts.pairs)[column],
        "gear_ratio": engagement.gear_ratio[row],
        "gear_ratio_unloaded": engagement.gear_ratio_unloaded[row],
        "gear_ratio_force": engagement.gear_ratio_force[row],
        "contact_x_mm": contacts.point[row, column, 0],
        "contact_y_mm": contacts.point[row, column, 1],
        "pressure_angle_deg": contacts.pressure_angle[row, column],
        "rolling_velocity_1_m_per_s": contacts.rolling_velocity1[row, column] * speed,
        "rolling_velocity_2_m_per_s": contacts.rolling_velocity2[row, column] * speed,
        "sliding_velocity_m_per_s": contacts.sliding_velocity[row, column] * speed,
        "equivalent_radius_mm": contacts.equivalent_radius[row, column],
        "gear_ratio_pair": (contacts.arm2 / contacts.arm1)[row, column],
        "material_velocity_1_m_per_s": contacts.material_velocity1[row, column] * speed,
        "material_velocity_2_m_per_s": contacts.material_velocity2[row, column] * speed,
        "specific_sliding_1": contacts.specific_sliding1[row, column],
        "specific_sliding_2": contacts.specific_sliding2[row, column],
        "contact_pressure_MPa": engagement.contact_pressure[row, column],
        "normal_force_N": engagement.force[row, column],
    }
    return _write(results, Path(out) / "kinematics.csv", columns)


def write_dynamics(results: Results, out: Path) -> tuple[Path, ...]:
    """Write rigid.csv and elastic.csv, and classical.csv with the columns of the latter where that model was run.

    Parameters
    ----------
    results : Results
        With its dynamics stage.
    out : Path
        Folder.

    Returns
    -------
    tuple of Path
        The files.
    """
    rigid = need(results.rigid, "rigid motion")
    columns = {
        "pinion_angle_rad": rigid.pinion_angle,
        "time_s": rigid.time,
        "pinion_speed_rad_per_s": rigid.pinion_speed,
        "pinion_acceleration_rad_per_s2": rigid.pinion_acceleration,
        "dynamic_factor": rigid.dynamic_factor,
    }
    files = [_write(results, Path(out) / "rigid.csv", columns)]
    files.append(_write(results, Path(out) / "elastic.csv", _motion(need(results.elastic, "elastic motion"))))
    if results.classical is not None:
        files.append(_write(results, Path(out) / "classical.csv", _motion(results.classical)))
    return tuple(files)


def _motion(motion: ElasticMotion) -> dict[str, Array]:
    return {
        "time_s": motion.time,
        "pinion_angle_rad": motion.pinion_angle,
        "mesh_force_N": motion.mesh_force,
        "transmission_error_um": motion.transmission_error,
        "pinion_speed_rad_per_s": motion.pinion_speed,
        "pinion_acceleration_rad_per_s2": motion.pinion_acceleration,
        "dynamic_factor": motion.dynamic_factor,
    }


def write_summary(results: Results, out: Path) -> Path:
    """Write summary.json: the numbers of `summarise`.

    Parameters
    ----------
    results : Results
        Of any stages; keys of stages that were not run are left out.
    out : Path
        Folder.

    Returns
    -------
    Path
        The file.
    """
    path = Path(out) / "summary.json"
    write_json(path, summarise(results))
    return path


def _write(results: Results, path: Path, columns: Mapping[str, ArrayLike]) -> Path:
    """Write SI columns in the units of their names, the file's origin in its first line."""
    scaled = {name: np.asarray(values) if factor(name) == 1.0 else np.asarray(values) / factor(name) for name, values in columns.items()}
    write_csv(path, scaled, comments=(identity(results.setup),))
    return path
