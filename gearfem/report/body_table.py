"""What the body has in the deflection of a tooth, as CSV."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gearfem.compliance.body import BodyCompliance
from gearfem.definition.setup import Member, Setup
from gearfem.foundation.files import write_csv
from gearfem.foundation.units import MM, UM_PER_N_PER_MM
from gearfem.report.summary import identity


def write_body(setup: Setup, parts: tuple[tuple[Member, BodyCompliance], ...], out: Path) -> Path:
    """Write body.csv: the deflection of a loaded tooth taken apart, and what the other teeth feel, over the load radius.

    Parameters
    ----------
    setup : Setup
        Definition of the pair.
    parts : tuple of (member, BodyCompliance)
        One or both gears.
    out : Path
        Folder.

    Returns
    -------
    Path
        The file.

    Notes
    -----
    Columns, deflections in um for a line load of 1 N/mm:

    ======================================== ==========================================================================
    gear                                     pinion or wheel
    radius_mm                                radius of the load point
    deflection_um_per_N_per_mm               whole gear held at its bore, along the load line (as in compliance.csv)
    tooth_deflection_um_per_N_per_mm         the tooth alone, held at its root
    body_deflection_um_per_N_per_mm          whole less tooth: wind-up and local yielding of the body
    wind_up_deflection_um_per_N_per_mm       rotation of the root circle about the bore times the arm of the load line
    wind_up_share                            wind-up part of the whole
    wind_up_rotation_rad_per_Nm_per_mm       that rotation for a torque of 1 N m on each mm of face width
    neighbour_1_deflection_um_per_N_per_mm   same flank point of the tooth one pitch away, unloaded, along its own normal
    neighbour_2_..., neighbour_3_...         two and three pitches away; the same towards either side by reciprocity
    ======================================== ==========================================================================

    Rows as in compliance.csv for ``root``: none where the crossing of load line and centreline lies under the root circle.
    """

    def column(name: str) -> np.ndarray:
        return np.concatenate([getattr(part, name) for _, part in parts])

    whole, wind_up = column("whole"), column("wind_up")
    deflections = {"": whole, "tooth_": column("tooth"), "body_": column("body"), "wind_up_": wind_up}
    columns = {
        "gear": np.concatenate([np.full(part.u.size, member) for member, part in parts]),
        "radius_mm": column("radius") / MM,
        **{f"{name}deflection_um_per_N_per_mm": values / UM_PER_N_PER_MM for name, values in deflections.items()},
        "wind_up_share": wind_up / whole,
        # A torque of 1 N m on each mm is 1000 N m on each m.
        "wind_up_rotation_rad_per_Nm_per_mm": column("rotation") / MM,
        **{
            f"neighbour_{pitches}_deflection_um_per_N_per_mm": values / UM_PER_N_PER_MM
            for pitches, values in enumerate(column("neighbours").T, start=1)
        },
    }
    path = Path(out) / "body.csv"
    write_csv(path, columns, comments=(identity(setup),))
    return path
