"""Volume of the metal that is missing from a flank, and the depth of a given shape that makes up a volume."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from gearfem.definition.setup import Gear
from gearfem.flank import Deviation, Outline
from gearfem.foundation import Array, InputError
from gearfem.foundation.units import MM

# Gauss points on each cell of the deviation's spline; its square is integrated exactly.
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)
MM3 = MM**3


def removed_volume(outline: Outline, face_width: float) -> float:
    """Return the volume of metal that is missing from one flank of one tooth.

    Parameters
    ----------
    outline : Outline
        The worn tooth.
    face_width : float
        Face width [m].

    Returns
    -------
    float
        Between involute and worn flank, from the form circle to the tip circle [m3]; negative where metal stands out.

    Notes
    -----
    A point that lies d below the involute on the normal of the roll length s has the radius of the roll length q = s - d, and
    an element of area is (q/r_b) dq ds (derived here). So the area is the integral over s of (q_high^2 - q_low^2)/(2 r_b), q from
    s - d to s, cut off at form and tip circle: exact. To first order it is the depth integrated over the arc s ds/r_b, which is
    more by d/(2 s). The tip round, smaller by far, is left out.
    """
    gear, deviation = outline.gear, outline.deviation
    if deviation is None or not outline.worn:
        return 0.0
    return _area(gear, outline.form_radius, deviation) * face_width


def _area(gear: Gear, form_radius: float, deviation: Deviation) -> float:
    low, high = (math.sqrt(radius**2 - gear.base_radius**2) for radius in (form_radius, gear.tip_radius))
    deepest = float(np.abs(deviation.depth).max())
    step = deviation.roll[1] - deviation.roll[0]
    edges = np.append(deviation.roll, high + np.arange(1, 2 + math.ceil(deepest / step)) * step)
    edges = np.unique(np.clip(np.append(edges, (low, high)), low, edges[-1]))
    middle, half = (edges[1:] + edges[:-1]) / 2.0, np.diff(edges) / 2.0
    roll = middle[:, None] + half[:, None] * POINTS
    outer, inner = np.clip(roll, low, high), np.clip(roll - deviation.at(roll), low, high)
    return float(np.sum(half[:, None] * WEIGHTS * (outer**2 - inner**2)) / (2.0 * gear.base_radius))


def depth_for_volume(outline: Outline, shape: Array, volume: float, face_width: float) -> Outline:
    """Return a tooth from which a volume of metal is missing, in a given shape over the height of its flank.

    Parameters
    ----------
    outline : Outline
        The tooth before; what is missing from it already stays missing.
    shape : ndarray, shape (n,)
        Depth over any one depth at the roll lengths `Deviation.none(gear).roll`, not negative.
    volume : float
        Metal to remove from one flank over the face width [m3], positive.
    face_width : float
        [m]

    Returns
    -------
    Outline

    Raises
    ------
    InputError
        If the shape has no metal on the flank, or the depth would be out of the bounds of a worn flank.

    Examples
    --------
    >>> from gearfem.model import load_model
    >>> from gearfem.flank import make_flanks
    >>> pinion = make_flanks(load_model("studies/coal_combine/model.toml")).pinion
    >>> even = depth_for_volume(pinion, np.ones(513), 242e-9, 0.075)
    >>> f"{1e3 * even.deepest:.3f} mm, {1e9 * removed_volume(even, 0.075):.1f} mm3"
    '0.201 mm, 242.0 mm3'
    """
    before = outline.deviation or Deviation.none(outline.gear)
    shape = np.asarray(shape, float)
    if shape.shape != before.depth.shape or not np.isfinite(shape).all() or shape.min() < 0.0 or shape.max() <= 0.0:
        raise InputError("shape", "a shape with negative depths, or none at all", f"{before.depth.size} depths of 0 or more")
    if not (math.isfinite(volume) and volume > 0.0):
        raise InputError("volume", f"{volume / MM3:g} mm3", "more than 0 mm3")

    def with_depth(depth: float) -> Outline:
        return Outline(gear=outline.gear, deviation=before.plus(lambda roll: depth * shape / shape.max()))

    def missing(depth: float) -> float:
        whole = before.plus(lambda roll: depth * shape / shape.max())
        return (_area(outline.gear, outline.form_radius, whole) - already) * face_width - volume

    already = _area(outline.gear, outline.form_radius, before)
    deepest = 0.5 * outline.gear.module
    if missing(deepest) < 0.0:
        raise InputError("volume", f"{volume / MM3:g} mm3", f"less than {(missing(deepest) + volume) / MM3:.4g} mm3, half a module deep")
    return with_depth(float(brentq(missing, 0.0, deepest, xtol=1e-15)))
