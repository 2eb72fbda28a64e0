"""One tooth pair over its way through the engagement: gap, arms, and its own law of force over approach, as tables."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from gearfem.engagement.contacts import find_contacts
from gearfem.engagement.engage import Mesh
from gearfem.engagement.grid import LEVEL, levels
from gearfem.engagement.record import Contacts
from gearfem.engagement.sharing import PairSystem
from gearfem.engagement.teeth import read_compliance
from gearfem.foundation import Array, Record, SolveError

# Width of the first cell beside a kink in pitches.
FINEST = 4e-5
# Steps to the pitch in which kinks are sought, sections of each in every round, and rounds: they are known to 3e-9 pitches then, and knots
# on them are moved this far off.
SEARCH, SECTIONS, ROUNDS, CLEAR = 200, 16, 5, 1e-8
# Change of the logarithm of the radius over a cell from which on the cell is divided.
BEND, MOST_PARTS = 0.03, 8
# A contact point that moves this many times farther in a step than the median has jumped.
JUMP = 5.0
GONE = 1.0
# Cells of a pair for one of the compliance between two.
COUPLED = 4
# Levels of samples below the tabulated ones, and Newton steps from them: the slope is taken where the last step, squared, ends.
BELOW, MOST_NEWTON, CLOSE = 8, 30, 1e-6
FLANK, ON_FLANK = 1, 6


class Span(NamedTuple):
    """A part of the way without kinks: its ends in pitches, whether they are kinks, and where the pair touches, see `_code`."""

    start: float
    end: float
    sharp: tuple[bool, bool]
    code: int


class Way(NamedTuple):
    """The way of a pair through the engagement: its spans, the knots of the cells of each, and the contacts there, clear of kinks."""

    spans: list[Span]
    knots: list[Array]
    contacts: Contacts


class Beside(NamedTuple):
    """Where two pairs are in reach together: the knots between kinks of either, and the contacts of both there."""

    knots: list[Array]
    contacts: Contacts


class Rough(NamedTuple):
    """Samples x (n,) of the way, and by what the logarithm of the radius of curvature changes between them (n - 1,)."""

    x: Array
    bend: Array


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class PairTable(Record):
    """One tooth pair over its local pinion angle x in pitches, 0 at the pitch point of perfect gears; cubics, highest power first.

    Parameters
    ----------
    knots : ndarray, shape (c + 1,)
        Ends of the cells; kinks of gap and law are among them.
    shape : ndarray, shape (c, 7, 4)
        Gap, arms l1, l2, friction arms h1, h2 [m] and sliding velocity [m/rad], over x - knot; 1 on the flanks, 0 on corners.
    law : ndarray, shape (c, l, 2, 4)
        Line load over available approach a at each level, and its derivative over ln a [N/m2].
    kinks : tuple of float
        Where contact begins or ends to lie on a tip round, or the contact point jumps.
    """

    knots: Array
    shape: Array
    law: Array
    kinks: tuple[float, ...]


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class CouplingTable(Record):
    """Compliance between one pair and a later one over the first one's local angle in pitches.

    Parameters
    ----------
    knots : ndarray, shape (c + 1,)
        Ends of the cells.
    coupling : ndarray, shape (c, 4)
        Approach of one per line load on the other [m per N/m], cubics over x - knot.
    """

    knots: Array
    coupling: Array


@functools.cache
def kernels() -> ModuleType:
    """Return the compiled loops; the first call of a process loads the compiler (or its cached code)."""
    from gearfem.engagement import turn_kernels as module

    return module


def way_of(mesh: Mesh, number: int) -> Way:
    """Return the way of a pair, see `pair_table`; what yields has no part in it."""
    spans, rough = _spans(mesh, number)
    knots = [_split(_graded(span, mesh.grid.cells, mesh.grid.growth), rough) for span in spans]
    return Way(spans, knots, _contacts(mesh, number, np.concatenate([_inside(part) for part in knots])))


def pair_table(mesh: Mesh, number: int, way: Way | None = None) -> PairTable:
    """Tabulate one tooth pair.

    Parameters
    ----------
    mesh : Mesh
        With placement without index errors, runout and supports: these act on whole rows and are added when angles are solved.
    number : int
        Number of the pair; its teeth may be odd ones.
    way : Way, optional
        Its way, or that of a pair of the same outlines, where that is known.

    Returns
    -------
    PairTable

    Raises
    ------
    SolveError
        If the pair never touches, or its law does not reach the levels.

    Notes
    -----
    Between kinks (ends of the path, ends of the tip rounds, jumps of the contact point), found by section to 3e-9 pitches,
    splines run over cells that shrink towards the kinks, since the law changes there over the half width of the contact.
    Levels are exact: samples of the law at given loads start Newton's method at each level. Between knots and levels the load errs by
    2e-5 where the band just meets an edge, by 2e-6 in 99 of 100 places (tests/truth/test_turns.py).
    """
    spans, knots, contacts = way or way_of(mesh, number)
    contacts = _numbered(mesh, contacts, number)
    system = mesh.system(contacts)
    quantities = (contacts.arm1, contacts.arm2, contacts.friction_arm1, contacts.friction_arm2, contacts.sliding_velocity)
    values = np.concatenate([system.gap, *quantities, np.ones_like(system.gap)], axis=1)
    law = _law(mesh, system, contacts.reach[:, 0])
    columns = np.concatenate([values, law.reshape(len(law), -1)], axis=1)
    pieces, start = [], 0
    for span, part in zip(spans, knots, strict=True):
        end = start + part.size
        piece = _spline(part, columns[start:end])
        piece[:, ON_FLANK] = [0.0, 0.0, 0.0, float(span.code == FLANK)]
        if span.code == 0:
            piece[:, 0] = [0.0, 0.0, 0.0, GONE]
        pieces.append(piece)
        start = end
    pieces_all = np.concatenate(pieces)
    return PairTable(
        knots=np.concatenate([part[:-1] for part in knots] + [knots[-1][-1:]]),
        shape=pieces_all[:, : ON_FLANK + 1],
        law=pieces_all[:, ON_FLANK + 1 :].reshape(len(pieces_all), -1, 2, 4),
        kinks=tuple(span.end for span in spans[:-1]),
    )


def beside(mesh: Mesh, number: int, apart: int, tables: tuple[PairTable, PairTable]) -> Beside | None:
    """Return where two pairs are in reach together, see `coupling_table`, or None; what yields has no part in it."""
    low = max(tables[0].knots[0], tables[1].knots[0] + apart)
    high = min(tables[0].knots[-1], tables[1].knots[-1] + apart)
    if not low < high:
        return None
    kinks = {*tables[0].kinks, *(kink + apart for kink in tables[1].kinks)}
    ends = [low, *sorted(kink for kink in kinks if low + FINEST < kink < high - FINEST), high]
    cells = mesh.grid.cells // COUPLED
    parts = [_graded(Span(a, b, (False, False), FLANK), cells, mesh.grid.growth) for a, b in itertools.pairwise(ends)]
    rows = np.concatenate([_inside(part) for part in parts])
    return Beside(parts, _contacts(mesh, number, rows, (number, number + apart)))


def coupling_table(
    mesh: Mesh, number: int, apart: int, tables: tuple[PairTable, PairTable], place: Beside | None = None
) -> CouplingTable | None:
    """Tabulate the compliance between two pairs, or return None if they are never in reach together.

    Parameters
    ----------
    mesh : Mesh
        As for `pair_table`.
    number, apart : int
        Number of the first pair, and by how many pitches the other one follows.
    tables : (PairTable, PairTable)
        Of the first pair and of the other.
    place : Beside, optional
        Where both are in reach, or pairs of the same outlines, where that is known.

    Returns
    -------
    CouplingTable or None

    Raises
    ------
    SolveError
        If the compliance does not couple teeth so far apart.
    """
    place = place or beside(mesh, number, apart, tables)
    if place is None:
        return None
    contacts = _numbered(mesh, place.contacts, number)
    linear = read_compliance(mesh.compliance, contacts).linear
    values, pieces, start = 0.5 * (linear[:, 0, 1] + linear[:, 1, 0]), [], 0
    for part in place.knots:
        pieces.append(_spline(part, values[start : start + part.size, None])[:, 0])
        start += part.size
    knots = np.concatenate([part[:-1] for part in place.knots] + [place.knots[-1][-1:]])
    return CouplingTable(knots=knots, coupling=np.concatenate(pieces))


def _numbered(mesh: Mesh, contacts: Contacts, number: int) -> Contacts:
    """Return contacts as those of the pair of a number, and of pairs after it: what yields goes by the number."""
    later = number - contacts.pairs[0]
    angle = contacts.pinion_angle + later * mesh.placement.pair.pinion.pitch_angle
    return dataclasses.replace(contacts, pairs=tuple(pair + later for pair in contacts.pairs), pinion_angle=angle)


def _contacts(mesh: Mesh, number: int, x: Array, pairs: tuple[int, ...] | None = None) -> Contacts:
    """Return contacts at local angles x in pitches of the pair of this number."""
    pitch = mesh.placement.pair.pinion.pitch_angle
    return find_contacts(mesh.flanks, mesh.placement, (x + number) * pitch, (number,) if pairs is None else pairs)


def _spans(mesh: Mesh, number: int) -> tuple[list[Span], Rough]:
    """Return the parts of the way between kinks, and where the curvature changes fast between them."""
    far = math.ceil(mesh.placement.pair.contact_ratio) + 0.5
    x = np.linspace(-far, far, round(2.0 * far * SEARCH) + 1)
    contacts = _contacts(mesh, number, x)
    code, place = _code(contacts), contacts.u1[:, 0] + contacts.u2[:, 0] * 1j
    if not (code > 0).any():
        raise SolveError(f"pair {number} never touches")
    steps = np.abs(np.diff(place))
    same = (code[1:] == code[:-1]) & (code[1:] > 0)
    found = np.flatnonzero((code[1:] != code[:-1]) | (same & (steps > JUMP * np.median(steps[same]))))
    low, high = _sections(mesh, number, x, found)
    bend = np.where(same, np.abs(np.diff(np.log(contacts.flank_radius[:, 0]))), 0.0)
    bend[found] = 0.0
    # The two sides of a kink share one end: its width is rounding.
    ends, codes = [x[0], *(0.5 * (low + high)).tolist(), x[-1]], [int(code[0]), *code[found + 1].tolist()]
    for k in reversed(range(len(codes) - 1)):
        if ends[k + 1] - ends[k] < FINEST and k > 0:
            del ends[k], codes[k]
    first, last = np.flatnonzero(codes)[[0, -1]]
    spans = [Span(ends[k], ends[k + 1], (bool(k > first), bool(k < last)), codes[k]) for k in range(first, last + 1)]
    return spans, Rough(x, bend)


def _code(contacts: Contacts) -> NDArray[np.int_]:
    """Return 0 out of reach, 1 on the flanks, 2 on a tip round."""
    reach = contacts.reach[:, 0].astype(int)
    code: NDArray[np.int_] = reach * (1 + (contacts.edge[:, 0] < 0.0))
    return code


def _sections(mesh: Mesh, number: int, x: Array, found: NDArray[np.intp]) -> tuple[Array, Array]:
    """Narrow the steps of x in which the kind of contact changes or its point jumps; return their ends."""
    low, high = x[found], x[found + 1]
    for _ in range(ROUNDS):
        if not found.size:
            break
        points = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, SECTIONS + 1)
        contacts = _contacts(mesh, number, points.ravel())
        code = _code(contacts).reshape(points.shape)
        place = (contacts.u1[:, 0] + 1j * contacts.u2[:, 0]).reshape(points.shape)
        changed = code[:, 1:] != code[:, :-1]
        at = np.where(changed.any(axis=1), np.argmax(changed, axis=1), np.argmax(np.abs(np.diff(place, axis=1)), axis=1))
        rows = np.arange(len(found))
        low, high = points[rows, at], points[rows, at + 1]
    return low, high


def _graded(span: Span, cells: int, growth: float) -> Array:
    """Return knots of a span, closer together beside kinks."""
    length = span.end - span.start
    count = max(math.ceil(-math.log(cells * FINEST) / math.log(growth)), 1)
    ramp = FINEST * (growth ** np.arange(count + 1) - 1.0) / (growth - 1.0)
    ramp = ramp[ramp < 0.45 * length]
    first = ramp if span.sharp[0] else ramp[:1]
    last = length - (ramp if span.sharp[1] else ramp[:1])[::-1]
    inner = np.linspace(first[-1], last[0], max(math.ceil((last[0] - first[-1]) * cells), 3) + 1)
    return span.start + np.concatenate([first[:-1], inner, last[1:]])


def _split(knots: Array, rough: Rough) -> Array:
    """Return knots with cells divided over which the curvature of worn flanks changes by more than `BEND`, into eight at most."""
    at = np.clip(np.searchsorted(rough.x, 0.5 * (knots[1:] + knots[:-1])) - 1, 0, rough.bend.size - 1)
    wide = np.diff(knots) * SEARCH > 1.0 / MOST_PARTS
    parts = np.where(wide, np.clip(np.ceil(rough.bend[at] / BEND), 1, MOST_PARTS), 1).astype(int)
    within = np.concatenate([np.arange(count) / count for count in parts]) if parts.max() > 1 else np.zeros(parts.size)
    return np.append(np.repeat(knots[:-1], parts) + within * np.repeat(np.diff(knots), parts), knots[-1])


def _inside(knots: Array) -> Array:
    """Return knots with the ends moved in, clear of the kinks that they lie on."""
    moved = knots.copy()
    shift = min(CLEAR, 1e-3 * float(np.diff(knots).min()))
    moved[0], moved[-1] = knots[0] + shift, knots[-1] - shift
    return moved


def _spline(knots: Array, values: Array) -> Array:
    """Return cubics (c, q, 4) through values (c + 1, q)."""
    return np.ascontiguousarray(np.moveaxis(CubicSpline(knots, values).c, 0, -1))


def _law(mesh: Mesh, system: PairSystem, reach: NDArray[np.bool_]) -> Array:
    """Return load over approach and its slope over ln(approach), shape (rows, levels, 2) [N/m2]; 1 and 0 out of reach."""
    steps = levels(mesh.placement.pair.pinion.module)
    out = np.stack([np.ones((reach.size, steps.size)), np.zeros((reach.size, steps.size))], axis=-1)
    own = system.linear[reach, 0, 0][:, None]
    # Every row once for each load that it is asked for.
    place: Any = (np.flatnonzero(reach).repeat(steps.size), 0)
    below: Any = (np.flatnonzero(reach).repeat(steps.size + BELOW), 0)
    at = {repeated[0].size: system.local(mesh.law).at(repeated) for repeated in (place, below)}

    def respond(force: Array) -> tuple[Array, Array]:
        approach, slope = at[force.size].respond(force.ravel())
        return own * force + approach.reshape(force.shape), own + slope.reshape(force.shape)

    # Loads that the teeth alone would bear at these approaches lie above the levels; samples go on below them.
    force = np.exp(np.concatenate([steps[0] - LEVEL * np.arange(BELOW, 0, -1), steps])) / own
    approach, slope = respond(force)
    loads = np.empty((force.shape[0], steps.size))
    kernels().resample(np.log(approach), np.log(force), approach / force / slope, steps, loads)
    loads, wanted = np.exp(loads), np.exp(steps)
    for _ in range(MOST_NEWTON):
        approach, slope = respond(loads)
        step = (wanted - approach) / slope
        loads = np.maximum(loads + step, 0.1 * loads)
        if np.abs(step / loads).max() < CLOSE:
            break
    else:
        raise SolveError("the contact law could not be tabulated")
    secant = loads / wanted
    out[reach] = np.stack([secant, 1.0 / slope - secant], axis=-1)
    return out
