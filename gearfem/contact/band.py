"""The band of contact over an edge between two curvatures, in closed form and without dimensions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gearfem.foundation import Array, SolveError

ITERATIONS = 30
# The root lies in [-1, 1] and Newton's step is there rounded to a few units in the last place.
SMALLEST_STEP = 4e-15


class Band(NamedTuple):
    """Band of contact over an edge; lengths in units of the Hertz half width a = sqrt(4 F R/(pi E*)) of the flank.

    Parameters
    ----------
    half_width : ndarray, shape (n,)
        Half the width of the band.
    middle, centre : ndarray, shape (n,)
        Middle of the band and centre of its pressure, from the rigid contact point towards the round.
    radius : ndarray, shape (n,)
        Radius of the Hertz contact with the same approach, in units of the flank's R.
    growth : ndarray, shape (n,)
        d ln a_e/d ln F, a_e being the half width of that Hertz contact; 1/2 in a Hertz contact.
    """

    half_width: Array
    middle: Array
    centre: Array
    radius: Array
    growth: Array


class _Edge(NamedTuple):
    """Integrals of a band whose edge lies at the angle phi (x = middle + half width cos theta)."""

    angle: Array
    sine: Array
    load: Array
    distance: Array


def edge_band(edge: Array, sharpness: Array) -> Band:
    """Return the band of contact whose edge lies at a given distance.

    Parameters
    ----------
    edge : ndarray, shape (n,)
        Arc t from the rigid contact point to the round, over a; from -1/sqrt(1 + k) (Hertz on the round) to 1
        (Hertz on the flank).
    sharpness : ndarray, shape (n,)
        k = R/rho, equivalent radius of the flanks over that of the round, positive.

    Returns
    -------
    Band

    Raises
    ------
    SolveError
        If the position of the edge in the band does not converge.

    Notes
    -----
    The gap has the curvature 1/R everywhere and 1/rho more beyond the edge e; with e_ = min(e, 0) it is

        h(x) = x^2/(2 R) + [max(x - e, 0)^2 + 2 e_ x - e_^2]/(2 rho),

    on the round tilted so that the rigid contact stays at x = 0. It is convex, so the band is one interval,
    x = m + w cos theta. For half planes -2/(pi E*) int p ln|x - s| ds = D - h in the band; expanded in
    cos(n theta), p vanishing at both ends (N. I. Muskhelishvili; K. L. Johnson, Contact Mechanics, sec. 2.7):

        int h' dtheta = 0,    F = E* w/2 int h' cos(theta) dtheta,    F (centre - m) = E* w^2/4 int h' cos(2 theta) dtheta,
        D = 2 F/(pi E*) ln(2/w) + (1/pi) int h dtheta,    all from 0 to pi.

    The rounded flat punch of M. Ciavarella, D. A. Hills, G. Monno (1998) is the symmetric case. With
    c = cos(phi) = (e - m)/w the integrals are elementary (derived here), and e/a follows from c alone and rises
    with it; Newton's method inverts that. Since dD/dF = 2/(pi E*) ln(2/w) and the band widens with the
    load, the approach is concave in it; and d ln a_e/d ln F = 1/2 - ln(a_e/w).
    """
    cosine = _edge_cosine(np.where(edge < 0.0, edge * (1.0 + sharpness), edge), sharpness)
    angle, sine, load, distance = _integrals(cosine, sharpness)
    place = np.where(distance < 0.0, distance / (1.0 + sharpness), distance)
    middle, past = place - cosine, np.minimum(place, 0.0)
    fall = angle * (0.5 + cosine**2) - 1.5 * sine * cosine
    mean_gap = 0.25 + middle**2 / 2.0 + sharpness * (fall / (2.0 * np.pi) + past * middle - past**2 / 2.0)
    growth = 2.0 * mean_gap / load
    width = 1.0 / np.sqrt(load)
    return Band(
        half_width=width,
        middle=middle * width,
        centre=(middle + sharpness * sine**3 / (3.0 * np.pi * load)) * width,
        radius=np.exp(1.0 - 2.0 * growth) / load,
        growth=growth,
    )


def _edge_cosine(distance: Array, sharpness: Array) -> Array:
    """Return c = cos(phi) at which the edge lies at `distance`, that of the flank going on past the edge, over a."""
    past = np.minimum(distance, 0.0) ** 2 / (1.0 + sharpness)
    before = 1.0 - np.maximum(distance, 0.0)
    # Asymptote of a sharp edge with its band just over it (before) and far over it (past); otherwise that of a blunt one.
    sharp = np.cos(np.minimum(np.cbrt(3.0 * np.pi * (before / sharpness + 2.0 * past)), np.pi))
    blunt = np.where(distance < 0.0, distance / np.sqrt(1.0 + sharpness), distance)
    cosine = np.clip(np.maximum(sharp, blunt), -1.0, 1.0)
    for _ in range(ITERATIONS):
        angle, sine, load, reached = _integrals(cosine, sharpness)
        slope = 1.0 + sharpness / np.pi * (angle + reached * sine / load)
        step = (distance * np.sqrt(load) - reached) / slope
        cosine = np.clip(cosine + step, -1.0, 1.0)
        if np.abs(step).max(initial=0.0) <= SMALLEST_STEP:
            return cosine
    raise SolveError("the band of contact over a tip edge did not converge")


def _integrals(cosine: Array, sharpness: Array) -> _Edge:
    """Return phi, sin(phi), (a/w)^2 and the distance to the edge, over w, if the flank went on past it."""
    angle = np.arccos(cosine)
    sine = np.sqrt((1.0 - cosine) * (1.0 + cosine))
    load = 1.0 + sharpness * (angle - sine * cosine) / np.pi
    return _Edge(angle, sine, load, cosine - sharpness * (sine - angle * cosine) / np.pi)
