"""The run-out of a tip edge: metal that is missing where the edge's curvature passes into the flank's."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from gearfem.definition.setup import Gear
from gearfem.flank.deviation import Deviation
from gearfem.flank.outline import Outline
from gearfem.foundation import Array, InputError
from gearfem.foundation.units import MM


def with_run_out(gear: Gear) -> Outline:
    """Return the outline of a gear whose tip edge runs out into the flank; without a run-out the involute.

    Parameters
    ----------
    gear : Gear
        With `tip_run_out`, the arc L from the tip round down the flank.

    Returns
    -------
    Outline
        Its deviation holds the run-out.

    Raises
    ------
    InputError
        If the outline is impossible.

    Notes
    -----
    The curvature is to fall as a parabola from that of the edge to that of the flank, k (1 - x/L)^2 above the flank's at the
    arc x from the round (Wojnarowski & Onishchenko 2003). A depth d adds d'' to the curvature, so d = k L^2/12 (1 - x/L)^4;
    the round is fitted to the flank that this leaves and begins where x = 0, which is solved for. Neglected: the square of the
    slope k L/3, which takes 1.5 times that share of k away (2 % at a slope of 0.12); besides, the spline's nodes stand wide
    against short run-outs. Both together, on the coal combine pair for limits from 2000 to 4000 MPa: up to 0.11 k where the
    round begins, up to 0.035 k below.
    """
    outline = Outline(gear=gear)
    if gear.tip_run_out == 0.0:
        return outline

    def cut(start: float) -> Outline:
        return Outline(gear=gear, deviation=Deviation.none(gear).plus(lambda roll: _depth(roll, gear, start)))

    reach = 2.0 * gear.tip_run_out + gear.tip_edge_radius
    low = max(outline.flank_end - reach, 0.5 * (outline.flank_start + outline.flank_end))
    try:
        start = brentq(lambda place: cut(place).flank_end - place, low, outline.flank_end + reach, xtol=1e-9 * gear.module)
    except ValueError:
        found = f"{gear.tip_edge_radius / MM:.4g} mm, running out over {gear.tip_run_out / MM:.4g} mm"
        raise InputError("tip_edge_radius_mm", found, "a tip edge that leaves a flank below its run-out") from None
    return cut(float(start))


def _depth(roll: Array, gear: Gear, start: float) -> Array:
    """Return the depth [m] of a run-out that ends at the roll length `start`."""
    bend, length = 1.0 / gear.tip_edge_radius - 1.0 / start, gear.tip_run_out
    away = (start**2 - roll**2) / (2.0 * gear.base_radius * length)
    # Above the round nothing of the flank is left; the depth keeps the edge's curvature for half a run-out, then its slope.
    beyond = np.maximum(-away, 0.0)
    curved = np.minimum(beyond, 0.5)
    above = beyond / 3.0 + curved * (beyond - 0.5 * curved)
    below = np.clip(1.0 - away, 0.0, 1.0) ** 4 / 12.0
    return np.asarray(bend * length**2 * (below + above))
