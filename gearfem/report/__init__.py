"""Tables, pictures and the report of results; matplotlib and pyvista are imported when a picture is asked for."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gearfem.report.animation import write_animation
    from gearfem.report.body_table import write_body
    from gearfem.report.diagnosis_html import write_diagnosis_report
    from gearfem.report.flank_plots import write_measured_flanks, write_measured_picture
    from gearfem.report.html import write_report
    from gearfem.report.kinematics_plots import write_kinematics_pictures
    from gearfem.report.motion_plots import write_motion_pictures, write_sweep_pictures
    from gearfem.report.plots import write_pictures
    from gearfem.report.render import Rendering, write_render, write_vtu
    from gearfem.report.render_solid import write_solid_render
    from gearfem.report.stiffness_plots import write_stiffness_pictures
    from gearfem.report.summary import summarise
    from gearfem.report.sweep_table import write_sweep
    from gearfem.report.tables import write_compliance, write_dynamics, write_kinematics, write_stiffness, write_summary
    from gearfem.report.width_plots import write_width_picture

__all__ = [
    "Rendering",
    "summarise",
    "write_animation",
    "write_body",
    "write_compliance",
    "write_diagnosis_report",
    "write_dynamics",
    "write_kinematics",
    "write_kinematics_pictures",
    "write_measured_flanks",
    "write_measured_picture",
    "write_motion_pictures",
    "write_pictures",
    "write_render",
    "write_report",
    "write_solid_render",
    "write_stiffness",
    "write_stiffness_pictures",
    "write_summary",
    "write_sweep",
    "write_sweep_pictures",
    "write_vtu",
    "write_width_picture",
]

_HOMES = {
    "animation": ("write_animation",),
    "kinematics_plots": ("write_kinematics_pictures",),
    "diagnosis_html": ("write_diagnosis_report",),
    "flank_plots": ("write_measured_flanks", "write_measured_picture"),
    "html": ("write_report",),
    "motion_plots": ("write_motion_pictures", "write_sweep_pictures"),
    "plots": ("write_pictures",),
    "render": ("Rendering", "write_render", "write_vtu"),
    "render_solid": ("write_solid_render",),
    "stiffness_plots": ("write_stiffness_pictures",),
    "summary": ("summarise",),
    "body_table": ("write_body",),
    "sweep_table": ("write_sweep",),
    "width_plots": ("write_width_picture",),
    "tables": ("write_compliance", "write_dynamics", "write_kinematics", "write_stiffness", "write_summary"),
}


def __getattr__(name: str) -> Any:
    for module, names in _HOMES.items():
        if name in names:
            return getattr(importlib.import_module(f"gearfem.report.{module}"), name)
    raise AttributeError(f"module 'gearfem.report' has no attribute {name!r}")
