"""What each picture of the report shows, in words and with its numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

Values = Mapping[str, Any]


def _pair(values: Values) -> str:
    return (
        "Drawn to scale at angle 0, where pair 0 touches at the pitch point C. The pinion (left) drives and turns counter-clockwise. "
        f"The path of contact holds {values['contact_ratio']:.4f} base pitches; circles mark the pairs that touch at this angle."
    )


def _measured_flanks(values: Values) -> str:
    return (
        "Metal missing along the normal of the involute as measured, and the fit that stands for it: polynomials joined in value and "
        "slope, degrees and breakpoints chosen by cross-validation, then one cubic spline. Beyond the points it runs out to a constant. "
        "Outliers carry the numbers of their rows; the assumptions hold one sentence for each flank, measured_flanks.csv every point."
    )


def _effects(values: Values) -> str:
    return (
        "The slowly turning gears under the operation torque, without and with the effects that the model names, over the turns of the "
        "pinion that bring every tooth of both gears into contact. The assumptions hold one sentence for each effect."
    )


def _compliance(values: Values) -> str:
    text = (
        "Deflection along the load line, where that line crosses the tooth's centreline, for 1 N per mm of face width. "
        "A whole gear, held at its bore, yields with its body; a tooth clamped at its root shows the tooth alone."
    )
    if "castigliano_over_fe_min" in values:
        low, high = values["castigliano_over_fe_min"], values["castigliano_over_fe_max"]
        text += (
            f" Castigliano's trapezoid gives {low:.3f} to {high:.3f} of the finite elements over the active flanks; the band is ±10 % of "
            "the finite elements."
        )
    return text + left_out_sentence(values)


def left_out_sentence(values: Values) -> str:
    """Say how many positions each compliance curve leaves out; empty where none does.

    Parameters
    ----------
    values : mapping
        Numbers of `summarise`.

    Returns
    -------
    str
        With a space in front.
    """
    rows = [
        f"{row['count']} of the {row['gear']} ({row['method']}, {row['support']})" for row in values.get("compliance_rows_left_out", [])
    ]
    if not rows:
        return ""
    return f" Left out, since their load line crosses the centreline under the clamp or the trapezoid's base: {', '.join(rows)}."


def _stiffness(values: Values) -> str:
    return (
        f"Stiffness of the whole face width along the line of action at {values['pinion_torque_Nm']:.4g} N m; shaded where more than one "
        f"pair carries. The slope's mean over one pitch is {values['mesh_stiffness_mean_N_per_mm_um']:.2f} N/(mm·µm), "
        f"ISO 6336-1 method B gives {values['iso6336_c_gamma_alpha_N_per_mm_um']:.2f}."
    )


def _load_share(values: Values) -> str:
    return "Share of each pair in the sum of the normal forces; where teeth bend, the next pair carries before its path of contact begins."


def _transmission_error(values: Values) -> str:
    swing = values["transmission_error_peak_to_peak_um"]
    return f"Lag of the loaded wheel behind perfect rigid gears, bodies included. From peak to peak {swing:.2f} µm."


def _gear_ratio(values: Values) -> str:
    low, high, mean = (values[f"gear_ratio_{name}"] for name in ("min", "max", "mean"))
    return f"Under load the ratio runs from {low:.4f} to {high:.4f} while pairs hand over; its mean over the wheel's angle is {mean:.5f}."


def _outlines(values: Values) -> str:
    return (
        "The working side of a tooth of each gear, without and with the metal that is missing from it, enlarged where a legend says so "
        "(as Fig. 6 of Wojnarowski & Onishchenko 2003)."
    )


def _line_of_action(values: Values) -> str:
    return (
        "The way of the contact point of every pair that carries, in the fixed frame and beside the straight line of unworn involutes, "
        f"from which it departs by up to {values['away_from_line_mm']:.3g} mm (as Fig. 7)."
    )


def _gear_ratios(values: Values) -> str:
    low, high, mean = (values[f"gear_ratio_{name}"] for name in ("min", "max", "mean"))
    return (
        "Four ratios (as Fig. 8): of one pair by its common normal, of the rigid gears, under load, and of the forces. Under load it "
        f"runs from {low:.4f} to {high:.4f}; its mean over the wheel's angle is {mean:.5f}."
    )


def _velocities(values: Values) -> str:
    return (
        "Speed of the contact point along both flanks at the nominal pinion speed, and the difference, the sliding: "
        "negative in approach, zero at the pitch point, positive in recess. Thin lines: a tip edge touches before or behind the path."
    )


def _rigid_motion(values: Values) -> str:
    return (
        "Periodic motion of the rigid model, one degree of freedom, forced by the ratio of the forces Σ P l₂/Σ P l₁ under the static "
        "load (Wojnarowski & Onishchenko 2003, eq. 11): the dashed curve of the picture of the gear ratio, which changes over a finite "
        "angle where pairs hand over, and not by steps. The pinion's speed has the nominal mean."
    )


def _elastic_motion(values: Values) -> str:
    return (
        "Steady motion of the elastic model: speed and acceleration of the pinion itself, the unloaded gears' motion and the "
        "vibration of the teeth together. The scales differ from those of the rigid model." + _reversal(values)
    )


def _reversal(values: Values) -> str:
    if not values["friction_coefficient"]:
        return ""
    return " The steps of the elastic models at whole pitches are friction's, which reverses where a pair passes the pitch point."


def _dynamic_factor(values: Values) -> str:
    return (
        "Dynamic factor Kw, the moment of the teeth on the pinion, friction included, over the driving torque T₁; where T₁ drives the "
        "pinion itself this is 1 - J₁ψ₁''/T₁, with a minus. Without friction it is the load on the teeth over the static load."
        + _reversal(values)
        + " The classical model keeps the gear ratio constant and takes the inertias of the two gears alone; the other two carry the "
        "whole drive."
    )


CAPTIONS: dict[str, tuple[str, Callable[[Values], str]]] = {
    "pair": ("Teeth in engagement", _pair),
    "measured_flanks": ("Measured flanks", _measured_flanks),
    "effects": ("Effects", _effects),
    "compliance": ("Tooth compliance", _compliance),
    "mesh_stiffness": ("Mesh stiffness", _stiffness),
    "load_share": ("Load sharing", _load_share),
    "transmission_error": ("Loaded transmission error", _transmission_error),
    "gear_ratios": ("Gear ratios", _gear_ratios),
    "gear_ratio": ("Gear ratio", _gear_ratio),
    "flank_outlines": ("Worn flanks", _outlines),
    "line_of_action": ("Line of action", _line_of_action),
    "velocities": ("Rolling and sliding", _velocities),
    "rigid_motion": ("Rigid model", _rigid_motion),
    "elastic_motion": ("Elastic model", _elastic_motion),
    "dynamic_factor": ("Dynamic factor", _dynamic_factor),
}
