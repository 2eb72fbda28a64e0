"""Archard's law on loaded flanks: depth per turn of the pinion at every point of both."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy.special import ndtr

from gearfem.contact import HertzLine
from gearfem.definition.setup import Member
from gearfem.engagement.engage import Loads, Mesh
from gearfem.engagement.record import Engagement
from gearfem.flank import Deviation, Outline
from gearfem.foundation import Array, InputError, Record

MEMBERS: tuple[Member, Member] = ("pinion", "wheel")
# Least standard deviation of the bell in parts of the flank: waves that the contact search may miss, 1/96 of it, then vanish.
FINEST = 1.0 / 50.0
# Standard deviation of Hertz's half ellipse of half width 1.
SPREAD = 0.5


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Archard(Record):
    """Coefficients of wear of both gears.

    Parameters
    ----------
    pinion_coefficient, wheel_coefficient : float
        k in depth = k p v_s t [1/Pa, which is m2/N]; 1e-9 mm3/(N m) is 1e-18 of it.
    rolling : float
        Part of the way that a flank rolls which wears as if it slid: dirt that is rolled over marks the flanks even at the
        pitch point. 0 is Archard's law itself.

    Raises
    ------
    InputError
        If one is negative, or both coefficients are 0.
    """

    pinion_coefficient: float
    wheel_coefficient: float
    rolling: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(field.name, value, "a number of 0 or more")
        if self.pinion_coefficient == 0.0 and self.wheel_coefficient == 0.0:
            raise InputError("pinion_coefficient, wheel_coefficient", "0 and 0", "at least one above 0: nothing wears")

    def of(self, member: Member) -> float:
        """Return the coefficient of a gear [1/Pa]."""
        return self.pinion_coefficient if member == "pinion" else self.wheel_coefficient


def wear_rates(mesh: Mesh, engagement: Engagement | Loads, law: Archard, finest: float = FINEST) -> dict[Member, Array]:
    """Return the depth that each gear loses per turn of the pinion.

    Parameters
    ----------
    mesh : Mesh
        Whose flanks wear; all teeth alike.
    engagement : Engagement or Loads
        Of it, at equally spaced angles over one pitch.
    law : Archard
        The coefficients.
    finest : float
        Least standard deviation of the bell over which wear is spread, as a part of the flank's arc.

    Returns
    -------
    dict of member to ndarray, shape (n,)
        At the roll lengths of `Deviation.none(gear).roll` [m per turn]; constant beyond the ends of the flank.

    Notes
    -----
    Archard: depth = k p v_s t. A point of the flank is pressed while the band of width 2 a passes it at the rolling velocity v_r,
    so that the integral of p dt is w/v_r, w the load per width, and a passage takes the depth

        k w |v_s|/v_r    (= k p_mean 2 a |v_s|/v_r);

    the pressure itself drops out. As area: while the pinion turns by dphi, k w |v_s| dphi of the section (v_s per angular
    velocity of the pinion) comes off under the band. This form is used, since it holds where the contact stands still on a tip edge or
    jumps across a hollow, and no metal is lost in it. The area is spread along the arc as a Gaussian bell as wide as the
    band of Hertz (same variance), and at least `finest` of the flank: finer waves would be lost to the contact search, and be noise
    of the angle's steps. A bell, since the spectra of the half ellipse and of every shape with an end have negative lobes, where a
    wave would be worn in its hollows and grow. What would fall beyond an end of the flank, on the tip round too, is taken from
    the flank inside that end. Dirt adds `rolling` times the way of the material point along the flank to the sliding.
    One pair's passage is what all pairs do over one pitch; a tooth of the pinion makes one passage per turn, one of the wheel z1/z2.
    """
    contacts, pair = engagement.contacts, mesh.placement.pair
    step = pair.pinion.pitch_angle / contacts.pinion_angle.size
    row, column = np.nonzero(engagement.force > 0.0)
    load = engagement.force[row, column] / pair.face_width
    steel = HertzLine(pinion=pair.pinion.material, wheel=pair.wheel.material)
    band = SPREAD * steel.half_width(load, contacts.equivalent_radius[row, column])
    sliding = np.abs(contacts.sliding_velocity[row, column])
    travel = {"pinion": contacts.material_velocity1, "wheel": contacts.material_velocity2}
    places, passages = {"pinion": contacts.u1, "wheel": contacts.u2}, {"pinion": 1.0, "wheel": 1.0 / pair.ratio}
    rates: dict[Member, Array] = {}
    for member in MEMBERS:
        outline = mesh.flanks.of(member)
        way = sliding + law.rolling * np.abs(travel[member][row, column])
        area = law.of(member) * passages[member] * load * way * step
        rates[member] = _spread(outline, places[member][row, column], area, band, finest)
    return rates


def _spread(outline: Outline, u: Array, area: Array, band: Array, finest: float) -> Array:
    """Return the depth at the nodes of the deviation that takes areas off the section, each around its own point."""
    nodes, base = Deviation.none(outline.gear).roll, outline.gear.base_radius
    depth = (outline.deviation or Deviation.none(outline.gear)).depth
    start, end = outline.flank_start, min(outline.flank_end, nodes[-1])
    edges = np.clip(np.concatenate([nodes[:1], (nodes[1:] + nodes[:-1]) / 2.0, nodes[-1:]]), start, end)

    def arc(roll: Array) -> Array:
        return np.asarray(roll**2 / (2.0 * base))

    centre = arc(np.clip(outline.roll_length(u), start, end))[:, None]
    low, high = arc(np.array(start)), arc(np.array(end))
    width_of_bell = np.hypot(band, finest * (high - low))[:, None]

    def below(place: Array) -> Array:
        return np.asarray(ndtr((place - centre) / width_of_bell))

    places = arc(edges)[None, :]
    taken = np.diff(area @ (below(places) - below(2.0 * low - places) - below(2.0 * high - places)))
    width = np.diff(edges)
    inside = np.flatnonzero(width > 0.0)
    rate = taken[inside] / (width * np.maximum(nodes - depth, 0.0) / base)[inside]
    return np.asarray(np.interp(nodes, nodes[inside], rate))
