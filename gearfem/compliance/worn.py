"""Compliance of worn teeth: a linear response to what is missing where that is little, finite elements where it is more."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from gearfem.compliance.elasticity import stiffness
from gearfem.compliance.finite_elements import OFFSETS, FiniteElements, SectionLoads, used_by
from gearfem.compliance.harmonic_ring import HarmonicRing
from gearfem.compliance.load_lines import LoadLines, forces, load_lines, readings
from gearfem.compliance.record import ToothCompliance
from gearfem.compliance.section_mesh import unworn
from gearfem.compliance.supports import Structure
from gearfem.compliance.uneven_ring import OddSector, Sector
from gearfem.flank import Deviation, Outline
from gearfem.foundation import Array, InputError, Record
from gearfem.foundation.cache import remembered
from gearfem.foundation.threads import one_thread

# Depth in modules up to which the compliance answers in proportion: studies/worn_compliance.py.
LITTLE = 0.02
# Legendre polynomials over the flank, and the depth in modules at which their response is taken.
SHAPES, PROBE = 8, 1e-4
# How far the shapes run on beyond the flank, in half flanks: its ends move with what is missing.
BEYOND = 1.1
# Roll length in modules below which the shapes run with the length of the flank.
ROUNDED = 0.5
# Turn of the loads from which their response is taken [rad].
TURN = 1e-4
# Rings that are remembered: those of both gears, and some megabytes each.
RINGS = 2


def worn_tooth(method: FiniteElements, outline: Outline, u: Array) -> ToothCompliance:
    """Return the compliance of a gear all of whose teeth have an outline.

    Parameters
    ----------
    method : FiniteElements
        Held at the bore.
    outline : Outline
        Of the teeth, worn or not.
    u : ndarray, shape (n,)
        Increasing load positions in [2, 4).

    Returns
    -------
    ToothCompliance
        Its outline is the one that was meshed: without wear if little is missing.

    Raises
    ------
    InputError, SolveError
        As `FiniteElements.tooth`.

    Notes
    -----
    Up to a depth of 0.02 modules the compliance without wear plus its response in proportion: no new finite elements for
    another shape or depth. Beyond it, finite elements of the worn teeth. Both meet at the bound within what the response misses of the
    transmission error: below 0.03 % for wear that bends gently, 0.1 % for a relief over the last third of the flank, 0.3 % in a pit
    as narrow as a quarter of it (Myga's rig; 1 % on Wojnarowski & Onishchenko's (2003) gears, where it changes 7 %). Where the
    involute begins beside the base circle, local depths at its very start, and there alone, miss up to 10 %.
    """
    sound = unworn(outline)
    if not outline.worn:
        return method.tooth(sound, u)
    if outline.deepest > LITTLE * outline.gear.module:
        return method.tooth(outline, u)
    return flank_response(method, sound, u).at(outline)


def odd_tooth(method: FiniteElements, outline: Outline, among: Outline, u: Array) -> ToothCompliance:
    """Return the compliance of one tooth among others of another outline.

    Parameters
    ----------
    method : FiniteElements
        Held at the bore.
    outline, among : Outline
        Of the tooth and of all others.
    u : ndarray, shape (n,)
        Increasing load positions in [2, 4).

    Returns
    -------
    ToothCompliance
        Its coupling is what the others feel of this tooth.

    Raises
    ------
    InputError, SolveError
        As `FiniteElements.tooth`.

    Notes
    -----
    Where little is missing, the deflection is that in a ring of such teeth and the coupling the mean of both rings: against the ring
    with one odd tooth, with 0.1 modules missing, the first is within 0.1 %, the second within 1.3 % of the least deflection.
    """
    if max(outline.deepest, among.deepest) > LITTLE * outline.gear.module:
        return _odd_tooth(method, outline, among, u)
    own = worn_tooth(method, outline, u)
    others = worn_tooth(method, among, own.u)
    return dataclasses.replace(own, coupling=0.5 * (own.coupling + others.coupling))


@remembered
def _odd_tooth(method: FiniteElements, outline: Outline, among: Outline, u: Array) -> ToothCompliance:
    with one_thread():
        own = method._loads(outline, u)
        others, ring = _others(method, among, own.lines.u)
        if not isinstance(ring, HarmonicRing):
            raise InputError("support", method.support.name, "bore: a tooth held at its root has no neighbours")
        odd = OddSector(ring, Sector(own.section, own.matrix, outline.gear.teeth, used_by(own.load, own.reading)))
        return ToothCompliance(
            **method._columns(own, odd),
            outline=outline,
            offsets=OFFSETS,
            coupling=odd.coupling(own.load, others.load, OFFSETS),
            local_depth=method._local_depth(outline, own, odd),
        )


@partial(remembered, kept=RINGS)
def _others(method: FiniteElements, outline: Outline, u: Array) -> tuple[SectionLoads, Structure]:
    """Return the loaded ring of teeth that are all alike: one odd tooth after another takes its place among them."""
    return method._loaded(outline, u)


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class FlankResponse(Record):
    """How the compliance of a tooth answers to metal missing from its flanks.

    Parameters
    ----------
    sound : ToothCompliance
        Without any missing.
    turn : ndarray, shape (n,)
        Of the deflection, to a turn of the load [m per N/m per rad].
    deflection, local : ndarray, shape (k, n)
        Of the deflection, beside its turn, and of ln(local depth/depth), to the k-th Legendre polynomial over the flank's roll
        length, rounded beside the base circle, per depth missing [1 per N/m], [1/m].
    coupling : ndarray, shape (k, o, n, n)
        Of the coupling [1 per N/m].
    """

    sound: ToothCompliance
    turn: Array
    deflection: Array
    local: Array
    coupling: Array

    def at(self, outline: Outline) -> ToothCompliance:
        """Return the compliance of teeth with this outline."""
        sound = self.sound
        share = _shares(outline)
        lines = load_lines(outline, sound.u)
        ratio = sound.local_depth / sound.depth * np.exp(share @ self.local)
        return dataclasses.replace(
            sound,
            radius=lines.radius,
            depth=lines.depth,
            deflection=sound.deflection + self.turn * _turned(lines, load_lines(sound.outline, sound.u)) + share @ self.deflection,
            local_depth=ratio * lines.depth,
            sound_depth=sound.local_depth,
            coupling=sound.coupling + np.tensordot(share, self.coupling, axes=1),
        )


@remembered
def flank_response(method: FiniteElements, outline: Outline, u: Array) -> FlankResponse:
    """Return how the compliance of teeth answers to metal missing from all of them; equal content costs one response per process.

    Parameters
    ----------
    method : FiniteElements
        Held at the bore.
    outline : Outline
        Without anything missing.
    u : ndarray, shape (n,)
        Increasing load positions in [2, 4).

    Returns
    -------
    FlankResponse

    Notes
    -----
    One finite element solve for each shape. Where the flank turns against its involute, the load turns with it, at
    once and there alone: that part is taken from loads turned on the sound tooth. What is left answers to the metal missing
    anywhere, smoothly, so that a few polynomials tell it for every shape of wear.
    """
    sound = method.tooth(outline, u)
    u, probe = sound.u, PROBE * outline.gear.module
    nominal = load_lines(outline, u)
    turn = _turn_response(method, outline, nominal)
    deflection, local, coupling = [], [], []
    for number in range(SHAPES):
        worn = dataclasses.replace(outline, deviation=Deviation.none(outline.gear).plus(_shape(outline, number, probe)))
        tooth = method.tooth(worn, u)
        turned = _turned(load_lines(worn, u), nominal)
        deflection.append((tooth.deflection - sound.deflection - turn * turned) / probe)
        local.append(np.log(tooth.local_depth / tooth.depth * sound.depth / sound.local_depth) / probe)
        coupling.append((tooth.coupling - sound.coupling) / probe)
    return FlankResponse(sound=sound, turn=turn, deflection=np.array(deflection), local=np.array(local), coupling=np.array(coupling))


def _place(outline: Outline, roll: ArrayLike) -> Array:
    """Return places along the flank without wear, from -1 at its start to 1 at its end.

    They run evenly along the flank beside the base circle too, where it begins across its line of action: there its length grows as the
    roll length squared, and what is even over the latter turns it without bound.
    """
    start, end, here = (np.hypot(one, ROUNDED * outline.gear.module) for one in (outline.flank_start, outline.flank_end, roll))
    return np.asarray(2.0 * (here - start) / (end - start) - 1.0)


def _roll(outline: Outline, place: Array) -> Array:
    """Return the roll lengths [m] of places along the flank, shape (n,): the inverse of `_place`."""
    rounded = ROUNDED * outline.gear.module
    start, end = np.hypot([outline.flank_start, outline.flank_end], rounded)
    return np.asarray(np.sqrt((start + 0.5 * (place + 1.0) * (end - start)) ** 2 - rounded**2))


def _shape(outline: Outline, number: int, depth: float) -> Callable[[Array], Array]:
    def missing(roll: Array) -> Array:
        place = np.clip(_place(outline, roll), -BEYOND, BEYOND)
        return np.asarray(depth * np.polynomial.legendre.legval(place, np.eye(SHAPES)[number]))

    return missing


def _shares(outline: Outline) -> Array:
    """Return how much of each shape is missing [m], by least squares over the flank."""
    place, weight = np.polynomial.legendre.leggauss(64)
    deviation = outline.deviation or Deviation.none(outline.gear)
    depth = deviation.at(_roll(outline, place))
    share: Array = (weight * depth) @ np.polynomial.legendre.legvander(place, SHAPES - 1) * (np.arange(SHAPES) + 0.5)
    return share


def _turned(lines: LoadLines, nominal: LoadLines) -> Array:
    """Return by which angle loads are turned against others [rad]."""
    (x, y), (x0, y0) = lines.direction.T, nominal.direction.T
    angle: Array = np.arctan2(x0 * y - y0 * x, x0 * x + y0 * y)
    return angle


def _turn_response(method: FiniteElements, outline: Outline, lines: LoadLines) -> Array:
    """Return the derivative of the deflection to a turn of the loads about their points."""
    with one_thread():
        section = method._mesh(outline)
        turned = []
        for sign in (-1.0, 1.0):
            cosine, sine = np.cos(sign * TURN), np.sin(sign * TURN)
            direction = lines.direction @ np.array([[cosine, sine], [-sine, cosine]])
            turned.append(dataclasses.replace(lines, direction=direction, depth=-lines.point[:, 1] / direction[:, 1]))
        load = np.hstack([forces(section, one) for one in turned])
        reading = np.hstack([readings(section, one) for one in turned])
        matrix = stiffness(section.mesh, method.plane, outline.gear.material)
        shown = method._structure(outline, section, matrix, load, reading).deflection(load, reading)
    first, second = np.split(shown, 2)
    slope: Array = (second - first) / (2.0 * TURN)
    return slope
