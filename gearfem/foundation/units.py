"""Factors between the units of files and pictures and the SI units used inside.

A quantity in a file is multiplied by its factor on reading and divided by it on writing:
``radius = value_mm * MM``; ``value_mm = radius / MM``.
"""

from __future__ import annotations

import math

MM = 1e-3
UM = 1e-6
MPA = 1e6
GPA = 1e9
DEG = math.pi / 180.0
RPM = 2.0 * math.pi / 60.0
N_PER_MM = 1e3
N_PER_UM = 1e6
N_PER_MM_UM = 1e9
UM_PER_N_PER_MM = UM / N_PER_MM
UM_PER_KN = UM / 1e3

SUFFIXES = {
    "_N_per_mm_um": N_PER_MM_UM,
    "_N_per_um": N_PER_UM,
    "_um_per_N_per_mm": UM_PER_N_PER_MM,
    "_um_per_kN": UM_PER_KN,
    "_Nms_per_rad": 1.0,
    "_Nm_per_rad": 1.0,
    "_Ns_per_m": 1.0,
    "_kg_per_m3": 1.0,
    "_kg_m2": 1.0,
    "_rad_per_s2": 1.0,
    "_rad_per_s": 1.0,
    "_m_per_s": 1.0,
    "_mm": MM,
    "_um": UM,
    "_MPa": MPA,
    "_deg": DEG,
    "_rpm": RPM,
    "_Nm": 1.0,
    "_rad": 1.0,
    "_Hz": 1.0,
    "_kg": 1.0,
    "_N": 1.0,
    "_s": 1.0,
}


def factor(name: str) -> float:
    """Return the SI value of one unit of a name that ends in its unit.

    Parameters
    ----------
    name : str
        Key or column, such as ``face_width_mm``; a name without a unit is dimensionless.

    Returns
    -------
    float
        Multiply a file's value by it to get SI.

    Examples
    --------
    >>> factor("face_width_mm"), factor("teeth")
    (0.001, 1.0)
    """
    for suffix, value in SUFFIXES.items():
        if name.endswith(suffix):
            return value
    return 1.0


def written(unit: str) -> str:
    """Return the unit that ends a name as people write it.

    Examples
    --------
    >>> written("rad_per_s2"), written("um_per_kN")
    ('rad/s²', 'µm/kN')
    """
    return unit.replace("_per_", "/").replace("um", "µm").replace("s2", "s²")


def digits(value: float) -> str:
    """Return a number with three digits, or all that stand before the point.

    Examples
    --------
    >>> digits(0.12345), digits(12345.6)
    ('0.123', '12346')
    """
    return f"{value:.3g}" if abs(value) < 999.5 else f"{value:.0f}"
