"""The nuisances of a model file, [calibration], in SI."""

from __future__ import annotations

import numpy as np

from gearfem.definition.calibration import Calibration
from gearfem.definition.schema import CalibrationTable
from gearfem.foundation import InputError
from gearfem.foundation.units import UM


def resolve_calibration(table: CalibrationTable, teeth: tuple[int, int]) -> Calibration:
    """Return the calibration of a model file.

    Parameters
    ----------
    table : CalibrationTable
        Validated table.
    teeth : (int, int)
        Numbers of teeth of pinion and wheel.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        If the index errors are not one per tooth, or a record is named twice.
    """
    late = []
    for key, count in zip(("pinion_index_error_um", "wheel_index_error_um"), teeth, strict=True):
        values = getattr(table, key)
        if len(values) not in (0, count):
            raise InputError(f"calibration.{key}", f"{len(values)} values", f"{count} values, one for each tooth")
        late.append(np.array(values, float) * UM)
    files = [entry.file for entry in table.record]
    for place, file in enumerate(files):
        if file in files[:place]:
            raise InputError(f"calibration.record[{place + 1}].file", f'"{file}" again', "one entry for each record")
    return Calibration(
        stiffness_scale=table.stiffness_scale,
        torque_scale=table.torque_scale,
        inertia_scale=table.inertia_scale,
        damping_scale=table.damping_scale,
        gain=table.gain,
        series_compliance=table.series_compliance_um_per_N * UM,
        coupling_scale=table.coupling_scale,
        tip_edge_scale=table.tip_edge_scale,
        contact_scale=table.contact_compliance_scale,
        body_scale=table.body_compliance_scale,
        depth_scale=table.contact_depth_scale,
        evenness=table.contact_evenness,
        friction=table.friction_coefficient,
        misalignment=table.misalignment_um * UM,
        centre_distance=table.centre_distance_um * UM,
        angle_offset=table.angle_offset_rad,
        pinion_late=late[0],
        wheel_late=late[1],
        offsets=tuple((entry.file, entry.offset_um * UM) for entry in table.record),
        firsts=tuple((entry.file, entry.first_tooth) for entry in table.record if entry.first_tooth),
        kicks=tuple((entry.file, (entry.kick[0], entry.kick[1])) for entry in table.record if any(entry.kick)),
    )
