"""The face width in slices: uneven loads along it, and the approach that a lead adds to a pair."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.interpolate import CubicSpline

from gearfem.compliance import SolidElements
from gearfem.compliance.record import Compliance, ToothCompliance
from gearfem.contact import Line
from gearfem.contact.scaled import on_flanks
from gearfem.definition.setup import Gear
from gearfem.engagement.contacts import find_contacts
from gearfem.engagement.lead_approach import LeadApproach
from gearfem.engagement.sharing import LineLaw, PairSystem, share_torque
from gearfem.engagement.teeth import read_compliance
from gearfem.flank import Flanks, Outline, path_of_contact
from gearfem.flank.lead import Lead
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.cache import remembered
from gearfem.placement import Placement, evenly_spaced, rigidly_held

# Positions of a pair on its path at which curves are computed; between them cubic splines, 1e-4 of the further approach.
POSITIONS = 7
# Line loads of the curves, in parts of the one that closes the lead, from few slices touching to all of them.
LEAST, LARGEST, LEVELS = 1e-3, 1e3, 43
SAMPLES = 16


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class FaceSlices(Record):
    """How the face width is cut for uneven loads.

    Parameters
    ----------
    count : int
        Number of equal slices, at least 4.
    method : SolidElements
        Solid elements of the whole gears, whose influence of slices on one another spreads the load.
    positions : int
        Load positions on the flank at which the influence is computed; parabolas between three of them.

    Raises
    ------
    InputError
        If there are fewer than 4 slices or 2 positions.
    """

    count: int = 8
    method: SolidElements = dataclasses.field(default_factory=lambda: SolidElements(resolution=0.5, layers=4))
    positions: int = 3

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.count >= 4:
            raise InputError("slices", self.count, "a whole number from 4 upwards")
        if not self.positions >= 2:
            raise InputError("positions", self.positions, "a whole number from 2 upwards")

    def gap(self, lead: Lead) -> Array:
        """Return the mean gap of each slice [m], shape (count,)."""
        place = (np.arange(self.count * SAMPLES) + 0.5) / (self.count * SAMPLES) - 0.5
        gap: Array = np.interp(place, lead.place, lead.gap).reshape(self.count, SAMPLES).mean(axis=1)
        return gap


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class SlicedPair(Record):
    """One pair at r positions of its path, its face width in n slices.

    Parameters
    ----------
    matrix : ndarray, shape (r, n, n)
        Approach of the centrelines at the middle of each slice per line load on each slice, of both gears [m per N/m].
    line : Line of ndarrays, shape (r,)
        Geometry of the line contacts, the same over the width.
    """

    matrix: Array
    line: Line

    def between(self, position: Array, wanted: Array) -> SlicedPair:
        """Return the pair at other positions, by cubic splines from those it is known at."""
        line = Line(*(CubicSpline(position, values)(wanted) for values in self.line))
        return SlicedPair(matrix=CubicSpline(position, self.matrix)(wanted), line=line)

    def load(self, law: LineLaw, mean_load: Array, gap: Array) -> tuple[Array, Array]:
        """Return the line loads of all slices under a mean line load, and the approach of the pair.

        Parameters
        ----------
        law : LineLaw
            Contact law of each slice.
        mean_load : ndarray, shape (r,)
            Mean line load over the face width [N/m], positive.
        gap : ndarray, shape (n,)
            Gap of each slice [m].

        Returns
        -------
        line_load : ndarray, shape (r, n)
            [N/m], 0 where a slice does not touch.
        approach : ndarray, shape (r,)
            Approach counted from a gap of 0 [m].

        Raises
        ------
        SolveError
            If a position does not converge to 1e-12 of its load.
        """
        shape = self.matrix.shape[:2]
        system = PairSystem(
            linear=self.matrix,
            lever=np.ones(shape),
            arm=np.broadcast_to((1.0 / (shape[1] * mean_load))[:, None], shape),
            gap=np.broadcast_to(gap, shape),
            line=Line(*(np.broadcast_to(values[:, None], shape) for values in self.line)),
        )
        shared = share_torque(system, law, 1.0)
        return shared.force, shared.transmission_error


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class LeadTable(Record):
    """Curves of a pair whose gap opens along the face width, over its position and mean line load.

    Parameters
    ----------
    first_touch : float
        Gap of the slice that touches first [m].
    position : ndarray, shape (k,)
        Pinion angles of the pair from its pitch point, over the path of contact [rad].
    start, step : float
        As in `LeadApproach`.
    approach, approach_rate, peak, peak_rate : ndarray, shape (k, m)
        What the lead adds to the approach after the first touch [m], and by what it multiplies the largest line load; with
        derivatives with respect to the logarithm of the load.
    """

    first_touch: float
    position: Array
    start: float
    step: float
    approach: Array
    approach_rate: Array
    peak: Array
    peak_rate: Array

    def at(self, position: Array) -> LeadApproach:
        """Return the further approach of pairs at positions [rad], off the path that of its end."""
        weights = self._weights(position)
        return LeadApproach(start=self.start, step=self.step, value=weights @ self.approach, rate=weights @ self.approach_rate)

    def peak_at(self, position: Array, force: Array) -> Array:
        """Return by what the lead multiplies the largest line load of pairs under mean line loads [N/m]."""
        weights = self._weights(position)
        curve = LeadApproach(start=self.start, step=self.step, value=weights @ self.peak, rate=weights @ self.peak_rate)
        return curve.approach(np.maximum(force, np.exp(self.start)))

    def _weights(self, position: Array) -> Array:
        inside = np.clip(position, self.position[0], self.position[-1])
        weights: Array = CubicSpline(self.position, np.eye(len(self.position)))(inside)
        return weights


def lead_table(flanks: Flanks, placement: Placement, compliance: Compliance, law: LineLaw, slices: FaceSlices) -> LeadTable:
    """Compute what the lead of the flanks adds to the approach of a pair, over its position and its load.

    Parameters
    ----------
    flanks, placement, compliance, law
        As of `Mesh`; teeth that differ from the others count as one of them, and tip edges are those that the compliance has.
    slices : FaceSlices
        How the face width is cut.

    Returns
    -------
    LeadTable

    Raises
    ------
    InputError, SolveError
        If solid elements or slices fail.

    Notes
    -----
    Slice i of a pair carries q_i >= 0 where its approach lets it,

        sum_j A_ij q_j + h(q_i) + g_i = delta,    mean(q) = f,

    A the influence of whole solid gears held at their bores, h the law of contact, g the gap. What is tabulated is
    delta(f; g) - delta(f; 0): the even part of A cancels in it, so that the chain keeps the compliance it has without a lead,
    and 0 lead adds 0, from where the addition starts with a finite slope. The pair stays one number for the sharing
    among pairs: exact, as far as the coupling through the bodies is even along the width. Bodies wind up and tilt as
    the solids do; shafts and bearings stay rigid against tilting.

    Flanks count as designed: nothing is missing from them but the lead. What is missing shifts the contact and bends the flanks: with
    reliefs of 60 um, slopes of 10 um and wear of 0.4 mm under leads of 2 and 10 um the transmission error moves by 0.02 um at single
    angles, and by 0.002 um, three thousandths of the lead's own course over the pitch, as root mean square.

    Sizes of errors, 20/30 teeth of 2 mm, 20 mm wide, under 133 N/mm and a tilt of as much as the deflection: 8 slices against 16,
    and the default solids against finer ones, each leave 0.1 % of what the lead adds and 1 to 2 % of the largest line load. The
    ends carry 5 % more if the influence is made reciprocal, which reading it on the centreline keeps it from being. All slices of
    all pairs solved at once differ by 0.4 % of the transmission error on the path and 2 % on a tip edge, by 0.003 and 0.02 in load
    shares; coupling through the body as uneven as the teeth themselves would make that at most 5 % and 0.05.
    """
    designed = dataclasses.replace(
        flanks,
        pinion=dataclasses.replace(flanks.pinion, deviation=None),
        wheel=dataclasses.replace(flanks.wheel, deviation=None),
    )
    return _lead_table(*_plain(designed, placement, compliance.each(ToothCompliance.sound)), on_flanks(law), slices)


def _plain(flanks: Flanks, placement: Placement, compliance: Compliance) -> tuple[Flanks, Placement, Compliance]:
    """Return the same gears without what a lead's approach does not depend on, so that it is computed once for all of these.

    Odd teeth, index errors, supports, and how much teeth yield but for the depth of their contact; and another radius of the tip edges than
    the gears have, which shifts the contact at the ends of the path: with a fifth of it the transmission error moves by 0.15 % of what a
    lead adds.
    """

    def outline(flank: Outline, tooth: ToothCompliance) -> Outline:
        edge = tooth.outline.gear.tip_edge_radius
        return dataclasses.replace(flank, gear=dataclasses.replace(flank.gear, tip_edge_radius=edge))

    def depths(tooth: ToothCompliance) -> ToothCompliance:
        none = np.zeros_like(tooth.deflection)
        return dataclasses.replace(tooth, radius=none, depth=none, deflection=none, coupling=np.zeros_like(tooth.coupling))

    bare = dataclasses.replace(
        flanks,
        pinion=outline(flanks.pinion, compliance.pinion),
        wheel=outline(flanks.wheel, compliance.wheel),
        pinion_odd=(),
        wheel_odd=(),
    )
    deep = dataclasses.replace(compliance, pinion_odd=(), wheel_odd=()).each(depths)
    return bare, rigidly_held(evenly_spaced(placement)), deep


@remembered
def _lead_table(flanks: Flanks, placement: Placement, compliance: Compliance, law: LineLaw, slices: FaceSlices) -> LeadTable:
    position = path_positions(flanks, placement)
    pair = sliced_pair(flanks, placement, compliance, slices, position)
    gap = slices.gap(flanks.lead)
    touch = float(gap.min())
    # The load that closes the lead if it tilts the teeth: an end slice alone yields softer, a body stiffer.
    scale = float(np.ptp(gap) / (slices.count * np.median(np.einsum("rii->ri", pair.matrix))))
    loads = np.geomspace(LEAST * scale, LARGEST * scale, LEVELS)
    rows = SlicedPair(matrix=np.repeat(pair.matrix, LEVELS, axis=0), line=Line(*(np.repeat(values, LEVELS) for values in pair.line)))
    mean = np.tile(loads, POSITIONS)
    (uneven, approach), (even, plain) = (rows.load(law, mean, values) for values in (gap - touch, np.zeros_like(gap)))
    further = (approach - plain).reshape(POSITIONS, LEVELS)
    peak = (largest(uneven) / largest(even)).reshape(POSITIONS, LEVELS)
    logarithm = np.log(loads)
    return LeadTable(
        first_touch=touch,
        position=position,
        start=float(logarithm[0]),
        step=float(logarithm[1] - logarithm[0]),
        approach=further,
        approach_rate=CubicSpline(logarithm, further, axis=1)(logarithm, 1),
        peak=peak,
        peak_rate=CubicSpline(logarithm, peak, axis=1)(logarithm, 1),
    )


def path_positions(flanks: Flanks, placement: Placement) -> Array:
    """Return pinion angles of a pair from its pitch point, over its path of contact [rad], shape (POSITIONS,)."""
    approach, recess = path_of_contact(flanks, placement.pair)
    base = placement.pair.pinion.base_radius
    # A thousandth inside, so that the ends of the path are on it.
    return 0.999 * np.linspace(-approach / base, recess / base, POSITIONS)


def sliced_pair(flanks: Flanks, placement: Placement, compliance: Compliance, slices: FaceSlices, position: Array) -> SlicedPair:
    """Return a pair of teeth like most in slices, at positions of its path, pinion angles from its pitch point [rad]."""
    flanks, placement, compliance = _plain(flanks, placement, compliance)
    contacts = find_contacts(flanks, placement, position, (0,))
    read = read_compliance(compliance, contacts)
    width = placement.pair.face_width
    # The gears of the compliance, whose tip edges no calibration moves: the solid elements do not see these.
    pinion, wheel = compliance.pinion.outline.gear, compliance.wheel.outline.gear
    matrix = _spread(pinion, width, slices, contacts.u1[:, 0]) + _spread(wheel, width, slices, contacts.u2[:, 0])
    # Unevenness comes of the width: edges of the profile are left to the law of the pair.
    far = np.full(len(position), placement.pair.pinion.module)
    line = Line(contacts.flank_radius[:, 0], read.depth1[:, 0], read.depth2[:, 0], far, contacts.edge_radius[:, 0])
    return SlicedPair(matrix=matrix, line=line)


def _spread(gear: Gear, face_width: float, slices: FaceSlices, u: Array) -> Array:
    """Return the influence of slices of one gear at load positions u, shape (len(u), n, n)."""
    outline = Outline(gear=gear)
    # The whole flank of the gear as designed, whatever is loaded of it: solid elements are needed once.
    first, last = outline.parameter([outline.flank_start, outline.flank_end])
    nodes = np.linspace(first, last, slices.positions)
    matrices = _influence(slices.method, outline, nodes, face_width, slices.count)
    weights = np.array([[np.prod([(x - b) / (a - b) for b in nodes if b != a]) for a in nodes] for x in u])
    spread: Array = np.einsum("rk,kij->rij", weights, matrices)
    return spread


@remembered
def _influence(method: SolidElements, outline: Outline, u: Array, face_width: float, count: int) -> Array:
    """Return the influence of slices of a whole gear at load positions u, shape (len(u), count, count)."""
    return np.array([one.matrix for one in method.influence(outline, u, face_width, count)])


def with_ends(line_load: Array) -> Array:
    """Return line loads of slices with those at both ends of the face, straight on from the two slices before them."""
    first = np.maximum(1.5 * line_load[..., :1] - 0.5 * line_load[..., 1:2], 0.0)
    last = np.maximum(1.5 * line_load[..., -1:] - 0.5 * line_load[..., -2:-1], 0.0)
    return np.concatenate([first, line_load, last], axis=-1)


def largest(line_load: Array) -> Array:
    """Return the largest line load over the face width, its ends included."""
    top: Array = with_ends(line_load).max(axis=-1)
    return top
