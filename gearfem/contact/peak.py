"""The largest pressure of a line contact, also where its band runs over a tip edge."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gearfem.contact.arguments import finite, not_negative, positive
from gearfem.contact.band import edge_band
from gearfem.contact.edge import EdgedLine, Line
from gearfem.foundation import Array

ANGLES = 512


def largest_pressure(law: EdgedLine, force_per_width: ArrayLike, line: Line) -> Array:
    """Return the largest pressure in the band of contact.

    Parameters
    ----------
    law : EdgedLine
        Law of the two materials.
    force_per_width : array_like, shape (...)
        Normal line load [N/m], not negative.
    line : Line
        Geometry of the contacts.

    Returns
    -------
    ndarray, shape (...)
        [Pa]; 0 without load.

    Raises
    ------
    InputError, SolveError
        As `EdgedLine.approach`.

    Notes
    -----
    With the edge outside the band it is the pressure of Hertz, on flank or round. Between them the gap of `edge_band` makes

        p(theta) = p_H w {sin(theta) (1 + k phi/pi) + (k/pi) (cos(theta) - cos(phi)) ln|sin((theta + phi)/2)/sin((theta - phi)/2)|},

    x = m + w cos(theta), w in half widths of the flank's own contact, p_H its pressure, k = R/rho, the edge at phi (derived here
    from the inversion of the half planes' integral, p vanishing at both ends; N. I. Muskhelishvili). The largest of 512
    values is taken, below 1e-4 too small. The errors of the band are those stated in `EdgedLine`.

    Examples
    --------
    >>> from gearfem.definition.setup import Material
    >>> steel = EdgedLine(pinion=Material(), wheel=Material())
    >>> line = Line(*map(np.array, (0.01, 3e-3, 3e-3, [1e-3, 0.0], 0.16e-3)))
    >>> [f"{pressure:.3e}" for pressure in largest_pressure(steel, 4e5, line)]
    ['1.200e+09', '4.724e+09']
    """
    flank, rho = positive("radius", line.radius), positive("edge_radius", line.edge_radius)
    hertz = law.hertz
    force, flank, rho, edge = np.broadcast_arrays(not_negative("force_per_width", force_per_width), flank, rho, finite("edge", line.edge))
    half_width, sharpness = hertz.half_width(force, flank), flank / rho
    over = (edge < half_width) & (edge > -half_width / np.sqrt(1.0 + sharpness))
    pressure = np.array(hertz.pressure(force, np.where(edge >= 0.0, flank, flank / (1.0 + sharpness))))
    if over.any():
        pressure[over] = hertz.pressure(force[over], flank[over]) * _peak(edge[over] / half_width[over], sharpness[over])
    return pressure


def _peak(edge: Array, sharpness: Array) -> Array:
    """Return the largest pressure over that of Hertz on the flank; arguments as `edge_band`."""
    band = edge_band(edge, sharpness)
    at_edge = np.arccos(np.clip((edge - band.middle) / band.half_width, -1.0, 1.0))[:, None]
    angle = np.pi * (np.arange(ANGLES) + 0.5) / ANGLES
    away = np.abs(np.sin(0.5 * (angle - at_edge)))
    # The logarithm is multiplied by a difference that vanishes with it.
    bend = (np.cos(angle) - np.cos(at_edge)) * np.log(np.sin(0.5 * (angle + at_edge)) / np.maximum(away, 1e-12))
    share = sharpness[:, None] / np.pi
    values = np.sin(angle) * (1.0 + share * at_edge) + share * bend
    return np.asarray(band.half_width * values.max(axis=1), dtype=np.float64)
